/* Collects times and counts of frames, as --stats writes them. Threads: the main thread only. */
#ifndef STP_TOOLS_DRAW_DRAW_MEASURE_H
#define STP_TOOLS_DRAW_DRAW_MEASURE_H

#include "runtime/stipple.h"

enum { DRAW_FRAME_MS, DRAW_PROJECT_MS, DRAW_PULL_PUSH_MS, DRAW_SHADE_MS, DRAW_TIME_COUNT };

/* Zero is empty. */
typedef struct draw_measure {
    double *times[DRAW_TIME_COUNT]; /* count each */
    size_t capacity[DRAW_TIME_COUNT];
    size_t count;
    stp_draw_stats last;
    stp_cut_measure cut; /* of the last frame, except the greatest error, which is of all frames */
    uint32_t most_missing;
} draw_measure;

/* Adds a frame's times. Errors: OUT_OF_MEMORY. */
stp_status draw_measure_add(draw_measure *measure, const stp_draw_stats *stats, stp_error *err);
/* Adds the cut of the renderer's last frame. */
void draw_measure_cut(draw_measure *measure, const stp_renderer *renderer);
/* Makes the JSON object frame_ms project_ms ... gl_renderer and sorts the times. NULL if memory is
 * exhausted. A context must be current. */
struct cJSON *draw_measure_json(draw_measure *measure, const stp_renderer *renderer,
                                const stp_model *model);
void draw_measure_clear(draw_measure *measure);

#endif

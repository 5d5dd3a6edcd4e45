/* The yardstick: draws every level-0 sample of a model as a bare one-pixel point, position only,
 * from one buffer in one draw call. Threads: the thread of the GL context. */
#ifndef STP_TOOLS_BENCH_BARE_POINTS_H
#define STP_TOOLS_BENCH_BARE_POINTS_H

#include "runtime/cut/model.h"
#include "runtime/stipple.h"

typedef struct bare_points {
    unsigned program, buffer, array, frame, colour, depth; /* GL names */
    int width, height;
    uint64_t count;
} bare_points;

/* Reads every leaf chunk. Errors: GL, LIMIT (2^31 points or more), and those of reading chunks. */
stp_status bare_points_create(bare_points *out, const stp_model *model, const stp_view *view,
                              stp_error *err);
void bare_points_destroy(bare_points *points);

/* Draws once and waits for the GPU. *ms is the time that took. Errors: GL. */
stp_status bare_points_draw(const bare_points *points, double *ms, stp_error *err);

#endif

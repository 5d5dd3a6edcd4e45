/* Draws a view at rest in passes, a step each frame, until it is complete.
 * Threads: the render thread. */
#ifndef STP_RUNTIME_SETTLE_H
#define STP_RUNTIME_SETTLE_H

#include "runtime/frame.h"
#include "runtime/stream/cache/block_cache.h"

typedef enum stp_settle_phase {
    STP_SETTLE_NONE,
    STP_SETTLE_RUNS,
    STP_SETTLE_DONE,
    STP_SETTLE_FAILED /* a block does not fit in GPU memory: frames are drawn as before */
} stp_settle_phase;

/* A still picture that settle.c draws pass by pass, while the last picture is shown. Zero: none. */
typedef struct stp_settling {
    stp_settle_phase phase;
    stp_draw_params params; /* for the passes */
    bool loading;           /* the blocks of a pass are on their way */
    bool headers;           /* as far as they tell the levels of patches */
    size_t begin;           /* the cut's first draw that is not drawn yet */
    bool fronts_done;       /* splats: the fronts of all draws are drawn */
    stp_cache_load load;
    double radius_px; /* greatest of the passes so far */
    stp_draw_stats stats;
} stp_settling;

/* Whether to begin or continue a settling picture, instead of drawing a frame. */
bool stp_settle_wanted(const stp_renderer *r, const stp_drawing *d);
/* Whether the next frame continues the settling picture if nothing changes and no chunk arrives. */
bool stp_settle_goes_on(const stp_renderer *r, const stp_drawing *d);
/* Takes one step of a settling picture, without waiting for chunks. Errors: GL, OUT_OF_MEMORY. */
stp_status stp_settle_step(stp_renderer *r, stp_drawing *d, stp_error *err);

#endif

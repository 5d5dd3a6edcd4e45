/* How well a frame rate is held: the model is flown around with the threshold that
 * runtime/camera/pace.h solves for, chunks streaming. Threads: the render thread. */
#ifndef STP_TOOLS_BENCH_PACE_RUN_H
#define STP_TOOLS_BENCH_PACE_RUN_H

#include "runtime/stipple.h"

typedef struct pace_run_params {
    const stp_model *model;
    stp_renderer *renderer;
    double fps;
    double seconds; /* measured, after two that are not */
    int width, height;
} pace_run_params;

typedef struct pace_run_result {
    double fps, frame_ms, threshold_px; /* medians but for fps, which is frames over time */
    double bare_ms; /* of a frame at the coarsest threshold: what is no choice */
    bool holds;     /* what stp_pace_holds says at the end */
} pace_run_result;

/* Errors: those of stp_renderer_draw; OUT_OF_MEMORY. */
stp_status pace_run(const pace_run_params *params, pace_run_result *out, stp_error *err);

#endif

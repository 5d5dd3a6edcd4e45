/* Measures how well a frame rate is held. Flies around the model with the threshold and the
 * resolution that runtime/camera/pace.h finds, while chunks stream. Threads: the render thread. */
#ifndef STP_TOOLS_BENCH_PACE_RUN_H
#define STP_TOOLS_BENCH_PACE_RUN_H

#include "runtime/stipple.h"

typedef struct pace_run_params {
    const stp_model *model;
    stp_renderer *renderer;
    double fps;
    double seconds; /* measured; two more seconds before are not */
    int width, height;
} pace_run_params;

typedef struct pace_run_result {
    double fps, frame_ms, threshold_px, scale; /* medians; fps is frames over time */
    double bare_ms; /* of a full frame at the coarsest threshold: what only fewer pixels can save */
    bool holds;     /* result of stp_pace_holds at the end */
} pace_run_result;

/* Errors: those of stp_renderer_draw; OUT_OF_MEMORY. */
stp_status pace_run(const pace_run_params *params, pace_run_result *out, stp_error *err);

#endif

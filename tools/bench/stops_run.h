/* A cold flight: stops around a model. Measures at each stop the time until its cut is complete,
 * including reading and decoding missing chunks. Threads: the render thread. */
#ifndef STP_TOOLS_BENCH_STOPS_RUN_H
#define STP_TOOLS_BENCH_STOPS_RUN_H

#include "runtime/cut/model.h"
#include "runtime/stipple.h"

#define STOPS_RUN_COUNT 6

typedef struct stops_run_result {
    double cold_ms[STOPS_RUN_COUNT]; /* the first frame at a stop, which waits for its chunks */
    double warm_ms[STOPS_RUN_COUNT]; /* the same frame again: the time of drawing alone */
} stops_run_result;

/* Errors: those of stp_renderer_draw. */
stp_status stops_run(stp_renderer *renderer, const stp_model *model, const int size[2],
                     stops_run_result *out, stp_error *err);

#endif

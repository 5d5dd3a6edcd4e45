/* Measures how soon a model looks like itself after opening: draws frames while chunks stream and
 * compares each with the complete one. Threads: the render thread. */
#ifndef STP_TOOLS_BENCH_OPEN_RUN_H
#define STP_TOOLS_BENCH_OPEN_RUN_H

#include "runtime/stipple.h"

/* Pixels that both pictures cover, over pixels that either covers. */
#define OPEN_RUN_OVERLAP 0.95

typedef struct open_run_result {
    double ready_s, first_s, alike_s, complete_s; /* since `begun`; ready_s: before any drawing */
    double first_overlap;                         /* of the first frame */
    uint64_t bytes;                               /* of payloads, until the cut was complete */
    unsigned frames;
    bool complete; /* false: the cut does not fit into the memory */
} open_run_result;

/* begun: stp_clock_seconds() at the beginning. Errors: those of stp_renderer_draw; OUT_OF_MEMORY.
 */
stp_status open_run(stp_renderer *renderer, const stp_view *view, double begun,
                    open_run_result *out, stp_error *err);

#endif

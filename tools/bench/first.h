/* Times the first picture of a fresh process, stage by stage. Threads: the main thread, once. */
#ifndef STP_TOOLS_BENCH_FIRST_H
#define STP_TOOLS_BENCH_FIRST_H

#include "base/error.h"

#include <stdint.h>

typedef struct first_params {
    const char *path;
    int size[2];
    uint64_t gpu_memory, cpu_memory; /* bytes; 0: the renderer's default */
    unsigned threads;
} first_params;

/* Draws the whole model as far as it is loaded, like a viewer's first frame, and prints the times.
 * Errors: those of opening and drawing; FORMAT (the picture is empty). */
stp_status first_run(const first_params *params, stp_error *err);

#endif

/* Measures how fast the payloads of two files of one model decode, on one thread, in turns.
 * Threads: any. */
#ifndef STP_TOOLS_BENCH_DECODE_RUN_H
#define STP_TOOLS_BENCH_DECODE_RUN_H

#include "base/error.h"

#include <stdint.h>

typedef struct decode_run_result {
    uint64_t file_bytes[2];
    double points_per_s[2]; /* level-0 samples; medians over the rounds */
    double ratio[3];        /* second over first: least, median, greatest of the rounds */
    uint32_t chunks;
} decode_run_result;

/* Decodes up to 64 chunks, spread over the file, `rounds` times from each file. Errors: those of
 * reading; INVALID_ARGUMENT (the files are not of one model). */
stp_status decode_run(const char *const paths[2], unsigned rounds, decode_run_result *out,
                      stp_error *err);

#endif

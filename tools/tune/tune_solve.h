/* The threshold at which something measured takes a wanted value.
 *
 * Bracketed by what a sweep has measured, then narrowed in the logarithm of the threshold by new
 * measurements. Does not measure by itself. Threads: any. */
#ifndef STP_TOOLS_TUNE_TUNE_SOLVE_H
#define STP_TOOLS_TUNE_TUNE_SOLVE_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>

/* Beyond the sweep it is looked for up to here. */
#define TUNE_SOLVE_COARSEST_PX 64.0
/* Thresholds measured in one go. */
#define TUNE_SOLVE_MOST 3

typedef enum tune_goal_kind {
    TUNE_GOAL_NONE,
    TUNE_GOAL_FPS,  /* rises with the threshold; met within 10 % */
    TUNE_GOAL_PSNR, /* falls; met within 0.5 dB */
    TUNE_GOAL_BYTES /* falls; a limit: met by what is no more, as near to it as can be */
} tune_goal_kind;

typedef struct tune_solve_params {
    tune_goal_kind kind;
    double target;
    const double *thresholds, *values; /* of the sweep, thresholds rising; 0 may be the first */
    size_t count;
    /* Measures up to TUNE_SOLVE_MOST thresholds in turns. */
    stp_status (*measure)(void *context, const double *thresholds, size_t count, double *values,
                          stp_error *err);
    void *context;
} tune_solve_params;

typedef struct tune_solution {
    double threshold_px, value;
    unsigned measured; /* thresholds besides the sweep's */
} tune_solution;

/* "fps", "psnr", "bytes". */
const char *tune_goal_word(tune_goal_kind kind);
/* Errors: INVALID_ARGUMENT (the target is out of reach: what can be reached is said), and those of
 * measuring. */
stp_status tune_solve(tune_solution *out, const tune_solve_params *params, stp_error *err);

#endif

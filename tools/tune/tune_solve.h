/* Finds the threshold at which a measured figure takes a wanted value.
 *
 * The sweep's measurements bracket the threshold. New measurements narrow the bracket in the
 * logarithm of the threshold. Does not measure by itself. Threads: any. */
#ifndef STP_TOOLS_TUNE_TUNE_SOLVE_H
#define STP_TOOLS_TUNE_TUNE_SOLVE_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>

/* Beyond the sweep, thresholds are tried up to this one. */
#define TUNE_SOLVE_COARSEST_PX 64.0
/* Most thresholds per call of measure. */
#define TUNE_SOLVE_MOST 3

typedef enum tune_goal_kind {
    TUNE_GOAL_NONE,
    TUNE_GOAL_FPS,  /* rises with the threshold; met within 10 % */
    TUNE_GOAL_PSNR, /* falls; met within 0.5 dB */
    TUNE_GOAL_BYTES /* falls; a limit: met by a value that does not exceed it, as near to it as
                       possible */
} tune_goal_kind;

typedef struct tune_solve_params {
    tune_goal_kind kind;
    double target;
    const double *thresholds, *values; /* of the sweep; thresholds rise; the first may be 0 */
    size_t count;
    /* Measures up to TUNE_SOLVE_MOST thresholds in turns. */
    stp_status (*measure)(void *context, const double *thresholds, size_t count, double *values,
                          stp_error *err);
    void *context;
} tune_solve_params;

typedef struct tune_solution {
    double threshold_px, value;
    unsigned measured; /* number of thresholds measured besides the sweep's */
} tune_solution;

/* "fps", "psnr", "bytes". */
const char *tune_goal_word(tune_goal_kind kind);
/* Errors: INVALID_ARGUMENT (the target is out of reach; the message says what can be reached), and
 * those of measuring. */
stp_status tune_solve(tune_solution *out, const tune_solve_params *params, stp_error *err);

#endif

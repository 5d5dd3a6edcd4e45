/* Finds a threshold by bracketing and narrowing. */
#include "tools/tune/tune_solve.h"

#include <math.h>
#include <stdio.h>

#define GOES_MOST 12
/* Near enough to stop: shares, and decibels. */
#define NEAR_SHARE 0.02
#define NEAR_DB 0.05
#define MET_SHARE 0.1
#define MET_DB 0.5
/* A bracket that begins at 0 begins at this share of its end instead. */
#define FINEST_SHARE (1.0 / 256.0)

typedef struct hunt {
    const tune_solve_params *p;
    double low, high;              /* thresholds: low is too fine, high is coarse enough */
    double least, greatest;        /* values measured so far */
    double finest_px, coarsest_px; /* thresholds measured so far */
    tune_solution best;
    double best_error; /* in units of the tolerance */
} hunt;

const char *tune_goal_word(tune_goal_kind kind)
{
    static const char *const words[] = {"none", "fps", "psnr", "bytes"};
    return words[kind];
}

/* The distance of a value from the target; 1 is the tolerance. A limit is either kept or not. */
static double error_of(const tune_solve_params *p, double value)
{
    if (p->kind == TUNE_GOAL_PSNR)
        return fabs(value - p->target) / MET_DB;
    if (p->kind == TUNE_GOAL_BYTES && value > p->target)
        return INFINITY;
    return p->kind == TUNE_GOAL_BYTES ? 0.5 * (1.0 - value / p->target)
                                      : fabs(value / p->target - 1.0) / MET_SHARE;
}

static bool near_enough(const hunt *h)
{
    return h->best_error <= (h->p->kind == TUNE_GOAL_PSNR  ? NEAR_DB / MET_DB
                             : h->p->kind == TUNE_GOAL_FPS ? NEAR_SHARE / MET_SHARE
                                                           : 0.5 * NEAR_SHARE);
}

/* True if the threshold with this value is coarse enough: fps has risen to the target, or PSNR or
 * bytes have fallen to it. */
static bool does(const tune_solve_params *p, double value)
{
    return p->kind == TUNE_GOAL_FPS ? value >= p->target : value <= p->target;
}

static void take(hunt *h, double threshold, double value)
{
    double error = error_of(h->p, value);
    h->least = fmin(h->least, value);
    h->greatest = fmax(h->greatest, value);
    h->finest_px = fmin(h->finest_px, threshold);
    h->coarsest_px = fmax(h->coarsest_px, threshold);
    if (error < h->best_error) {
        h->best_error = error;
        h->best.threshold_px = threshold;
        h->best.value = value;
    }
}

static stp_status measure(hunt *h, const double *thresholds, size_t count, double *values,
                          stp_error *err)
{
    stp_status status = h->p->measure(h->p->context, thresholds, count, values, err);
    for (size_t i = 0; status == STP_OK && i < count; i++)
        take(h, thresholds[i], values[i]);
    if (status == STP_OK)
        h->best.measured += (unsigned)count;
    return status;
}

/* Finds the first threshold that is coarse enough and the last before it. *found: there is one. */
static stp_status bracket(hunt *h, bool *found, stp_error *err)
{
    stp_status status = STP_OK;
    const tune_solve_params *p = h->p;
    size_t i = 0;
    for (size_t k = 0; k < p->count; k++)
        take(h, p->thresholds[k], p->values[k]);
    while (i < p->count && !does(p, p->values[i]))
        i++;
    *found = i < p->count;
    h->high = p->thresholds[*found ? i : p->count - 1];
    h->low = i > 0 ? p->thresholds[i - 1] : h->high;
    while (!*found && h->high < TUNE_SOLVE_COARSEST_PX) {
        double value;
        h->low = h->high;
        h->high = fmin(fmax(2.0 * h->high, 0.25), TUNE_SOLVE_COARSEST_PX);
        STP_TRY(measure(h, &h->high, 1, &value, err));
        *found = does(p, value);
    }
done:
    return status;
}

static stp_status narrow(hunt *h, stp_error *err)
{
    stp_status status = STP_OK;
    const tune_solve_params *p = h->p;
    /* Times are noisy, so several thresholds are measured in turns. */
    size_t count = p->kind == TUNE_GOAL_FPS ? TUNE_SOLVE_MOST : 1;
    double t[TUNE_SOLVE_MOST], values[TUNE_SOLVE_MOST];
    if (h->low <= 0.0)
        h->low = h->high * FINEST_SHARE;
    for (int i = 0; i < GOES_MOST && !near_enough(h) && h->high > 1.005 * h->low; i++) {
        double ratio = pow(h->high / h->low, 1.0 / (double)(count + 1));
        for (size_t k = 0; k < count; k++)
            t[k] = h->low * pow(ratio, (double)(k + 1));
        STP_TRY(measure(h, t, count, values, err));
        size_t first = 0;
        while (first < count && !does(p, values[first]))
            first++;
        double low = first > 0 ? t[first - 1] : h->low;
        h->high = first < count ? t[first] : h->high;
        h->low = low;
    }
done:
    return status;
}

/* Formats a value in a readable unit. */
static void format(tune_goal_kind kind, double value, char out[32])
{
    if (kind == TUNE_GOAL_BYTES)
        snprintf(out, 32, "%.3g MiB", value / 1048576.0);
    else
        snprintf(out, 32, "%.*f%s", value < 10.0 || kind == TUNE_GOAL_PSNR ? 2 : 1, value,
                 kind == TUNE_GOAL_PSNR ? " dB" : " frames a second");
}

static stp_status refuse(const hunt *h, stp_error *err)
{
    char target[32], least[32], greatest[32];
    format(h->p->kind, h->p->target, target);
    format(h->p->kind, h->least, least);
    format(h->p->kind, h->greatest, greatest);
    return stp_error_set(err, STP_INVALID_ARGUMENT,
                         "--%s: %s cannot be reached with these views: thresholds from %g to %g px "
                         "give %s to %s",
                         tune_goal_word(h->p->kind), target, h->finest_px, h->coarsest_px, least,
                         greatest);
}

stp_status tune_solve(tune_solution *out, const tune_solve_params *p, stp_error *err)
{
    stp_status status = STP_OK;
    hunt h = {.p = p,
              .least = INFINITY,
              .greatest = -INFINITY,
              .finest_px = INFINITY,
              .best_error = INFINITY};
    bool found;
    STP_TRY(bracket(&h, &found, err));
    /* The finest threshold is already coarse enough, so there is nothing to narrow. For a limit it
     * is the answer. */
    bool within = p->kind == TUNE_GOAL_BYTES && does(p, p->values[0]);
    if (within)
        h.best = (tune_solution){p->thresholds[0], p->values[0], h.best.measured};
    if (found && h.low < h.high && !within)
        STP_TRY(narrow(&h, err));
    if (!(h.best_error <= 1.0))
        return refuse(&h, err);
    *out = h.best;
done:
    return status;
}

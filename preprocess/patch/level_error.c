/* Errors of merged samples: measures only those that a bound does not show to be within the code
 * that the greatest one is rounded up to. */
#include "preprocess/patch/level_error.h"

#include "formats/chunk/sample/patch.h"

/* The samples of level 0 under a merged one. */
static const stp_disc *under(const stp_level_discs *d, unsigned index, unsigned *count)
{
    const unsigned first = stp_covered_begin(d->counts, d->level, index, 0);
    *count = stp_covered_begin(d->counts, d->level, index + 1, 0) - first;
    return &d->finest[first];
}

/* What the code holds that an error is rounded up to. */
static double held(double error, int exponent)
{
    return stp_error_decode(stp_error_encode(error, exponent), exponent);
}

double stp_level_error(const stp_level_discs *d, unsigned from, unsigned to, int exponent,
                       double worst)
{
    double high[STP_PATCH_SAMPLES];
    unsigned count;
    for (unsigned i = from; i < to; i++) {
        const stp_disc *finest = under(d, i, &count);
        const stp_error_bounds e = stp_merge_bound_error(&d->merged[i], finest, count);
        worst = stp_max(worst, e.low);
        high[i] = e.high;
    }
    double most = held(worst, exponent);
    for (unsigned i = from; i < to; i++) {
        const stp_disc *finest = under(d, i, &count);
        // cppcheck-suppress uninitvar ; the loop above has set it
        if (high[i] <= most)
            continue;
        worst = stp_merge_measure_rim(&d->merged[i], finest, count, worst);
        most = held(worst, exponent);
    }
    return worst;
}

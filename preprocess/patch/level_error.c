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
    for (unsigned i = from; i < to; i++) {
        const stp_disc *finest = under(d, i, &count);
        if (high[i] > stp_error_decode(stp_error_encode(worst, exponent), exponent))
            worst = stp_max(worst, stp_merge_measure(&d->merged[i], finest, count).error);
    }
    return worst;
}

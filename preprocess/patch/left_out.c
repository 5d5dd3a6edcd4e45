/* Measures what merged discs leave out beside holes. */
#include "preprocess/patch/left_out.h"

#include <math.h>

double stp_left_out_spread(const stp_disc *merged, const stp_disc *discs, const double *spreads,
                           unsigned count)
{
    double out = 0.0;
    for (unsigned i = 0; i < count; i++) {
        const stp_dvec3 way = stp_dvec3_sub(discs[i].centre, merged->centre);
        out = stp_max(out, stp_dvec3_length(way) + spreads[i]);
    }
    return out;
}

/* How far originals under a disc of level 0 lie from the nearest of the merged discs, at most. */
static double nearest(const stp_disc *disc, double spread, const stp_disc *merged, unsigned count)
{
    double least = INFINITY;
    for (unsigned j = 0; j < count; j++) {
        const stp_dvec3 way = stp_dvec3_sub(disc->centre, merged[j].centre);
        least = stp_min(least, stp_dvec3_length(way) - merged[j].radius);
    }
    return stp_max(0.0, least + spread);
}

static double left_out(const stp_patch *patch, const stp_disc (*discs)[STP_PATCH_SAMPLES],
                       const double *spreads, int level, unsigned q)
{
    const unsigned from = stp_quarter_begin(patch->counts, level, q);
    const unsigned to = stp_quarter_begin(patch->counts, level, q + 1);
    double out = 0.0;
    for (unsigned i = stp_quarter_begin(patch->counts, 0, q);
         i < stp_quarter_begin(patch->counts, 0, q + 1); i++)
        out = stp_max(out, nearest(&discs[0][i], spreads[i], &discs[level][from], to - from));
    return out;
}

void stp_left_out_store(stp_patch *patch, const stp_disc (*discs)[STP_PATCH_SAMPLES],
                        const double *spreads)
{
    double worst = 0.0;
    for (unsigned q = 0; q < patch->counts[2]; q++) {
        double out = 0.0;
        for (int level = 1; level <= 2; level++) {
            out = stp_max(out, left_out(patch, discs, spreads, level, q));
            const uint8_t code = stp_error_encode(out, patch->exponent);
            patch->quarter_tangential_error[level - 1][q] = code;
            if (code > patch->tangential_error[level])
                patch->tangential_error[level] = code;
        }
        worst = stp_max(worst, out);
    }
    for (unsigned i = 0; i < patch->counts[0]; i++)
        worst = stp_max(worst, nearest(&discs[0][i], spreads[i], discs[STP_LEVEL_COUNT - 1], 1));
    patch->tangential_error[STP_LEVEL_COUNT - 1] = stp_error_encode(worst, patch->exponent);
}

/* What merged discs leave out where holes limit them (holes.h): how far the samples that they stand
 * for lie from what is left. Threads: any (pure functions). */
#ifndef STP_PREPROCESS_PATCH_LEFT_OUT_H
#define STP_PREPROCESS_PATCH_LEFT_OUT_H

#include "formats/chunk/measure/patch_bounds.h"

/* How far originals lie from the merged disc's centre, at most. spreads: how far those of each disc
 * of level 0 lie from its centre. */
double stp_left_out_spread(const stp_disc *merged, const stp_disc *discs, const double *spreads,
                           unsigned count);
/* Sets the tangential errors of the patch, level by level, and of its quarters: the greatest
 * distance of an original of the quarter from the quarter's nearest disc. discs: by level, with the
 * patch's counts. */
void stp_left_out_store(stp_patch *patch, const stp_disc (*discs)[STP_PATCH_SAMPLES],
                        const double *spreads);

#endif

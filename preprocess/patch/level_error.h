/* Errors of a patch's merged samples. Threads: any (pure). */
#ifndef STP_PREPROCESS_PATCH_LEVEL_ERROR_H
#define STP_PREPROCESS_PATCH_LEVEL_ERROR_H

#include "formats/chunk/measure/patch_bounds.h"

typedef struct stp_level_discs {
    const stp_disc *finest, *merged; /* of levels 0 and `level` */
    const uint8_t *counts;           /* by level */
    int level;
} stp_level_discs;

/* Returns a number that is rounded to the same code as the greatest perpendicular error of the
 * merged samples [from, to), or as `worst` if that is more. exponent: the patch's. */
double stp_level_error(const stp_level_discs *discs, unsigned from, unsigned to, int exponent,
                       double worst);

#endif

/* How exact fitted normals are: the standard errors of a model's normals, and the grid of codes
 * (formats/chunk/sample/normal_grid.h) that is fine enough for them. Threads: any (pure functions).
 */
#ifndef STP_PREPROCESS_SURFACE_NORMAL_ERROR_H
#define STP_PREPROCESS_SURFACE_NORMAL_ERROR_H

#include "preprocess/surface/moments.h"

#include <stdbool.h>
#include <stdint.h>

#define STP_NORMAL_ERROR_BINS 64u

/* A histogram of standard errors, in quarters of octaves from 2^-14 radians on. */
typedef struct stp_normal_errors {
    uint64_t counts[STP_NORMAL_ERROR_BINS];
} stp_normal_errors;

/* Adds the normal of a plane through the points of m, whose heights over the plane have the
 * variance `noise`. */
void stp_normal_errors_add(stp_normal_errors *errors, const stp_moments *m, float noise);
/* The median, radians; 0 if no normal was added. */
double stp_normal_errors_median(const stp_normal_errors *errors);
/* Bits of the coarsest grid whose greatest angle is at most twice the error; 12 if the error is 0.
 * quiet: what the planes leave is curvature rather than noise. Then at least 9 bits, so that
 * shading shows no bands. */
unsigned stp_normal_bits_for(double error, bool quiet);
/* Likewise the coarsest step of any grid (normal_grid.h). */
unsigned stp_normal_step_for(double error, bool quiet);

#endif

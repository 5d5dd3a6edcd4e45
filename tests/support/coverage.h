/* Judges the coverage of a picture against the true silhouette: holes, and what the picture and the
 * truth have far from each other.
 *
 * Masks have one byte per pixel, not 0 where covered; rows in either order. Threads: any. */
#ifndef STP_TESTS_SUPPORT_COVERAGE_H
#define STP_TESTS_SUPPORT_COVERAGE_H

#include "base/error.h"

#include <stddef.h>
#include <stdint.h>

/* A hole is a pixel that the picture misses although the silhouette contains it and its eight
 * neighbours. It must also be enclosed (no path over uncovered side neighbours leads out of the
 * silhouette), or lie deeper inside than the tolerance. Any other missing pixel was lost from
 * outside: the outline has moved. */
typedef struct coverage_verdict {
    size_t silhouette; /* pixels whose centre is in the truth */
    size_t hole_pixels;
    size_t hole_count;   /* connected across sides and corners */
    size_t largest_hole; /* pixels */
    /* Pixels with an open side or at the picture's edge, of the silhouette and of the picture. */
    size_t outline;
    size_t spill; /* covered pixels farther than the tolerance from the truth */
    size_t lost;  /* pixels of the silhouette farther than it from all covered pixels */
    double spill_max_px, lost_max_px; /* the greatest such distances; 0: none */
} coverage_verdict;

/* truth: as the picture, with scale x scale pixels for each of its pixels; scale is odd, so that
 * one of them has the same centre. A scale above 1 tells how far it is to the surface and not only
 * to the next pixel's centre. Distances are between centres. A gap of the truth that is no wider
 * than twice the tolerance may close. Errors: OUT_OF_MEMORY. */
stp_status coverage_judge(const uint8_t *picture, int width, int height, const uint8_t *truth,
                          int scale, double tolerance_px, coverage_verdict *out, stp_error *err);

/* The exact Euclidean distance in pixels from each pixel to the nearest one that is not 0
 * (Felzenszwalb and Huttenlocher 2012); INFINITY if there is none. Errors: OUT_OF_MEMORY. */
stp_status coverage_distance(const uint8_t *mask, int width, int height, double *distance,
                             stp_error *err);

#endif

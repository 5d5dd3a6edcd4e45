/* Judges the coverage of a picture against the true silhouette: holes, and the distance between the
 * outlines.
 *
 * Masks have one byte per pixel, not 0 where covered; rows in either order. Threads: any. */
#ifndef STP_TESTS_SUPPORT_COVERAGE_H
#define STP_TESTS_SUPPORT_COVERAGE_H

#include "base/error.h"

#include <stddef.h>
#include <stdint.h>

/* A hole is a pixel that the picture misses although the silhouette contains it and its eight
 * neighbours. It must also be enclosed (no path over uncovered side neighbours leads out of the
 * silhouette), or lie deeper inside than the outline's tolerance. Any other missing pixel was lost
 * from outside and counts as an error of the outline. */
typedef struct coverage_verdict {
    size_t silhouette; /* pixels of the true silhouette */
    size_t hole_pixels;
    size_t hole_count;   /* connected across sides and corners */
    size_t largest_hole; /* pixels */
    size_t spill;        /* covered pixels more than one from the silhouette, also across corners */
    size_t outline;      /* outline pixels judged, of the picture and of the silhouette */
    size_t outline_far;  /* of these: farther than the tolerance from the other outline */
    double outline_p99_px, outline_max_px;
} coverage_verdict;

/* outline_tolerance_px: 99 % of the outline must be within it. An outline pixel is a covered pixel
 * with an uncovered side neighbour or at the picture's edge. Distances are between pixel centres.
 * Errors: OUT_OF_MEMORY. */
stp_status coverage_judge(const uint8_t *picture, const uint8_t *silhouette, int width, int height,
                          double outline_tolerance_px, coverage_verdict *out, stp_error *err);

/* The exact Euclidean distance in pixels from each pixel to the nearest one that is not 0
 * (Felzenszwalb and Huttenlocher 2012); INFINITY if there is none. Errors: OUT_OF_MEMORY. */
stp_status coverage_distance(const uint8_t *mask, int width, int height, double *distance,
                             stp_error *err);

#endif

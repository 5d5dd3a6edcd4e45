/* Coverage of a picture against the true silhouette: holes, and how far the outlines are apart.
 *
 * Masks are one byte a pixel, not 0 where covered, rows in either order. Threads: any. */
#ifndef STP_TESTS_SUPPORT_COVERAGE_H
#define STP_TESTS_SUPPORT_COVERAGE_H

#include "base/error.h"

#include <stddef.h>
#include <stdint.h>

/* A hole is a pixel that the picture misses although the silhouette holds it and its eight
 * neighbours, if it is shut in (no way out of the silhouette over uncovered pixels side by side) or
 * lies deeper inside than the outline may be off. What else is missing has been eaten away from
 * outside and is the outline's fault. */
typedef struct coverage_verdict {
    size_t silhouette; /* pixels of the true silhouette */
    size_t hole_pixels;
    size_t hole_count;   /* connected over sides and corners */
    size_t largest_hole; /* pixels */
    size_t spill;        /* covered pixels more than one from the silhouette, corners included */
    size_t outline;      /* outline pixels judged, of the picture and of the silhouette */
    size_t outline_far;  /* of these, further than the tolerance from the other outline */
    double outline_p99_px, outline_max_px;
} coverage_verdict;

/* outline_tolerance_px: what 99 % of the outline must keep. An outline pixel is a covered one with
 * an uncovered side neighbour or at the picture's edge; distances are between pixel centres.
 * Errors: OUT_OF_MEMORY. */
stp_status coverage_judge(const uint8_t *picture, const uint8_t *silhouette, int width, int height,
                          double outline_tolerance_px, coverage_verdict *out, stp_error *err);

/* Exact Euclidean distance, pixels, from each pixel to the nearest one that is not 0 (Felzenszwalb
 * and Huttenlocher 2012); INFINITY where there is none. Errors: OUT_OF_MEMORY. */
stp_status coverage_distance(const uint8_t *mask, int width, int height, double *distance,
                             stp_error *err);

#endif

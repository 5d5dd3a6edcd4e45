/* What compare_metrics.h leaves out of how far one picture is from another: how far its outlines
 * lie from the other's, how its normals turn, and what changes from frame to frame that should not.
 *
 * Rows may be in either order, the same for both. A is judged, B is the reference. Does not draw.
 * Threads: any. */
#ifndef STP_TOOLS_TUNE_TUNE_METRICS_H
#define STP_TOOLS_TUNE_TUNE_METRICS_H

#include "base/error.h"
#include "formats/image/image.h"

#include <stddef.h>
#include <stdint.h>

/* Uncovered parts of fewer pixels that do not touch the picture's rim are holes, no outlines. */
#define TUNE_HOLE_PIXELS 16
/* Distances of outlines are no greater: one that the other picture does not have counts so. */
#define TUNE_OUTLINE_LIMIT_PX 64.0

/* Distances between two sets, of each member to the other set. */
typedef struct tune_shift {
    double mean_px, p95_px, max_px;
    size_t points; /* of both outlines; 0: neither has any, and all is 0 */
} tune_shift;

/* Outlines are where alpha crosses one half between the centres of two pixels next to each other,
 * found linearly, so those of a supersampled picture are known to a fraction of a pixel. Of each
 * such point of either picture the distance to the nearest of the other. Errors: INVALID_ARGUMENT
 * (sizes differ), OUT_OF_MEMORY. */
stp_status tune_shift_compute(const stp_image *a, const stp_image *b, tune_shift *out,
                              stp_error *err);

typedef struct tune_angles {
    double mean_deg, median_deg, p95_deg;
    size_t pixels; /* where both have a normal */
} tune_angles;

/* Angles between unit normals, xyz by pixel, 0 0 0 where there is none. Errors: OUT_OF_MEMORY. */
stp_status tune_angles_compute(const float *a, const float *b, size_t pixel_count, tune_angles *out,
                               stp_error *err);

/* Sums over the steps of a film; zero is the start. */
typedef struct tune_change {
    uint64_t pixels;                /* covered in any of the four pictures, times steps */
    uint64_t squares_a, squares_b;  /* of the RGB changes of A and of B over black */
    uint64_t squares_extra;         /* of what A changes more or otherwise than B */
    uint64_t opened, closed, steps; /* holes of A, as compare_metrics.h has them, that come, go */
} tune_change;

/* Adds the step from one frame to the next; all four pictures have the same size. */
void tune_change_add(tune_change *change, const stp_image *a_before, const stp_image *a_after,
                     const stp_image *b_before, const stp_image *b_after);
/* Root of the mean square, in levels of 0 to 255, of one of the sums. */
double tune_change_level(const tune_change *change, uint64_t squares);

#endif

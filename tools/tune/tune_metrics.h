/* Picture metrics beside compare_metrics.h: how far outlines lie apart, how normals differ, and
 * what changes from frame to frame but should not.
 *
 * Rows may be in either order, the same for both pictures. A is judged, B is the reference. Does
 * not draw. Threads: any. */
#ifndef STP_TOOLS_TUNE_TUNE_METRICS_H
#define STP_TOOLS_TUNE_TUNE_METRICS_H

#include "base/error.h"
#include "formats/image/image.h"

#include <stddef.h>
#include <stdint.h>

/* An uncovered part with fewer pixels that does not touch the picture's rim is a hole, not an
 * outline. */
#define TUNE_HOLE_PIXELS 16
/* Distances of outlines are cut at this value. A point counts so if the other picture has no
 * outline. */
#define TUNE_OUTLINE_LIMIT_PX 64.0

/* Distances from each member of two sets to the other set. */
typedef struct tune_shift {
    double mean_px, p95_px, max_px;
    size_t points; /* in both outlines; 0: neither has any, and all members are 0 */
} tune_shift;

/* An outline is where alpha crosses one half between the centres of two neighbouring pixels,
 * interpolated linearly. So outlines of a supersampled picture are known to a fraction of a pixel.
 * For each outline point of either picture, this takes the distance to the nearest outline point of
 * the other. Errors: INVALID_ARGUMENT (sizes differ), OUT_OF_MEMORY. */
stp_status tune_shift_compute(const stp_image *a, const stp_image *b, tune_shift *out,
                              stp_error *err);

typedef struct tune_angles {
    double mean_deg, median_deg, p95_deg;
    size_t pixels; /* pixels in which both have a normal */
} tune_angles;

/* Computes angles between unit normals, xyz per pixel, 0 0 0 if there is none. Errors:
 * OUT_OF_MEMORY. */
stp_status tune_angles_compute(const float *a, const float *b, size_t pixel_count, tune_angles *out,
                               stp_error *err);

/* Sums over the steps of a film; zero is the start. */
typedef struct tune_change {
    uint64_t pixels;                /* pixels covered in any of the four pictures, times steps */
    uint64_t squares_a, squares_b;  /* squares of the RGB changes of A and of B over black */
    uint64_t squares_extra;         /* squares of the difference between A's change and B's */
    uint64_t opened, closed, steps; /* holes of A that come and go */
} tune_change;

/* Adds the step from one frame to the next. All four pictures have the same size. */
void tune_change_add(tune_change *change, const stp_image *a_before, const stp_image *a_after,
                     const stp_image *b_before, const stp_image *b_after);
/* Root of the mean square of one of the sums, in levels of 0 to 255. */
double tune_change_level(const tune_change *change, uint64_t squares);

#endif

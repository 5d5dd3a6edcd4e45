/* Normals of scans whose points are the pixels of an image, where noise is along the rays.
 *
 * A depth camera's pixels are off in depth by far more than they lie apart, often by whole steps of
 * its disparity, so the nearest points in space are those of the same step and say nothing of the
 * surface. Along rays x u + y w + v about a pixel's ray v a plane n p = h has the inverse depth
 * 1 / t = (n_u x + n_w y + n_v) / h: affine in x and y, with noise in 1 / t alone. It is fitted by
 * least squares to windows of the image, each twice as wide as the one before, from which it takes
 * what lies by the former plane within three deviations of the noise; until the angle is sure, or
 * what is left exceeds the noise: there is a crease, or curvature. The noise is the median of what
 * planes leave in small windows, tile by tile. Threads: those of the pool; the same for any number.
 */
#ifndef STP_PREPROCESS_SURFACE_IMAGE_NORMALS_H
#define STP_PREPROCESS_SURFACE_IMAGE_NORMALS_H

#include "base/pool.h"
#include "preprocess/viewpoint/image_fit.h"

/* Sets the normals, towards the station, of the points that have none given, where the noise is
 * more than a quarter of their spacing; they count as given then. Adds their number to *count. The
 * station saw all pixels; the grid has columns. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_image_normals(const stp_file_points *points, const stp_scan_grid *grid,
                             stp_dvec3 station, stp_pool *pool, uint64_t *count, stp_error *err);

#endif

/* Normals of scans whose points are the pixels of an image, with noise along the rays.
 *
 * A depth camera's error in depth is far larger than the distance between its pixels, often whole
 * steps of its disparity. The nearest points in space are those of the same step, and they say
 * nothing about the surface.
 *
 * Take rays x u + y w + v around a pixel's ray v. On a plane n p = h, the inverse depth is affine
 * in x and y, with noise in 1 / t alone:
 *
 *     1 / t = (n_u x + n_w y + n_v) / h
 *
 * 1. The plane is fitted by least squares to windows of the image, each twice as wide as the one
 *    before.
 * 2. A wider window takes only pixels within three deviations of the noise of the former plane.
 * 3. It ends when the angle is sure, or when the residual exceeds the noise: there is a crease, or
 *    curvature.
 * 4. The normal is the mean of those of 3 x 3 pixels that are alike.
 *
 * The noise is the median residual of planes in small windows, tile by tile. Threads: those of the
 * pool; the same result for any number. */
#ifndef STP_PREPROCESS_SURFACE_IMAGE_NORMALS_H
#define STP_PREPROCESS_SURFACE_IMAGE_NORMALS_H

#include "base/pool.h"
#include "preprocess/viewpoint/image_fit.h"

/* About the median standard error of the normals, radians: windows grow, by factors of two, until
 * it is below twice as much. */
#define STP_IMAGE_NORMAL_ERROR 0.0075

/* Sets normals, facing the station, of points that have none given, if the noise is more than a
 * quarter of their spacing. These normals then count as given. Adds their number to *count. The
 * station saw all pixels; the grid has columns. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_image_normals(const stp_file_points *points, const stp_scan_grid *grid,
                             stp_dvec3 station, stp_pool *pool, uint64_t *count, stp_error *err);

#endif

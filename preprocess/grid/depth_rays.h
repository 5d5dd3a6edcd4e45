/* The rays of cameras and scanners, found from the points of their images.
 *
 * Along an axis of the world, a ray has two tangents. Those of a camera that looks along an axis
 * are linear in column and row: the rays of its image are one piece. Those of a camera that is
 * turned in space, or of a scanner, whose steps are equal angles, are not. So an image is cut into
 * pieces of 64 x 64 to 8 x 8 pixels, whose tangents are linear to 1/8 pixel; where even 8 x 8 are
 * not, since a scanner's angles are rough, to 1/4 pixel. Each piece has an axis and rays of its
 * own, by least squares. Where 8 x 8 pixels have no rays at all, the points that are farthest off
 * are taken out of the image, one by one, until the others have. Threads: one maker. */
#ifndef STP_PREPROCESS_GRID_DEPTH_RAYS_H
#define STP_PREPROCESS_GRID_DEPTH_RAYS_H

#include "formats/chunk/codec/square/square.h"
#include "preprocess/orient/pixel_image.h"

/* Rays of a piece: a point whose depth, along `axis` from the station, is h lies at station +
 * h (tilt[k][0] + column tilt[k][1] + row tilt[k][2]) along axis (axis + 1 + k) % 3. */
typedef struct stp_depth_rays {
    stp_dvec3 station;
    unsigned axis;
    uint32_t first[2], side; /* of the piece: column and row, both columns and rows */
    double sign;             /* of depths */
    double tilt[2][3];
} stp_depth_rays;

/* The rays of a square that has no points. */
#define STP_DEPTH_NO_RAYS UINT32_MAX

/* Rays of images, piece by piece. */
typedef struct stp_depth_pieces {
    stp_depth_rays *rays;
    uint32_t *of_square; /* by image and square of 8 x 8 pixels, row by row: its rays */
    size_t count, capacity, square_count, square_capacity;
} stp_depth_pieces;

/* Squares along so many columns or rows. */
static inline uint32_t stp_depth_squares(uint32_t pixels)
{
    return (pixels - 1) / STP_SQUARE_SIDE + 1;
}

/* Appends the rays of an image, and takes points that are on none out of it. *found: whether few
 * were. *turned: whether, as the points are seen, rows turn left to columns. Errors: OUT_OF_MEMORY.
 */
stp_status stp_depth_pieces_add(stp_depth_pieces *pieces, const stp_cloud *cloud,
                                stp_pixel_image *image, bool *found, bool *turned, stp_error *err);
void stp_depth_pieces_clear(stp_depth_pieces *pieces);

/* A point relative to the station, axes in order from the rays' axis on. */
void stp_depth_see(const stp_depth_rays *rays, stp_dvec3 position, double out[3]);
/* The longer side of a pixel, at a place that stp_depth_see told, across its ray. */
double stp_depth_pixel_side(const stp_depth_rays *rays, const double seen[3]);

/* Squares are numbered with 32 bits. Errors: LIMIT. */
stp_status stp_depth_squares_check(size_t count, stp_error *err);

#endif

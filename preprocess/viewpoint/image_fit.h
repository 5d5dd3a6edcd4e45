/* Finds the camera of a scan whose points are the pixels of an image.
 *
 * With an eye given: if the image is a camera's, one projective map takes rays to pixels. The map
 * is fitted by least squares. Without an eye, the image may have parallel rays: positions are then
 * linear in column, row and depth. At most STP_IMAGE_PIXELS pixels are used. Threads: any (the
 * cloud is only read). */
#ifndef STP_PREPROCESS_VIEWPOINT_IMAGE_FIT_H
#define STP_PREPROCESS_VIEWPOINT_IMAGE_FIT_H

#include "formats/scan/scan.h"
#include "preprocess/cloud/cloud.h"
#include "preprocess/ranks/ranks.h"
#include "preprocess/viewpoint/first_camera.h"

#define STP_IMAGE_PIXELS 16384u

/* The points of one file in the order of their places, in a cloud that is not sorted yet. */
typedef struct stp_file_points {
    const stp_cloud *cloud;
    uint64_t begin, end;
    uint64_t first_place; /* of the file's first record, stored or not */
    bool pixels_told;     /* by the cloud's pixels */
    stp_ranks *ranks; /* NULL: all points are here; else each rank has some, one after the other */
} stp_file_points;

/* A point's place in the cloud, and its pixel. */
typedef struct stp_grid_point {
    uint64_t at;
    uint32_t column, row;
} stp_grid_point;

/* A point and its pixel. x goes from -1 to 1 along columns, y along rows. */
typedef struct stp_pixel {
    double x, y;
    stp_dvec3 position;
} stp_pixel;

typedef struct stp_file_image {
    stp_pixel *pixels;
    uint32_t count, columns, rows;
} stp_file_image;

/* A map between rays and pixels. axes: the third points forwards. to_pixel: from tangents to
 * pixels; to_ray: back. */
typedef struct stp_image_map {
    stp_dvec3 axes[3];
    double to_pixel[3][3], to_ray[3][3];
    double fitting; /* share of the pixels that the map meets to within one pixel */
} stp_image_map;

/* The first place of a run whose point is not from an earlier record than `source`; end if there is
 * none. */
uint64_t stp_find_source(const stp_cloud *cloud, uint64_t begin, uint64_t end, uint64_t source);
/* How many indices stp_grid_find takes. */
uint64_t stp_grid_count(const stp_file_points *points, const stp_scan_grid *grid);
/* Finds the i-th point and its pixel. False if the point is not stored or has no pixel. The grid
 * has columns. */
bool stp_grid_find(stp_grid_point *out, const stp_file_points *points, const stp_scan_grid *grid,
                   uint64_t i);
/* Makes the image. The grid has columns. Errors: OUT_OF_MEMORY. */
stp_status stp_file_image_create(stp_file_image *out, const stp_file_points *points,
                                 const stp_scan_grid *grid, stp_error *err);
void stp_file_image_clear(stp_file_image *image);
/* The best map from an eye. fitting is 0 if there is none. */
stp_image_map stp_image_fit(const stp_file_image *image, stp_dvec3 eye);
/* The view from the eye through the whole image. Up is against the rows; if that gives a mirror
 * image, along them. The camera looks at a point as far as the middle half of the points. */
stp_first_camera stp_image_view_from(const stp_file_image *image, const stp_image_map *map,
                                     stp_dvec3 eye);
/* The view along parallel rays that shows the points. Its side is the one towards which the middle
 * of the image bulges, since surfaces turn away at outlines. False if the rays are not parallel. */
bool stp_image_view_along(const stp_file_image *image, stp_first_camera *out);

#endif

/* The camera of a scan whose points are the pixels of an image.
 *
 * From a given eye, one projective map takes rays to pixels if the image is a camera's; the map is
 * fitted by least squares. Without an eye, an image whose rays are parallel is looked for: then
 * positions are linear in column, row and depth. At most STP_IMAGE_PIXELS pixels are looked at.
 * Threads: any (the cloud is only read). */
#ifndef STP_PREPROCESS_VIEWPOINT_IMAGE_FIT_H
#define STP_PREPROCESS_VIEWPOINT_IMAGE_FIT_H

#include "formats/scan/scan.h"
#include "preprocess/cloud/cloud.h"
#include "preprocess/viewpoint/first_camera.h"

#define STP_IMAGE_PIXELS 16384u

/* Points of one file, in the order of their places: of a cloud that is not sorted yet. */
typedef struct stp_file_points {
    const stp_cloud *cloud;
    uint32_t begin, end;
    uint64_t first_place; /* of the file's first record, stored or not */
} stp_file_points;

/* A point's place in the cloud, and its pixel. */
typedef struct stp_grid_point {
    uint32_t at, column, row;
} stp_grid_point;

/* A point and its pixel: from -1 to 1 across the image, columns to x, rows to y. */
typedef struct stp_pixel {
    double x, y;
    stp_dvec3 position;
} stp_pixel;

typedef struct stp_image {
    stp_pixel *pixels;
    uint32_t count, columns, rows;
} stp_image;

/* Of a map to pixels: its axes, the third one forwards, and the way from pixels to tangents. */
typedef struct stp_image_map {
    stp_dvec3 axes[3];
    double to_pixel[3][3], to_ray[3][3];
    double fitting; /* share of the pixels that it meets to within one pixel */
} stp_image_map;

/* The first place of a run whose point is not of an earlier record; end if there is none. */
uint32_t stp_find_source(const stp_cloud *cloud, uint32_t begin, uint32_t end, uint64_t source);
/* What stp_grid_find counts. */
uint32_t stp_grid_count(const stp_file_points *points, const stp_scan_grid *grid);
/* False if the i-th one is not stored, or has no pixel. The grid has columns. */
bool stp_grid_find(stp_grid_point *out, const stp_file_points *points, const stp_scan_grid *grid,
                   uint32_t i);
/* The grid has columns. Errors: OUT_OF_MEMORY. */
stp_status stp_image_create(stp_image *out, const stp_file_points *points,
                            const stp_scan_grid *grid, stp_error *err);
void stp_image_clear(stp_image *image);
/* The best map from an eye; fitting is 0 if there is none. */
stp_image_map stp_image_fit(const stp_image *image, stp_dvec3 eye);
/* The view from the eye through the whole image; up is against the rows or, where that would be a
 * mirror's image, along them. It looks at a point as far as the middle half of the points. */
stp_first_camera stp_image_view_from(const stp_image *image, const stp_image_map *map,
                                     stp_dvec3 eye);
/* The view along parallel rays that shows the points; from the side towards which the middle of the
 * image bulges, since surfaces turn away at outlines. False if rays are not parallel. */
bool stp_image_view_along(const stp_image *image, stp_first_camera *out);

#endif

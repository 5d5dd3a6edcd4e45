/* Depth cameras' images whose pixels are points of a cloud, and how far neighbours lie off each
 * other's surface.
 *
 * A depth camera's error grows with the square of the distance, as that of a disparity does.
 * Threads: any (the cloud is only read). */
#ifndef STP_PREPROCESS_ORIENT_PIXEL_IMAGE_H
#define STP_PREPROCESS_ORIENT_PIXEL_IMAGE_H

#include "preprocess/cloud/cloud.h"

struct stp_prep_source;

#define STP_PIXEL_NONE UINT64_MAX

typedef struct stp_pixel_image {
    stp_dvec3 station;
    uint64_t first, count; /* its records */
    bool told;             /* the cloud's pixels say which pixel a record is; else its place does */
    uint32_t columns, rows; /* columns is 0 if no point of the cloud is in the image */
    bool has_points;
    uint32_t *points; /* by pixel, row by row: the point (stp_pixel_point), its low bits */
    uint8_t *high;    /* and those above; NULL: no place of the cloud has any */
} stp_pixel_image;

/* The images of a source. */
typedef struct stp_pixel_images {
    stp_pixel_image *list; /* in the order of records */
    size_t count;
    uint32_t *points; /* of all images, in the cloud's spill */
    uint8_t *high;    /* likewise, or NULL */
    uint64_t point_count;
} stp_pixel_images;

/* Lists the images that one station saw each and whose pixels are their files' records, from record
 * `first` on, without points. Errors: OUT_OF_MEMORY. */
stp_status stp_pixel_images_list(stp_pixel_images *images, const struct stp_prep_source *source,
                                 uint64_t first, stp_error *err);
/* Gives the listed images pixels without points, for places of a cloud. Errors: OUT_OF_MEMORY, IO.
 */
stp_status stp_pixel_images_room(stp_pixel_images *images, const stp_cloud *cloud, stp_error *err);
/* The image that a point belongs to, or NULL: the last one that begins no later than its record. */
stp_pixel_image *stp_pixel_image_of(const stp_pixel_images *images, const stp_cloud_point *point);
/* Lists the images as above, and finds the points of a cloud in them. If several points fall into
 * one pixel, the first record has it. Errors: OUT_OF_MEMORY, IO. Free with stp_pixel_images_clear.
 */
stp_status stp_pixel_images_create(stp_pixel_images *out, const stp_cloud *cloud,
                                   const struct stp_prep_source *source, stp_error *err);
void stp_pixel_images_clear(stp_pixel_images *images, const stp_cloud *cloud);

static inline uint64_t stp_pixel_count(const stp_pixel_image *image)
{
    return (uint64_t)image->columns * image->rows;
}

/* The point of a pixel, or STP_PIXEL_NONE. */
static inline uint64_t stp_pixel_point(const stp_pixel_image *image, uint64_t pixel)
{
    const uint32_t low = image->points[pixel];
    const uint8_t high = image->high ? image->high[pixel] : low == UINT32_MAX ? UINT8_MAX : 0;
    return low == UINT32_MAX && high == UINT8_MAX ? STP_PIXEL_NONE : (uint64_t)high << 32 | low;
}

static inline void stp_pixel_set(const stp_pixel_image *image, uint64_t pixel, uint64_t point)
{
    image->points[pixel] = (uint32_t)point;
    if (image->high)
        image->high[pixel] = (uint8_t)(point >> 32);
}

/* Of pair i of an image: the point *a of pixel i / 2, and the one so many pixels to the right of
 * it, or below it, which is returned. STP_PIXEL_NONE if one of them is not. */
uint64_t stp_pixel_pair(const stp_pixel_image *image, uint64_t i, uint32_t pixels, uint64_t *a);
/* How far two points are off each other's plane, by the square of the distance to the camera. */
double stp_pixel_step(const stp_cloud *cloud, const stp_pixel_image *image, uint64_t a, uint64_t b);
/* The greatest step between neighbours on one surface, as far as the image's noise tells. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_pixel_step_most(double *out, const stp_cloud *cloud, const stp_pixel_image *image,
                               stp_error *err);

#endif

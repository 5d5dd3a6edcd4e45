/* Images of a cloud that ranks share: each image belongs to one rank, which gets its points from
 * their owners. Images follow each other from rank to rank. Threads: the main thread; all ranks
 * call the same functions. */
#ifndef STP_PREPROCESS_ORIENT_PIXEL_SHARE_H
#define STP_PREPROCESS_ORIENT_PIXEL_SHARE_H

#include "preprocess/orient/pixel_image.h"
#include "preprocess/ranks/ranks.h"

/* The points of this rank's images. */
typedef struct stp_pixel_share {
    stp_cloud own;         /* points, sheets and marks, in any order; else nothing is known */
    uint32_t *places;      /* by point of it: its place in the whole cloud, the low bits */
    uint8_t *high;         /* and those above; NULL: no place has any */
    const stp_cloud *seen; /* what to look for images in: own, or the cloud if it is not shared */
} stp_pixel_share;

/* Errors: OUT_OF_MEMORY, IO, CANCELLED. Borrows the cloud. Free with stp_pixel_share_clear. */
stp_status stp_pixel_share_create(stp_pixel_share *out, const stp_cloud *cloud,
                                  const struct stp_prep_source *source, stp_error *err);
void stp_pixel_share_clear(stp_pixel_share *share);

/* The place in the whole cloud of a point of `own`. */
static inline uint64_t stp_pixel_share_place(const stp_pixel_share *share, uint64_t point)
{
    return (share->high ? (uint64_t)share->high[point] << 32 : 0) | share->places[point];
}

/* The rank that an image belongs to. */
unsigned stp_pixel_image_rank(const stp_pixel_images *images, const stp_pixel_image *image,
                              const stp_ranks *ranks);

#endif

/* Gives depth images to all ranks, after each rank has cut its own (pixel_share.h). Threads: the
 * main thread. */
#ifndef STP_PREPROCESS_GRID_DEPTH_SHARE_H
#define STP_PREPROCESS_GRID_DEPTH_SHARE_H

#include "preprocess/grid/depth_image.h"
#include "preprocess/orient/pixel_share.h"

/* cloud: the whole one. Gives every rank the cameras, pieces and squares of all images, and of each
 * pixel the place of its point in the whole cloud. *extents: by square. Errors: OUT_OF_MEMORY, IO,
 * CANCELLED, LIMIT. */
stp_status stp_depth_images_share(stp_depth_images *images, stp_leaf_extent **extents,
                                  const stp_pixel_share *share, const stp_cloud *cloud,
                                  stp_error *err);

#endif

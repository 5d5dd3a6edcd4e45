/* Keeps open what depth images leave open (--holes grow): no disc of an image covers the ray of a
 * pixel without a sample. Threads: one maker. */
#ifndef STP_PREPROCESS_GRID_DEPTH_HOLES_H
#define STP_PREPROCESS_GRID_DEPTH_HOLES_H

#include "preprocess/grid/depth_image.h"

/* Notes the holes of all images, which stay where they are. Points that are in no image are not
 * limited. Errors: OUT_OF_MEMORY. */
stp_status stp_depth_images_keep_open(stp_depth_images *images, stp_error *err);
/* Limits the discs of samples of an image, and keeps them apart from those of other images. */
void stp_depth_keep_open(const stp_depth_images *images, uint32_t image, stp_item *items,
                         uint32_t count);

#endif

/* Images in and out through OpenImageIO: 8-bit RGBA and float planes, top row first.
 * Threads: any, one image each. */
#ifndef STP_FORMATS_IMAGE_IMAGE_H
#define STP_FORMATS_IMAGE_IMAGE_H

#include "base/error.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct stp_image {
    int width, height;
    uint8_t *rgba; /* width * height * 4, top row first, straight alpha */
} stp_image;

/* Any format OpenImageIO reads, converted to 8-bit RGBA (alpha 255 where absent). Errors:
 * NOT_FOUND, FORMAT, CORRUPT, OUT_OF_MEMORY. */
stp_status stp_image_load(stp_image *out, const char *path, stp_error *err);
/* Format by the name's ending (png, tif, jpg, exr). Appears whole or not at all. Errors: EXISTS,
 * IO, UNSUPPORTED. */
stp_status stp_image_save(const stp_image *image, const char *path, bool force, stp_error *err);
void stp_image_destroy(stp_image *image);

#endif

/* Images in and out through OpenImageIO: 8-bit RGBA in and out, floats out; top row first.
 * Threads: any, one image each. */
#ifndef STP_FORMATS_IMAGE_IMAGE_H
#define STP_FORMATS_IMAGE_IMAGE_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
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

/* A text kept with an image. */
typedef struct stp_image_note {
    const char *name, *text;
} stp_image_note;

#define STP_IMAGE_CHANNELS_LIMIT 4

/* Measurements, not colours; all borrowed. */
typedef struct stp_float_image {
    int width, height, channel_count; /* 1 to STP_IMAGE_CHANNELS_LIMIT */
    const char *channel_names[STP_IMAGE_CHANNELS_LIMIT];
    const float *values; /* width * height * channel_count, top row first */
    const stp_image_note *notes;
    size_t note_count;
} stp_float_image;

/* True for a name that stp_image_save_floats takes: one that ends in .exr. */
bool stp_image_keeps_floats(const char *path);
/* As 32-bit floats without loss (EXR, ZIP), with the notes as attributes. Appears whole or not at
 * all. Errors: EXISTS, IO, UNSUPPORTED (a name that is no .exr). */
stp_status stp_image_save_floats(const stp_float_image *image, const char *path, bool force,
                                 stp_error *err);

#endif

/* Reads and writes images, PNG by libpng, others through OpenImageIO: 8-bit RGBA both ways, floats
 * only out; top row first. Threads: any, one image each. */
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

/* Loads any format that OpenImageIO reads, converted to 8-bit RGBA (alpha 255 if absent). Errors:
 * NOT_FOUND, FORMAT, CORRUPT, OUT_OF_MEMORY. */
stp_status stp_image_load(stp_image *out, const char *path, stp_error *err);
/* One channel of floats, the only one or that named Z, depth or height, read row by row. Zero is
 * closed. */
typedef struct stp_height_image {
    int width, height;
    struct stp_oiio_heights *image;
    const char *path;
    float *band;
    int band_rows, band_begin, band_end; /* rows that were read together */
} stp_height_image;

/* path must outlive the image. Errors: as stp_image_load. */
stp_status stp_height_image_open(stp_height_image *out, const char *path, stp_error *err);
/* *values: the row's, until the next call. Rows in any order; going down is fastest. Errors:
 * CORRUPT. */
stp_status stp_height_image_read(stp_height_image *image, int row, const float **values,
                                 stp_error *err);
void stp_height_image_close(stp_height_image *image);
/* Saves in the format of the name's ending (png, tif, jpg, exr), over black if the format has no
 * alpha. The file appears whole or not at all. Errors: EXISTS, IO, UNSUPPORTED. */
stp_status stp_image_save(const stp_image *image, const char *path, bool force, stp_error *err);
void stp_image_destroy(stp_image *image);

/* A text that is stored with an image. */
typedef struct stp_image_note {
    const char *name, *text;
} stp_image_note;

#define STP_IMAGE_CHANNELS_LIMIT 4

/* Measurements instead of colours. All pointers are borrowed. */
typedef struct stp_float_image {
    int width, height, channel_count; /* 1 to STP_IMAGE_CHANNELS_LIMIT */
    const char *channel_names[STP_IMAGE_CHANNELS_LIMIT];
    const float *values; /* width * height * channel_count, top row first */
    const stp_image_note *notes;
    size_t note_count;
} stp_float_image;

/* True if stp_image_save_floats takes the name: it ends in .exr. */
bool stp_image_keeps_floats(const char *path);
/* Saves 32-bit floats without loss (EXR, ZIP), with the notes as attributes. The file appears whole
 * or not at all. Errors: EXISTS, IO, UNSUPPORTED (the name does not end in .exr). */
stp_status stp_image_save_floats(const stp_float_image *image, const char *path, bool force,
                                 stp_error *err);

#endif

/* PNG by libpng, without the module of OpenImageIO: its libraries take most of a second to load,
 * and nearly every picture is a PNG. Threads: any, one image each. */
#ifndef STP_FORMATS_IMAGE_PNG_FILE_H
#define STP_FORMATS_IMAGE_PNG_FILE_H

#include "formats/image/image.h"

/* True if the name ends in .png. */
bool stp_png_is_named(const char *path);
/* Whether a file begins as a PNG does. descriptor: open for reading. */
bool stp_png_is_file(int descriptor);
/* Loads any kind of PNG as 8-bit RGBA, straight alpha. Errors: CORRUPT, OUT_OF_MEMORY. */
stp_status stp_png_load(stp_image *out, const char *path, stp_error *err);
/* Errors: as stp_image_save. */
stp_status stp_png_save(const stp_image *image, const char *path, bool force, stp_error *err);

#endif

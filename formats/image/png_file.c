/* Reads and writes PNG through libpng's simplified calls. */
#include "formats/image/png_file.h"

#include "base/file.h"
#include "base/memory.h"

#include <png.h>

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

bool stp_png_is_named(const char *path)
{
    return stp_path_ends_in(path, ".png");
}

bool stp_png_is_file(int descriptor)
{
    static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    uint8_t found[sizeof signature];
    return pread(descriptor, found, sizeof found, 0) == (ssize_t)sizeof found &&
           memcmp(found, signature, sizeof found) == 0;
}

stp_status stp_png_load(stp_image *out, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    png_image png = {.version = PNG_IMAGE_VERSION};
    stp_image image = {0};
    if (!png_image_begin_read_from_file(&png, path)) {
        status = stp_error_set(err, STP_CORRUPT, "%s: the image is damaged: %s", path, png.message);
        goto done;
    }
    png.format = PNG_FORMAT_RGBA;
    png.flags |=
        PNG_IMAGE_FLAG_16BIT_sRGB; /* 16 bits hold no linear light unless the file says so */
    image.width = (int)png.width;
    image.height = (int)png.height;
    STP_TRY(stp_alloc(&image.rgba, (uint64_t)png.width * png.height, 4, "the image", err));
    if (!png_image_finish_read(&png, NULL, image.rgba, 0, NULL)) {
        status = stp_error_set(err, STP_CORRUPT, "%s: the image is damaged: %s", path, png.message);
        goto done;
    }
    *out = image;
    image.rgba = NULL;
done:
    free(image.rgba);
    png_image_free(&png);
    return status;
}

stp_status stp_png_save(const stp_image *image, const char *path, bool force, stp_error *err)
{
    stp_status status = STP_OK;
    stp_output *output = NULL;
    uint8_t *bytes = NULL;
    png_image png = {.version = PNG_IMAGE_VERSION,
                     .width = (png_uint_32)image->width,
                     .height = (png_uint_32)image->height,
                     .format = PNG_FORMAT_RGBA};
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    STP_TRY(stp_output_create(&output, path, force, err));
    STP_TRY(stp_alloc(&bytes, size, 1, "the image", err));
    if (!png_image_write_to_memory(&png, bytes, &size, 0, image->rgba, 0, NULL)) {
        status = stp_error_set(err, STP_IO, "%s: writing the image failed: %s", path, png.message);
        goto done;
    }
    STP_TRY(stp_output_write(output, bytes, size, err));
    STP_TRY(stp_output_commit(&output, err));
done:
    stp_output_destroy(&output);
    free(bytes);
    png_image_free(&png);
    return status;
}

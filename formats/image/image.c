/* Images in and out. */
#include "formats/image/image.h"

#include "base/file.h"
#include "formats/image/image_module.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

stp_status stp_image_load(stp_image *out, const char *path, stp_error *err)
{
    char reason[256] = "";
    uint64_t size = 0;
    int descriptor = -1;
    stp_image image = {0};
    stp_image_module module;
    stp_status status = stp_file_open(path, &descriptor, &size, err);
    if (status != STP_OK)
        return status;
    close(descriptor);
    status = stp_image_module_get(&module, err);
    if (status != STP_OK)
        return status;
    switch (module.load(path, &image.width, &image.height, &image.rgba, reason, sizeof reason)) {
    case STP_OIIO_OK:
        *out = image;
        return STP_OK;
    case STP_OIIO_NO_MEMORY:
        return stp_error_set(err, STP_OUT_OF_MEMORY, "%s: no memory for the image", path);
    case STP_OIIO_UNKNOWN_FORMAT:
        return stp_error_set(err, STP_FORMAT, "%s is not an image that can be read: %s", path,
                             reason);
    case STP_OIIO_DISK_FULL:
    case STP_OIIO_DAMAGED:
    case STP_OIIO_FAILED:
        break;
    }
    return stp_error_set(err, STP_CORRUPT, "%s: the image is damaged: %s", path, reason);
}

/* What the library says of an output, for the user. */
static stp_status check_saved(stp_oiio_result result, const char *path, const char *use,
                              const char *reason, stp_error *err)
{
    if (result == STP_OIIO_UNKNOWN_FORMAT)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: no image format of that ending can be written: use %s", path,
                             use);
    if (result == STP_OIIO_DISK_FULL)
        return stp_error_set(err, STP_IO,
                             "%s: the disk is full: free some space or write elsewhere", path);
    if (result != STP_OIIO_OK)
        return stp_error_set(err, STP_IO, "%s: writing the image failed: %s", path, reason);
    return STP_OK;
}

stp_status stp_image_save(const stp_image *image, const char *path, bool force, stp_error *err)
{
    char reason[256] = "";
    stp_output *output = NULL;
    stp_status status = STP_OK;
    stp_image_module module;
    STP_TRY(stp_image_module_get(&module, err));
    STP_TRY(stp_output_create(&output, path, force, err));
    stp_oiio_result result = module.save(stp_output_temporary_path(output), path, image->width,
                                         image->height, image->rgba, reason, sizeof reason);
    STP_TRY(check_saved(result, path, ".png", reason, err));
    STP_TRY(stp_output_commit(&output, err));
done:
    stp_output_destroy(&output);
    return status;
}

bool stp_image_keeps_floats(const char *path)
{
    size_t length = strlen(path);
    return length > 4 && strcasecmp(path + length - 4, ".exr") == 0;
}

stp_status stp_image_save_floats(const stp_float_image *image, const char *path, bool force,
                                 stp_error *err)
{
    char reason[256] = "";
    stp_output *output = NULL;
    stp_status status = STP_OK;
    stp_image_module module;
    if (!stp_image_keeps_floats(path))
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: depths and normals are floats: give a name that ends in .exr",
                             path);
    STP_TRY(stp_image_module_get(&module, err));
    STP_TRY(stp_output_create(&output, path, force, err));
    stp_oiio_result result =
        module.save_floats(stp_output_temporary_path(output), path, image, reason, sizeof reason);
    STP_TRY(check_saved(result, path, ".exr", reason, err));
    STP_TRY(stp_output_commit(&output, err));
done:
    stp_output_destroy(&output);
    return status;
}

void stp_image_destroy(stp_image *image)
{
    free(image->rgba);
    *image = (stp_image){0};
}

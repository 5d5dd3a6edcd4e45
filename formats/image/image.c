/* Reads and writes images. */
#include "formats/image/image.h"

#include "base/file.h"
#include "base/memory.h"
#include "formats/image/image_module.h"
#include "formats/image/png_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#define MEMORY_NAME_BYTES 32

/* Converts the library's result for an input to a message for the user. */
static stp_status check_loaded(stp_oiio_result result, const char *path, const char *reason,
                               stp_error *err)
{
    switch (result) {
    case STP_OIIO_OK:
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
    bool is_png = stp_png_is_file(descriptor);
    close(descriptor);
    if (is_png)
        return stp_png_load(out, path, err);
    status = stp_image_module_get(&module, err);
    if (status != STP_OK)
        return status;
    stp_oiio_result result =
        module.load(path, &image.width, &image.height, &image.rgba, reason, sizeof reason);
    status = check_loaded(result, path, reason, err);
    if (status == STP_OK)
        *out = image;
    return status;
}

stp_status stp_height_image_open(stp_height_image *out, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    char reason[256] = "";
    stp_image_module module;
    stp_height_image image = {.path = path};
    STP_TRY(stp_image_module_get(&module, err));
    STP_TRY(check_loaded(module.open_heights(&image.image, path, &image.width, &image.height,
                                             &image.band_rows, reason, sizeof reason),
                         path, reason, err));
    image.band_rows = image.band_rows < image.height ? image.band_rows : image.height;
    STP_TRY(stp_alloc(&image.band, (size_t)image.band_rows * (size_t)image.width,
                      sizeof *image.band, "rows of an image", err));
    *out = image;
    image = (stp_height_image){0};
done:
    stp_height_image_close(&image);
    return status;
}

stp_status stp_height_image_read(stp_height_image *image, int row, const float **values,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    char reason[256] = "";
    stp_image_module module;
    if (row < image->band_begin || row >= image->band_end) {
        const int begin = row / image->band_rows * image->band_rows;
        const int end =
            begin + image->band_rows < image->height ? begin + image->band_rows : image->height;
        STP_TRY(stp_image_module_get(&module, err));
        STP_TRY(check_loaded(
            module.read_heights(image->image, begin, end, image->band, reason, sizeof reason),
            image->path, reason, err));
        image->band_begin = begin;
        image->band_end = end;
    }
    *values = image->band + (size_t)(row - image->band_begin) * (size_t)image->width;
done:
    return status;
}

void stp_height_image_close(stp_height_image *image)
{
    stp_image_module module;
    if (image->image != NULL && stp_image_module_get(&module, NULL) == STP_OK)
        module.close_heights(image->image);
    free(image->band);
    *image = (stp_height_image){0};
}

/* Converts the library's result for an output to a message for the user. */
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

/* The library writes to memory, because some formats' own writers end the process on a full disk.
 * That memory becomes the output. *memory: a nameless file, -1 before. */
static stp_status open_memory(int *memory, char name[MEMORY_NAME_BYTES], const char *path,
                              stp_error *err)
{
    *memory = memfd_create("image", MFD_CLOEXEC);
    if (*memory < 0)
        return stp_error_set(err, STP_IO, "%s: no memory to write the image in: %s", path,
                             strerror(errno));
    snprintf(name, MEMORY_NAME_BYTES, "/proc/self/fd/%d", *memory);
    return STP_OK;
}

static stp_status keep_memory(int memory, const char *path, bool force, stp_error *err)
{
    stp_status status = STP_OK;
    stp_output *output = NULL;
    struct stat info;
    uint8_t block[16384];
    STP_TRY(stp_output_create(&output, path, force, err));
    if (fstat(memory, &info) != 0) {
        status =
            stp_error_set(err, STP_IO, "%s: writing the image failed: %s", path, strerror(errno));
        goto done;
    }
    for (off_t at = 0; at < info.st_size; at += (off_t)sizeof block) {
        const off_t left = info.st_size - at;
        const size_t part = left < (off_t)sizeof block ? (size_t)left : sizeof block;
        STP_TRY(stp_file_read_at(memory, path, (uint64_t)at, block, part, err));
        STP_TRY(stp_output_write(output, block, part, err));
    }
    STP_TRY(stp_output_commit(&output, err));
done:
    stp_output_destroy(&output);
    return status;
}

stp_status stp_image_save(const stp_image *image, const char *path, bool force, stp_error *err)
{
    char reason[256] = "", name[MEMORY_NAME_BYTES];
    int memory = -1;
    stp_status status = STP_OK;
    stp_image_module module;
    if (stp_png_is_named(path))
        return stp_png_save(image, path, force, err);
    STP_TRY(stp_image_module_get(&module, err));
    STP_TRY(open_memory(&memory, name, path, err));
    stp_oiio_result result =
        module.save(name, path, image->width, image->height, image->rgba, reason, sizeof reason);
    STP_TRY(check_saved(result, path, ".png", reason, err));
    STP_TRY(keep_memory(memory, path, force, err));
done:
    if (memory >= 0)
        close(memory);
    return status;
}

bool stp_image_keeps_floats(const char *path)
{
    return stp_path_ends_in(path, ".exr");
}

stp_status stp_image_save_floats(const stp_float_image *image, const char *path, bool force,
                                 stp_error *err)
{
    char reason[256] = "", name[MEMORY_NAME_BYTES];
    int memory = -1;
    stp_status status = STP_OK;
    stp_image_module module;
    if (!stp_image_keeps_floats(path))
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: depths and normals are floats: give a name that ends in .exr",
                             path);
    STP_TRY(stp_image_module_get(&module, err));
    STP_TRY(open_memory(&memory, name, path, err));
    stp_oiio_result result = module.save_floats(name, path, image, reason, sizeof reason);
    STP_TRY(check_saved(result, path, ".exr", reason, err));
    STP_TRY(keep_memory(memory, path, force, err));
done:
    if (memory >= 0)
        close(memory);
    return status;
}

void stp_image_destroy(stp_image *image)
{
    free(image->rgba);
    *image = (stp_image){0};
}

/* Reads Alicona's AL3D: a line of magic, then tags of 52 bytes (a name of 20, a value of 30, CR
 * LF), then an image of depths in metres, float32, and one of texture in planes of 8 bits. All is
 * little endian. Rows are padded to 8 bytes. (As read by Gwyddion and by SurfaceTopography.) */
#include "base/file.h"
#include "base/memory.h"
#include "formats/scan/grid/raster.h"
#include "formats/scan/grid/raster_numbers.h"
#include "formats/scan/number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MAGIC_BYTES = 17, TAG_BYTES = 52, NAME_BYTES = 20, VALUE_BYTES = 30, TAGS_LIMIT = 1000 };

typedef struct al3d_raster {
    const char *path;
    int descriptor;
    bool opened, floats;
    uint64_t begin, plane_bytes, stride;
    uint32_t width, channels;
    unsigned char *row;
} al3d_raster;

/* The numbers of the tags that are needed; NaN: not there. */
typedef struct al3d_tags {
    double columns, rows, depth, texture, dx, dy, none, planes, count;
} al3d_tags;

static void keep_tag(al3d_tags *tags, const char *name, const char *value)
{
    const struct {
        const char *name;
        double *out;
    } known[] = {
        {"Cols", &tags->columns},           {"Rows", &tags->rows},
        {"DepthImageOffset", &tags->depth}, {"TextureImageOffset", &tags->texture},
        {"PixelSizeXMeter", &tags->dx},     {"PixelSizeYMeter", &tags->dy},
        {"InvalidPixelValue", &tags->none}, {"NumberOfPlanes", &tags->planes},
        {"TagCount", &tags->count},
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strcmp(name, known[i].name) == 0)
            (void)stp_number_parse(value, value + strlen(value), known[i].out);
}

static stp_status read_tags(const al3d_raster *a, al3d_tags *tags, stp_error *err)
{
    stp_status status = STP_OK;
    tags->count = 2.0; /* until it is read: Version and TagCount come first */
    for (unsigned i = 0; i < TAGS_LIMIT && (double)i < tags->count + 2.0; i++) {
        char tag[TAG_BYTES], name[NAME_BYTES + 1], value[VALUE_BYTES + 1];
        STP_TRY(stp_file_read_at(a->descriptor, a->path, MAGIC_BYTES + (uint64_t)i * TAG_BYTES, tag,
                                 sizeof tag, err));
        if (tag[TAG_BYTES - 2] != '\r' || tag[TAG_BYTES - 1] != '\n')
            break; /* the tags end */
        snprintf(name, sizeof name, "%.*s", NAME_BYTES, tag);
        snprintf(value, sizeof value, "%.*s", VALUE_BYTES, tag + NAME_BYTES);
        keep_tag(tags, name, value);
    }
done:
    return status;
}

static uint64_t padded(uint64_t bytes)
{
    return (bytes + 7) / 8 * 8;
}

static stp_status open_al3d(void *state, stp_raster_info *info, const char *path,
                            stp_raster_use use, uint32_t step, stp_error *err)
{
    al3d_raster *a = state;
    stp_status status = STP_OK;
    uint64_t size = 0;
    al3d_tags tags = {NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN};
    const bool colours = use == STP_RASTER_COLOURS;
    (void)step;
    a->path = path;
    STP_TRY(stp_file_open(path, &a->descriptor, &size, err));
    a->opened = true;
    STP_TRY(read_tags(a, &tags, err));
    const double offset = colours ? tags.texture : tags.depth;
    if (!stp_raster_is_side(tags.columns) || !stp_raster_is_side(tags.rows) || !(tags.dx > 0.0) ||
        !(tags.dy > 0.0))
        return stp_error_set(
            err, STP_CORRUPT,
            "%s: its header has no sound Cols, Rows and PixelSize: export it again", path);
    if (!(offset >= MAGIC_BYTES) || !(offset < 1e15))
        return stp_error_set(err, STP_UNSUPPORTED, "%s has no image of %s: export it with one",
                             path, colours ? "colours" : "depths");
    a->begin = (uint64_t)offset;
    a->floats = !colours;
    a->width = (uint32_t)tags.columns;
    a->channels = !colours ? 1 : tags.planes >= 3.0 ? 3 : 1;
    a->stride = padded((uint64_t)a->width * (colours ? 1 : 4));
    a->plane_bytes = a->stride * (uint64_t)tags.rows;
    if (a->begin + a->channels * a->plane_bytes > size)
        return stp_error_set(err, STP_CORRUPT, "%s ends early: copy or export it again", path);
    STP_TRY(stp_alloc(&a->row, a->stride, 1, "a row of an image", err));
    *info = (stp_raster_info){.format = "AL3D",
                              .width = a->width,
                              .height = (uint32_t)tags.rows,
                              .channels = a->channels,
                              .floats = !colours,
                              .full = colours ? 255.0 : 1.0,
                              .has_none = !colours && !isnan(tags.none),
                              .none = (double)(float)tags.none,
                              .spaced = true,
                              .dx = tags.dx,
                              .dy = tags.dy};
done:
    return status;
}

static stp_status read_al3d(void *state, uint32_t row, double *values, stp_error *err)
{
    al3d_raster *a = state;
    stp_status status = STP_OK;
    for (uint32_t k = 0; k < a->channels; k++) {
        STP_TRY(stp_file_read_at(a->descriptor, a->path,
                                 a->begin + k * a->plane_bytes + row * a->stride, a->row, a->stride,
                                 err));
        for (uint32_t i = 0; i < a->width; i++)
            values[i * a->channels + k] =
                a->floats ? stp_raster_float(a->row + 4 * i, true) : a->row[i];
    }
done:
    return status;
}

static void close_al3d(void *state)
{
    al3d_raster *a = state;
    if (a->opened)
        close(a->descriptor);
    free(a->row);
}

const stp_raster_reader stp_raster_al3d = {
    .state_bytes = sizeof(al3d_raster), .open = open_al3d, .read = read_al3d, .close = close_al3d};

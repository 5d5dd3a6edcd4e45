/* Opens images of numbers of any format. */
#include "formats/scan/grid/raster.h"

#include "base/file.h"
#include "base/memory.h"

#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

struct stp_raster_file {
    stp_raster_info info;
    const stp_raster_reader *reader;
    void *state;
    const char *path;
    uint32_t next; /* row */
};

/* How files begin that may hold heights. reader NULL: the module of TIFF. Case counts, but in ESRI
 * ASCII grids, which may begin with spaces. */
typedef struct raster_kind {
    const char *magic;
    size_t length;
    const stp_raster_reader *reader;
} raster_kind;

static const raster_kind kinds[] = {
    {"II*\0", 4, NULL},
    {"MM\0*", 4, NULL},
    {"II+\0", 4, NULL},
    {"MM\0+", 4, NULL},
    {"\x89PNG\r\n", 6, &stp_raster_png},
    {"Pf\n", 3, &stp_raster_pnm},
    {"Pf ", 3, &stp_raster_pnm},
    {"Pf\r", 3, &stp_raster_pnm},
    {"P5\n", 3, &stp_raster_pnm},
    {"P5 ", 3, &stp_raster_pnm},
    {"P5\r", 3, &stp_raster_pnm},
    {"P2\n", 3, &stp_raster_pnm},
    {"P2 ", 3, &stp_raster_pnm},
    {"P2\r", 3, &stp_raster_pnm},
    {"ncols", 5, &stp_raster_esri},
    {"nrows", 5, &stp_raster_esri},
    {"DSAA", 4, &stp_raster_surfer},
    {"DSBB", 4, &stp_raster_surfer},
    {"DSRB", 4, &stp_raster_surfer},
    {"AliconaImaging", 14, &stp_raster_al3d},
    {"\x76\x2f\x31\x01", 4, &stp_raster_image}, /* EXR */
};
enum { KIND_COUNT = sizeof kinds / sizeof *kinds };

static bool begins(const raster_kind *kind, const char *bytes, size_t length)
{
    const bool is_esri = kind->reader == &stp_raster_esri;
    for (; is_esri && length > 0 && (*bytes == ' ' || *bytes == '\t'); length--)
        bytes++;
    return length >= kind->length && (is_esri ? strncasecmp(bytes, kind->magic, kind->length)
                                              : memcmp(bytes, kind->magic, kind->length)) == 0;
}

/* KIND_COUNT: no kind of these. */
static size_t find_kind(const char *bytes, size_t length)
{
    size_t i = 0;
    while (i < KIND_COUNT && !begins(&kinds[i], bytes, length))
        i++;
    return i;
}

bool stp_raster_may_hold_heights(const char *bytes, size_t length)
{
    return find_kind(bytes, length) < KIND_COUNT;
}

/* Loads the module through the program's run path, once, and keeps it. */
static stp_status load_tiff(const stp_raster_reader **out, stp_error *err)
{
    void *module = dlopen("libstipple-tiff.so", RTLD_NOW | RTLD_LOCAL);
    *out = module != NULL ? dlsym(module, "stp_raster_tiff") : NULL;
    if (*out != NULL)
        return STP_OK;
    return stp_error_set(err, STP_UNSUPPORTED,
                         "TIFF cannot be read: %s: install stipple anew, or libtiff", dlerror());
}

static stp_status check_info(const stp_raster_file *r, stp_error *err)
{
    const stp_raster_info *info = &r->info;
    if (info->width == 0 || info->height == 0 || info->width > STP_RASTER_SIDE_LIMIT ||
        info->height > STP_RASTER_SIDE_LIMIT)
        return stp_error_set(err, STP_LIMIT, "%s is %u x %u: at most %u x %u are read", r->path,
                             info->width, info->height, STP_RASTER_SIDE_LIMIT,
                             STP_RASTER_SIDE_LIMIT);
    if (info->channels == 0 || info->channels > STP_RASTER_CHANNELS_LIMIT)
        return stp_error_set(err, STP_UNSUPPORTED, "%s has %u channels: images of 1 to %u are read",
                             r->path, info->channels, STP_RASTER_CHANNELS_LIMIT);
    return STP_OK;
}

stp_status stp_raster_open(stp_raster_file **out, const char *path, stp_raster_use use,
                           uint32_t step, stp_error *err)
{
    stp_status status = STP_OK;
    stp_raster_file *r = NULL;
    int descriptor = -1;
    uint64_t size = 0;
    char begin[16];
    STP_TRY(stp_file_open(path, &descriptor, &size, err));
    const size_t length = size < sizeof begin ? (size_t)size : sizeof begin;
    STP_TRY(stp_file_read_at(descriptor, path, 0, begin, length, err));
    STP_TRY(stp_alloc(&r, 1, sizeof *r, "an image", err));
    r->path = path;
    r->info.full = 1.0;
    const size_t kind = find_kind(begin, length);
    r->reader = kind < KIND_COUNT               ? kinds[kind].reader
                : stp_raster_is_named(path)     ? &stp_raster_hgt
                : stp_raster_is_raw(path, size) ? &stp_raster_raw
                                                : &stp_raster_image;
    if (r->reader == NULL)
        STP_TRY(load_tiff(&r->reader, err));
    STP_TRY(stp_alloc(&r->state, 1, r->reader->state_bytes, "an image", err));
    STP_TRY(r->reader->open(r->state, &r->info, path, use, step, err));
    STP_TRY(check_info(r, err));
    r->info.reduced = r->info.reduced > 0 ? r->info.reduced : 1;
    *out = r;
    r = NULL;
done:
    if (descriptor >= 0)
        close(descriptor);
    stp_raster_close(&r);
    return status;
}

const stp_raster_info *stp_raster_get_info(const stp_raster_file *raster)
{
    return &raster->info;
}

stp_status stp_raster_read(stp_raster_file *r, uint32_t row, double *values, stp_error *err)
{
    stp_status status = STP_OK;
    for (r->next = r->reader->each ? r->next : row; r->next <= row; r->next++)
        STP_TRY(r->reader->read(r->state, r->next, values, err));
done:
    return status;
}

void stp_raster_close(stp_raster_file **raster)
{
    stp_raster_file *r = *raster;
    if (r == NULL)
        return;
    if (r->reader != NULL && r->state != NULL)
        r->reader->close(r->state);
    free(r->state);
    free(r);
    *raster = NULL;
}

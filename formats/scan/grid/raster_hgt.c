/* Reads HGT, the tiles of SRTM: rows of 16-bit integers, big-endian, the top row first, and nothing
 * else. The size tells how many; the name tells the south-western corner in degrees (N47E008.hgt).
 * Samples lie on the tile's edges, too, so that tiles share a row or column. */
#include "base/file.h"
#include "base/memory.h"
#include "formats/scan/grid/raster.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define WGS_84 4326u
#define NO_HEIGHT (-32768.0)

/* Far from the equator, columns may lie farther apart than rows. */
static const uint32_t sizes[][2] = {
    {1201, 1201}, {3601, 3601}, {1801, 3601}, {601, 1201}, {1201, 3601}};
enum { SIZE_COUNT = sizeof sizes / sizeof *sizes };

typedef struct hgt_raster {
    const char *path;
    int descriptor;
    uint32_t width;
    unsigned char *row;
} hgt_raster;

bool stp_raster_is_named(const char *path)
{
    return stp_path_ends_in(path, ".hgt");
}

/* A letter and so many digits; false if there is something else. */
static bool read_angle(const char *text, char positive, char negative, int digits, double *out)
{
    const char sign = (char)toupper((unsigned char)text[0]);
    double value = 0.0;
    for (int i = 1; i <= digits; i++) {
        if (text[i] < '0' || text[i] > '9')
            return false;
        value = 10.0 * value + (text[i] - '0');
    }
    *out = sign == negative ? -value : value;
    return sign == positive || sign == negative;
}

/* The corner that the name tells, as in N47E008 or n47_e008; a part of it would be no place. */
static void find_place(const char *path, stp_raster_info *info)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    double north, east;
    if (strlen(name) < 7 || !read_angle(name, 'N', 'S', 2, &north) ||
        !read_angle(name + 3 + (name[3] == '_'), 'E', 'W', 3, &east))
        return;
    info->placed = info->degrees = info->spaced = true;
    info->epsg = WGS_84;
    info->x = east;
    info->y = north + 1.0;
    info->dx = 1.0 / (info->width - 1);
    info->dy = 1.0 / (info->height - 1);
}

static stp_status open_hgt(void *state, stp_raster_info *info, const char *path, stp_raster_use use,
                           uint32_t step, stp_error *err)
{
    hgt_raster *h = state;
    stp_status status = STP_OK;
    uint64_t size = 0;
    size_t i = 0;
    (void)use;
    (void)step;
    h->descriptor = -1;
    h->path = path;
    STP_TRY(stp_file_open(path, &h->descriptor, &size, err));
    while (i < SIZE_COUNT && size != 2ull * sizes[i][0] * sizes[i][1])
        i++;
    if (i == SIZE_COUNT)
        return stp_error_set(err, STP_CORRUPT,
                             "%s has %llu bytes, and an HGT tile of 1201 x 1201 heights has "
                             "2884802, one of 3601 x 3601 has 25934402: copy it again, or convert "
                             "it to GeoTIFF (gdal_translate)",
                             path, (unsigned long long)size);
    *info = (stp_raster_info){.format = "HGT",
                              .width = sizes[i][0],
                              .height = sizes[i][1],
                              .channels = 1,
                              .full = 65535.0,
                              .has_none = true,
                              .none = NO_HEIGHT};
    find_place(path, info);
    h->width = info->width;
    status = stp_alloc(&h->row, h->width, 2, "a row of heights", err);
done:
    return status;
}

static stp_status read_hgt(void *state, uint32_t row, double *values, stp_error *err)
{
    hgt_raster *h = state;
    stp_status status = STP_OK;
    STP_TRY(
        stp_file_read_at(h->descriptor, h->path, 2ull * row * h->width, h->row, 2 * h->width, err));
    for (uint32_t i = 0; i < h->width; i++)
        values[i] = (int16_t)(h->row[2 * i] << 8 | h->row[2 * i + 1]);
done:
    return status;
}

static void close_hgt(void *state)
{
    hgt_raster *h = state;
    if (h->descriptor >= 0)
        close(h->descriptor);
    free(h->row);
}

const stp_raster_reader stp_raster_hgt = {
    .state_bytes = sizeof(hgt_raster), .open = open_hgt, .read = read_hgt, .close = close_hgt};

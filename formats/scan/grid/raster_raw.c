/* Reads height maps without a header, as game engines and their terrain programs exchange them: a
 * square of 16-bit integers (.r16, .raw) or of floats (.r32), the top row first. The size tells how
 * many. Of the two byte orders of integers it is the one with which neighbours differ less. */
#include "base/file.h"
#include "base/memory.h"
#include "formats/scan/grid/raster.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define SIDE_LEAST 33u /* fewer are no landscape */

typedef struct raw_raster {
    const char *path;
    int descriptor;
    uint32_t width;
    unsigned bytes; /* of a number */
    bool swapped;   /* the high byte is first */
    unsigned char *row;
} raw_raster;

/* Bytes of a number by the file's name; 0: it is none of these. */
static unsigned bytes_of(const char *path)
{
    if (stp_path_ends_in(path, ".r32"))
        return 4;
    return stp_path_ends_in(path, ".r16") || stp_path_ends_in(path, ".raw") ? 2 : 0;
}

/* 0: it is no square. */
static uint32_t side_of(uint64_t size, unsigned bytes)
{
    const uint64_t count = bytes > 0 && size % bytes == 0 ? size / bytes : 0;
    if (count > UINT64_C(1) << 48)
        return 0;
    const uint64_t side = (uint64_t)llround(sqrt((double)count));
    return side >= SIDE_LEAST && side * side == count ? (uint32_t)side : 0;
}

bool stp_raster_is_raw(const char *path, uint64_t size)
{
    return side_of(size, bytes_of(path)) > 0;
}

static unsigned number_at(const unsigned char *bytes, bool swapped)
{
    return swapped ? (unsigned)(bytes[0] << 8 | bytes[1]) : (unsigned)(bytes[1] << 8 | bytes[0]);
}

static stp_status read_bytes(raw_raster *r, uint32_t row, stp_error *err)
{
    const size_t bytes = (size_t)r->width * r->bytes;
    return stp_file_read_at(r->descriptor, r->path, (uint64_t)row * bytes, r->row, bytes, err);
}

/* Looks at eight rows. */
static stp_status find_order(raw_raster *r, stp_error *err)
{
    enum { ROWS = 8 };
    stp_status status = STP_OK;
    double steps[2] = {0.0, 0.0};
    for (uint32_t k = 0; k < ROWS; k++) {
        STP_TRY(read_bytes(r, k * (r->width - 1) / (ROWS - 1), err));
        for (uint32_t i = 1; i < r->width; i++)
            for (int swapped = 0; swapped < 2; swapped++)
                steps[swapped] += fabs((double)number_at(r->row + 2 * (size_t)i, swapped) -
                                       number_at(r->row + 2 * (size_t)(i - 1), swapped));
    }
    r->swapped = steps[1] < steps[0];
done:
    return status;
}

static stp_status open_raw(void *state, stp_raster_info *info, const char *path, stp_raster_use use,
                           uint32_t step, stp_error *err)
{
    raw_raster *r = state;
    stp_status status = STP_OK;
    uint64_t size = 0;
    (void)use;
    (void)step;
    r->descriptor = -1;
    r->path = path;
    r->bytes = bytes_of(path);
    STP_TRY(stp_file_open(path, &r->descriptor, &size, err));
    r->width = side_of(size, r->bytes);
    *info = (stp_raster_info){.format = "raw numbers",
                              .width = r->width,
                              .height = r->width,
                              .channels = 1,
                              .floats = r->bytes == 4,
                              .full = r->bytes == 4 ? 1.0 : 65535.0};
    STP_TRY(stp_alloc(&r->row, r->width, r->bytes, "a row of heights", err));
    if (r->bytes == 2)
        STP_TRY(find_order(r, err));
done:
    return status;
}

static stp_status read_raw(void *state, uint32_t row, double *values, stp_error *err)
{
    raw_raster *r = state;
    stp_status status = STP_OK;
    STP_TRY(read_bytes(r, row, err));
    for (uint32_t i = 0; i < r->width && r->bytes == 2; i++)
        values[i] = number_at(r->row + 2 * (size_t)i, r->swapped);
    for (uint32_t i = 0; i < r->width && r->bytes == 4; i++) {
        float number;
        memcpy(&number, r->row + 4 * (size_t)i, sizeof number);
        values[i] = (double)number;
    }
done:
    return status;
}

static void close_raw(void *state)
{
    raw_raster *r = state;
    if (r->descriptor >= 0)
        close(r->descriptor);
    free(r->row);
}

const stp_raster_reader stp_raster_raw = {
    .state_bytes = sizeof(raw_raster), .open = open_raw, .read = read_raw, .close = close_raw};

/* Writes and reads rasters of cameras. */
#include "formats/chunk/codec/square/camera_raster.h"

#include "formats/chunk/layout.h"

#include <math.h>
#include <string.h>

/* The first byte: bits 0-1 are the axis, 2 and 3 are set, 4-7 say which slopes are not 0. Then come
 * the station, 3 numbers of 3 bytes; f32 d_1, d_2, and these slopes; u16 column, row. */
#define SLOPE_BIT 4u
#define SLOPES 4u
#define SHORT_BYTES 3u
#define FLOAT_BYTES 4u
#define PLACE_BYTES 4u
#define PLACES (UINT32_C(1) << 16)
#define BYTES_LEAST (1 + 3 * SHORT_BYTES + 2 * FLOAT_BYTES + PLACE_BYTES)

/* What a camera's raster follows from. */
typedef struct camera {
    double station[3];    /* along the axis, then across it */
    double middle[2];     /* tangents of the ray at column and row 0 */
    double slope[SLOPES]; /* of these by column and row */
} camera;

static void find_across(const camera *c, double across[2][6])
{
    for (unsigned k = 0; k < 2; k++) {
        across[k][0] = c->station[1 + k] - c->station[0] * c->middle[k];
        across[k][3] = c->middle[k];
        for (unsigned i = 0; i < 2; i++) {
            const double slope = c->slope[2 * k + i];
            across[k][1 + i] = (double)(float)(0.0 - c->station[0] * slope);
            across[k][4 + i] = slope;
        }
    }
}

/* The camera that a raster may be of. */
static camera camera_of(const stp_raster *raster)
{
    const double(*a)[6] = raster->across;
    camera c = {.middle = {a[0][3], a[1][3]}, .slope = {a[0][4], a[0][5], a[1][4], a[1][5]}};
    double greatest = 0.0;
    for (unsigned i = 0; i < SLOPES; i++)
        if (fabs(c.slope[i]) > greatest) {
            greatest = fabs(c.slope[i]);
            c.station[0] = stp_raster_short(-a[i / 2][1 + i % 2] / c.slope[i]);
        }
    for (unsigned k = 0; k < 2; k++)
        c.station[1 + k] = stp_raster_short(a[k][0] + c.station[0] * c.middle[k]);
    return c;
}

static bool is_of(const stp_raster *raster, const camera *c)
{
    double across[2][6];
    find_across(c, across);
    for (unsigned k = 0; k < 2; k++)
        for (unsigned i = 0; i < 6; i++)
            if (across[k][i] != raster->across[k][i] ||
                (i > 2 && (double)(float)across[k][i] != across[k][i]))
                return false;
    return true;
}

static uint8_t *put_float(double number, unsigned left_out, uint8_t *to)
{
    uint8_t bytes[FLOAT_BYTES];
    stp_put_floats(bytes, (const float[1]){(float)number}, 1);
    memcpy(to, bytes + left_out, FLOAT_BYTES - left_out);
    return to + FLOAT_BYTES - left_out;
}

size_t stp_camera_raster_put(const stp_raster *raster, const stp_square *first, uint8_t *to)
{
    uint8_t *const begin = to++;
    if (!stp_raster_spreads(raster) || first->column >= PLACES || first->row >= PLACES)
        return 0;
    const camera c = camera_of(raster);
    if (!is_of(raster, &c))
        return 0;
    *begin = (uint8_t)(raster->axis | STP_CAMERA_RASTER);
    for (unsigned i = 0; i < 3; i++)
        to = put_float(c.station[i], 1, to);
    for (unsigned k = 0; k < 2; k++)
        to = put_float(c.middle[k], 0, to);
    for (unsigned i = 0; i < SLOPES; i++)
        if (c.slope[i] != 0.0) {
            *begin |= (uint8_t)(1u << (SLOPE_BIT + i));
            to = put_float(c.slope[i], 0, to);
        }
    stp_put_u16(to, (uint16_t)first->column);
    stp_put_u16(to + 2, (uint16_t)first->row);
    return (size_t)(to + PLACE_BYTES - begin);
}

static double get_float(const uint8_t **from, unsigned left_out)
{
    uint8_t bytes[FLOAT_BYTES] = {0};
    float number;
    memcpy(bytes + left_out, *from, FLOAT_BYTES - left_out);
    *from += FLOAT_BYTES - left_out;
    stp_get_floats(bytes, &number, 1);
    return (double)number;
}

size_t stp_camera_raster_get(const uint8_t *bytes, size_t left, stp_raster *raster,
                             stp_square *first)
{
    const unsigned kind = *bytes, slopes = kind >> SLOPE_BIT;
    const size_t size = BYTES_LEAST + FLOAT_BYTES * (size_t)__builtin_popcount(slopes);
    const uint8_t *next = bytes + 1;
    camera c = {.station = {0.0}};
    if (size > left)
        return 0;
    for (unsigned i = 0; i < 3; i++)
        c.station[i] = get_float(&next, 1);
    for (unsigned k = 0; k < 2; k++)
        c.middle[k] = get_float(&next, 0);
    for (unsigned i = 0; i < SLOPES; i++)
        if (slopes >> i & 1u)
            c.slope[i] = get_float(&next, 0);
    *raster = (stp_raster){.axis = kind & 3u};
    find_across(&c, raster->across);
    first->column = stp_get_u16(next);
    first->row = stp_get_u16(next + 2);
    return size;
}

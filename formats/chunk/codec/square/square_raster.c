/* Writes and reads rasters: the four forms of SPEC.md, "Rasters". */
#include "formats/chunk/codec/square/square_raster.h"

#include "formats/chunk/codec/square/camera_raster.h"
#include "formats/chunk/layout.h"

#include <string.h>

/* A level raster: f64 x, y, dx, dy; u32 column, row of the first square */
#define LEVEL_BYTES 40u
/* A tilted one: u8 axis, 2 f64, 6 f32, 2 u32 column, row of its first square */
#define TILTED_BYTES 49u
/* One that spreads has this bit beside its axis, and four floats more before column and row. */
#define SPREADS 4u
#define SPREAD_BYTES 16u
/* One whose numbers are short has this bit, and 2 f32, 6 numbers of 3 bytes, 2 u8 instead. With
 * both bits it is a camera's (camera_raster.h). */
#define SHORT 8u
#define SHORT_BYTES 29u
#define SHORT_PLACES 256u

/* ---- writing: each returns the bytes ---- */

static size_t put_level(const stp_raster *r, const stp_square *first, uint8_t *to)
{
    const double numbers[4] = {r->across[0][0], r->across[1][0], r->across[0][1], r->across[1][2]};
    for (unsigned i = 0; i < 4; i++)
        stp_put_f64(to + 8 * i, numbers[i]);
    stp_put_u32(to + 32, first->column);
    stp_put_u32(to + 36, first->row);
    return LEVEL_BYTES;
}

static bool is_short(const stp_raster *r, const stp_square *first)
{
    for (unsigned k = 0; k < 2; k++) {
        if ((double)(float)r->across[k][0] != r->across[k][0])
            return false;
        for (unsigned i = 1; i < 4; i++)
            if (stp_raster_short(r->across[k][i]) != r->across[k][i])
                return false;
    }
    return !stp_raster_spreads(r) && first->column < SHORT_PLACES && first->row < SHORT_PLACES;
}

static size_t put_short(const stp_raster *r, const stp_square *first, uint8_t *to)
{
    *to++ = (uint8_t)(r->axis | SHORT);
    for (unsigned k = 0; k < 2; k++) {
        for (unsigned i = 0; i < 4; i++) {
            const unsigned left_out = i > 0;
            uint8_t bytes[4];
            stp_put_floats(bytes, (const float[1]){(float)r->across[k][i]}, 1);
            memcpy(to, bytes + left_out, 4 - left_out);
            to += 4 - left_out;
        }
    }
    to[0] = (uint8_t)first->column;
    to[1] = (uint8_t)first->row;
    return SHORT_BYTES;
}

static size_t put_tilted(const stp_raster *r, const stp_square *first, uint8_t *to)
{
    const bool spreads = stp_raster_spreads(r);
    *to++ = (uint8_t)(r->axis | (spreads ? SPREADS : 0));
    for (unsigned k = 0; k < 2; k++, to += 20) {
        const float slopes[3] = {(float)r->across[k][1], (float)r->across[k][2],
                                 (float)r->across[k][3]};
        stp_put_f64(to, r->across[k][0]);
        stp_put_floats(to + 8, slopes, 3);
    }
    for (unsigned k = 0; spreads && k < 2; k++, to += 8)
        stp_put_floats(to, (const float[2]){(float)r->across[k][4], (float)r->across[k][5]}, 2);
    stp_put_u32(to, first->column);
    stp_put_u32(to + 4, first->row);
    return TILTED_BYTES + (spreads ? SPREAD_BYTES : 0);
}

size_t stp_raster_put(const stp_raster *raster, const stp_square *first, uint8_t *out)
{
    const size_t camera = raster->level ? 0 : stp_camera_raster_put(raster, first, out);
    return camera > 0                ? camera
           : raster->level           ? put_level(raster, first, out)
           : is_short(raster, first) ? put_short(raster, first, out)
                                     : put_tilted(raster, first, out);
}

/* ---- reading ---- */

static stp_raster get_level(const uint8_t *bytes)
{
    return (stp_raster){.level = true,
                        .axis = 2,
                        .across = {{stp_get_f64(bytes), stp_get_f64(bytes + 16)},
                                   {stp_get_f64(bytes + 8), 0.0, stp_get_f64(bytes + 24)}}};
}

static stp_raster get_tilted(const uint8_t *bytes)
{
    const bool spreads = *bytes & SPREADS;
    stp_raster out = {.axis = *bytes++ & ~SPREADS};
    for (unsigned k = 0; k < 2; k++, bytes += 20) {
        float slopes[3];
        out.across[k][0] = stp_get_f64(bytes);
        stp_get_floats(bytes + 8, slopes, 3);
        for (unsigned i = 0; i < 3; i++)
            out.across[k][1 + i] = (double)slopes[i];
    }
    for (unsigned k = 0; spreads && k < 2; k++, bytes += 8) {
        float spread[2];
        stp_get_floats(bytes, spread, 2);
        out.across[k][4] = (double)spread[0];
        out.across[k][5] = (double)spread[1];
    }
    return out;
}

static stp_raster get_short(const uint8_t *bytes)
{
    stp_raster out = {.axis = *bytes++ & ~SHORT};
    for (unsigned k = 0; k < 2; k++)
        for (unsigned i = 0; i < 4; i++) {
            const unsigned left_out = i > 0;
            uint8_t all[4] = {0};
            float number;
            memcpy(all + left_out, bytes, 4 - left_out);
            stp_get_floats(all, &number, 1);
            out.across[k][i] = (double)number;
            bytes += 4 - left_out;
        }
    return out;
}

size_t stp_raster_get(const uint8_t *bytes, size_t left, bool tilted, stp_raster *raster,
                      stp_square *first)
{
    const uint8_t kind = tilted && left > 0 ? *bytes : 0;
    const size_t size = !tilted          ? LEVEL_BYTES
                        : kind & SHORT   ? SHORT_BYTES
                        : kind & SPREADS ? TILTED_BYTES + SPREAD_BYTES
                                         : TILTED_BYTES;
    if ((kind & STP_CAMERA_RASTER) == STP_CAMERA_RASTER)
        return stp_camera_raster_get(bytes, left, raster, first);
    if (size > left)
        return 0;
    *raster = !tilted ? get_level(bytes) : kind & SHORT ? get_short(bytes) : get_tilted(bytes);
    const uint8_t *end = bytes + size;
    first->column = kind & SHORT ? end[-2] : stp_get_u32(end - 8);
    first->row = kind & SHORT ? end[-1] : stp_get_u32(end - 4);
    return size;
}

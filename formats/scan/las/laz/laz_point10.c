/* Codes LAZ's POINT10, the 20 bytes that all points of formats 0 to 5 begin with. */
#include "formats/scan/las/laz/laz_item.h"

#include "formats/scan/las/laz/laz_median.h"

#include <string.h>

/* Places in a record. */
enum { AT_X = 0, AT_Y = 4, AT_Z = 8, AT_INTENSITY = 12, AT_RETURNS = 14, AT_CLASS = 15 };
enum { AT_ANGLE = 16, AT_USER = 17, AT_SOURCE = 18 };

/* ---- version 1 ---- */

typedef struct point10_v1 {
    unsigned char last[STP_LAZ_POINT10_BYTES];
    int32_t x_changes[3], y_changes[3];
    unsigned oldest; /* of the changes */
    stp_laz_integer x, y, z, intensity, angle, source;
    stp_laz_symbols changed, returns[256], classes[256], user[256];
} point10_v1;

static void v1_place(void *state, unsigned bytes, stp_laz_arena *arena)
{
    point10_v1 *s = state;
    (void)bytes;
    stp_laz_integer_place(&s->x, 32, 1, arena);
    stp_laz_integer_place(&s->y, 32, 20, arena);
    stp_laz_integer_place(&s->z, 32, 20, arena);
    stp_laz_integer_place(&s->intensity, 16, 1, arena);
    stp_laz_integer_place(&s->angle, 8, 2, arena);
    stp_laz_integer_place(&s->source, 16, 1, arena);
    stp_laz_symbols_place(&s->changed, 64, arena);
    for (int i = 0; i < 256; i++) {
        stp_laz_symbols_place(&s->returns[i], 256, arena);
        stp_laz_symbols_place(&s->classes[i], 256, arena);
        stp_laz_symbols_place(&s->user[i], 256, arena);
    }
}

static unsigned v1_begin(void *state, const unsigned char *first, unsigned channel)
{
    point10_v1 *s = state;
    memcpy(s->last, first, sizeof s->last);
    memset(s->x_changes, 0, sizeof s->x_changes);
    memset(s->y_changes, 0, sizeof s->y_changes);
    s->oldest = 0;
    return channel;
}

/* As LASzip has it: where numbers are equal, which one is chosen does not matter. */
static int32_t median_of_three(const int32_t v[3])
{
    const int32_t low = v[0] < v[1] ? v[0] : v[1], high = v[0] < v[1] ? v[1] : v[0];
    return v[2] < low ? low : v[2] > high ? high : v[2];
}

static unsigned v1_next(void *state, stp_laz_stream *d, unsigned channel, unsigned char *out)
{
    point10_v1 *s = state;
    unsigned char *p = s->last;
    const int32_t x = stp_laz_decode_integer(d, &s->x, median_of_three(s->x_changes), 0);
    const int32_t y = stp_laz_decode_integer(d, &s->y, median_of_three(s->y_changes),
                                             stp_laz_at_most(s->x.size, 19));
    stp_las_put_u32(p + AT_X, stp_las_u32(p + AT_X) + (uint32_t)x);
    stp_las_put_u32(p + AT_Y, stp_las_u32(p + AT_Y) + (uint32_t)y);
    s->x_changes[s->oldest] = x;
    s->y_changes[s->oldest] = y;
    s->oldest = (s->oldest + 1) % 3;
    const unsigned size = (s->x.size + s->y.size) / 2;
    stp_las_put_u32(p + AT_Z,
                    (uint32_t)stp_laz_decode_integer(d, &s->z, (int32_t)stp_las_u32(p + AT_Z),
                                                     stp_laz_at_most(size, 19)));
    const unsigned changed = stp_laz_decode_symbol(d, &s->changed);
    if (changed & 32)
        stp_las_put_u16(p + AT_INTENSITY, (uint16_t)stp_laz_decode_integer(
                                              d, &s->intensity, stp_las_u16(p + AT_INTENSITY), 0));
    if (changed & 16)
        p[AT_RETURNS] = (unsigned char)stp_laz_decode_symbol(d, &s->returns[p[AT_RETURNS]]);
    if (changed & 8)
        p[AT_CLASS] = (unsigned char)stp_laz_decode_symbol(d, &s->classes[p[AT_CLASS]]);
    if (changed & 4)
        p[AT_ANGLE] = (unsigned char)stp_laz_decode_integer(d, &s->angle, p[AT_ANGLE], size < 3);
    if (changed & 2)
        p[AT_USER] = (unsigned char)stp_laz_decode_symbol(d, &s->user[p[AT_USER]]);
    if (changed & 1)
        stp_las_put_u16(p + AT_SOURCE, (uint16_t)stp_laz_decode_integer(
                                           d, &s->source, stp_las_u16(p + AT_SOURCE), 0));
    memcpy(out, p, sizeof s->last);
    return channel;
}

const stp_laz_coder stp_laz_point10_v1 = {.type = STP_LAZ_POINT10,
                                          .version = 1,
                                          .bytes = STP_LAZ_POINT10_BYTES,
                                          .state_bytes = sizeof(point10_v1),
                                          .place = v1_place,
                                          .begin = v1_begin,
                                          .next = v1_next};

/* ---- version 2 ---- */

#define RETURN_CONTEXTS 16u

typedef struct point10_v2 {
    unsigned char last[STP_LAZ_POINT10_BYTES];
    stp_laz_median x_median[RETURN_CONTEXTS], y_median[RETURN_CONTEXTS];
    uint16_t intensities[RETURN_CONTEXTS];
    int32_t heights[8];
    stp_laz_integer x, y, z, intensity, source;
    stp_laz_symbols changed, angle[2], returns[256], classes[256], user[256];
} point10_v2;

/* Context of a point by number of returns (row) and return number. */
static const uint8_t return_context[8][8] = {
    {15, 14, 13, 12, 11, 10, 9, 8},  {14, 0, 1, 3, 6, 10, 10, 9},
    {13, 1, 2, 4, 7, 11, 11, 10},    {12, 3, 4, 5, 8, 12, 12, 11},
    {11, 6, 7, 8, 9, 13, 13, 12},    {10, 10, 11, 12, 13, 14, 14, 13},
    {9, 10, 11, 12, 13, 14, 15, 14}, {8, 9, 10, 11, 12, 13, 14, 15}};

static void v2_place(void *state, unsigned bytes, stp_laz_arena *arena)
{
    point10_v2 *s = state;
    (void)bytes;
    stp_laz_integer_place(&s->x, 32, 2, arena);
    stp_laz_integer_place(&s->y, 32, 22, arena);
    stp_laz_integer_place(&s->z, 32, 20, arena);
    stp_laz_integer_place(&s->intensity, 16, 4, arena);
    stp_laz_integer_place(&s->source, 16, 1, arena);
    stp_laz_symbols_place(&s->changed, 64, arena);
    stp_laz_symbols_place(&s->angle[0], 256, arena);
    stp_laz_symbols_place(&s->angle[1], 256, arena);
    for (int i = 0; i < 256; i++) {
        stp_laz_symbols_place(&s->returns[i], 256, arena);
        stp_laz_symbols_place(&s->classes[i], 256, arena);
        stp_laz_symbols_place(&s->user[i], 256, arena);
    }
}

static unsigned v2_begin(void *state, const unsigned char *first, unsigned channel)
{
    point10_v2 *s = state;
    memcpy(s->last, first, sizeof s->last);
    stp_las_put_u16(s->last + AT_INTENSITY, 0);
    memset(s->x_median, 0, sizeof s->x_median);
    memset(s->y_median, 0, sizeof s->y_median);
    memset(s->intensities, 0, sizeof s->intensities);
    memset(s->heights, 0, sizeof s->heights);
    return channel;
}

/* Which fields change. */
static unsigned v2_changed(const point10_v2 *s, const unsigned char *item)
{
    const unsigned char *p = s->last;
    const unsigned context = return_context[item[AT_RETURNS] >> 3 & 7][item[AT_RETURNS] & 7];
    return (p[AT_RETURNS] != item[AT_RETURNS] ? 32u : 0u) |
           (s->intensities[context] != stp_las_u16(item + AT_INTENSITY) ? 16u : 0u) |
           (p[AT_CLASS] != item[AT_CLASS] ? 8u : 0u) | (p[AT_ANGLE] != item[AT_ANGLE] ? 4u : 0u) |
           (p[AT_USER] != item[AT_USER] ? 2u : 0u) |
           (memcmp(p + AT_SOURCE, item + AT_SOURCE, 2) != 0 ? 1u : 0u);
}

/* A byte that is coded in the context of the last one. */
static void code_in_context(stp_laz_stream *d, stp_laz_symbols models[256], unsigned char *last,
                            unsigned char value)
{
    *last = (unsigned char)stp_laz_code_symbol(d, &models[*last], value);
}

/* Codes the fields that a point has besides its position. */
static void v2_fields(point10_v2 *s, stp_laz_stream *d, unsigned changed, const unsigned char *item)
{
    unsigned char *p = s->last;
    if (changed & 32)
        code_in_context(d, s->returns, &p[AT_RETURNS], item[AT_RETURNS]);
    const unsigned context = return_context[p[AT_RETURNS] >> 3 & 7][p[AT_RETURNS] & 7];
    if (changed & 16)
        s->intensities[context] = (uint16_t)stp_laz_code_integer(
            d, &s->intensity, s->intensities[context], stp_laz_at_most(context, 3),
            stp_las_u16(item + AT_INTENSITY));
    stp_las_put_u16(p + AT_INTENSITY, s->intensities[context]);
    if (changed & 8)
        code_in_context(d, s->classes, &p[AT_CLASS], item[AT_CLASS]);
    if (changed & 4)
        p[AT_ANGLE] =
            stp_laz_code_byte(d, &s->angle[p[AT_RETURNS] >> 6 & 1], p[AT_ANGLE], item[AT_ANGLE]);
    if (changed & 2)
        code_in_context(d, s->user, &p[AT_USER], item[AT_USER]);
    if (changed & 1)
        stp_las_put_u16(p + AT_SOURCE,
                        (uint16_t)stp_laz_code_integer(d, &s->source, stp_las_u16(p + AT_SOURCE), 0,
                                                       stp_las_u16(item + AT_SOURCE)));
}

static unsigned v2_next(void *state, stp_laz_stream *d, unsigned channel, unsigned char *item)
{
    point10_v2 *s = state;
    unsigned char *p = s->last;
    const unsigned changed =
        stp_laz_code_symbol(d, &s->changed, d->packs ? v2_changed(s, item) : 0);
    if (changed)
        v2_fields(s, d, changed, item);
    const unsigned number = p[AT_RETURNS] & 7, count = p[AT_RETURNS] >> 3 & 7;
    const unsigned context = return_context[count][number];
    const unsigned level = count > number ? count - number : number - count;
    const unsigned single = count == 1;
    stp_laz_code_along(d, &s->x, &s->x_median[context], single, p + AT_X, item + AT_X);
    stp_laz_code_along(d, &s->y, &s->y_median[context],
                       single + stp_laz_at_most(s->x.size & ~1u, 20), p + AT_Y, item + AT_Y);
    const unsigned size = (s->x.size + s->y.size) / 2;
    s->heights[level] =
        stp_laz_code_integer(d, &s->z, s->heights[level], single + stp_laz_at_most(size & ~1u, 18),
                             (int32_t)stp_las_u32(item + AT_Z));
    stp_las_put_u32(p + AT_Z, (uint32_t)s->heights[level]);
    memcpy(item, p, sizeof s->last);
    return channel;
}

const stp_laz_coder stp_laz_point10_v2 = {.type = STP_LAZ_POINT10,
                                          .version = 2,
                                          .bytes = STP_LAZ_POINT10_BYTES,
                                          .packs = true,
                                          .state_bytes = sizeof(point10_v2),
                                          .place = v2_place,
                                          .begin = v2_begin,
                                          .next = v2_next};

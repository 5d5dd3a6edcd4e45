/* Codes LAZ's colours: RGB12, RGB14 and RGBNIR14. */
#include "formats/scan/las/laz/laz_item.h"

#include "formats/scan/las/laz/laz_last.h"

#include <string.h>

#define RGB_BYTES 6u
#define RGBNIR_BYTES 8u

/* ---- models ---- */

typedef struct rgb_models {
    stp_laz_symbols used; /* which bytes change; bit 6: the colour is not grey */
    stp_laz_symbols change[6];
} rgb_models;

static void rgb_place(rgb_models *m, stp_laz_arena *arena)
{
    stp_laz_symbols_place(&m->used, 128, arena);
    for (int i = 0; i < 6; i++)
        stp_laz_symbols_place(&m->change[i], 256, arena);
}

static int clamp_byte(int value)
{
    return value < 0 ? 0 : value > 255 ? 255 : value;
}

/* The low (half 0) or high bytes of green and blue, from what red's byte changed by. */
static void code_rest(rgb_models *m, stp_laz_stream *d, unsigned used, unsigned half,
                      const unsigned char *last, unsigned char *out)
{
    const unsigned char *before = last + half;
    unsigned char *byte = out + half;
    int change = byte[0] - before[0];
    byte[2] = used >> (2 + half) & 1
                  ? stp_laz_code_byte(d, &m->change[2 + half],
                                      (unsigned)clamp_byte(change + before[2]), byte[2])
                  : before[2];
    change = (change + byte[2] - before[2]) / 2;
    byte[4] = used >> (4 + half) & 1
                  ? stp_laz_code_byte(d, &m->change[4 + half],
                                      (unsigned)clamp_byte(change + before[4]), byte[4])
                  : before[4];
}

/* Which bytes of a colour change, and whether it is not grey. */
static unsigned rgb_used(const unsigned char *last, const unsigned char *item)
{
    unsigned used = 0;
    for (unsigned i = 0; i < RGB_BYTES; i++)
        used |= (last[i] != item[i] ? 1u : 0u) << i;
    return used | (memcmp(item, item + 2, 4) != 0 ? 64u : 0u);
}

/* Codes three 16-bit colours from the last point's. item and last do not overlap. */
static void rgb_code(rgb_models *m, stp_laz_stream *d, const unsigned char *last,
                     unsigned char *item)
{
    const unsigned used = stp_laz_code_symbol(d, &m->used, d->packs ? rgb_used(last, item) : 0);
    d->needed |= used != 0;
    for (unsigned half = 0; half < 2; half++)
        item[half] = used >> half & 1
                         ? stp_laz_code_byte(d, &m->change[half], last[half], item[half])
                         : last[half];
    if (used & 64) {
        code_rest(m, d, used, 0, last, item);
        code_rest(m, d, used, 1, last, item);
    } else {
        memcpy(item + 2, item, 2);
        memcpy(item + 4, item, 2);
    }
}

/* ---- RGB12 ---- */

typedef struct rgb12 {
    unsigned char last[RGB_BYTES];
    rgb_models models;
} rgb12;

static void rgb12_place(void *state, unsigned bytes, stp_laz_arena *arena)
{
    rgb12 *s = state;
    (void)bytes;
    rgb_place(&s->models, arena);
}

/* Both versions' states begin with the last colour. */
static unsigned rgb12_begin(void *state, const unsigned char *first, unsigned channel)
{
    memcpy(state, first, RGB_BYTES);
    return channel;
}

static unsigned rgb12_next(void *state, stp_laz_stream *d, unsigned channel, unsigned char *item)
{
    rgb12 *s = state;
    rgb_code(&s->models, d, s->last, item);
    memcpy(s->last, item, sizeof s->last);
    return channel;
}

const stp_laz_coder stp_laz_rgb12_v2 = {.type = STP_LAZ_RGB12,
                                        .version = 2,
                                        .bytes = RGB_BYTES,
                                        .packs = true,
                                        .state_bytes = sizeof(rgb12),
                                        .place = rgb12_place,
                                        .begin = rgb12_begin,
                                        .next = rgb12_next};

/* Version 1 codes each byte as a number near the last point's. */
typedef struct rgb12_v1 {
    unsigned char last[RGB_BYTES];
    stp_laz_symbols used;
    stp_laz_integer value;
} rgb12_v1;

static void rgb1_place(void *state, unsigned bytes, stp_laz_arena *arena)
{
    rgb12_v1 *s = state;
    (void)bytes;
    stp_laz_symbols_place(&s->used, 64, arena);
    stp_laz_integer_place(&s->value, 8, RGB_BYTES, arena);
}

static unsigned rgb1_next(void *state, stp_laz_stream *d, unsigned channel, unsigned char *out)
{
    rgb12_v1 *s = state;
    const unsigned used = stp_laz_decode_symbol(d, &s->used);
    for (unsigned i = 0; i < RGB_BYTES; i++)
        if (used >> i & 1)
            s->last[i] = (unsigned char)stp_laz_decode_integer(d, &s->value, s->last[i], i);
    memcpy(out, s->last, sizeof s->last);
    return channel;
}

const stp_laz_coder stp_laz_rgb12_v1 = {.type = STP_LAZ_RGB12,
                                        .version = 1,
                                        .bytes = RGB_BYTES,
                                        .state_bytes = sizeof(rgb12_v1),
                                        .place = rgb1_place,
                                        .begin = rgb12_begin,
                                        .next = rgb1_next};

/* ---- RGB14 and RGBNIR14 ---- */

typedef struct channel_models {
    rgb_models rgb;
    stp_laz_symbols nir_used, nir_change[2];
} channel_models;

typedef struct rgb14 {
    stp_laz_last last;
    channel_models channels[STP_LAZ_CHANNELS];
} rgb14;

static void rgb14_place(void *state, unsigned bytes, stp_laz_arena *arena)
{
    rgb14 *s = state;
    s->last.bytes = bytes;
    for (unsigned c = 0; c < STP_LAZ_CHANNELS; c++) {
        channel_models *m = &s->channels[c];
        rgb_place(&m->rgb, arena);
        stp_laz_symbols_place(&m->nir_used, 4, arena);
        stp_laz_symbols_place(&m->nir_change[0], 256, arena);
        stp_laz_symbols_place(&m->nir_change[1], 256, arena);
    }
}

static unsigned rgb14_begin(void *state, const unsigned char *first, unsigned channel)
{
    rgb14 *s = state;
    stp_laz_last_begin(&s->last, first, channel);
    return channel;
}

/* The item has the last point's bytes, or those to pack. */
static void nir_code(channel_models *m, stp_laz_stream *d, const unsigned char *last,
                     unsigned char *item)
{
    const unsigned changed = (last[0] != item[0] ? 1u : 0u) | (last[1] != item[1] ? 2u : 0u);
    const unsigned used = stp_laz_code_symbol(d, &m->nir_used, changed);
    d->needed |= used != 0;
    for (unsigned half = 0; half < 2; half++)
        if (used >> half & 1)
            item[half] = stp_laz_code_byte(d, &m->nir_change[half], last[half], item[half]);
}

static void rgb14_next(rgb14 *s, stp_laz_stream *layers, unsigned channel, bool version_3,
                       unsigned char *item)
{
    const unsigned bytes = s->last.bytes;
    unsigned char *last = stp_laz_last_enter(&s->last, channel, version_3);
    channel_models *m = &s->channels[channel];
    if (!layers[0].packs)
        memcpy(item, last, bytes);
    if (layers[0].length > 0)
        rgb_code(&m->rgb, &layers[0], last, item);
    if (bytes == RGBNIR_BYTES && layers[1].length > 0)
        nir_code(m, &layers[1], last + RGB_BYTES, item + RGB_BYTES);
    memcpy(last, item, bytes);
}

static unsigned rgb14_v3_next(void *state, stp_laz_stream *layers, unsigned channel,
                              unsigned char *item)
{
    rgb14_next(state, layers, channel, true, item);
    return channel;
}

static unsigned rgb14_v4_next(void *state, stp_laz_stream *layers, unsigned channel,
                              unsigned char *item)
{
    rgb14_next(state, layers, channel, false, item);
    return channel;
}

#define RGB14_CODER(item_type, item_version, item_bytes, item_layers, item_next)                   \
    {                                                                                              \
        .type = (item_type), .version = (item_version), .bytes = (item_bytes),                     \
        .layers = (item_layers), .packs = true, .state_bytes = sizeof(rgb14),                      \
        .place = rgb14_place, .begin = rgb14_begin, .next = (item_next)                            \
    }
const stp_laz_coder stp_laz_rgb14_v3 = RGB14_CODER(STP_LAZ_RGB14, 3, RGB_BYTES, 1, rgb14_v3_next);
const stp_laz_coder stp_laz_rgb14_v4 = RGB14_CODER(STP_LAZ_RGB14, 4, RGB_BYTES, 1, rgb14_v4_next);
const stp_laz_coder stp_laz_rgbnir14_v3 =
    RGB14_CODER(STP_LAZ_RGBNIR14, 3, RGBNIR_BYTES, 2, rgb14_v3_next);
const stp_laz_coder stp_laz_rgbnir14_v4 =
    RGB14_CODER(STP_LAZ_RGBNIR14, 4, RGBNIR_BYTES, 2, rgb14_v4_next);

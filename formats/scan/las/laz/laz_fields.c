/* Codes the items of LAZ besides points and colours: time, waveform, extra bytes. */
#include "formats/scan/las/laz/laz_item.h"

#include "formats/scan/las/las_bytes.h"
#include "formats/scan/las/laz/laz_last.h"
#include "formats/scan/las/laz/laz_time.h"

#include <string.h>

/* ---- time, version 2 ---- */

static void time2_place(void *state, unsigned bytes, stp_laz_arena *arena)
{
    (void)bytes;
    stp_laz_time_place(state, true, arena);
}

static unsigned time2_begin(void *state, const unsigned char *first, unsigned channel)
{
    stp_laz_time_begin(state, stp_las_u64(first));
    return channel;
}

static unsigned time2_next(void *state, stp_laz_stream *d, unsigned channel, unsigned char *item)
{
    stp_las_put_u64(item, stp_laz_time_next(state, true, d, stp_las_u64(item)));
    return channel;
}

const stp_laz_coder stp_laz_time11_v2 = {.type = STP_LAZ_TIME11,
                                         .version = 2,
                                         .bytes = 8,
                                         .packs = true,
                                         .state_bytes = sizeof(stp_laz_time),
                                         .place = time2_place,
                                         .begin = time2_begin,
                                         .next = time2_next};

/* ---- time, version 1 ---- */

/* Symbols: multiples of the last difference; the last two: a time in full, unchanged. */
#define MULTIPLE_SYMBOLS 512u
#define MULTIPLE_GREATEST (MULTIPLE_SYMBOLS - 3)
#define EXTREMES_LIMIT 3u

typedef struct time1 {
    uint64_t last; /* the bits of a double */
    int32_t difference;
    unsigned extremes; /* differences that no multiple fits */
    stp_laz_symbols multiple, first;
    stp_laz_integer change;
} time1;

static void time1_place(void *state, unsigned bytes, stp_laz_arena *arena)
{
    time1 *s = state;
    (void)bytes;
    stp_laz_symbols_place(&s->multiple, MULTIPLE_SYMBOLS, arena);
    stp_laz_symbols_place(&s->first, 3, arena);
    stp_laz_integer_place(&s->change, 32, 6, arena);
}

static unsigned time1_begin(void *state, const unsigned char *first, unsigned channel)
{
    time1 *s = state;
    s->last = stp_las_u64(first);
    s->difference = 0;
    s->extremes = 0;
    return channel;
}

/* A difference that follows one that was not zero. */
static void time1_multiple(time1 *s, stp_laz_stream *d, unsigned symbol)
{
    const uint32_t product = symbol * (uint32_t)s->difference;
    const int32_t predicted = symbol == 0 ? s->difference / 4 : (int32_t)product;
    const unsigned context = symbol == 0   ? 2
                             : symbol == 1 ? 1
                             : symbol < 10 ? 3
                             : symbol < 50 ? 4
                                           : 5;
    const int32_t difference = stp_laz_decode_integer(d, &s->change, predicted, context);
    const bool extreme = symbol == 0 || symbol == MULTIPLE_GREATEST;
    if (symbol == 1 || (extreme && ++s->extremes > EXTREMES_LIMIT)) {
        s->difference = difference;
        s->extremes = 0;
    }
    s->last += (uint64_t)(int64_t)difference;
}

static unsigned time1_next(void *state, stp_laz_stream *d, unsigned channel, unsigned char *out)
{
    time1 *s = state;
    if (s->difference == 0) {
        const unsigned symbol = stp_laz_decode_symbol(d, &s->first);
        if (symbol == 1) {
            s->difference = stp_laz_decode_integer(d, &s->change, 0, 0);
            s->last += (uint64_t)(int64_t)s->difference;
        } else if (symbol == 2) {
            s->last = stp_laz_decode_u64(d);
        }
    } else {
        const unsigned symbol = stp_laz_decode_symbol(d, &s->multiple);
        if (symbol <= MULTIPLE_GREATEST)
            time1_multiple(s, d, symbol);
        else if (symbol == MULTIPLE_GREATEST + 1)
            s->last = stp_laz_decode_u64(d);
    }
    stp_las_put_u64(out, s->last);
    return channel;
}

const stp_laz_coder stp_laz_time11_v1 = {.type = STP_LAZ_TIME11,
                                         .version = 1,
                                         .bytes = 8,
                                         .state_bytes = sizeof(time1),
                                         .place = time1_place,
                                         .begin = time1_begin,
                                         .next = time1_next};

/* ---- waveform ---- */

/* u8 descriptor, u64 offset, u32 size, then return point, x, y, z: four floats coded as integers.
 */
#define WAVE_BYTES 29u
enum { AT_OFFSET = 1, AT_SIZE = 9, AT_RETURN = 13, AT_DIRECTION = 17 };

typedef struct wave {
    unsigned char last[WAVE_BYTES];
    int32_t offset_change;
    unsigned offset_symbol;
    stp_laz_symbols descriptor, offset_symbols[4];
    stp_laz_integer offset, size, returned, direction;
} wave;

static void wave_place(void *state, unsigned bytes, stp_laz_arena *arena)
{
    wave *s = state;
    (void)bytes;
    stp_laz_symbols_place(&s->descriptor, 256, arena);
    for (int i = 0; i < 4; i++)
        stp_laz_symbols_place(&s->offset_symbols[i], 4, arena);
    stp_laz_integer_place(&s->offset, 32, 1, arena);
    stp_laz_integer_place(&s->size, 32, 1, arena);
    stp_laz_integer_place(&s->returned, 32, 1, arena);
    stp_laz_integer_place(&s->direction, 32, 3, arena);
}

static unsigned wave_begin(void *state, const unsigned char *first, unsigned channel)
{
    wave *s = state;
    memcpy(s->last, first, sizeof s->last);
    s->offset_change = 0;
    s->offset_symbol = 0;
    return channel;
}

static uint64_t wave_offset(wave *s, stp_laz_stream *d)
{
    const uint64_t last = stp_las_u64(s->last + AT_OFFSET);
    s->offset_symbol = stp_laz_decode_symbol(d, &s->offset_symbols[s->offset_symbol]);
    switch (s->offset_symbol) {
    case 0:
        return last;
    case 1:
        return last + stp_las_u32(s->last + AT_SIZE);
    case 2:
        s->offset_change = stp_laz_decode_integer(d, &s->offset, s->offset_change, 0);
        return last + (uint64_t)(int64_t)s->offset_change;
    default:
        return stp_laz_decode_u64(d);
    }
}

static void wave_number(stp_laz_stream *d, stp_laz_integer *m, unsigned char *at, unsigned context)
{
    const int32_t last = (int32_t)stp_las_u32(at);
    stp_las_put_u32(at, (uint32_t)stp_laz_decode_integer(d, m, last, context));
}

static unsigned wave_next(void *state, stp_laz_stream *d, unsigned channel, unsigned char *out)
{
    wave *s = state;
    s->last[0] = (unsigned char)stp_laz_decode_symbol(d, &s->descriptor);
    stp_las_put_u64(s->last + AT_OFFSET, wave_offset(s, d));
    wave_number(d, &s->size, s->last + AT_SIZE, 0);
    wave_number(d, &s->returned, s->last + AT_RETURN, 0);
    for (unsigned i = 0; i < 3; i++)
        wave_number(d, &s->direction, s->last + AT_DIRECTION + 4 * i, i);
    memcpy(out, s->last, sizeof s->last);
    return channel;
}

const stp_laz_coder stp_laz_wave13 = {.type = STP_LAZ_WAVE13,
                                      .version = 1,
                                      .bytes = WAVE_BYTES,
                                      .state_bytes = sizeof(wave),
                                      .place = wave_place,
                                      .begin = wave_begin,
                                      .next = wave_next};

/* ---- extra bytes ---- */

typedef struct extra {
    unsigned count;
    unsigned char last[STP_LAZ_EXTRA_MOST];
    stp_laz_symbols added[STP_LAZ_EXTRA_MOST];
} extra;

static void extra_place(void *state, unsigned bytes, stp_laz_arena *arena)
{
    extra *s = state;
    s->count = bytes;
    for (unsigned i = 0; i < bytes; i++)
        stp_laz_symbols_place(&s->added[i], 256, arena);
}

static unsigned extra_begin(void *state, const unsigned char *first, unsigned channel)
{
    extra *s = state;
    memcpy(s->last, first, s->count);
    return channel;
}

static unsigned extra_next(void *state, stp_laz_stream *d, unsigned channel, unsigned char *item)
{
    extra *s = state;
    for (unsigned i = 0; i < s->count; i++)
        item[i] = s->last[i] = stp_laz_code_byte(d, &s->added[i], s->last[i], item[i]);
    return channel;
}

const stp_laz_coder stp_laz_bytes_v2 = {.type = STP_LAZ_BYTES,
                                        .version = 2,
                                        .bytes_most = STP_LAZ_EXTRA_MOST,
                                        .packs = true,
                                        .state_bytes = sizeof(extra),
                                        .place = extra_place,
                                        .begin = extra_begin,
                                        .next = extra_next};

/* Version 1 codes a byte as a number, with a context of its own. */
typedef struct extra1 {
    unsigned count;
    unsigned char last[STP_LAZ_INTEGER_CONTEXTS];
    stp_laz_integer value;
} extra1;

static void extra1_place(void *state, unsigned bytes, stp_laz_arena *arena)
{
    extra1 *s = state;
    s->count = bytes;
    stp_laz_integer_place(&s->value, 8, bytes, arena);
}

static unsigned extra1_begin(void *state, const unsigned char *first, unsigned channel)
{
    extra1 *s = state;
    memcpy(s->last, first, s->count);
    return channel;
}

static unsigned extra1_next(void *state, stp_laz_stream *d, unsigned channel, unsigned char *out)
{
    extra1 *s = state;
    for (unsigned i = 0; i < s->count; i++)
        out[i] = s->last[i] = (unsigned char)stp_laz_decode_integer(d, &s->value, s->last[i], i);
    return channel;
}

const stp_laz_coder stp_laz_bytes_v1 = {.type = STP_LAZ_BYTES,
                                        .version = 1,
                                        .bytes_most = STP_LAZ_INTEGER_CONTEXTS,
                                        .state_bytes = sizeof(extra1),
                                        .place = extra1_place,
                                        .begin = extra1_begin,
                                        .next = extra1_next};

/* ---- extra bytes of layered files: a layer each ---- */

typedef struct extra14 {
    stp_laz_last last;
    stp_laz_symbols added[STP_LAZ_CHANNELS][STP_LAZ_EXTRA_MOST];
} extra14;

static void extra14_place(void *state, unsigned bytes, stp_laz_arena *arena)
{
    extra14 *s = state;
    s->last.bytes = bytes;
    for (unsigned c = 0; c < STP_LAZ_CHANNELS; c++)
        for (unsigned i = 0; i < bytes; i++)
            stp_laz_symbols_place(&s->added[c][i], 256, arena);
}

static unsigned extra14_begin(void *state, const unsigned char *first, unsigned channel)
{
    extra14 *s = state;
    stp_laz_last_begin(&s->last, first, channel);
    return channel;
}

static void extra14_next(extra14 *s, stp_laz_stream *layers, unsigned channel, bool version_3,
                         unsigned char *item)
{
    unsigned char *last = stp_laz_last_enter(&s->last, channel, version_3);
    for (unsigned i = 0; i < s->last.bytes; i++)
        if (layers[i].length > 0) {
            layers[i].needed |= last[i] != item[i];
            last[i] = stp_laz_code_byte(&layers[i], &s->added[channel][i], last[i], item[i]);
        }
    memcpy(item, last, s->last.bytes);
}

static unsigned extra14_v3_next(void *state, stp_laz_stream *layers, unsigned channel,
                                unsigned char *item)
{
    extra14_next(state, layers, channel, true, item);
    return channel;
}

static unsigned extra14_v4_next(void *state, stp_laz_stream *layers, unsigned channel,
                                unsigned char *item)
{
    extra14_next(state, layers, channel, false, item);
    return channel;
}

#define EXTRA14_CODER(item_version, item_next)                                                     \
    {                                                                                              \
        .type = STP_LAZ_BYTES14, .version = (item_version), .bytes_most = STP_LAZ_EXTRA_MOST,      \
        .layers = 1, .packs = true, .state_bytes = sizeof(extra14), .place = extra14_place,        \
        .begin = extra14_begin, .next = (item_next)                                                \
    }
const stp_laz_coder stp_laz_bytes14_v3 = EXTRA14_CODER(3, extra14_v3_next);
const stp_laz_coder stp_laz_bytes14_v4 = EXTRA14_CODER(4, extra14_v4_next);

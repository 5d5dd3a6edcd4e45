/* Codes LAZ's POINT14, the 30 bytes that all points of formats 6 to 10 begin with. Versions 3 and
 * 4 differ in what the point's other items take for its channel. */
#include "formats/scan/las/laz/laz_item.h"

#include "formats/scan/las/laz/laz_median.h"
#include "formats/scan/las/laz/laz_time.h"

#include <string.h>

/* Places in a record. */
enum { AT_X = 0, AT_Y = 4, AT_Z = 8, AT_INTENSITY = 12, AT_RETURNS = 14, AT_FLAGS = 15 };
enum { AT_CLASS = 16, AT_USER = 17, AT_ANGLE = 18, AT_SOURCE = 20, AT_TIME = 22 };

enum {
    LAYER_RETURNS_XY,
    LAYER_Z,
    LAYER_CLASS,
    LAYER_FLAGS,
    LAYER_INTENSITY,
    LAYER_ANGLE,
    LAYER_USER,
    LAYER_SOURCE,
    LAYER_TIME
};

/* Bits of what changes from point to point; the least two say how the return number does. */
enum { CHANGED_COUNT = 4, CHANGED_ANGLE = 8, CHANGED_TIME = 16, CHANGED_SOURCE = 32 };
enum { CHANGED_CHANNEL = 64 };

/* Bits of AT_FLAGS: 0-3 class flags, 4-5 channel, 6 scan direction, 7 edge of flight line. */
#define CHANNEL_SHIFT 4
#define CHANNEL_BITS (3u << CHANNEL_SHIFT)
#define CLASS_FLAGS 0x0fu

/* What is known of the points of one channel. */
typedef struct channel_state {
    bool used, time_changed; /* of the last point */
    unsigned char last[STP_LAZ_POINT14_BYTES];
    stp_laz_median x_median[12], y_median[12];
    int32_t heights[8];
    uint16_t intensities[8];
    stp_laz_symbols changed[8], channel, counts[16], numbers[16], number_same_time;
    stp_laz_symbols classes[64], flags[64], user[64];
    stp_laz_integer x, y, z, intensity, angle, source;
    stp_laz_time time;
} channel_state;

typedef struct point14 {
    unsigned current;
    channel_state channels[STP_LAZ_CHANNELS];
} point14;

/* A point as contexts see it. */
typedef struct returns {
    unsigned count, number;
    bool time_changed;
    unsigned place; /* among the returns of its pulse: 1 first, 2 last, 3 both, 0 between */
} returns;

static const uint8_t return_context[16][16] = {{0, 1, 2, 3, 4, 5, 3, 4, 4, 5, 5, 5, 5, 5, 5, 5},
                                               {1, 0, 1, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3},
                                               {2, 1, 2, 4, 4, 4, 4, 4, 4, 4, 4, 3, 3, 3, 3, 3},
                                               {3, 3, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4},
                                               {4, 3, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4},
                                               {5, 3, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4},
                                               {3, 3, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4},
                                               {4, 3, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4},
                                               {4, 3, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4},
                                               {5, 3, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4},
                                               {5, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4},
                                               {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 4, 4, 4},
                                               {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4, 4},
                                               {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4},
                                               {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5},
                                               {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5}};
#define HEIGHT_CONTEXT_MOST 7u

static void channel_place(channel_state *c, stp_laz_arena *arena)
{
    for (int i = 0; i < 8; i++)
        stp_laz_symbols_place(&c->changed[i], 128, arena);
    stp_laz_symbols_place(&c->channel, 3, arena);
    for (int i = 0; i < 16; i++) {
        stp_laz_symbols_place(&c->counts[i], 16, arena);
        stp_laz_symbols_place(&c->numbers[i], 16, arena);
    }
    stp_laz_symbols_place(&c->number_same_time, 13, arena);
    for (int i = 0; i < 64; i++) {
        stp_laz_symbols_place(&c->classes[i], 256, arena);
        stp_laz_symbols_place(&c->flags[i], 64, arena);
        stp_laz_symbols_place(&c->user[i], 256, arena);
    }
    stp_laz_integer_place(&c->x, 32, 2, arena);
    stp_laz_integer_place(&c->y, 32, 22, arena);
    stp_laz_integer_place(&c->z, 32, 20, arena);
    stp_laz_integer_place(&c->intensity, 16, 4, arena);
    stp_laz_integer_place(&c->angle, 16, 2, arena);
    stp_laz_integer_place(&c->source, 16, 1, arena);
    stp_laz_time_place(&c->time, false, arena);
}

static void place(void *state, unsigned bytes, stp_laz_arena *arena)
{
    point14 *s = state;
    (void)bytes;
    for (unsigned c = 0; c < STP_LAZ_CHANNELS; c++)
        channel_place(&s->channels[c], arena);
}

/* Begins a channel from the point before it, of whatever channel. */
static void channel_begin(channel_state *c, const unsigned char *point)
{
    c->used = true;
    c->time_changed = false;
    memmove(c->last, point, sizeof c->last);
    memset(c->x_median, 0, sizeof c->x_median);
    memset(c->y_median, 0, sizeof c->y_median);
    for (int i = 0; i < 8; i++) {
        c->heights[i] = (int32_t)stp_las_u32(point + AT_Z);
        c->intensities[i] = stp_las_u16(point + AT_INTENSITY);
    }
    stp_laz_time_begin(&c->time, stp_las_u64(point + AT_TIME));
}

static unsigned channel_of(const unsigned char *item)
{
    return item[AT_FLAGS] >> CHANNEL_SHIFT & 3;
}

static unsigned begin(void *state, const unsigned char *first, unsigned channel)
{
    point14 *s = state;
    (void)channel;
    for (unsigned c = 0; c < STP_LAZ_CHANNELS; c++)
        s->channels[c].used = false;
    s->current = channel_of(first);
    channel_begin(&s->channels[s->current], first);
    return s->current;
}

/* The place among the returns: bit 0 first, bit 1 last. */
static unsigned place_of(unsigned number, unsigned count)
{
    return (number == 1 ? 1u : 0u) | (number >= count ? 2u : 0u);
}

/* To pack a point: what changes from the last one of its channel, or, if it has none, from the
 * last one. Says of each layer whether that needs it. */
static unsigned find_changes(const point14 *s, stp_laz_stream *layers, const unsigned char *item)
{
    const channel_state *own = &s->channels[channel_of(item)];
    const unsigned char *last = own->used ? own->last : s->channels[s->current].last;
    const unsigned count = item[AT_RETURNS] >> 4, last_count = last[AT_RETURNS] >> 4;
    const unsigned step = (unsigned)(item[AT_RETURNS] - last[AT_RETURNS]) & 15;
    const bool angle = memcmp(last + AT_ANGLE, item + AT_ANGLE, 2) != 0;
    const bool source = memcmp(last + AT_SOURCE, item + AT_SOURCE, 2) != 0;
    const bool time = memcmp(last + AT_TIME, item + AT_TIME, 8) != 0;
    layers[LAYER_CLASS].needed |= last[AT_CLASS] != item[AT_CLASS];
    layers[LAYER_FLAGS].needed |= ((last[AT_FLAGS] ^ item[AT_FLAGS]) & ~CHANNEL_BITS) != 0;
    layers[LAYER_INTENSITY].needed |= memcmp(last + AT_INTENSITY, item + AT_INTENSITY, 2) != 0;
    layers[LAYER_ANGLE].needed |= angle;
    layers[LAYER_USER].needed |= last[AT_USER] != item[AT_USER];
    layers[LAYER_SOURCE].needed |= source;
    layers[LAYER_TIME].needed |= time;
    return (step == 0    ? 0u
            : step == 1  ? 1u
            : step == 15 ? 2u
                         : 3u) |
           (count != last_count ? (unsigned)CHANGED_COUNT : 0u) |
           (angle ? (unsigned)CHANGED_ANGLE : 0u) | (time ? (unsigned)CHANGED_TIME : 0u) |
           (source ? (unsigned)CHANGED_SOURCE : 0u) |
           (channel_of(item) != s->current ? (unsigned)CHANGED_CHANNEL : 0u);
}

static void change_channel(point14 *s, stp_laz_stream *d, const unsigned char *item)
{
    channel_state *before = &s->channels[s->current];
    const unsigned next = (channel_of(item) - s->current - 1) % STP_LAZ_CHANNELS;
    const unsigned step = stp_laz_code_symbol(d, &before->channel, next) + 1;
    s->current = (s->current + step) % STP_LAZ_CHANNELS;
    channel_state *c = &s->channels[s->current];
    if (!c->used)
        channel_begin(c, before->last);
    c->last[AT_FLAGS] =
        (unsigned char)((c->last[AT_FLAGS] & ~CHANNEL_BITS) | s->current << CHANNEL_SHIFT);
}

/* Codes how many returns the pulse has, and which of them the point is. */
static returns code_returns(channel_state *c, stp_laz_stream *d, unsigned changed,
                            const unsigned char *item)
{
    const unsigned last_count = c->last[AT_RETURNS] >> 4, last_number = c->last[AT_RETURNS] & 15;
    const unsigned number = item[AT_RETURNS] & 15;
    returns r = {.count = last_count, .number = last_number};
    r.time_changed = changed & CHANGED_TIME;
    if (changed & CHANGED_COUNT)
        r.count = stp_laz_code_symbol(d, &c->counts[last_count], item[AT_RETURNS] >> 4);
    switch (changed & 3) {
    case 1:
        r.number = (last_number + 1) & 15;
        break;
    case 2:
        r.number = (last_number + 15) & 15;
        break;
    case 3:
        r.number =
            r.time_changed
                ? stp_laz_code_symbol(d, &c->numbers[last_number], number)
                : (last_number + 2 +
                   stp_laz_code_symbol(d, &c->number_same_time, (number - last_number - 2) & 15)) &
                      15;
        break;
    default:
        break;
    }
    c->last[AT_RETURNS] = (unsigned char)(r.number | r.count << 4);
    r.place = place_of(r.number, r.count);
    return r;
}

static void code_position(channel_state *c, stp_laz_stream *layers, const returns *r,
                          const unsigned char *item)
{
    const unsigned context = (unsigned)return_context[r->count][r->number] << 1 | r->time_changed;
    const unsigned single = r->count == 1;
    stp_laz_stream *d = &layers[LAYER_RETURNS_XY];
    stp_laz_code_along(d, &c->x, &c->x_median[context], single, c->last + AT_X, item + AT_X);
    stp_laz_code_along(d, &c->y, &c->y_median[context],
                       single + stp_laz_at_most(c->x.size & ~1u, 20), c->last + AT_Y, item + AT_Y);
    if (layers[LAYER_Z].length == 0)
        return;
    const unsigned off = r->count > r->number ? r->count - r->number : r->number - r->count;
    int32_t *height = &c->heights[stp_laz_at_most(off, HEIGHT_CONTEXT_MOST)];
    const unsigned size = (c->x.size + c->y.size) / 2;
    *height = stp_laz_code_integer(&layers[LAYER_Z], &c->z, *height,
                                   single + stp_laz_at_most(size & ~1u, 18),
                                   (int32_t)stp_las_u32(item + AT_Z));
    stp_las_put_u32(c->last + AT_Z, (uint32_t)*height);
}

/* Flags are coded in another order: class flags, scan direction, edge. */
static unsigned flags_of(unsigned byte)
{
    return (byte & CLASS_FLAGS) | (byte >> 2 & 0x30u);
}

static void code_flags(channel_state *c, stp_laz_stream *d, const unsigned char *item)
{
    const unsigned last = c->last[AT_FLAGS];
    const unsigned flags =
        stp_laz_code_symbol(d, &c->flags[flags_of(last)], flags_of(item[AT_FLAGS]));
    c->last[AT_FLAGS] =
        (unsigned char)((flags & CLASS_FLAGS) | (flags & 0x30u) << 2 | (last & CHANNEL_BITS));
}

static void code_class_and_intensity(channel_state *c, stp_laz_stream *layers, const returns *r,
                                     const unsigned char *item)
{
    unsigned char *p = c->last;
    if (layers[LAYER_CLASS].length > 0) {
        const unsigned context = (p[AT_CLASS] & 31u) << 1 | (r->place == 3);
        p[AT_CLASS] = (unsigned char)stp_laz_code_symbol(&layers[LAYER_CLASS], &c->classes[context],
                                                         item[AT_CLASS]);
    }
    if (layers[LAYER_FLAGS].length > 0)
        code_flags(c, &layers[LAYER_FLAGS], item);
    if (layers[LAYER_INTENSITY].length > 0) {
        uint16_t *intensity = &c->intensities[r->place << 1 | r->time_changed];
        *intensity =
            (uint16_t)stp_laz_code_integer(&layers[LAYER_INTENSITY], &c->intensity, *intensity,
                                           r->place, stp_las_u16(item + AT_INTENSITY));
        stp_las_put_u16(p + AT_INTENSITY, *intensity);
    }
}

static void code_rest(channel_state *c, stp_laz_stream *layers, const returns *r, unsigned changed,
                      const unsigned char *item)
{
    unsigned char *p = c->last;
    if (layers[LAYER_ANGLE].length > 0 && changed & CHANGED_ANGLE)
        stp_las_put_u16(p + AT_ANGLE,
                        (uint16_t)stp_laz_code_integer(
                            &layers[LAYER_ANGLE], &c->angle, (int16_t)stp_las_u16(p + AT_ANGLE),
                            r->time_changed, (int16_t)stp_las_u16(item + AT_ANGLE)));
    if (layers[LAYER_USER].length > 0)
        p[AT_USER] = (unsigned char)stp_laz_code_symbol(&layers[LAYER_USER],
                                                        &c->user[p[AT_USER] / 4], item[AT_USER]);
    if (layers[LAYER_SOURCE].length > 0 && changed & CHANGED_SOURCE)
        stp_las_put_u16(p + AT_SOURCE,
                        (uint16_t)stp_laz_code_integer(&layers[LAYER_SOURCE], &c->source,
                                                       stp_las_u16(p + AT_SOURCE), 0,
                                                       stp_las_u16(item + AT_SOURCE)));
    if (layers[LAYER_TIME].length > 0 && r->time_changed)
        stp_las_put_u64(p + AT_TIME, stp_laz_time_next(&c->time, false, &layers[LAYER_TIME],
                                                       stp_las_u64(item + AT_TIME)));
}

/* Returns whether the channel changed. */
static bool next(point14 *s, stp_laz_stream *layers, unsigned char *item)
{
    stp_laz_stream *d = &layers[LAYER_RETURNS_XY];
    channel_state *c = &s->channels[s->current];
    const unsigned last_place = place_of(c->last[AT_RETURNS] & 15, c->last[AT_RETURNS] >> 4);
    const unsigned changed =
        stp_laz_code_symbol(d, &c->changed[last_place | (c->time_changed ? 4u : 0u)],
                            d->packs ? find_changes(s, layers, item) : 0);
    if (changed & CHANGED_CHANNEL)
        change_channel(s, d, item);
    c = &s->channels[s->current];
    const returns r = code_returns(c, d, changed, item);
    code_position(c, layers, &r, item);
    code_class_and_intensity(c, layers, &r, item);
    code_rest(c, layers, &r, changed, item);
    c->time_changed = r.time_changed;
    memcpy(item, c->last, sizeof c->last);
    return changed & CHANGED_CHANNEL;
}

/* In version 3, the other items see the channel of a point that changes it, and else channel 0. */
static unsigned v3_next(void *state, stp_laz_stream *layers, unsigned channel, unsigned char *item)
{
    point14 *s = state;
    (void)channel;
    return next(s, layers, item) ? s->current : 0;
}

static unsigned v4_next(void *state, stp_laz_stream *layers, unsigned channel, unsigned char *item)
{
    point14 *s = state;
    (void)channel;
    next(s, layers, item);
    return s->current;
}

#define POINT14_CODER(item_version, item_next)                                                     \
    {                                                                                              \
        .type = STP_LAZ_POINT14, .version = (item_version), .bytes = STP_LAZ_POINT14_BYTES,        \
        .layers = STP_LAZ_POINT14_LAYERS, .packs = true, .state_bytes = sizeof(point14),           \
        .place = place, .begin = begin, .next = (item_next)                                        \
    }
const stp_laz_coder stp_laz_point14_v3 = POINT14_CODER(3, v3_next);
const stp_laz_coder stp_laz_point14_v4 = POINT14_CODER(4, v4_next);

/* Decodes GPS times of LAZ. */
#include "formats/scan/las/laz_time.h"

#include <string.h>

/* A difference is coded as this many times the last one, from LEAST to MOST. */
#define MULTIPLE_MOST 500
#define MULTIPLE_LEAST (-10)
/* Symbols behind the multiples, without the one for "unchanged": a time in full, then three to
 * change the sequence. */
#define SYMBOL_FULL (MULTIPLE_MOST - MULTIPLE_LEAST + 1)
#define SYMBOL_COUNT (SYMBOL_FULL + 4)
#define FIRST_SYMBOL_COUNT 5
#define EXTREMES_LIMIT 3
#define CONTEXTS 9

void stp_laz_time_place(stp_laz_time *t, bool may_stay, stp_laz_arena *arena)
{
    stp_laz_symbols_place(&t->multiple, SYMBOL_COUNT + may_stay, arena);
    stp_laz_symbols_place(&t->first, FIRST_SYMBOL_COUNT + may_stay, arena);
    stp_laz_integer_place(&t->change, 32, CONTEXTS, arena);
}

void stp_laz_time_begin(stp_laz_time *t, uint64_t first)
{
    memset(t->last, 0, sizeof t->last);
    memset(t->difference, 0, sizeof t->difference);
    memset(t->extremes, 0, sizeof t->extremes);
    t->current = t->newest = 0;
    t->last[0] = first;
}

static void advance(stp_laz_time *t, int32_t difference)
{
    t->last[t->current] += (uint64_t)(int64_t)difference;
}

/* A difference that no multiple fits. Several in a row become the sequence's difference. */
static void take_extreme(stp_laz_time *t, int32_t difference)
{
    const unsigned c = t->current;
    if (++t->extremes[c] > EXTREMES_LIMIT) {
        t->difference[c] = difference;
        t->extremes[c] = 0;
    }
    advance(t, difference);
}

/* A time far from all others begins a sequence. */
static void take_full(stp_laz_time *t, stp_laz_decoder *d)
{
    const int32_t high = (int32_t)(t->last[t->current] >> 32);
    t->newest = (t->newest + 1) % STP_LAZ_TIME_SEQUENCES;
    t->last[t->newest] = (uint64_t)(uint32_t)stp_laz_decode_integer(d, &t->change, high, 8) << 32;
    t->last[t->newest] |= stp_laz_decode_bits(d, 32);
    t->current = t->newest;
    t->difference[t->current] = 0;
    t->extremes[t->current] = 0;
}

static int32_t decode_multiple(stp_laz_time *t, stp_laz_decoder *d, int factor, unsigned context)
{
    const uint32_t predicted = (uint32_t)factor * (uint32_t)t->difference[t->current];
    return stp_laz_decode_integer(d, &t->change, (int32_t)predicted, context);
}

/* A time of a sequence whose last difference is not zero. */
static void take_multiple(stp_laz_time *t, stp_laz_decoder *d, int symbol)
{
    if (symbol == 1) {
        advance(t, decode_multiple(t, d, 1, 1));
        t->extremes[t->current] = 0;
    } else if (symbol == 0) {
        take_extreme(t, decode_multiple(t, d, 0, 7));
    } else if (symbol < MULTIPLE_MOST) {
        advance(t, decode_multiple(t, d, symbol, symbol < 10 ? 2 : 3));
    } else if (symbol == MULTIPLE_MOST) {
        take_extreme(t, decode_multiple(t, d, MULTIPLE_MOST, 4));
    } else if (MULTIPLE_MOST - symbol > MULTIPLE_LEAST) {
        advance(t, decode_multiple(t, d, MULTIPLE_MOST - symbol, 5));
    } else {
        take_extreme(t, decode_multiple(t, d, MULTIPLE_LEAST, 6));
    }
}

/* Takes one symbol; true if the time is known then, else the sequence was changed. */
static bool take_symbol(stp_laz_time *t, bool may_stay, stp_laz_decoder *d)
{
    int symbol;
    if (t->difference[t->current] == 0) {
        symbol = (int)stp_laz_decode_symbol(d, &t->first) - may_stay;
        if (symbol == 0) {
            t->difference[t->current] = decode_multiple(t, d, 0, 0);
            t->extremes[t->current] = 0;
            advance(t, t->difference[t->current]);
        } else if (symbol == 1) {
            take_full(t, d);
        } else if (symbol > 1) {
            t->current = (t->current + (unsigned)symbol - 1) % STP_LAZ_TIME_SEQUENCES;
        }
        return symbol < 2;
    }
    symbol = (int)stp_laz_decode_symbol(d, &t->multiple);
    if (may_stay && symbol == SYMBOL_FULL)
        return true;
    symbol -= may_stay && symbol > SYMBOL_FULL;
    if (symbol < SYMBOL_FULL)
        take_multiple(t, d, symbol);
    else if (symbol == SYMBOL_FULL)
        take_full(t, d);
    else
        t->current = (t->current + (unsigned)(symbol - SYMBOL_FULL)) % STP_LAZ_TIME_SEQUENCES;
    return symbol <= SYMBOL_FULL;
}

uint64_t stp_laz_time_next(stp_laz_time *t, bool may_stay, stp_laz_decoder *d)
{
    unsigned changes = 0;
    while (!take_symbol(t, may_stay, d) && changes < STP_LAZ_TIME_SEQUENCES)
        changes++;
    if (changes == STP_LAZ_TIME_SEQUENCES) /* an encoder changes the sequence once a time */
        d->cut = true;
    return t->last[t->current];
}

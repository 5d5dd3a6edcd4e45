/* Codes GPS times of LAZ. */
#include "formats/scan/las/laz/laz_time.h"

#include <string.h>

/* A difference is coded as this many times the last one, from LEAST to MOST. */
#define MULTIPLE_MOST 500
#define MULTIPLE_LEAST (-10)
/* Symbols behind the multiples, without the one for "unchanged": a time in full, then three to
 * change the sequence. */
#define SYMBOL_FULL (MULTIPLE_MOST - MULTIPLE_LEAST + 1)
#define SYMBOL_COUNT (SYMBOL_FULL + 4)
/* The same where the last difference is zero, behind a difference in full. */
#define FIRST_SYMBOL_FULL 1
#define FIRST_SYMBOL_COUNT (FIRST_SYMBOL_FULL + 4)
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

/* The difference of a time from the last one of a sequence; false if it is huge. */
static bool differs_by(const stp_laz_time *t, unsigned sequence, uint64_t time, int32_t *out)
{
    const int64_t difference = (int64_t)(time - t->last[sequence]);
    *out = (int32_t)difference;
    return difference == *out;
}

/* The symbol of a difference that follows one that was not zero. */
static int symbol_of_multiple(int32_t difference, int32_t last)
{
    const float multiple = (float)difference / (float)last;
    const float rounded = multiple >= 0.0f ? multiple + 0.5f : multiple - 0.5f;
    if (rounded >= (float)MULTIPLE_MOST)
        return MULTIPLE_MOST;
    if (rounded <= (float)MULTIPLE_LEAST)
        return MULTIPLE_MOST - MULTIPLE_LEAST;
    return (int)rounded >= 0 ? (int)rounded : MULTIPLE_MOST - (int)rounded;
}

/* To pack a time: its symbol, as if none could stay. A time far from its sequence belongs to
 * another one, or begins one. */
static int choose_symbol(const stp_laz_time *t, uint64_t time)
{
    const int32_t last = t->difference[t->current];
    const int full = last == 0 ? FIRST_SYMBOL_FULL : SYMBOL_FULL;
    int32_t difference;
    if (differs_by(t, t->current, time, &difference))
        return last == 0 ? 0 : symbol_of_multiple(difference, last);
    for (unsigned i = 1; i < STP_LAZ_TIME_SEQUENCES; i++)
        if (differs_by(t, (t->current + i) % STP_LAZ_TIME_SEQUENCES, time, &difference))
            return full + (int)i;
    return full;
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
static void take_full(stp_laz_time *t, stp_laz_stream *d, uint64_t time)
{
    const int32_t high = (int32_t)(t->last[t->current] >> 32);
    t->newest = (t->newest + 1) % STP_LAZ_TIME_SEQUENCES;
    t->last[t->newest] =
        (uint64_t)(uint32_t)stp_laz_code_integer(d, &t->change, high, 8, (int32_t)(time >> 32))
        << 32;
    t->last[t->newest] |= stp_laz_code_bits(d, 32, (uint32_t)time);
    t->current = t->newest;
    t->difference[t->current] = 0;
    t->extremes[t->current] = 0;
}

/* Codes a difference that is near a multiple of the last one. */
static int32_t code_multiple(stp_laz_time *t, stp_laz_stream *d, int factor, unsigned context,
                             uint64_t time)
{
    const uint32_t predicted = (uint32_t)factor * (uint32_t)t->difference[t->current];
    return stp_laz_code_integer(d, &t->change, (int32_t)predicted, context,
                                (int32_t)(uint32_t)(time - t->last[t->current]));
}

/* A time of a sequence whose last difference is not zero. */
static void take_multiple(stp_laz_time *t, stp_laz_stream *d, int symbol, uint64_t time)
{
    if (symbol == 1) {
        advance(t, code_multiple(t, d, 1, 1, time));
        t->extremes[t->current] = 0;
    } else if (symbol == 0) {
        take_extreme(t, code_multiple(t, d, 0, 7, time));
    } else if (symbol < MULTIPLE_MOST) {
        advance(t, code_multiple(t, d, symbol, symbol < 10 ? 2 : 3, time));
    } else if (symbol == MULTIPLE_MOST) {
        take_extreme(t, code_multiple(t, d, MULTIPLE_MOST, 4, time));
    } else if (MULTIPLE_MOST - symbol > MULTIPLE_LEAST) {
        advance(t, code_multiple(t, d, MULTIPLE_MOST - symbol, 5, time));
    } else {
        take_extreme(t, code_multiple(t, d, MULTIPLE_LEAST, 6, time));
    }
}

/* Codes one symbol; true if the time is known then, else the sequence was changed. */
static bool take_symbol(stp_laz_time *t, bool may_stay, stp_laz_stream *d, uint64_t time)
{
    const bool stays = may_stay && time == t->last[t->current];
    int symbol = d->packs ? choose_symbol(t, time) : 0;
    if (t->difference[t->current] == 0) {
        symbol = (int)stp_laz_code_symbol(d, &t->first, stays ? 0 : (unsigned)(symbol + may_stay)) -
                 may_stay;
        if (symbol == 0) {
            t->difference[t->current] = code_multiple(t, d, 0, 0, time);
            t->extremes[t->current] = 0;
            advance(t, t->difference[t->current]);
        } else if (symbol == FIRST_SYMBOL_FULL) {
            take_full(t, d, time);
        } else if (symbol > FIRST_SYMBOL_FULL) {
            t->current =
                (t->current + (unsigned)(symbol - FIRST_SYMBOL_FULL)) % STP_LAZ_TIME_SEQUENCES;
        }
        return symbol <= FIRST_SYMBOL_FULL;
    }
    symbol += may_stay && symbol >= SYMBOL_FULL;
    symbol = (int)stp_laz_code_symbol(d, &t->multiple, stays ? SYMBOL_FULL : (unsigned)symbol);
    if (may_stay && symbol == SYMBOL_FULL)
        return true;
    symbol -= may_stay && symbol > SYMBOL_FULL;
    if (symbol < SYMBOL_FULL)
        take_multiple(t, d, symbol, time);
    else if (symbol == SYMBOL_FULL)
        take_full(t, d, time);
    else
        t->current = (t->current + (unsigned)(symbol - SYMBOL_FULL)) % STP_LAZ_TIME_SEQUENCES;
    return symbol <= SYMBOL_FULL;
}

uint64_t stp_laz_time_next(stp_laz_time *t, bool may_stay, stp_laz_stream *d, uint64_t time)
{
    unsigned changes = 0;
    while (!take_symbol(t, may_stay, d, time) && changes < STP_LAZ_TIME_SEQUENCES)
        changes++;
    if (changes == STP_LAZ_TIME_SEQUENCES) /* an encoder changes the sequence once a time */
        d->cut = true;
    return t->last[t->current];
}

/* Symbols as bytes: a range coder of asymmetric numeral systems (Duda 2013, "Asymmetric numeral
 * systems").
 *
 * A symbol takes as many bits as its odds say, to a fraction of a bit; plain bits can stand between
 * symbols. Two lanes have a state each and share one run of words, so that a processor works on
 * several symbols at once. The writer begins with the last symbol, so it gathers all of them first.
 * The reader takes every byte as hostile. formats/SPEC.md, "Odds", has the arithmetic. Threads:
 * any. */
#ifndef STP_FORMATS_CHUNK_CODEC_ODDS_SYMBOLS_H
#define STP_FORMATS_CHUNK_CODEC_ODDS_SYMBOLS_H

#include "formats/chunk/codec/odds/odds.h"
#include "formats/chunk/codec/table/column.h"
#include "formats/chunk/layout.h"

#define STP_SYMBOL_LANES 2u
/* A state is less than 2^63 and, between items, 2^31 or more: it moves by words of 32 bits. */
#define STP_SYMBOL_WORD_BITS 32
#define STP_SYMBOL_STATE_LEAST (UINT64_C(1) << 31)
/* Short states are this behind the last item. Lesser ones would not tell whether there are more. */
#define STP_SYMBOL_STATE_SHORT STP_ODDS_ALL

/* ---- writing ---- */

/* A symbol, plain bits, or both: then the bits follow the symbol. */
typedef struct stp_symbol_item {
    uint16_t below, odds; /* of the symbol; 0 and 2^15 if there is none */
    uint16_t plain;
    uint8_t bits; /* of plain, 0 to 16 */
    uint8_t lane;
} stp_symbol_item;

/* Items in their order. Free `items`. */
typedef struct stp_symbol_writer {
    stp_symbol_item *items;
    size_t count, capacity;
} stp_symbol_writer;

/* Makes room for `more` items. Errors: OUT_OF_MEMORY. */
stp_status stp_symbols_reserve(stp_symbol_writer *w, size_t more, stp_error *err);
/* Appends all items as bytes: two states of 8 bytes, words. Errors: OUT_OF_MEMORY. */
stp_status stp_symbols_write(const stp_symbol_writer *w, stp_bytes *out, stp_error *err);
/* The same, with states of as many bytes as they need, for a reader that knows the odds. They are
 * short, and end at 2^15, unless one lane has so few items before the other one's words begin that
 * a reader could not tell whose they are. Errors: OUT_OF_MEMORY. */
stp_status stp_symbols_write_known(const stp_symbol_writer *w, stp_bytes *out, stp_error *err);

/* Takes a symbol with plain bits. There must be room. */
STP_INLINE void stp_symbol_put_fixed(stp_symbol_writer *w, unsigned lane, const stp_odds *odds,
                                     unsigned symbol, uint32_t plain, unsigned bits)
{
    w->items[w->count++] = (stp_symbol_item){.below = (uint16_t)odds->below[symbol],
                                             .odds = (uint16_t)stp_odds_of(odds, symbol),
                                             .plain = (uint16_t)plain,
                                             .bits = (uint8_t)bits,
                                             .lane = (uint8_t)lane};
}

/* The same, and learns the symbol. */
STP_INLINE void stp_symbol_put(stp_symbol_writer *w, unsigned lane, stp_odds *odds, int shift,
                               unsigned symbol, uint32_t plain, unsigned bits)
{
    stp_symbol_put_fixed(w, lane, odds, symbol, plain, bits);
    stp_odds_learn(odds, symbol, shift);
}

/* Takes 0 to 16 plain bits. There must be room. */
STP_INLINE void stp_symbol_put_bits(stp_symbol_writer *w, unsigned lane, uint32_t plain,
                                    unsigned bits)
{
    w->items[w->count++] = (stp_symbol_item){.odds = (uint16_t)STP_ODDS_ALL,
                                             .plain = (uint16_t)plain,
                                             .bits = (uint8_t)bits,
                                             .lane = (uint8_t)lane};
}

/* ---- reading ---- */

typedef struct stp_symbol_reader {
    const uint8_t *next, *end;
    uint64_t state[STP_SYMBOL_LANES];
    uint64_t last;    /* both states behind the last item: LEAST, or SHORT */
    uint32_t missing; /* words asked for behind the end: they were 0 */
} stp_symbol_reader;

/* Errors: CORRUPT. */
stp_status stp_symbols_begin(stp_symbol_reader *r, const uint8_t *bytes, size_t size,
                             stp_error *err);
/* Whether bytes begin as those of stp_symbols_write_known do, or, if not known, with short states
 * that do not tell of odds. Nothing writes these any more. */
bool stp_symbols_are_sized(const uint8_t *bytes, size_t size, bool known);
/* Begins with them. Errors: CORRUPT. */
stp_status stp_symbols_begin_sized(stp_symbol_reader *r, const uint8_t *bytes, size_t size,
                                   stp_error *err);
/* Checks that all symbols are read and nothing is left. Errors: CORRUPT. */
stp_status stp_symbols_end(const stp_symbol_reader *r, stp_error *err);

/* Adds a word to a state that has become too small; to short ones only while there are words.
 * Without a branch that nobody can predict. */
STP_INLINE uint64_t stp_symbols_refill(stp_symbol_reader *r, uint64_t state)
{
    uint32_t asks = state < STP_SYMBOL_STATE_LEAST;
    uint64_t word = 0;
    if (r->end - r->next >= 4) {
        word = stp_get_u32(r->next);
        r->next += (size_t)4 * asks;
    } else {
        asks = r->last == STP_SYMBOL_STATE_SHORT ? 0 : asks;
        r->missing += asks;
    }
    return asks ? state << STP_SYMBOL_WORD_BITS | word : state;
}

/* The next symbol, and in *plain the bits behind it. */
STP_INLINE unsigned stp_symbol_get_fixed(stp_symbol_reader *r, unsigned lane, const stp_odds *odds,
                                         unsigned bits, uint32_t *plain)
{
    uint64_t state = r->state[lane];
    const uint32_t place = (uint32_t)state & (STP_ODDS_ALL - 1u);
    const unsigned symbol = stp_odds_find(odds, (int32_t)place);
    const uint32_t below = (uint32_t)odds->below[symbol];
    state = stp_odds_of(odds, symbol) * (state >> STP_ODDS_BITS) + place - below;
    *plain = (uint32_t)state & ((UINT32_C(1) << bits) - 1);
    r->state[lane] = stp_symbols_refill(r, state >> bits);
    return symbol;
}

/* The same, and learns the symbol. */
STP_INLINE unsigned stp_symbol_get(stp_symbol_reader *r, unsigned lane, stp_odds *odds, int shift,
                                   unsigned bits, uint32_t *plain)
{
    const unsigned symbol = stp_symbol_get_fixed(r, lane, odds, bits, plain);
    stp_odds_learn(odds, symbol, shift);
    return symbol;
}

STP_INLINE uint32_t stp_symbol_get_bits(stp_symbol_reader *r, unsigned lane, unsigned bits)
{
    const uint64_t state = r->state[lane];
    r->state[lane] = stp_symbols_refill(r, state >> bits);
    return (uint32_t)state & ((UINT32_C(1) << bits) - 1);
}

#endif

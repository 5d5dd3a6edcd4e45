/* Codes a number by odds that follow from how large those before it were, and the one beside it.
 *
 * Functions of loops: without branches, which nobody could predict. formats/SPEC.md, "Odds", has
 * the arithmetic. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_ODDS_NUMBER_H
#define STP_FORMATS_CHUNK_CODEC_ODDS_NUMBER_H

#include "formats/chunk/codec/odds/symbols.h"

#include <stdlib.h>

/* High parts from -STP_NUMBER_HIGH_MOST to that are symbols 0 to 30; symbol 31 stands for all
 * others. */
#define STP_NUMBER_HIGH_MOST 15
#define STP_NUMBER_FAR (STP_ODDS_SYMBOLS - 1)
/* Whether a high part beyond the symbols is negative, and bits of how far it is beyond. */
#define STP_NUMBER_FAR_BITS 5u
/* The mean of magnitudes is in 1/256 and follows about the last eight numbers. */
#define STP_MEAN_BITS 8u
#define STP_MEAN_SHIFT 3
/* Bits of the mean without low bits: it is less than 4. */
#define STP_MEAN_BITS_WHOLE (STP_MEAN_BITS + 2)
/* A mean of fewer bits, below 1/16, counts as that. */
#define STP_MEAN_BITS_LEAST (STP_MEAN_BITS - 4)
/* Sizes of the mean: below 1/16, one an octave up to 2, and above. */
#define STP_NUMBER_SIZES 7
_Static_assert(STP_NUMBER_SIZES == STP_MEAN_BITS_WHOLE - STP_MEAN_BITS_LEAST + 1, "sizes of means");
/* How large the high part of the number beside is: not there, 0, up to 2, more. */
enum {
    STP_BESIDE_ABSENT,
    STP_BESIDE_SMALL,
    STP_BESIDE_MIDDLE,
    STP_BESIDE_LARGE,
    STP_NUMBER_BESIDES
};
#define STP_BESIDE_MIDDLE_LEAST 1u
#define STP_BESIDE_LARGE_LEAST 3u
/* Items of a number: symbol, low bits, length of what is beyond, what is beyond. */
#define STP_NUMBER_ITEMS 4u

/* The odds of numbers of one kind: of each size of the mean and of the number beside their own. */
typedef struct stp_number_odds {
    stp_odds of[STP_NUMBER_SIZES * STP_NUMBER_BESIDES];
} stp_number_odds;

/* What tells of the next number. */
typedef struct stp_number_way {
    uint32_t mean;
    unsigned beside; /* STP_BESIDE_SMALL and so on */
    unsigned lane;
    int shift; /* by which odds learn */
} stp_number_way;

/* At least 1. */
STP_INLINE unsigned stp_significant_bits(uint32_t value)
{
    return 32u - (unsigned)__builtin_clz(value | 1u);
}

STP_INLINE uint32_t stp_mean_after(uint32_t mean, int32_t number)
{
    return mean +
           (((uint32_t)abs(number) << STP_MEAN_BITS >> STP_MEAN_SHIFT) - (mean >> STP_MEAN_SHIFT));
}

/* How many bits of the next number are low: as many as leave the mean of high parts below 4. */
STP_INLINE unsigned stp_mean_low_bits(uint32_t mean)
{
    const unsigned bits = stp_significant_bits(mean);
    return (bits > STP_MEAN_BITS_WHOLE ? bits : STP_MEAN_BITS_WHOLE) - STP_MEAN_BITS_WHOLE;
}

/* The size of a mean, 0 to STP_NUMBER_SIZES - 1. */
STP_INLINE unsigned stp_mean_size(uint32_t mean)
{
    unsigned bits = stp_significant_bits(mean);
    bits = bits > STP_MEAN_BITS_LEAST ? bits : STP_MEAN_BITS_LEAST;
    bits = bits < STP_MEAN_BITS_WHOLE ? bits : STP_MEAN_BITS_WHOLE;
    return bits - STP_MEAN_BITS_LEAST;
}

/* Which odds the next number has. */
STP_INLINE unsigned stp_number_odds_at(const stp_number_way *way)
{
    return stp_mean_size(way->mean) * STP_NUMBER_BESIDES + way->beside;
}

/* What a number is beside another one: STP_BESIDE_SMALL and so on. */
STP_INLINE unsigned stp_beside_of(int32_t high)
{
    const unsigned size = (unsigned)abs(high);
    return STP_BESIDE_SMALL + (unsigned)(size >= STP_BESIDE_MIDDLE_LEAST) +
           (unsigned)(size >= STP_BESIDE_LARGE_LEAST);
}

STP_INLINE void stp_number_put_far(stp_symbol_writer *w, unsigned lane, int32_t high)
{
    const uint32_t beyond = (uint32_t)(abs(high) - STP_NUMBER_HIGH_MOST);
    const unsigned length = stp_significant_bits(beyond) - 1;
    stp_symbol_put_bits(w, lane, 2 * length + (high < 0), STP_NUMBER_FAR_BITS);
    stp_symbol_put_bits(w, lane, beyond - (1u << length), length);
}

/* Takes a number of these odds, for which there must be room. learns: the same odds, or NULL.
 * Returns its high part, or the greatest or least one that has a symbol. */
STP_INLINE int32_t stp_number_put_by(stp_symbol_writer *w, const stp_odds *odds, stp_odds *learns,
                                     const stp_number_way *way, int32_t number)
{
    const unsigned bits = stp_mean_low_bits(way->mean);
    const int32_t raised = number + (int32_t)(1u << bits >> 1);
    const int32_t high = raised >> bits;
    const bool far = abs(high) > STP_NUMBER_HIGH_MOST;
    const unsigned symbol = far ? STP_NUMBER_FAR : (unsigned)(high + STP_NUMBER_HIGH_MOST);
    stp_symbol_put_fixed(w, way->lane, odds, symbol, (uint32_t)raised & ((1u << bits) - 1), bits);
    if (learns)
        stp_odds_learn(learns, symbol, way->shift);
    if (far)
        stp_number_put_far(w, way->lane, high);
    return !far ? high : high < 0 ? -STP_NUMBER_HIGH_MOST : STP_NUMBER_HIGH_MOST;
}

/* The same. odds: as in stp_number_odds, or known. Returns its stp_beside_of. */
STP_INLINE unsigned stp_number_put(stp_symbol_writer *w, stp_odds *odds, const stp_number_way *way,
                                   int32_t number)
{
    stp_odds *own = &odds[stp_number_odds_at(way)];
    return stp_beside_of(stp_number_put_by(w, own, own, way, number));
}

STP_INLINE int32_t stp_number_get_far(stp_symbol_reader *r, unsigned lane)
{
    const uint32_t head = stp_symbol_get_bits(r, lane, STP_NUMBER_FAR_BITS);
    const unsigned length = head >> 1;
    const uint32_t rest = stp_symbol_get_bits(r, lane, length);
    const int32_t size = STP_NUMBER_HIGH_MOST + (int32_t)((1u << length) + rest);
    return head & 1u ? -size : size;
}

/* The next number, of these odds; *shown and learns: as of stp_number_put_by. */
STP_INLINE int16_t stp_number_get_by(stp_symbol_reader *r, const stp_odds *odds, stp_odds *learns,
                                     const stp_number_way *way, int32_t *shown)
{
    const unsigned bits = stp_mean_low_bits(way->mean);
    uint32_t low;
    const unsigned symbol = stp_symbol_get_fixed(r, way->lane, odds, bits, &low);
    if (learns)
        stp_odds_learn(learns, symbol, way->shift);
    int32_t high = (int32_t)symbol - STP_NUMBER_HIGH_MOST;
    *shown = high;
    if (symbol == STP_NUMBER_FAR) {
        high = stp_number_get_far(r, way->lane);
        *shown = high < 0 ? -STP_NUMBER_HIGH_MOST : STP_NUMBER_HIGH_MOST;
    }
    return (int16_t)(((uint32_t)high << bits) + low - (1u << bits >> 1));
}

/* The next number; *beside: its stp_beside_of. */
STP_INLINE int16_t stp_number_get(stp_symbol_reader *r, stp_odds *odds, const stp_number_way *way,
                                  unsigned *beside)
{
    int32_t high;
    stp_odds *own = &odds[stp_number_odds_at(way)];
    const int16_t number = stp_number_get_by(r, own, own, way, &high);
    *beside = stp_beside_of(high);
    return number;
}

#endif

/* How likely each symbol is, by the symbols before: adaptive odds for a range coder.
 *
 * The odds of 32 symbols are cumulative, on a scale to 2^15. Each symbol that comes moves them
 * towards itself, the first ones by 1/32, later ones by 1/128. So they need no table in the file.
 * All arithmetic is of whole numbers; formats/SPEC.md, "Odds", has it. The loops are over all
 * symbols, so that compilers make vectors of them. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_ODDS_ODDS_H
#define STP_FORMATS_CHUNK_CODEC_ODDS_ODDS_H

#include "formats/chunk/codec/inline.h"

#include <stdint.h>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

#define STP_ODDS_SYMBOLS 32
#define STP_ODDS_BITS 15
#define STP_ODDS_ALL (1 << STP_ODDS_BITS)

/* below[s]: the sum of the odds of the symbols less than s. It grows by 1 or more from s to s + 1.
 * One line of a processor's cache. */
typedef struct stp_odds {
    _Alignas(64) int16_t below[STP_ODDS_SYMBOLS];
} stp_odds;

/* Rows of a table that move odds quickly, and by a middle step. */
#define STP_ODDS_QUICK_ROWS 64u
#define STP_ODDS_MIDDLE_ROWS 256u

/* A symbol of this row moves its odds by 1 / 2^shift of the way. known: 1 if the odds begin as they
 * are in other blocks, else 0. */
STP_INLINE int stp_odds_shift(uint32_t row, int known)
{
    return 5 + (row >= STP_ODDS_QUICK_ROWS) + (known | (row >= STP_ODDS_MIDDLE_ROWS));
}

/* The symbol at a place of the scale: one less than how many of `below` are not above it. */
STP_INLINE unsigned stp_odds_find(const stp_odds *odds, int32_t place)
{
#ifdef __SSE2__
    const __m128i *below = (const __m128i *)(const void *)odds->below;
    const __m128i at = _mm_set1_epi16((int16_t)place);
    __m128i above[STP_ODDS_SYMBOLS / 8];
    for (int i = 0; i < STP_ODDS_SYMBOLS / 8; i++)
        above[i] = _mm_cmpgt_epi16(_mm_load_si128(&below[i]), at);
    const uint32_t low = (uint32_t)_mm_movemask_epi8(_mm_packs_epi16(above[0], above[1]));
    const uint32_t high = (uint32_t)_mm_movemask_epi8(_mm_packs_epi16(above[2], above[3]));
    /* The mask is never 0 behind the last symbol. */
    return (unsigned)__builtin_ctzll(low | (uint64_t)high << 16 | UINT64_C(1) << 32) - 1;
#else
    unsigned count = 0;
    for (int s = 0; s < STP_ODDS_SYMBOLS; s++)
        count += odds->below[s] <= (int16_t)place;
    return count - 1;
#endif
}

STP_INLINE uint32_t stp_odds_of(const stp_odds *odds, unsigned symbol)
{
    const int32_t end = symbol + 1 < STP_ODDS_SYMBOLS ? odds->below[symbol + 1] : STP_ODDS_ALL;
    return (uint32_t)(end - odds->below[symbol]);
}

/* What the odds move to, less s: 0 up to the symbol, and this above it. */
#define STP_ODDS_REST (STP_ODDS_ALL - STP_ODDS_SYMBOLS)
#define STP_ODDS_REST_8                                                                            \
    STP_ODDS_REST, STP_ODDS_REST, STP_ODDS_REST, STP_ODDS_REST, STP_ODDS_REST, STP_ODDS_REST,      \
        STP_ODDS_REST, STP_ODDS_REST
static const int16_t stp_odds_step[2 * STP_ODDS_SYMBOLS] = {
    [STP_ODDS_SYMBOLS] = STP_ODDS_REST_8, STP_ODDS_REST_8, STP_ODDS_REST_8, STP_ODDS_REST_8};

STP_INLINE void stp_odds_learn(stp_odds *odds, unsigned symbol, int shift)
{
    const int16_t *step = stp_odds_step + STP_ODDS_SYMBOLS - 1 - symbol;
    for (int16_t s = 0; s < STP_ODDS_SYMBOLS; s++) {
        const int16_t way = (int16_t)(s + step[s] - odds->below[s]);
        odds->below[s] = (int16_t)(odds->below[s] + (way >> shift));
    }
}

#endif

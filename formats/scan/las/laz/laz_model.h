/* The models of LAZ's arithmetic code: how likely each symbol is, learnt from those before. They
 * are the same for packing and unpacking. laz_stream.h codes by them.
 *
 * Source: A. Said, "Introduction to Arithmetic Coding" (2004), as LASzip uses it: M. Isenburg,
 * "LASzip: lossless compression of LiDAR data" (2013). Threads: any, one at a time per model. */
#ifndef STP_FORMATS_SCAN_LAS_LAZ_LAZ_MODEL_H
#define STP_FORMATS_SCAN_LAS_LAZ_LAZ_MODEL_H

#include <stddef.h>
#include <stdint.h>

/* Bits of a symbol's probability, and of a bit's. */
#define STP_LAZ_SYMBOL_SHIFT 15u
#define STP_LAZ_BIT_SHIFT 13u
/* Models with more symbols find a symbol by a table first. The others compare with all of these at
 * once, without a branch that could be foretold wrongly. */
#define STP_LAZ_TABLE_SYMBOLS 16u
#define STP_LAZ_INTEGER_CONTEXTS 22u
#define STP_LAZ_INTEGER_BITS 32u
/* Bits of a correction that a model codes; the rest stands as it is. */
#define STP_LAZ_MODELLED_BITS 8u

/* How often each symbol came. Memory: stp_laz_symbols_place. */
typedef struct stp_laz_symbols {
    uint32_t epoch;
    uint32_t total, cycle, left; /* left: symbols until the next update */
    uint16_t count;
    uint8_t table_shift; /* 0: no table */
    uint16_t *counts, *distribution, *table;
} stp_laz_symbols;

typedef struct stp_laz_bit {
    uint32_t epoch;
    uint32_t zeros, total, cycle, left;
    uint32_t zero_probability;
} stp_laz_bit;

/* Whole numbers: first the number of bits of the correction, then the correction. */
typedef struct stp_laz_integer {
    unsigned bits;
    unsigned size; /* of the last correction, in bits */
    stp_laz_symbols sizes[STP_LAZ_INTEGER_CONTEXTS];
    stp_laz_symbols corrections[STP_LAZ_INTEGER_BITS]; /* [k]: of k bits; [0] is not used */
    stp_laz_bit unit;
} stp_laz_integer;

/* Hands out the memory of models. A first round with words = NULL counts. */
typedef struct stp_laz_arena {
    uint16_t *words;
    size_t used;
} stp_laz_arena;

/* Gives a model its memory. count: 2 to 516 symbols. */
void stp_laz_symbols_place(stp_laz_symbols *m, unsigned count, stp_laz_arena *arena);
/* bits: 8, 16 or 32. contexts: 1 to STP_LAZ_INTEGER_CONTEXTS. */
void stp_laz_integer_place(stp_laz_integer *m, unsigned bits, unsigned contexts,
                           stp_laz_arena *arena);

/* Makes all symbols as likely as each other. */
void stp_laz_symbols_begin(stp_laz_symbols *m, uint32_t epoch);
void stp_laz_bit_begin(stp_laz_bit *m, uint32_t epoch);
/* Makes new probabilities of the counts. */
void stp_laz_symbols_update(stp_laz_symbols *m);
void stp_laz_bit_update(stp_laz_bit *m);

#endif

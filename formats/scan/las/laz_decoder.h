/* The entropy coder of LAZ: an adaptive arithmetic decoder, and whole numbers coded by it.
 *
 * Source: LASzip's stream as described by M. Isenburg, "LASzip: lossless compression of LiDAR data"
 * (2013); the coder is A. Said's, "Introduction to Arithmetic Coding" (2004). A decoder reads one
 * range of a file. Behind the range it gets zeros, and `cut` says so. Whatever bytes it gets, it
 * stays within its memory. Threads: any, one at a time per decoder and its models. */
#ifndef STP_FORMATS_SCAN_LAS_LAZ_DECODER_H
#define STP_FORMATS_SCAN_LAS_LAZ_DECODER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STP_LAZ_BUFFER_BYTES 8192u
/* The interval is at least this long after each step. */
#define STP_LAZ_LENGTH_LEAST (UINT32_C(1) << 24)
/* Bits of a symbol's probability, and of a bit's. */
#define STP_LAZ_SYMBOL_SHIFT 15u
#define STP_LAZ_BIT_SHIFT 13u
/* Symbols of the largest model. */
#define STP_LAZ_SYMBOLS_LIMIT 516u
#define STP_LAZ_INTEGER_CONTEXTS 22u
#define STP_LAZ_INTEGER_BITS 32u

typedef struct stp_laz_decoder {
    int descriptor;          /* of the file; borrowed */
    uint64_t next, end;      /* bytes of the file not read into the buffer yet */
    const unsigned char *at; /* next byte in the buffer */
    const unsigned char *stop;
    bool cut;     /* a byte behind the range was asked for, or could not be read */
    int io_error; /* errno of a failed read, else 0 */
    uint32_t value, length;
    uint32_t epoch; /* models of another epoch begin anew */
    unsigned char buffer[STP_LAZ_BUFFER_BYTES];
} stp_laz_decoder;

/* Reads from [begin, end) of a file. */
void stp_laz_decoder_open(stp_laz_decoder *d, int descriptor, uint64_t begin, uint64_t end);
/* Copies bytes as they are. */
void stp_laz_decoder_raw(stp_laz_decoder *d, unsigned char *out, size_t size);
/* Begins to decode at the next byte. All models used with an epoch other than this begin anew. */
void stp_laz_decoder_begin(stp_laz_decoder *d, uint32_t epoch);
/* The place of the next byte in the file. */
static inline uint64_t stp_laz_decoder_place(const stp_laz_decoder *d)
{
    return d->next - (uint64_t)(d->stop - d->at);
}

/* ---- models ---- */

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

/* Gives a model its memory. count: 2 to STP_LAZ_SYMBOLS_LIMIT. */
void stp_laz_symbols_place(stp_laz_symbols *m, unsigned count, stp_laz_arena *arena);
/* bits: 8, 16 or 32. contexts: 1 to STP_LAZ_INTEGER_CONTEXTS. */
void stp_laz_integer_place(stp_laz_integer *m, unsigned bits, unsigned contexts,
                           stp_laz_arena *arena);

/* ---- decoding ---- */

unsigned stp_laz_decode_symbol(stp_laz_decoder *d, stp_laz_symbols *m);
/* As many bits as they are, 1 to 32. */
uint32_t stp_laz_decode_bits(stp_laz_decoder *d, unsigned bits);
uint64_t stp_laz_decode_u64(stp_laz_decoder *d);
/* A number near `predicted`, modulo 2^bits. */
int32_t stp_laz_decode_integer(stp_laz_decoder *d, stp_laz_integer *m, int32_t predicted,
                               unsigned context);

/* Contexts of numbers are limited. */
static inline unsigned stp_laz_at_most(unsigned value, unsigned most)
{
    return value < most ? value : most;
}

/* A symbol is added to a byte, modulo 256. */
static inline unsigned char stp_laz_decode_byte(stp_laz_decoder *d, stp_laz_symbols *m,
                                                unsigned predicted)
{
    return (unsigned char)(predicted + stp_laz_decode_symbol(d, m));
}

#endif

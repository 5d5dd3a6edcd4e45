/* The entropy coder of LAZ: an adaptive arithmetic coder, and whole numbers coded by it. A stream
 * unpacks or packs.
 *
 * Unpacking reads one range of a file. Behind the range it gets zeros, and `cut` says so. Whatever
 * bytes it gets, it stays within its memory. Packing collects bytes in memory, as many as it needs.
 * The stp_laz_code_* functions go both ways: one that unpacks ignores the value and returns the one
 * of the stream, one that packs puts the value into the stream and returns it. So the order of
 * values, their predictions and their contexts are written once. Source: see laz_model.h. Threads:
 * any, one at a time per stream and its models. */
#ifndef STP_FORMATS_SCAN_LAS_LAZ_LAZ_STREAM_H
#define STP_FORMATS_SCAN_LAS_LAZ_LAZ_STREAM_H

#include "formats/scan/las/laz/laz_model.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STP_LAZ_BUFFER_BYTES 8192u
/* The interval is at least this long after each step. */
#define STP_LAZ_LENGTH_LEAST (UINT32_C(1) << 24)

typedef struct stp_laz_stream {
    bool packs;
    bool cut; /* a byte behind the range was asked for, or could not be read; memory ran out */
    unsigned char *at; /* next byte in the memory that is read or written, which ends at stop */
    unsigned char *stop;
    uint32_t value, length; /* unpacking: value lies below length; packing: the interval's begin */
    uint32_t epoch;         /* models of another epoch begin anew */
    /* Unpacking: */
    int descriptor;     /* of the file; borrowed */
    int io_error;       /* errno of a failed read, else 0 */
    uint64_t next, end; /* bytes of the file not read into the buffer yet */
    /* Packing: */
    bool needed;           /* an item sets it if unpacking needs these bytes */
    unsigned char *packed; /* owned */
    size_t capacity;
    unsigned char buffer[STP_LAZ_BUFFER_BYTES];
} stp_laz_stream;

/* ---- unpacking ---- */

/* Reads from [begin, end) of a file. */
void stp_laz_stream_open(stp_laz_stream *s, int descriptor, uint64_t begin, uint64_t end);
/* Copies bytes as they are. */
void stp_laz_stream_raw(stp_laz_stream *s, unsigned char *out, size_t size);
/* Begins to decode at the next byte. All models used with an epoch other than this begin anew. */
void stp_laz_stream_begin(stp_laz_stream *s, uint32_t epoch);
/* The place of the next byte in the file. */
static inline uint64_t stp_laz_stream_place(const stp_laz_stream *s)
{
    return s->next - (uint64_t)(s->stop - s->at);
}

unsigned stp_laz_decode_symbol(stp_laz_stream *s, stp_laz_symbols *m);
/* As many bits as they are, 1 to 32. */
uint32_t stp_laz_decode_bits(stp_laz_stream *s, unsigned bits);
uint64_t stp_laz_decode_u64(stp_laz_stream *s);
/* A number near `predicted`, modulo 2^bits. */
int32_t stp_laz_decode_integer(stp_laz_stream *s, stp_laz_integer *m, int32_t predicted,
                               unsigned context);

/* ---- packing ---- */

/* Begins to encode. What was packed before is gone. */
void stp_laz_stream_pack(stp_laz_stream *s, uint32_t epoch);
/* Ends: the bytes in `packed`, so many, are complete unless `cut`. */
size_t stp_laz_stream_finish(stp_laz_stream *s);
void stp_laz_stream_free(stp_laz_stream *s);

/* symbol: below the model's count. */
void stp_laz_encode_symbol(stp_laz_stream *s, stp_laz_symbols *m, unsigned symbol);
void stp_laz_encode_bits(stp_laz_stream *s, unsigned bits, uint32_t value);
void stp_laz_encode_integer(stp_laz_stream *s, stp_laz_integer *m, int32_t predicted,
                            unsigned context, int32_t value);

/* ---- both ---- */

static inline unsigned stp_laz_code_symbol(stp_laz_stream *s, stp_laz_symbols *m, unsigned symbol)
{
    if (__builtin_expect(!s->packs, 1))
        return stp_laz_decode_symbol(s, m);
    stp_laz_encode_symbol(s, m, symbol);
    return symbol;
}

static inline uint32_t stp_laz_code_bits(stp_laz_stream *s, unsigned bits, uint32_t value)
{
    if (__builtin_expect(!s->packs, 1))
        return stp_laz_decode_bits(s, bits);
    stp_laz_encode_bits(s, bits, value);
    return value;
}

static inline int32_t stp_laz_code_integer(stp_laz_stream *s, stp_laz_integer *m, int32_t predicted,
                                           unsigned context, int32_t value)
{
    if (__builtin_expect(!s->packs, 1))
        return stp_laz_decode_integer(s, m, predicted, context);
    stp_laz_encode_integer(s, m, predicted, context, value);
    return value;
}

/* A symbol is added to a byte, modulo 256. */
static inline unsigned char stp_laz_code_byte(stp_laz_stream *s, stp_laz_symbols *m,
                                              unsigned predicted, unsigned value)
{
    return (unsigned char)(predicted + stp_laz_code_symbol(s, m, (value - predicted) & 0xff));
}

/* Contexts of numbers are limited. */
static inline unsigned stp_laz_at_most(unsigned value, unsigned most)
{
    return value < most ? value : most;
}

#endif

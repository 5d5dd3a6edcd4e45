/* Data in LZF's form, written by a small compressor of the tests' own. */
#ifndef STP_TESTS_LZF_FIXTURE_H
#define STP_TESTS_LZF_FIXTURE_H

#include "tests/byte_fixture.h"

/* Up to 32 literals. */
static inline void lzf_literals(byte_row *out, const unsigned char *data, size_t size)
{
    bytes_integer(out, size - 1, 1);
    bytes_add(out, data, size);
}

/* 3 to 264 bytes from 1 to 8,192 bytes back. */
static inline void lzf_match(byte_row *out, size_t length, size_t distance)
{
    const size_t code = length - 2, back = distance - 1;
    bytes_integer(out, (code < 7 ? code : 7) << 5 | back >> 8, 1);
    if (code >= 7)
        bytes_integer(out, code - 7, 1);
    bytes_integer(out, back & 255u, 1);
}

static inline size_t lzf_match_length(const unsigned char *data, size_t at, size_t distance,
                                      size_t size)
{
    size_t length = 0;
    while (length < 264 && at + length < size && data[at + length] == data[at + length - distance])
        length++;
    return length;
}

static inline void lzf_flush(byte_row *out, const unsigned char *data, size_t from, size_t to)
{
    for (; from < to; from += 32)
        lzf_literals(out, data + from, to - from < 32 ? to - from : 32);
}

/* Matches are looked for where three bytes were last. */
static inline void lzf_compress(byte_row *out, const unsigned char *data, size_t size)
{
    size_t *last = calloc(65536, sizeof *last); /* place of a hash, counted from 1 */
    size_t at = 0, literals = 0;
    if (!last)
        abort();
    while (at < size) {
        size_t length = 0, distance = 0;
        if (at + 3 <= size) {
            const size_t hash =
                (data[at] * 2654435u ^ data[at + 1] * 40503u ^ data[at + 2]) % 65536;
            distance = last[hash] ? at - (last[hash] - 1) : 0;
            last[hash] = at + 1;
            if (distance > 0 && distance <= 8192)
                length = lzf_match_length(data, at, distance, size);
        }
        if (length < 3) {
            at++;
            continue;
        }
        lzf_flush(out, data, literals, at);
        lzf_match(out, length, distance);
        at += length;
        literals = at;
    }
    lzf_flush(out, data, literals, size);
    free(last);
}

#endif

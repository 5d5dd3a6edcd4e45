/* What tests that make files byte by byte share: a growing row of little-endian bytes. */
#ifndef STP_TESTS_BYTE_FIXTURE_H
#define STP_TESTS_BYTE_FIXTURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct byte_row {
    unsigned char *data;
    size_t size, capacity;
    unsigned bit; /* of the last byte, where the next bits go; 0: a new byte */
} byte_row;

static inline void bytes_add(byte_row *row, const void *data, size_t size)
{
    if (row->size + size > row->capacity) {
        row->capacity = 2 * (row->size + size);
        row->data = realloc(row->data, row->capacity);
        if (!row->data)
            abort();
    }
    if (size > 0 && data)
        memcpy(row->data + row->size, data, size);
    else if (size > 0)
        memset(row->data + row->size, 0, size);
    row->size += size;
    row->bit = 0;
}

static inline void bytes_text(byte_row *row, const char *text)
{
    bytes_add(row, text, strlen(text));
}

/* The lowest size bytes. */
static inline void bytes_integer(byte_row *row, uint64_t value, size_t size)
{
    bytes_add(row, &value, size);
}

static inline void bytes_float(byte_row *row, float value)
{
    bytes_add(row, &value, sizeof value);
}

static inline void bytes_double(byte_row *row, double value)
{
    bytes_add(row, &value, sizeof value);
}

/* The lowest count bits, from the lowest on, where the bits before them ended. One by one. */
static inline void bytes_bits(byte_row *row, uint64_t value, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        const unsigned bit = row->bit;
        if (bit == 0)
            bytes_add(row, NULL, 1);
        row->data[row->size - 1] |= (unsigned char)((value >> i & 1u) << bit);
        row->bit = (bit + 1) % 8;
    }
}

static inline void bytes_set(byte_row *row, size_t at, uint64_t value, size_t size)
{
    memcpy(row->data + at, &value, size);
}

static inline void bytes_free(byte_row *row)
{
    free(row->data);
    *row = (byte_row){0};
}

#endif

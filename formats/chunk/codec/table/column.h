/* Codes one column of small integers as bytes: the high bits of its cells through Draco, the low
 * bits as they are.
 *
 * The magnitude of the cells before decides how many bits of a cell are low. So Draco sees few
 * symbols (short tables of probabilities), alike along the column. formats/SPEC.md, "Payload", has
 * the arithmetic. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_TABLE_COLUMN_H
#define STP_FORMATS_CHUNK_CODEC_TABLE_COLUMN_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A byte array that grows at its end. */
typedef struct stp_bytes {
    uint8_t *data;
    size_t size, capacity;
} stp_bytes;

/* Appends size bytes; zeros if data is NULL. Errors: OUT_OF_MEMORY. */
stp_status stp_bytes_append(stp_bytes *bytes, const void *data, size_t size, stp_error *err);

/* Bytes that are read from their begin. */
typedef struct stp_cursor {
    const uint8_t *bytes;
    size_t left;
} stp_cursor;

/* size: at most what is left. */
static inline void stp_cursor_skip(stp_cursor *c, size_t size)
{
    c->bytes += size;
    c->left -= size;
}

/* Appends 1 to 65536 cells. smallest: as many bits are low as make it smallest, by entropy; else
 * the mean decides, as the first writers did. Errors: OUT_OF_MEMORY, INTERNAL (Draco fails). */
stp_status stp_column_encode(const int16_t *cells, uint32_t count, bool smallest, stp_bytes *out,
                             stp_error *err);

/* Decodes `count` cells from the start of bytes. *used: the column's size in bytes. Errors:
 * CORRUPT, OUT_OF_MEMORY. */
stp_status stp_column_decode(const uint8_t *bytes, size_t size, int16_t *cells, uint32_t count,
                             size_t *used, stp_error *err);
/* The same at a cursor, which moves behind the column. */
stp_status stp_column_read(stp_cursor *c, int16_t *cells, uint32_t count, stp_error *err);

/* Checks the number by which Draco would allocate, before Draco sees the stream: it must claim no
 * more symbols than int16 has values. Errors: CORRUPT. */
stp_status stp_stream_check(const uint8_t *stream, size_t size, stp_error *err);

#endif

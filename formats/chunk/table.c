/* A block of a payload: a table of integer columns, constants apart, the rest through Draco. */
#include "formats/chunk/table.h"

#include "base/memory.h"
#include "formats/chunk/draco_shim.h"
#include "formats/chunk/layout.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define SIZE_BYTES 4u
#define MASK_BYTES 8u

stp_status stp_bytes_append(stp_bytes *bytes, const void *data, size_t size, stp_error *err)
{
    stp_status status =
        stp_grow(&bytes->data, &bytes->capacity, bytes->size + size, 1, "payload", err);
    if (status != STP_OK || size == 0)
        return status;
    if (data)
        memcpy(bytes->data + bytes->size, data, size);
    else
        memset(bytes->data + bytes->size, 0, size);
    bytes->size += size;
    return STP_OK;
}

static uint64_t constant_mask(const stp_table *table)
{
    uint64_t mask = 0;
    for (unsigned c = 0; c < table->column_count; c++) {
        const int16_t *column = stp_table_column(table, c);
        uint32_t r = 1;
        while (r < table->row_count && column[r] == column[0])
            r++;
        if (r == table->row_count)
            mask |= (uint64_t)1 << c;
    }
    return mask;
}

static stp_status append_u32(stp_bytes *out, size_t value, stp_error *err)
{
    uint8_t bytes[SIZE_BYTES];
    stp_put_u32(bytes, (uint32_t)value);
    return stp_bytes_append(out, bytes, sizeof bytes, err);
}

static stp_status append_column(const int16_t *column, uint32_t count, stp_bytes *out,
                                stp_error *err)
{
    stp_status status = STP_OK;
    void *stream = NULL;
    size_t stream_bytes = 0;
    STP_TRY(stp_draco_encode(column, count, &stream, &stream_bytes, err));
    STP_TRY(append_u32(out, stream_bytes, err));
    STP_TRY(stp_bytes_append(out, stream, stream_bytes, err));
done:
    free(stream);
    return status;
}

stp_status stp_table_encode(const stp_table *table, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    size_t start = out->size;
    uint8_t head[SIZE_BYTES + MASK_BYTES] = {0};
    if (table->row_count == 0)
        return STP_OK;
    uint64_t mask = constant_mask(table);
    stp_put_u64(head + SIZE_BYTES, mask);
    STP_TRY(stp_bytes_append(out, head, sizeof head, err));
    for (unsigned c = 0; c < table->column_count; c++) {
        uint8_t value[2];
        stp_put_u16(value, (uint16_t)stp_table_column(table, c)[0]);
        if (mask >> c & 1u)
            STP_TRY(stp_bytes_append(out, value, sizeof value, err));
    }
    for (unsigned c = 0; c < table->column_count; c++)
        if (!(mask >> c & 1u))
            STP_TRY(append_column(stp_table_column(table, c), table->row_count, out, err));
    stp_put_u32(out->data + start, (uint32_t)(out->size - start - SIZE_BYTES));
done:
    return status;
}

/* ---- decoding ---- */

/* Draco's own numbers: the two ways of coding symbols. */
enum { STREAM_TAGGED = 0, STREAM_RAW = 1 };
#define STREAM_BIT_LENGTH_LIMIT 18u
#define STREAM_TAGS_LIMIT 33u
#define STREAM_SYMBOLS_LIMIT 65536u

/* Little-endian groups of seven bits; false where it is longer than three bytes or cut. */
static bool get_varint(const uint8_t *bytes, size_t size, uint32_t *out)
{
    uint32_t value = 0;
    for (unsigned i = 0; i < 3 && i < size; i++) {
        value |= (uint32_t)(bytes[i] & 127u) << (7 * i);
        if (!(bytes[i] & 128u)) {
            *out = value;
            return true;
        }
    }
    return false;
}

stp_status stp_stream_check(const uint8_t *stream, size_t size, stp_error *err)
{
    uint32_t symbols = 0;
    if (size < 3 || stream[0] > STREAM_RAW)
        return stp_error_set(err, STP_CORRUPT, "a Draco stream is not coded as this format says");
    bool raw = stream[0] == STREAM_RAW;
    size_t head = raw ? 2 : 1;
    if ((raw && stream[1] > STREAM_BIT_LENGTH_LIMIT) ||
        !get_varint(stream + head, size - head, &symbols) ||
        symbols > (raw ? STREAM_SYMBOLS_LIMIT : STREAM_TAGS_LIMIT))
        return stp_error_set(err, STP_CORRUPT, "a Draco stream claims more symbols than exist");
    return STP_OK;
}

/* What is left of a block. */
typedef struct cursor {
    const uint8_t *bytes;
    size_t left;
} cursor;

static void skip(cursor *c, size_t size)
{
    c->bytes += size;
    c->left -= size;
}

static stp_status decode_constant(cursor *c, int16_t *column, uint32_t count, stp_error *err)
{
    if (c->left < 2)
        return stp_error_set(err, STP_CORRUPT, "a block ends within its constants");
    int16_t value = (int16_t)stp_get_u16(c->bytes);
    for (uint32_t r = 0; r < count; r++)
        column[r] = value;
    skip(c, 2);
    return STP_OK;
}

static stp_status decode_column(cursor *c, int16_t *column, uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    if (c->left < SIZE_BYTES || stp_get_u32(c->bytes) > c->left - SIZE_BYTES)
        return stp_error_set(err, STP_CORRUPT, "a stream does not fit into its block");
    size_t size = stp_get_u32(c->bytes);
    STP_TRY(stp_stream_check(c->bytes + SIZE_BYTES, size, err));
    STP_TRY(stp_draco_decode(c->bytes + SIZE_BYTES, size, column, count, err));
    skip(c, SIZE_BYTES + size);
done:
    return status;
}

stp_status stp_table_decode(const uint8_t *bytes, size_t size, stp_table *table, size_t *used,
                            stp_error *err)
{
    stp_status status = STP_OK;
    if (table->row_count == 0) {
        *used = 0;
        return STP_OK;
    }
    if (size < SIZE_BYTES + MASK_BYTES || stp_get_u32(bytes) > size - SIZE_BYTES ||
        stp_get_u32(bytes) < MASK_BYTES)
        return stp_error_set(err, STP_CORRUPT, "a block does not fit into the %zu bytes left",
                             size);
    cursor c = {bytes + SIZE_BYTES + MASK_BYTES, stp_get_u32(bytes) - MASK_BYTES};
    uint64_t mask = stp_get_u64(bytes + SIZE_BYTES);
    if (mask >> table->column_count != 0)
        return stp_error_set(err, STP_CORRUPT, "a block has constants for columns it lacks");
    for (unsigned k = 0; k < table->column_count; k++)
        if (mask >> k & 1u)
            STP_TRY(decode_constant(&c, stp_table_column(table, k), table->row_count, err));
    for (unsigned k = 0; k < table->column_count; k++)
        if (!(mask >> k & 1u))
            STP_TRY(decode_column(&c, stp_table_column(table, k), table->row_count, err));
    if (c.left != 0)
        return stp_error_set(err, STP_CORRUPT, "%zu bytes of a block are left over", c.left);
    *used = SIZE_BYTES + (size_t)stp_get_u32(bytes);
done:
    return status;
}

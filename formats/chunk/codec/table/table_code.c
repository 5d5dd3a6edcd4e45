/* Encodes and decodes a table of integer columns. */
#include "formats/chunk/codec/table/table_code.h"

#include "base/memory.h"
#include "formats/chunk/codec/odds/cells.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/sample/normal_grid.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define SIZE_BYTES 4u
#define MASK_BYTES 8u
/* The bits of the mask from here on are the shift of normals. */
#define SHIFT_BIT 60
/* Of samples, two bits from this one on: the odd part of the step of normals. */
#define ODD_BIT 56
/* This bit of the mask: the columns are coded by odds. */
#define ODDS_BIT 59
/* This bit: a scale follows the mask. */
#define SCALE_BIT 58
/* This bit: squares follow the table. Tables that squares may follow have no scale, and the other
 * bit tells that the squares are on tilted planes. */
#define SQUARES_BIT 57
#define TILTED_BIT SCALE_BIT
/* This bit: patches are predicted by the middles of their lattices. */
#define MIDDLES_BIT 56
/* This bit: patches are predicted as in tight parts. */
#define TIGHT_BIT 55
/* Draco, in the first files of version 2: tables with fewer rows join columns (formats/SPEC.md,
 * "Shared streams"). */
#define JOINED_ROWS 768u

static stp_status append_scale(const stp_scale *scale, stp_bytes *out, stp_error *err)
{
    uint8_t bytes[STP_SCALE_BYTES];
    stp_scale_write(scale, bytes);
    return stp_bytes_append(out, bytes, sizeof bytes, err);
}

stp_status stp_table_encode(const stp_table *table, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    size_t start = out->size;
    uint8_t head[SIZE_BYTES + MASK_BYTES] = {0};
    if (table->row_count == 0)
        return STP_OK;
    uint64_t mask = stp_table_constants(table);
    stp_put_u64(
        head + SIZE_BYTES,
        mask | (uint64_t)table->tight << TIGHT_BIT | (uint64_t)table->middles << MIDDLES_BIT |
            (uint64_t)table->squares << SQUARES_BIT | (uint64_t)table->tilted << TILTED_BIT |
            (uint64_t)(table->scale.step > 0.0) << SCALE_BIT |
            (uint64_t)table->normal_odd << ODD_BIT | (uint64_t)table->by_odds << ODDS_BIT |
            (uint64_t)table->normal_shift << SHIFT_BIT);
    STP_TRY(stp_bytes_append(out, head, sizeof head, err));
    if (table->scale.step > 0.0)
        STP_TRY(append_scale(&table->scale, out, err));
    for (unsigned c = 0; c < table->column_count; c++) {
        uint8_t value[2];
        stp_put_u16(value, (uint16_t)stp_table_column(table, c)[0]);
        if (mask >> c & 1u)
            STP_TRY(stp_bytes_append(out, value, sizeof value, err));
    }
    if (table->by_odds)
        STP_TRY(stp_cells_encode(table, mask, out, err));
    for (unsigned c = 0; !table->by_odds && c < table->column_count; c++)
        if (!(mask >> c & 1u))
            STP_TRY(stp_column_encode(stp_table_column(table, c), table->row_count, table->smallest,
                                      out, err));
    stp_put_u32(out->data + start, (uint32_t)(out->size - start - SIZE_BYTES));
done:
    return status;
}

/* ---- decoding ---- */

/* The first column behind the stream that begins with column c. Long tables have a stream for each
 * column. */
static unsigned stream_end(const stp_table *table, unsigned c)
{
    const uint64_t joined = table->row_count < JOINED_ROWS ? table->joined : 0;
    do
        c++;
    while (c < table->column_count && joined >> c & 1u);
    return c;
}

/* How many columns of a stream are not constant. */
static uint32_t varying_columns(const stp_table *table, unsigned begin, uint64_t mask)
{
    uint32_t count = 0;
    for (unsigned c = begin; c < stream_end(table, begin); c++)
        count += !(mask >> c & 1u);
    return count;
}

static void count_bytes(const stp_table *table, unsigned column, size_t bytes)
{
    if (table->column_bytes)
        table->column_bytes[column] += bytes;
}

static stp_status decode_constant(stp_cursor *c, const stp_table *table, unsigned column,
                                  stp_error *err)
{
    int16_t *cells = stp_table_column(table, column);
    if (c->left < 2)
        return stp_error_set(err, STP_CORRUPT, "a table ends within its constants");
    int16_t value = (int16_t)stp_get_u16(c->bytes);
    for (uint32_t r = 0; r < table->row_count; r++)
        cells[r] = value;
    stp_cursor_skip(c, 2);
    count_bytes(table, column, 2);
    return STP_OK;
}

/* Decodes the stream that begins with a column into its varying columns. */
static stp_status decode_stream(stp_cursor *c, const stp_table *table, unsigned begin,
                                uint64_t mask, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t rows = table->row_count, count = varying_columns(table, begin, mask) * rows;
    int16_t *cells = NULL;
    if (count == 0)
        return STP_OK;
    if (stream_end(table, begin) == begin + 1)
        return stp_column_read(c, stp_table_column(table, begin), rows, err);
    STP_TRY(stp_alloc(&cells, count, sizeof *cells, "a stream of columns", err));
    STP_TRY(stp_column_read(c, cells, count, err));
    const int16_t *next = cells;
    for (unsigned k = begin; k < stream_end(table, begin); k++) {
        if (mask >> k & 1u)
            continue;
        memcpy(stp_table_column(table, k), next, rows * sizeof *next);
        next += rows;
    }
done:
    free(cells);
    return status;
}

/* Takes the shift of normals and the bits of odds, middles, tight tables and squares off the mask.
 */
static stp_status take_flags(uint64_t *mask, stp_table *table, stp_error *err)
{
    table->normal_shift = table->may_shift ? (unsigned)(*mask >> SHIFT_BIT) : 0;
    table->normal_odd =
        table->may_shift && table->may_coarsen ? *mask >> ODD_BIT & STP_NORMAL_ODD_MOST : 0;
    *mask &= ~((uint64_t)table->normal_odd << ODD_BIT);
    table->by_odds = table->beside && (*mask >> ODDS_BIT & 1u);
    *mask &= ~((uint64_t)table->normal_shift << SHIFT_BIT | (uint64_t)table->by_odds << ODDS_BIT);
    table->middles = table->is_patches && (*mask >> MIDDLES_BIT & 1u);
    table->tight = table->middles && (*mask >> TIGHT_BIT & 1u);
    if (table->middles)
        *mask &= ~(UINT64_C(1) << MIDDLES_BIT);
    if (table->tight)
        *mask &= ~(UINT64_C(1) << TIGHT_BIT);
    table->squares = table->is_patches && (*mask >> SQUARES_BIT & 1u);
    table->tilted = table->squares && (*mask >> TILTED_BIT & 1u);
    if (table->squares)
        *mask &= ~(UINT64_C(1) << SQUARES_BIT | UINT64_C(1) << TILTED_BIT);
    table->scale = (stp_scale){0};
    return stp_table_check_shift(table, err);
}

/* Takes the scale, if the mask says that there is one. */
static stp_status take_scale(stp_cursor *c, uint64_t *mask, stp_table *table, stp_error *err)
{
    if (!table->may_scale || !(*mask >> SCALE_BIT & 1u))
        return STP_OK;
    *mask &= ~(UINT64_C(1) << SCALE_BIT);
    if (c->left < STP_SCALE_BYTES)
        return stp_error_set(err, STP_CORRUPT, "a table ends within its scale");
    const stp_status status = stp_scale_read(c->bytes, &table->scale, err);
    if (status == STP_OK)
        stp_cursor_skip(c, STP_SCALE_BYTES);
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
        return stp_error_set(err, STP_CORRUPT, "a table does not fit into the %zu bytes left",
                             size);
    stp_cursor c = {bytes + SIZE_BYTES + MASK_BYTES, stp_get_u32(bytes) - MASK_BYTES};
    uint64_t mask = stp_get_u64(bytes + SIZE_BYTES);
    STP_TRY(take_flags(&mask, table, err));
    STP_TRY(take_scale(&c, &mask, table, err));
    if (mask >> table->column_count != 0)
        return stp_error_set(err, STP_CORRUPT, "a table has constants for columns it lacks");
    for (unsigned k = 0; k < table->column_count; k++)
        if (mask >> k & 1u)
            STP_TRY(decode_constant(&c, table, k, err));
    if (table->by_odds) {
        STP_TRY(stp_cells_decode(c.bytes, c.left, mask, table, err));
        stp_cursor_skip(&c, c.left);
    }
    for (unsigned k = 0; !table->by_odds && k < table->column_count; k = stream_end(table, k)) {
        const size_t left = c.left;
        STP_TRY(decode_stream(&c, table, k, mask, err));
        count_bytes(table, k, left - c.left);
    }
    if (c.left != 0)
        return stp_error_set(err, STP_CORRUPT, "%zu bytes of a table are left over", c.left);
    *used = SIZE_BYTES + (size_t)stp_get_u32(bytes);
done:
    return status;
}

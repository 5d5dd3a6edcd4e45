/* Finds, encodes and decodes squares of a grid. */
#include "formats/chunk/codec/square.h"

#include "base/memory.h"
#include "formats/chunk/layout.h"

#include <math.h>
#include <stdlib.h>

/* f64 x, y, dx, dy; u32 column, row of the first square */
#define HEAD_BYTES 40u
#define MASK_BYTES 8u
/* Column and row after those of the square before; then the bytes of the mask. */
#define SQUARE_COLUMNS (2u + MASK_BYTES)
#define DELTA_MOST 32767

static const int16_t square_beside[SQUARE_COLUMNS] = {STP_BESIDE_NONE,  0,
                                                      STP_BESIDE_KINDS, STP_BESIDE_KINDS,
                                                      STP_BESIDE_KINDS, STP_BESIDE_KINDS,
                                                      STP_BESIDE_KINDS, STP_BESIDE_KINDS,
                                                      STP_BESIDE_KINDS, STP_BESIDE_KINDS};

/* ---- finding ---- */

/* The nearest column or row; none if it is not on the grid's side of 0. */
static bool find_place(double at, double first, double step, uint32_t *out)
{
    const double place = floor((at - first) / step + 0.5);
    if (!(place >= 0.0 && place < (double)STP_SQUARE_PLACES_LIMIT * STP_SQUARE_SIDE))
        return false;
    *out = (uint32_t)place;
    return true;
}

static uint32_t spread(uint32_t n)
{
    return (n & 1u) | (n & 2u) << 1 | (n & 4u) << 2;
}

static bool find_square(const stp_raster *raster, const stp_patch *patch, const stp_sample *samples,
                        stp_square *out)
{
    int before = -1;
    *out = (stp_square){0};
    for (unsigned i = 0; i < patch->counts[0]; i++) {
        const stp_dvec3 at = stp_sample_position(&samples[i], patch);
        uint32_t column, row;
        if (!find_place(at.x, raster->x, raster->dx, &column) ||
            !find_place(at.y, raster->y, raster->dy, &row))
            return false;
        const stp_square own = {.column = column / STP_SQUARE_SIDE, .row = row / STP_SQUARE_SIDE};
        const int bit =
            (int)(spread(column % STP_SQUARE_SIDE) | spread(row % STP_SQUARE_SIDE) << 1);
        if (bit <= before || (i > 0 && (own.column != out->column || own.row != out->row)))
            return false;
        out->column = own.column;
        out->row = own.row;
        out->samples |= UINT64_C(1) << bit;
        before = bit;
    }
    return true;
}

static bool follows(uint32_t place, uint32_t before)
{
    return labs((long)place - (long)before) <= DELTA_MOST;
}

bool stp_squares_find(const stp_chunk *block, stp_square *out)
{
    for (uint32_t p = 0; p < block->patch_count; p++) {
        if (!find_square(&block->raster, &block->patches[p],
                         block->samples[0] + block->level_begin[0][p], &out[p]))
            return false;
        if (p > 0 &&
            (!follows(out[p].column, out[p - 1].column) || !follows(out[p].row, out[p - 1].row)))
            return false;
    }
    return true;
}

/* ---- coding ---- */

static stp_status table_create(uint32_t rows, stp_table *table, stp_error *err)
{
    *table = (stp_table){.stride = rows,
                         .column_count = SQUARE_COLUMNS,
                         .row_count = rows,
                         .beside = square_beside,
                         .by_odds = true};
    return stp_alloc(&table->values, (size_t)SQUARE_COLUMNS * rows, sizeof *table->values,
                     "a payload's table", err);
}

/* 255 less byte k of a mask, as a number from -128 to 127. */
static int16_t mask_cell(uint64_t samples, unsigned k)
{
    const unsigned byte = ~(unsigned)(samples >> 8 * k) & 255u;
    return (int16_t)((int)(byte ^ 128u) - 128);
}

stp_status stp_squares_encode(const stp_chunk *block, const stp_square *squares, stp_bytes *out,
                              stp_error *err)
{
    stp_status status = STP_OK;
    stp_table table = {0};
    uint8_t head[HEAD_BYTES];
    const stp_raster *r = &block->raster;
    const double numbers[4] = {r->x, r->y, r->dx, r->dy};
    for (unsigned i = 0; i < 4; i++)
        stp_put_f64(head + 8 * i, numbers[i]);
    stp_put_u32(head + 32, squares[0].column);
    stp_put_u32(head + 36, squares[0].row);
    STP_TRY(stp_bytes_append(out, head, sizeof head, err));
    STP_TRY(table_create(block->patch_count, &table, err));
    for (uint32_t p = 0; p < block->patch_count; p++) {
        const stp_square *before = &squares[p ? p - 1 : 0];
        stp_table_column(&table, 0)[p] = (int16_t)(squares[p].column - before->column);
        stp_table_column(&table, 1)[p] = (int16_t)(squares[p].row - before->row);
        for (unsigned k = 0; k < MASK_BYTES; k++)
            stp_table_column(&table, 2 + k)[p] = mask_cell(squares[p].samples, k);
    }
    STP_TRY(stp_table_encode(&table, out, err));
done:
    free(table.values);
    return status;
}

static const char *raster_fault(const stp_raster *r)
{
    const double numbers[4] = {r->x, r->y, r->dx, r->dy};
    for (int i = 0; i < 4; i++)
        if (!(fabs(numbers[i]) <= STP_REACH_LIMIT) || (i >= 2 && numbers[i] == 0.0))
            return "the raster of its squares is out of range";
    return NULL;
}

/* Takes one row of the table. `before`: the square before, or the first. */
static const char *take_square(const stp_table *table, uint32_t p, const stp_square *before,
                               unsigned count, stp_square *out)
{
    const int64_t column = (int64_t)before->column + stp_table_column(table, 0)[p];
    const int64_t row = (int64_t)before->row + stp_table_column(table, 1)[p];
    uint64_t samples = 0;
    for (unsigned k = 0; k < MASK_BYTES; k++)
        samples |= (uint64_t)(uint8_t)~stp_table_column(table, 2 + k)[p] << 8 * k;
    if (column < 0 || column >= STP_SQUARE_PLACES_LIMIT || row < 0 ||
        row >= STP_SQUARE_PLACES_LIMIT)
        return "a square is out of range";
    if ((unsigned)__builtin_popcountll(samples) != count)
        return "a square has not as many samples as its patch";
    *out = (stp_square){samples, (uint32_t)column, (uint32_t)row};
    return NULL;
}

stp_status stp_squares_decode(const uint8_t *bytes, size_t size, stp_chunk *block,
                              stp_square *squares, size_t *used, stp_error *err)
{
    stp_status status = STP_OK;
    stp_table table = {0};
    if (size < HEAD_BYTES)
        return stp_error_set(err, STP_CORRUPT, "it ends within the raster of its squares");
    stp_raster *r = &block->raster;
    *r = (stp_raster){stp_get_f64(bytes), stp_get_f64(bytes + 8), stp_get_f64(bytes + 16),
                      stp_get_f64(bytes + 24), 1};
    stp_square before = {.column = stp_get_u32(bytes + 32), .row = stp_get_u32(bytes + 36)};
    const char *fault = raster_fault(r);
    STP_TRY(table_create(block->patch_count, &table, err));
    STP_TRY(stp_table_decode(bytes + HEAD_BYTES, size - HEAD_BYTES, &table, used, err));
    *used += HEAD_BYTES;
    for (uint32_t p = 0; !fault && p < block->patch_count; p++) {
        fault = take_square(&table, p, &before, block->patches[p].counts[0], &squares[p]);
        before = squares[p];
    }
    if (fault)
        status = stp_error_set(err, STP_CORRUPT, "%s", fault);
done:
    free(table.values);
    return status;
}

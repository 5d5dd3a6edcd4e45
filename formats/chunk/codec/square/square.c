/* Encodes and decodes the rasters and squares of a block. */
#include "formats/chunk/codec/square/square.h"

#include "base/memory.h"
#include "formats/chunk/codec/square/square_raster.h"
#include "formats/chunk/layout.h"

#include <stdlib.h>

/* Of tilted rasters: how many, less 1. */
#define COUNT_BYTES 2u
#define MASK_BYTES 8u
/* Column and row after those of the square before; then the bytes of the mask; the raster after
 * that of the square before. */
#define LEVEL_COLUMNS (2u + MASK_BYTES)
#define RASTER_COLUMN LEVEL_COLUMNS
#define TILTED_COLUMNS (LEVEL_COLUMNS + 1u)

static const int16_t square_beside[TILTED_COLUMNS] = {STP_BESIDE_NONE,  0,
                                                      STP_BESIDE_KINDS, STP_BESIDE_KINDS,
                                                      STP_BESIDE_KINDS, STP_BESIDE_KINDS,
                                                      STP_BESIDE_KINDS, STP_BESIDE_KINDS,
                                                      STP_BESIDE_KINDS, STP_BESIDE_KINDS,
                                                      STP_BESIDE_NONE};

/* Of tight tables: the bits of the means that odds begin with. */
static const uint8_t square_first[TILTED_COLUMNS] = {8, 8, [RASTER_COLUMN] = 5};

stp_status stp_squares_table(uint32_t rows, bool tilted, stp_table *table, stp_error *err)
{
    *table = (stp_table){.beside = square_beside,
                         .by_odds = true,
                         .tight_first = square_first,
                         .known = stp_known_squares()};
    return stp_table_create(table, tilted ? TILTED_COLUMNS : LEVEL_COLUMNS, rows, err);
}

/* 255 less byte k of a mask, as a number from -128 to 127. */
static int16_t mask_cell(uint64_t samples, unsigned k)
{
    const unsigned byte = ~(unsigned)(samples >> 8 * k) & 255u;
    return (int16_t)((int)(byte ^ 128u) - 128);
}

/* The rasters of a block in the order in which its patches come to them. */
typedef struct used_rasters {
    uint32_t *places;   /* by raster of the chunk: its place here, plus 1; 0: none */
    stp_square *before; /* by place: the square before the next one */
    uint32_t count;
} used_rasters;

/* Notes a square's raster. Returns its place. */
static uint32_t use_raster(used_rasters *used, const stp_square *square)
{
    uint32_t *place = &used->places[square->raster];
    if (*place == 0) {
        used->before[used->count] = *square;
        *place = ++used->count;
    }
    return *place - 1;
}

static stp_status put_rasters(const stp_chunk *block, const used_rasters *used, bool tilted,
                              stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t bytes[STP_RASTER_BYTES_MOST];
    stp_put_u16(bytes, (uint16_t)(used->count - 1));
    STP_TRY(stp_bytes_append(out, bytes, tilted ? COUNT_BYTES : 0, err));
    for (uint32_t i = 0; i < used->count; i++) {
        const stp_square *first = &used->before[i];
        const size_t size = stp_raster_put(&block->rasters[first->raster], first, bytes);
        STP_TRY(stp_bytes_append(out, bytes, size, err));
    }
done:
    return status;
}

static void fill_table(const stp_square *squares, uint32_t count, used_rasters *used, bool tilted,
                       const stp_table *table)
{
    uint32_t last = 0;
    for (uint32_t p = 0; p < count; p++) {
        const uint32_t place = use_raster(used, &squares[p]);
        stp_square *before = &used->before[place];
        stp_table_column(table, 0)[p] = (int16_t)(squares[p].column - before->column);
        stp_table_column(table, 1)[p] = (int16_t)(squares[p].row - before->row);
        for (unsigned k = 0; k < MASK_BYTES; k++)
            stp_table_column(table, 2 + k)[p] = mask_cell(squares[p].samples, k);
        if (tilted)
            stp_table_column(table, RASTER_COLUMN)[p] = (int16_t)(place - last);
        *before = squares[p];
        last = place;
    }
}

stp_status stp_squares_encode(const stp_chunk *block, const stp_square *squares, stp_bytes *rasters,
                              stp_table *table, stp_error *err)
{
    stp_status status = STP_OK;
    used_rasters used = {0};
    const bool tilted = stp_squares_are_tilted(block, squares);
    STP_TRY(stp_alloc(&used.places, block->raster_count, sizeof *used.places, "rasters", err));
    STP_TRY(stp_alloc(&used.before, block->raster_count, sizeof *used.before, "rasters", err));
    for (uint32_t p = 0; p < block->patch_count; p++)
        use_raster(&used, &squares[p]);
    STP_TRY(put_rasters(block, &used, tilted, rasters, err));
    STP_TRY(stp_squares_table(block->patch_count, tilted, table, err));
    fill_table(squares, block->patch_count, &used, tilted, table);
done:
    free(used.places);
    free(used.before);
    return status;
}

/* ---- reading ---- */

static const char *raster_fault(const stp_raster *r)
{
    const double(*a)[6] = r->across;
    const double area = a[0][1] * a[1][2] - a[0][2] * a[1][1];
    bool within = r->axis < 3 && (area != 0.0 || stp_raster_spreads(r));
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 6; i++)
            within = within && fabs(a[k][i]) <= STP_REACH_LIMIT;
    return within ? NULL : "a raster of its squares is out of range";
}

/* Takes one row of the table. *before: the square before in its raster. */
static const char *take_square(const stp_table *table, uint32_t p, stp_square *before)
{
    const int64_t column = (int64_t)before->column + stp_table_column(table, 0)[p];
    const int64_t row = (int64_t)before->row + stp_table_column(table, 1)[p];
    uint64_t samples = 0;
    for (unsigned k = 0; k < MASK_BYTES; k++)
        samples |= (uint64_t)(uint8_t)~stp_table_column(table, 2 + k)[p] << 8 * k;
    if (column < 0 || column >= STP_SQUARE_PLACES_LIMIT || row < 0 ||
        row >= STP_SQUARE_PLACES_LIMIT)
        return "a square is out of range";
    *before = (stp_square){samples, (uint32_t)column, (uint32_t)row, before->raster};
    return NULL;
}

stp_status stp_rasters_decode(stp_cursor *c, bool tilted, stp_chunk *block, stp_square **first,
                              stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = !tilted ? 1 : c->left < COUNT_BYTES ? 0 : stp_get_u16(c->bytes) + 1u;
    if (count == 0)
        return stp_error_set(err, STP_CORRUPT, "it ends within the rasters of its squares");
    if (count > block->patch_count)
        return stp_error_set(err, STP_CORRUPT, "its squares have more rasters than patches");
    STP_TRY(stp_alloc(&block->rasters, count, sizeof *block->rasters, "rasters", err));
    STP_TRY(stp_alloc(first, count, sizeof **first, "rasters", err));
    block->raster_count = count;
    stp_cursor_skip(c, tilted ? COUNT_BYTES : 0);
    for (uint32_t i = 0; i < count; i++) {
        const size_t size =
            stp_raster_get(c->bytes, c->left, tilted, &block->rasters[i], &(*first)[i]);
        if (size == 0) {
            status = stp_error_set(err, STP_CORRUPT, "it ends within the rasters of its squares");
            goto done;
        }
        const char *fault = raster_fault(&block->rasters[i]);
        if (fault) {
            status = stp_error_set(err, STP_CORRUPT, "%s", fault);
            goto done;
        }
        (*first)[i].raster = i;
        stp_cursor_skip(c, size);
    }
done:
    return status;
}

stp_status stp_squares_decode(const stp_table *table, const stp_chunk *block, stp_square *first,
                              stp_square *squares, stp_error *err)
{
    const char *fault = NULL;
    const bool tilted = table->column_count == TILTED_COLUMNS;
    int64_t raster = 0;
    for (uint32_t p = 0; !fault && p < block->patch_count; p++) {
        raster += tilted ? stp_table_column(table, RASTER_COLUMN)[p] : 0;
        fault = raster < 0 || raster >= block->raster_count ? "a square is of no raster"
                                                            : take_square(table, p, &first[raster]);
        if (!fault)
            squares[p] = first[raster];
    }
    return fault ? stp_error_set(err, STP_CORRUPT, "%s", fault) : STP_OK;
}

stp_status stp_squares_check(const stp_chunk *block, stp_error *err)
{
    for (uint32_t p = 0; p < block->patch_count; p++)
        if (__builtin_popcountll(block->squares[p].samples) != block->patches[p].counts[0])
            return stp_error_set(err, STP_CORRUPT, "a square has not as many samples as its patch");
    return STP_OK;
}

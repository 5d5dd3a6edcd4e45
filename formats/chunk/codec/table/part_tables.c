/* The tables of a part, empty: how the columns of each are coded. */
#include "formats/chunk/codec/table/part_tables.h"

#include "base/memory.h"
#include "formats/chunk/codec/odds/tight.h"
#include "formats/chunk/sample/patch.h"
#include "formats/chunk/sample/sublattice.h"

#include <stdlib.h>

unsigned stp_patch_columns(const stp_chunk *chunk)
{
    return chunk->linked ? STP_LINKED_PATCH_COLUMN_COUNT : STP_PATCH_COLUMN_COUNT;
}

/* Columns of blocks that are of one kind (SPEC.md, "Shared streams"). Of patches 1-3, 4-6, 7-9,
 * 10-13, 14-18, 19-23, 24-28, 29-33, 34-37, 38-40, 41-42, 43-44. */
#define JOINED_PATCH_COLUMNS                                                                       \
    (UINT64_C(0x6) << 1 | UINT64_C(0x6) << 4 | UINT64_C(0x6) << 7 | UINT64_C(0xe) << 10 |          \
     UINT64_C(0x1e) << 14 | UINT64_C(0x1e) << 19 | UINT64_C(0x1e) << 24 | UINT64_C(0x1e) << 29 |   \
     UINT64_C(0xe) << 34 | UINT64_C(0x6) << 38 | UINT64_C(0x2) << 41 | UINT64_C(0x2) << 43)
/* Columns of samples 1-2, 3-4, 6-7, 9-11. */
#define JOINED_SAMPLE_COLUMNS                                                                      \
    (UINT64_C(0x2) << 1 | UINT64_C(0x2) << 3 | UINT64_C(0x2) << 6 | UINT64_C(0x6) << 9)

/* Of each column, the column beside it (formats/SPEC.md, "Odds"). */
#define NONE STP_BESIDE_NONE
#define KINDS STP_BESIDE_KINDS
static const int16_t sample_beside[STP_SAMPLE_COLUMN_COUNT] = {
    [STP_COLUMN_RADIUS] = NONE,
    [STP_COLUMN_FLAGS] = KINDS,
    [STP_COLUMN_CLASS] = KINDS,
    [STP_COLUMN_NORMAL_U] = NONE,
    [STP_COLUMN_NORMAL_V] = STP_COLUMN_NORMAL_U,
    [STP_COLUMN_GREEN] = NONE,
    [STP_COLUMN_RED] = STP_COLUMN_GREEN,
    [STP_COLUMN_BLUE] = STP_COLUMN_RED,
    [STP_COLUMN_INTENSITY] = NONE,
    [STP_COLUMN_POSITION_A] = NONE,
    [STP_COLUMN_POSITION_B] = STP_COLUMN_POSITION_A,
    [STP_COLUMN_POSITION_C] = STP_COLUMN_POSITION_B,
};
/* Each patch column from 2 on has the one before beside it; child and flags are kinds. */
static const int16_t patch_beside[STP_LINKED_PATCH_COLUMN_COUNT] = {
    NONE, NONE, 1,  2,  3,  4,  5,  KINDS, KINDS, NONE, 9,  10, 11, 12, 13, 14,
    15,   16,   17, 18, 19, 20, 21, 22,    23,    24,   25, 26, 27, 28, 29, 30,
    31,   32,   33, 34, 35, 36, 37, 38,    39,    40,   41, 42, 43, 44,
};
#undef NONE
#undef KINDS

/* A grid of radii of this shift has two codes. */
#define RADIUS_SHIFT_MOST 7u

/* Quarters of bits that it takes about to say that a patch has another sublattice than the one
 * before. */
#define CHANGE_QUARTERS 32u

/* What the means of patch columns are like in blocks of scans (formats/SPEC.md, "Middles"). */
static const uint8_t patch_first[STP_LINKED_PATCH_COLUMN_COUNT] = {
    4,  13, 7,  13, 7,  11, 7,  0,  0,  11, 11, 12, 12, 12, 12, 11, 11, 11, 11, 9,  9,  9,  9,
    13, 12, 11, 11, 11, 11, 10, 10, 10, 10, 14, 11, 8,  9,  11, 19, 19, 19, 8,  12, 16, 16, 16,
};

stp_status stp_part_table_create(const stp_chunk *chunk, bool squares, stp_table *table,
                                 unsigned column_count, uint32_t row_count, stp_error *err)
{
    const stp_status status = stp_table_create(table, column_count, row_count, err);
    table->smallest = chunk->is_block;
    table->by_odds = chunk->is_block && row_count < STP_ODDS_ROWS;
    if (chunk->is_block)
        table->beside = column_count == STP_SAMPLE_COLUMN_COUNT ? sample_beside : patch_beside;
    table->may_shift = chunk->is_block && column_count == STP_SAMPLE_COLUMN_COUNT;
    table->is_patches = chunk->is_block && column_count != STP_SAMPLE_COLUMN_COUNT;
    table->first = patch_first;
    table->tight_first = table->is_patches ? stp_tight_patches : stp_tight_vertices;
    table->side = table->is_patches ? stp_tight_sides : NULL;
    table->known = table->is_patches ? stp_known_patches(squares) : stp_known_vertices(squares);
    if (chunk->is_block)
        table->joined =
            column_count == STP_SAMPLE_COLUMN_COUNT ? JOINED_SAMPLE_COLUMNS : JOINED_PATCH_COLUMNS;
    return status;
}

stp_status stp_level_tables_create(const stp_chunk *chunk, int level, bool squares,
                                   stp_level_tables *tables, stp_error *err)
{
    uint32_t elder;
    uint32_t last;
    stp_predict_row_counts(chunk, level, &elder, &last);
    elder -= tables->corners.recalled[0];
    last -= tables->corners.recalled[1];
    stp_status status =
        stp_part_table_create(chunk, squares, &tables->elder, STP_SAMPLE_COLUMN_COUNT, elder, err);
    if (status == STP_OK)
        status = stp_part_table_create(chunk, squares, &tables->last, STP_SAMPLE_COLUMN_COUNT, last,
                                       err);
    tables->elder.tight_first = squares ? stp_tight_squares[level > 0][0] : stp_tight_elder;
    tables->last.tight_first = squares ? stp_tight_squares[level > 0][1] : stp_tight_last;
    tables->elder.known = stp_known_level(squares, level, false);
    tables->last.known = stp_known_level(squares, level, true);
    tables->elder.may_scale = tables->last.may_scale = chunk->is_block && level == 0;
    tables->elder.may_coarsen = tables->last.may_coarsen = chunk->is_block && !squares;
    tables->elder.may_sign = tables->elder.may_coarsen && !tables->corners.of;
    tables->elder.level = level;
    if (status == STP_OK && level == 0 && tables->elder.may_coarsen)
        status = stp_alloc(&tables->elder.sublattices, chunk->patch_count, 1, "sublattices", err);
    tables->last.sublattices = tables->elder.sublattices;
    tables->elder.sublattice_count = tables->last.sublattice_count = chunk->patch_count;
    return status;
}

stp_status stp_level_row_kinds(const stp_chunk *chunk, int level, stp_level_tables *tables,
                               stp_error *err)
{
    stp_status status = STP_OK;
    stp_table *elder = &tables->elder, *last = &tables->last;
    STP_TRY(stp_alloc_unset(&elder->row_kinds, elder->row_count + 1u, 1, "rows", err));
    STP_TRY(stp_alloc_unset(&last->row_kinds, last->row_count + 1u, 1, "rows", err));
    stp_predict_row_kinds(chunk, level, tables->corners.of, elder->row_kinds, last->row_kinds);
done:
    return status;
}

unsigned stp_radius_shift(const stp_chunk *chunk, int level)
{
    uint32_t bits = UINT32_C(1) << RADIUS_SHIFT_MOST;
    for (uint32_t i = 0; i < chunk->level_begin[level][chunk->patch_count]; i++)
        bits |= (uint32_t)chunk->samples[level][i].radius - 1; /* radius 0 is on no coarser grid */
    return (unsigned)__builtin_ctz(bits);
}

/* The sublattice of a patch: the coarsest, unless that of the patch before does nearly as well. */
static unsigned sublattice_after(unsigned before, const stp_patch *patch, const stp_sample *samples,
                                 const stp_level_tables *tables)
{
    if (stp_scale_of_patch(&tables->elder.scale, patch).used)
        return before;
    const unsigned own = stp_sublattice_of(patch, samples);
    const unsigned gain = stp_sublattice_quarters(own), had = stp_sublattice_quarters(before);
    const bool worth = gain > had && (gain - had) * patch->counts[0] > CHANGE_QUARTERS;
    return worth || !stp_sublattice_has(before, patch, samples) ? own : before;
}

void stp_level_coarsen(const stp_chunk *chunk, int level, stp_level_tables *tables)
{
    if (!tables->elder.may_coarsen)
        return;
    tables->elder.radius_shift = tables->last.radius_shift = stp_radius_shift(chunk, level);
    unsigned before = 0;
    for (uint32_t i = 0; tables->elder.sublattices && i < chunk->patch_count; i++) {
        before = sublattice_after(before, &chunk->patches[i],
                                  chunk->samples[0] + chunk->level_begin[0][i], tables);
        tables->elder.sublattices[i] = (uint8_t)before;
    }
}

void stp_level_tables_destroy(stp_level_tables *tables)
{
    free(tables->elder.values);
    free(tables->last.values);
    free(tables->elder.sublattices);
    free(tables->elder.row_kinds);
    free(tables->last.row_kinds);
    stp_corners_clear(&tables->corners);
}

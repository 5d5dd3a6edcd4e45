/* Writes parts of codec 1. */
#include "formats/chunk/codec/draco_part.h"

#include "formats/chunk/codec/odds/tight.h"
#include "formats/chunk/codec/part.h"
#include "formats/chunk/codec/predict/predict.h"
#include "formats/chunk/codec/square/block_squares.h"
#include "formats/chunk/codec/square/square_colours.h"
#include "formats/chunk/codec/square/square_level.h"
#include "formats/chunk/codec/table/part_tables.h"
#include "formats/chunk/codec/table/table_code.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/sample/normal_grid.h"
#include "formats/chunk/sample/patch.h"

#include <stdlib.h>

#define VERTEX_LEVEL (STP_LEVEL_COUNT - 1)

/* Symbols of a tight part, by sample: they get room at once. Colours by rows reserve 12 last. */
#define ITEMS_EXPECTED 8u
#define ITEMS_OF_SQUARES 17u

/* Whether no patch is of strips, whose cones tell nothing of where the next patch is. */
static bool are_surface(const stp_chunk *chunk)
{
    unsigned flags = 0;
    for (uint32_t i = 0; i < chunk->patch_count; i++)
        flags |= chunk->patches[i].flags;
    return !(flags & STP_PATCH_STRIP);
}

/* Where the tables of a part go. */
typedef struct table_sink {
    stp_bytes *out;
    stp_tight_writer tight;
    bool is_tight;
    stp_patch_shifts shifts; /* of errors and axes of tight squares */
} table_sink;

static stp_status table_write(table_sink *to, const stp_table *table, stp_error *err)
{
    return to->is_tight ? stp_tight_put(&to->tight, table, err)
                        : stp_table_encode(table, to->out, err);
}

static stp_status patches_encode(const stp_chunk *chunk, const stp_block_squares *squares,
                                 table_sink *to, stp_error *err)
{
    stp_table table = {0}, own = {0};
    stp_status status = STP_OK;
    STP_TRY(stp_part_table_create(chunk, squares->found, &table, stp_patch_columns(chunk),
                                  chunk->patch_count, err));
    table.middles = table.tight = table.is_patches && are_surface(chunk);
    table.squares = squares->found;
    table.tilted = squares->found && stp_squares_are_tilted(chunk, squares->of);
    stp_set_placed(squares->found && to->is_tight, &table);
    stp_patches_encode(chunk->patches, &table);
    if (table.placed) {
        stp_placed_encode(chunk, &squares->map, &table);
        stp_patch_shifts_encode(&to->shifts, chunk, &table);
    }
    STP_TRY(table_write(to, &table, err));
    if (squares->found) {
        STP_TRY(stp_squares_encode(chunk, squares->of, to->out, &own, err));
        own.tight = to->is_tight;
        STP_TRY(table_write(to, &own, err));
    }
done:
    free(table.values);
    free(own.values);
    return status;
}

static stp_status vertices_encode(const stp_chunk *chunk, bool squares, table_sink *to,
                                  stp_error *err)
{
    stp_table table = {0};
    stp_status status = STP_OK;
    STP_TRY(stp_part_table_create(chunk, squares, &table, STP_SAMPLE_COLUMN_COUNT,
                                  chunk->patch_count, err));
    table.normal_shift = stp_level_normal_shift(chunk, VERTEX_LEVEL);
    stp_predict_vertices_encode(chunk, &table);
    table.tight = to->is_tight;
    STP_TRY(table_write(to, &table, err));
done:
    free(table.values);
    return status;
}

static stp_status ladder_write(const stp_ladder *ladder, table_sink *to, stp_error *err)
{
    stp_table table = {0};
    stp_status status = STP_OK;
    STP_TRY(stp_ladder_table(ladder->count, &table, err));
    stp_ladder_encode(ladder, &table);
    STP_TRY(table_write(to, &table, err));
done:
    free(table.values);
    return status;
}

/* Fills the tables of a level of squares, and writes the choice that goes before them. out:
 * the choice. Colours that it codes by rows come behind the tables. */
static stp_status squares_predict(const stp_chunk *chunk, int level, stp_square_map *map,
                                  stp_level_tables *tables, table_sink *to, stp_square_choice *out,
                                  stp_error *err)
{
    stp_square_choice choice = {.reach = level == 0 ? chunk->reach : 1, .tight = to->is_tight};
    stp_ladder ladder = {0};
    stp_status status = STP_OK;
    tables->elder.by_odds = tables->last.by_odds = true;
    if (level == 0 && to->is_tight && stp_raster_spreads(map->grids[0].raster))
        STP_TRY(stp_ladder_find(chunk, map, &ladder, err));
    choice.rungs = ladder.count;
    if (level == 0 && to->is_tight)
        STP_TRY(stp_square_colours_pay(chunk, map, &choice.rows, &choice.by_parents, err));
    stp_square_level_encode(chunk, level, map, ladder.count > 0 ? &ladder : NULL, &choice, tables);
    *out = choice;
    STP_TRY(stp_square_choice_write(&choice, to->out, err));
    if (ladder.count > 0)
        STP_TRY(ladder_write(&ladder, to, err));
done:
    free(ladder.rungs);
    return status;
}

static stp_status level_encode(const stp_chunk *chunk, int level, stp_block_squares *squares,
                               table_sink *to, stp_error *err)
{
    stp_level_tables tables = {0};
    stp_square_choice choice = {0};
    stp_status status = STP_OK;
    if (to->is_tight && level == 0 && stp_has_corners(chunk))
        STP_TRY(stp_corners_find(chunk, &tables.corners, err));
    if (tables.corners.of)
        STP_TRY(stp_tight_put_corners(&to->tight, chunk, &tables.corners, err));
    STP_TRY(stp_level_tables_create(chunk, level, squares->found, &tables, err));
    tables.elder.normal_shift = tables.last.normal_shift = stp_level_normal_shift(chunk, level);
    if (tables.elder.may_coarsen)
        tables.elder.normal_odd = tables.last.normal_odd = stp_level_normal_odd(chunk, level);
    if (tables.elder.may_scale)
        stp_scale_find(chunk, &tables.elder.scale);
    tables.last.scale = tables.elder.scale;
    if (to->is_tight)
        stp_level_coarsen(chunk, level, &tables);
    if (to->is_tight)
        STP_TRY(stp_level_row_kinds(chunk, level, &tables, err));
    if (squares->found)
        STP_TRY(squares_predict(chunk, level, &squares->map, &tables, to, &choice, err));
    else
        stp_predict_level_encode(chunk, level, &tables);
    tables.elder.tight = tables.last.tight = to->is_tight;
    tables.elder.is_signed = to->is_tight && tables.elder.may_sign;
    STP_TRY(table_write(to, &tables.elder, err));
    STP_TRY(table_write(to, &tables.last, err));
    if (choice.rows)
        STP_TRY(stp_square_colours_encode(chunk, &squares->map, choice.by_parents,
                                          &to->tight.symbols, err));
done:
    stp_level_tables_destroy(&tables);
    return status;
}

/* Whether a part is tight: it is of a block, patches are of surfaces, and all tables are coded by
 * odds, as those of squares always are. */
static bool may_be_tight(const stp_chunk *chunk, int segment, const stp_block_squares *squares)
{
    uint32_t elder, last;
    stp_predict_row_counts(chunk, stp_segment_finest(segment), &elder, &last);
    return chunk->is_block && (squares->found || (elder < STP_ODDS_ROWS && last < STP_ODDS_ROWS)) &&
           (segment > 0 || are_surface(chunk));
}

/* Begins a tight part of squares: says so, and of which kind they are. */
static stp_status squares_begin(const stp_chunk *chunk, const stp_block_squares *squares,
                                table_sink *to, stp_error *err)
{
    uint8_t head[STP_TIGHT_SQUARES_BYTES];
    to->shifts = stp_patch_shifts_find(chunk);
    stp_put_u32(head, STP_TIGHT_SQUARES | STP_TIGHT_PLACED |
                          stp_patch_shifts_bits(&to->shifts) << STP_TIGHT_SHIFTS_AT |
                          (stp_squares_are_tilted(chunk, squares->of) ? STP_TIGHT_TILTED : 0) |
                          (squares->map.stops ? STP_TIGHT_STOPS : 0));
    return stp_bytes_append(to->out, head, sizeof head, err);
}

static stp_status tables_encode(const stp_chunk *chunk, int segment, stp_block_squares *squares,
                                stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    table_sink to = {.out = out, .is_tight = may_be_tight(chunk, segment, squares)};
    const uint32_t samples = chunk->level_begin[stp_segment_finest(segment)][chunk->patch_count];
    const size_t items = squares->found ? ITEMS_OF_SQUARES : ITEMS_EXPECTED;
    if (to.is_tight)
        STP_TRY(stp_symbols_reserve(&to.tight.symbols, items * samples, err));
    if (segment == 0) {
        if (to.is_tight && squares->found)
            STP_TRY(squares_begin(chunk, squares, &to, err));
        STP_TRY(patches_encode(chunk, squares, &to, err));
        STP_TRY(vertices_encode(chunk, squares->found, &to, err));
    }
    STP_TRY(level_encode(chunk, stp_segment_finest(segment), squares, &to, err));
    if (to.is_tight)
        STP_TRY(stp_symbols_write_known(&to.tight.symbols, out, err));
done:
    stp_tight_clear(&to.tight);
    return status;
}

stp_status stp_draco_part_encode(const stp_chunk *chunk, int segment, stp_bytes *out,
                                 stp_error *err)
{
    stp_block_squares squares = {0};
    stp_status status = stp_block_squares_find(chunk, segment, &squares, err);
    if (status == STP_OK)
        status = tables_encode(chunk, segment, &squares, out, err);
    stp_block_squares_clear(&squares);
    return status;
}

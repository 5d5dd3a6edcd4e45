/* Reads parts of codec 1. */
#include "formats/chunk/codec/draco_part.h"

#include "base/memory.h"
#include "formats/chunk/codec/odds/tight.h"
#include "formats/chunk/codec/part.h"
#include "formats/chunk/codec/predict/predict.h"
#include "formats/chunk/codec/square/square_colours.h"
#include "formats/chunk/codec/square/square_level.h"
#include "formats/chunk/codec/table/part_tables.h"
#include "formats/chunk/codec/table/table_code.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/sample/patch.h"

#include <stdlib.h>

/* Where the tables of a part come from. */
typedef struct table_source {
    stp_cursor c; /* not tight */
    stp_tight_reader tight;
    bool is_tight;
    stp_shares *shares; /* NULL: nobody asks */
    /* Of squares: */
    stp_square_choice choice; /* of the level, read before a tight part's tables */
    stp_square *first;        /* by raster (square.h) */
    bool placed;              /* patches are placed by their squares */
    stp_patch_shifts shifts;  /* of errors and axes */
    stp_square_map map;       /* that places them, and is there for level 2 */
} table_source;

/* Reads a table; *used: its bytes. */
static stp_status next_table(table_source *from, stp_table *table, size_t *used, stp_error *err)
{
    if (from->is_tight) {
        const uint8_t *begin = from->tight.symbols.next;
        stp_status status = stp_tight_get(&from->tight, table, err);
        *used = (size_t)(from->tight.symbols.next - begin);
        return status;
    }
    stp_status status = stp_table_decode(from->c.bytes, from->c.left, table, used, err);
    if (status == STP_OK)
        stp_cursor_skip(&from->c, *used);
    return status;
}

static stp_status table_read(table_source *from, stp_table *table, stp_error *err)
{
    size_t used = 0;
    stp_shares *shares = from->shares;
    uint64_t column_bytes[STP_LINKED_PATCH_COLUMN_COUNT] = {0};
    table->column_bytes = shares ? column_bytes : NULL;
    stp_status status = next_table(from, table, &used, err);
    if (status != STP_OK)
        return status;
    if (shares && table->column_count == STP_SAMPLE_COLUMN_COUNT)
        stp_shares_add_samples(shares, column_bytes, used);
    else if (shares)
        shares->bytes[STP_SHARE_PATCHES] += used;
    return STP_OK;
}

static stp_status rasters_read(table_source *from, bool tilted, stp_chunk *chunk, stp_error *err)
{
    const size_t left = from->c.left;
    const stp_status status = stp_rasters_decode(&from->c, tilted, chunk, &from->first, err);
    if (status == STP_OK && from->shares)
        from->shares->bytes[STP_SHARE_PATCHES] += left - from->c.left;
    return status;
}

static stp_status squares_decode(table_source *from, bool tilted, stp_chunk *chunk, stp_error *err)
{
    stp_status status = STP_OK;
    stp_table table = {0};
    STP_TRY(stp_alloc(&chunk->squares, chunk->patch_count, sizeof *chunk->squares, "squares", err));
    STP_TRY(stp_squares_table(chunk->patch_count, tilted, &table, err));
    STP_TRY(table_read(from, &table, err));
    STP_TRY(stp_squares_decode(&table, chunk, from->first, chunk->squares, err));
done:
    free(table.values);
    return status;
}

static bool has_planes(const stp_square_choice *choice)
{
    return choice->reach > 0 && choice->reach <= STP_SQUARE_REACH_MOST;
}

/* Makes the map, and finds the origins of patches. */
static stp_status place(table_source *from, const stp_table *table, stp_chunk *chunk,
                        stp_error *err)
{
    const stp_status status =
        stp_square_map_create(chunk, chunk->squares, has_planes(&from->choice), &from->map, err);
    if (status == STP_OK)
        stp_placed_decode(chunk, &from->map, table);
    return status;
}

static stp_status patches_decode(table_source *from, uint32_t child_count, stp_chunk *chunk,
                                 stp_error *err)
{
    stp_table table = {0};
    stp_status status = STP_OK;
    STP_TRY(stp_part_table_create(chunk, from->first != NULL, &table, stp_patch_columns(chunk),
                                  chunk->patch_count, err));
    stp_set_placed(from->placed, &table);
    STP_TRY(table_read(from, &table, err));
    if (from->placed) {
        STP_TRY(squares_decode(from, !chunk->rasters[0].level, chunk, err));
        stp_placed_count(chunk, &table);
    }
    stp_patch_shifts_decode(&from->shifts, &table);
    stp_patches_decode(chunk->patches, &table);
    STP_TRY(stp_patches_take(chunk, child_count, err));
    if (table.squares)
        STP_TRY(rasters_read(from, table.tilted, chunk, err));
    if (from->first && !from->placed)
        STP_TRY(squares_decode(from, !chunk->rasters[0].level, chunk, err));
    if (from->first)
        STP_TRY(stp_squares_check(chunk, err));
    if (from->placed)
        STP_TRY(place(from, &table, chunk, err));
done:
    free(table.values);
    return status;
}

static stp_status vertices_decode(table_source *from, stp_chunk *chunk, stp_error *err)
{
    stp_table table = {0};
    stp_status status = STP_OK;
    STP_TRY(stp_part_table_create(chunk, from->first != NULL, &table, STP_SAMPLE_COLUMN_COUNT,
                                  chunk->patch_count, err));
    STP_TRY(table_read(from, &table, err));
    stp_predict_vertices_decode(chunk, &table);
done:
    free(table.values);
    return status;
}

static stp_status colours_read(table_source *from, const stp_square_map *map, stp_chunk *chunk,
                               stp_error *err)
{
    const uint8_t *begin = from->tight.symbols.next;
    const stp_status status =
        stp_square_colours_decode(chunk, map, from->choice.by_parents, &from->tight, err);
    if (from->shares)
        from->shares->bytes[STP_SHARE_COLOURS] += (size_t)(from->tight.symbols.next - begin);
    return status;
}

/* Decodes a level of squares from its tables, and colours by rows from what follows. */
static stp_status squares_level_decode(table_source *from, int level, const stp_ladder *ladder,
                                       stp_chunk *chunk, const stp_level_tables *tables,
                                       stp_error *err)
{
    const stp_square_choice *choice = &from->choice;
    stp_square_map map = from->map;
    stp_status status = STP_OK;
    from->map = (stp_square_map){0};
    if (!map.memory)
        status = stp_square_map_create(chunk, chunk->squares, has_planes(choice), &map, err);
    if (status == STP_OK && choice->rows)
        status = colours_read(from, &map, chunk, err);
    if (status == STP_OK)
        stp_square_level_decode(chunk, level, &map, choice->rungs > 0 ? ladder : NULL, choice,
                                tables);
    if (level == 0)
        chunk->reach = choice->reach;
    stp_square_map_clear(&map);
    return status;
}

static stp_status choice_read(table_source *from, int level, stp_error *err)
{
    const size_t left = from->c.left;
    const stp_status status =
        stp_square_choice_read(&from->c, level, from->is_tight, &from->choice, err);
    if (status == STP_OK && from->shares)
        from->shares->bytes[STP_SHARE_FRAME] += left - from->c.left;
    return status;
}

static stp_status ladder_read(table_source *from, stp_ladder *ladder, stp_error *err)
{
    stp_table table = {0};
    stp_status status = STP_OK;
    STP_TRY(stp_ladder_table(from->choice.rungs, &table, err));
    STP_TRY(table_read(from, &table, err));
    STP_TRY(stp_ladder_decode(&table, ladder, err));
done:
    free(table.values);
    return status;
}

static stp_status corners_read(table_source *from, const stp_chunk *chunk, stp_corners *out,
                               stp_error *err)
{
    const uint8_t *begin = from->tight.symbols.next;
    const stp_status status = stp_tight_get_corners(&from->tight, chunk, out, err);
    if (from->shares)
        from->shares->bytes[STP_SHARE_POSITIONS] += (size_t)(from->tight.symbols.next - begin);
    return status;
}

static stp_status level_decode(table_source *from, int level, stp_chunk *chunk, stp_error *err)
{
    stp_level_tables tables = {0};
    stp_ladder ladder = {0};
    stp_status status = STP_OK;
    const bool squares = stp_chunk_is_squares(chunk);
    if (from->is_tight && level == 0 && stp_has_corners(chunk))
        STP_TRY(corners_read(from, chunk, &tables.corners, err));
    STP_TRY(stp_level_tables_create(chunk, level, squares, &tables, err));
    if (from->is_tight && from->tight.known)
        STP_TRY(stp_level_row_kinds(chunk, level, &tables, err));
    if (squares && !from->is_tight)
        STP_TRY(choice_read(from, level, err));
    if (squares && from->choice.rungs > 0)
        STP_TRY(ladder_read(from, &ladder, err));
    STP_TRY(table_read(from, &tables.elder, err));
    STP_TRY(table_read(from, &tables.last, err));
    if (squares)
        STP_TRY(squares_level_decode(from, level, &ladder, chunk, &tables, err));
    else
        stp_predict_level_decode(chunk, level, &tables);
done:
    free(ladder.rungs);
    stp_level_tables_destroy(&tables);
    return status;
}

/* Reads what is before the tables of squares, if the part is tight: the kind of squares and their
 * rasters in segment 0, and the choice. */
static stp_status tight_squares_begin(table_source *from, int segment, stp_chunk *chunk,
                                      stp_error *err)
{
    stp_status status = STP_OK;
    stp_cursor *c = &from->c;
    if (!chunk->is_block)
        return STP_OK;
    if (segment > 0) {
        from->is_tight =
            stp_chunk_is_squares(chunk) && c->left > 0 && stp_square_choice_is_tight(*c->bytes);
    } else if (c->left >= STP_TIGHT_SQUARES_BYTES &&
               stp_get_u32(c->bytes) >> STP_TIGHT_BITS == STP_TIGHT_SQUARES >> STP_TIGHT_BITS) {
        const uint32_t how = stp_get_u32(c->bytes);
        from->placed = how & STP_TIGHT_PLACED;
        STP_TRY(stp_patch_shifts_take(how >> STP_TIGHT_SHIFTS_AT, &from->shifts, err));
        stp_cursor_skip(c, STP_TIGHT_SQUARES_BYTES);
        if (from->shares)
            from->shares->bytes[STP_SHARE_FRAME] += STP_TIGHT_SQUARES_BYTES;
        STP_TRY(rasters_read(from, how & STP_TIGHT_TILTED, chunk, err));
        for (uint32_t i = 0; i < chunk->raster_count; i++)
            chunk->rasters[i].stops = how & STP_TIGHT_STOPS;
        from->is_tight = true;
    }
    if (from->is_tight)
        STP_TRY(choice_read(from, stp_segment_finest(segment), err));
done:
    return status;
}

static stp_status tables_begin(table_source *from, int segment, stp_chunk *chunk, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cursor *c = &from->c;
    STP_TRY(tight_squares_begin(from, segment, chunk, err));
    from->is_tight = from->is_tight || (chunk->is_block && !stp_chunk_is_squares(chunk) &&
                                        stp_is_tight(c->bytes, c->left));
    if (!from->is_tight)
        return STP_OK;
    STP_TRY(stp_tight_read(&from->tight, c->bytes, c->left, err));
    if (from->shares)
        from->shares->bytes[STP_SHARE_FRAME] += (size_t)(from->tight.symbols.next - c->bytes);
    c->left = 0;
done:
    return status;
}

stp_status stp_draco_part_decode(const uint8_t *bytes, size_t size, int segment,
                                 uint32_t child_count, stp_chunk *chunk, stp_shares *shares,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    table_source from = {.c = {bytes, size}, .shares = shares};
    STP_TRY(tables_begin(&from, segment, chunk, err));
    if (segment == 0) {
        STP_TRY(patches_decode(&from, child_count, chunk, err));
        STP_TRY(vertices_decode(&from, chunk, err));
    }
    STP_TRY(level_decode(&from, stp_segment_finest(segment), chunk, err));
    if (from.is_tight)
        STP_TRY(stp_tight_end(&from.tight, err));
    if (from.c.left != 0)
        status = stp_error_set(err, STP_CORRUPT, "%zu bytes are left over at its end", from.c.left);
done:
    stp_square_map_clear(&from.map);
    free(from.first);
    return status;
}

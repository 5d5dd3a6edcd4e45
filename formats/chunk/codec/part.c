/* Encodes and decodes segments, whole or a block's part of them. */
#include "formats/chunk/codec/part.h"

#include "base/memory.h"
#include "formats/chunk/codec/odds/tight.h"
#include "formats/chunk/codec/paper.h"
#include "formats/chunk/codec/predict/predict.h"
#include "formats/chunk/codec/raw.h"
#include "formats/chunk/codec/shares.h"
#include "formats/chunk/codec/square/block_squares.h"
#include "formats/chunk/codec/square/coarse_patches.h"
#include "formats/chunk/codec/square/placed.h"
#include "formats/chunk/codec/square/square_colours.h"
#include "formats/chunk/codec/square/square_level.h"
#include "formats/chunk/codec/table/part_tables.h"
#include "formats/chunk/codec/table/table_code.h"
#include "formats/chunk/codec/zstd/zstd_segment.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/sample/normal_grid.h"
#include "formats/chunk/sample/patch.h"

#include <stdlib.h>

#define VERTEX_LEVEL (STP_LEVEL_COUNT - 1)

/* ---- tables ---- */

/* A tight part of squares, no other one, begins with this number, plus 1 if they are tilted, plus 2
 * if patches are placed by them, plus the shifts of their errors and axes. */
#define TIGHT_SQUARES (UINT32_C(1) << 30)
#define TIGHT_TILTED 1u
#define TIGHT_PLACED 2u
#define TIGHT_SHIFTS_AT 2u
#define TIGHT_BITS (TIGHT_SHIFTS_AT + STP_PATCH_SHIFTS_BITS)
#define TIGHT_SQUARES_BYTES 4u

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
} table_sink;

static stp_status table_write(table_sink *to, const stp_table *table, stp_error *err)
{
    return to->is_tight ? stp_tight_put(&to->tight, table, err)
                        : stp_table_encode(table, to->out, err);
}

static void set_placed(bool placed, stp_table *patches)
{
    patches->placed = placed;
    if (placed)
        patches->tight_first = stp_placed_first;
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
    set_placed(squares->found && to->is_tight, &table);
    stp_patches_encode(chunk->patches, &table);
    if (table.placed) {
        stp_placed_encode(chunk, &squares->map, &table);
        stp_patch_shifts_encode(chunk, &table);
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
                                stp_bytes *out, stp_error *err)
{
    uint8_t head[TIGHT_SQUARES_BYTES];
    stp_put_u32(head, TIGHT_SQUARES | TIGHT_PLACED |
                          stp_patch_shifts_bits(chunk) << TIGHT_SHIFTS_AT |
                          (stp_squares_are_tilted(chunk, squares->of) ? TIGHT_TILTED : 0));
    return stp_bytes_append(out, head, sizeof head, err);
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
            STP_TRY(squares_begin(chunk, squares, out, err));
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

static stp_status draco_encode(const stp_chunk *chunk, int segment, stp_bytes *out, stp_error *err)
{
    stp_block_squares squares = {0};
    stp_status status = stp_block_squares_find(chunk, segment, &squares, err);
    if (status == STP_OK)
        status = tables_encode(chunk, segment, &squares, out, err);
    stp_block_squares_clear(&squares);
    return status;
}

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
    set_placed(from->placed, &table);
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
    } else if (c->left >= TIGHT_SQUARES_BYTES &&
               stp_get_u32(c->bytes) >> TIGHT_BITS == TIGHT_SQUARES >> TIGHT_BITS) {
        const uint32_t how = stp_get_u32(c->bytes);
        from->placed = how & TIGHT_PLACED;
        STP_TRY(stp_patch_shifts_take(how >> TIGHT_SHIFTS_AT, &from->shifts, err));
        stp_cursor_skip(c, TIGHT_SQUARES_BYTES);
        if (from->shares)
            from->shares->bytes[STP_SHARE_FRAME] += TIGHT_SQUARES_BYTES;
        STP_TRY(rasters_read(from, how & TIGHT_TILTED, chunk, err));
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

static stp_status draco_decode(const uint8_t *bytes, size_t size, int segment, uint32_t child_count,
                               stp_chunk *chunk, stp_shares *shares, stp_error *err)
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

/* ---- planes ---- */

static stp_status zstd_encode(const stp_chunk *chunk, int segment, stp_bytes *out, stp_error *err)
{
    const stp_status status = segment == 0 ? stp_zstd_head_encode(chunk, out, err) : STP_OK;
    return status == STP_OK ? stp_zstd_level_encode(chunk, stp_segment_finest(segment), out, err)
                            : status;
}

static stp_status zstd_decode(const uint8_t *bytes, size_t size, int segment, uint32_t child_count,
                              stp_chunk *chunk, stp_chunk_scratch *scratch, stp_error *err)
{
    stp_status status = STP_OK;
    size_t used = 0;
    STP_TRY(stp_chunk_scratch_reserve(scratch, stp_zstd_scratch_bytes(chunk, segment), err));
    if (segment == 0) {
        STP_TRY(stp_zstd_patches_decode(bytes, size, chunk->patches, chunk->patch_count,
                                        chunk->linked, scratch, &used, err));
        STP_TRY(stp_patches_take(chunk, child_count, err));
        stp_zstd_vertices_decode(chunk, scratch);
    }
    STP_TRY(stp_zstd_level_decode(bytes + used, size - used, stp_segment_finest(segment), chunk,
                                  scratch, err));
done:
    return status;
}

/* ---- the paper's maps ---- */

static stp_status paper_encode(const stp_chunk *chunk, int segment, stp_bytes *out, stp_error *err)
{
    stp_block_squares squares = {0};
    stp_status status = stp_block_squares_find(chunk, segment, &squares, err);
    if (status == STP_OK)
        status = stp_paper_encode(chunk, segment, squares.of, squares.found ? &squares.map : NULL,
                                  out, err);
    stp_block_squares_clear(&squares);
    return status;
}

/* ---- all codecs ---- */

stp_status stp_part_encode(const stp_chunk *chunk, int segment, stp_codec codec, stp_bytes *out,
                           stp_error *err)
{
    switch (codec) {
    case STP_CODEC_RAW:
        return stp_raw_encode(chunk, segment, out, err);
    case STP_CODEC_DRACO:
        return draco_encode(chunk, segment, out, err);
    case STP_CODEC_ZSTD:
        return zstd_encode(chunk, segment, out, err);
    case STP_CODEC_PAPER:
        return paper_encode(chunk, segment, out, err);
    default:
        return stp_error_set(err, STP_INVALID_ARGUMENT, "codec %d does not exist", (int)codec);
    }
}

stp_status stp_part_decode(const uint8_t *bytes, size_t size, int segment, int codec,
                           uint32_t child_count, stp_chunk *chunk, stp_chunk_scratch *scratch,
                           stp_error *err)
{
    stp_status status = STP_OK;
    if (codec == STP_CODEC_RAW)
        status = stp_raw_decode(bytes, size, segment, child_count, chunk, scratch->shares, err);
    else if (codec == STP_CODEC_DRACO)
        status = draco_decode(bytes, size, segment, child_count, chunk, scratch->shares, err);
    else if (codec == STP_CODEC_ZSTD)
        status = zstd_decode(bytes, size, segment, child_count, chunk, scratch, err);
    else if (codec == STP_CODEC_PAPER)
        status = stp_paper_decode(bytes, size, segment, child_count, chunk, scratch->shares, err);
    else
        status = stp_error_set(err, STP_UNSUPPORTED,
                               "codec %d is not known to this program: use a newer stipple", codec);
    return status == STP_OK && stp_segment_finest(segment) == 0
               ? stp_patches_check_kinds(chunk, err)
               : status;
}

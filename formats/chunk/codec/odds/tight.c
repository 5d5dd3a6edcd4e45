/* Codes the tables of a part as one run of symbols. */
#include "formats/chunk/codec/odds/tight.h"

#include "formats/chunk/codec/predict/predict.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/sample/patch.h"
#include "formats/chunk/sample/sublattice.h"

#include <stdlib.h>
#include <string.h>

/* Set in the first u32, which is the upper half of the state of lane 0. */
#define TIGHT_MARK (UINT32_C(1) << 31)
#define MARK_BYTES 8u
/* What is common to the tables takes this lane. */
#define LANE 0u
/* Symbols: how a column is coded. */
enum { HOW_VARYING, HOW_ZERO, HOW_CONSTANT, HOW_COUNT };
#define HOW_SHIFT 5
#define CELL_BITS 16u
#define SHIFT_BITS 4u
#define SCALE_WORDS (STP_SCALE_BYTES / 2u)
/* In place of the shift of normals: that follows, then how coarse radii and positions are. */
#define COARSE_MARK 15u
/* Likewise: corners that are told once follow, then all that is there without them. */
#define CORNERS_MARK 14u
/* Likewise: the odds of the table go by signed cells; all follows that is there without them. */
#define SIGNED_MARK 13u
/* Of a coarse level, in place of the shift: that follows, then the odd part of the step. */
#define STEP_MARK 14u
#define ODD_BITS 2u
#define RADIUS_BITS 3u
/* How many sublattices there are, without slanted ones, which are announced by another mark, and
 * with them; and what the odds of each change to another one are at first. */
#define SUBLATTICES(slanted) ((slanted) ? STP_SLANTED_MOST + 1 : STP_SUBLATTICE_MOST + 1)
#define CHANGE_ODDS(slanted) ((slanted) ? 768 : 1024)
#define SUBLATTICE_SHIFT 4
/* Symbols and plain bits of a table before its rows, without those of sublattices. */
#define HEAD_ITEMS (10u + SCALE_WORDS + 2u * STP_TABLE_COLUMNS_LIMIT)

const uint8_t stp_tight_patches[STP_LINKED_PATCH_COLUMN_COUNT] = {
    4, 14, 8,  15, 8,  10, 8,  0,  0,  12, 12, 9,  10, 8, 13, 11, 11, 11, 11, 10, 10, 10, 10,
    4, 13, 11, 11, 11, 10, 10, 10, 10, 10, 13, 11, 9,  9, 12, 9,  3,  3,  9,  12, 17, 17, 16,
};
const int8_t stp_tight_sides[STP_LINKED_PATCH_COLUMN_COUNT] = {
    [2] = 1,   [4] = 1,   [6] = 1,   [9] = -1,  [15] = -1, [16] = -1, [17] = -1, [18] = -1,
    [19] = -1, [20] = -1, [21] = -1, [22] = -1, [25] = -1, [26] = -1, [27] = -1, [28] = -1,
    [29] = -1, [30] = -1, [31] = -1, [32] = -1, [35] = -1, [36] = -1, [38] = 1,  [41] = 1,
};
const uint8_t stp_tight_vertices[STP_SAMPLE_COLUMN_COUNT] = {3,  0,  0,  4, 4, 13,
                                                             10, 10, 13, 3, 3, 3};
const uint8_t stp_tight_elder[STP_SAMPLE_COLUMN_COUNT] = {8, 0, 0, 11, 11, 9, 8, 8, 11, 13, 13, 10};
const uint8_t stp_tight_last[STP_SAMPLE_COLUMN_COUNT] = {8, 0, 0, 8, 8, 8, 8, 8, 8, 9, 9, 9};
static const uint8_t finest_elder[STP_SAMPLE_COLUMN_COUNT] = {7, 0, 0, 7, 7, 9, 8, 8, 8, 3, 3, 11};
static const uint8_t finest_last[STP_SAMPLE_COLUMN_COUNT] = {7, 0, 0, 7, 7, 8, 8, 8, 8, 3, 3, 9};
static const uint8_t merged_elder[STP_SAMPLE_COLUMN_COUNT] = {10, 0, 0, 12, 12, 9,
                                                              8,  8, 8, 6,  6,  12};
static const uint8_t merged_last[STP_SAMPLE_COLUMN_COUNT] = {10, 0, 0, 12, 12, 8, 8, 8, 8, 6, 6, 9};
const uint8_t *const stp_tight_squares[2][2] = {{finest_elder, finest_last},
                                                {merged_elder, merged_last}};

/* 3/4, 3/16 and what is left but a little. */
static void how_begin(stp_odds *how)
{
    for (int s = 0; s < STP_ODDS_SYMBOLS; s++)
        how->below[s] = (int16_t)(STP_ODDS_ALL - 4 * (STP_ODDS_SYMBOLS - s));
    how->below[HOW_VARYING] = 0;
    how->below[HOW_ZERO] = 3 << 13;
    how->below[HOW_CONSTANT] = 15 << 11;
}

/* The odds of how a column is coded, which is known: they do not go on. */
static stp_odds *known_how(const stp_table *table, uint64_t constant, unsigned column,
                           stp_odds *out)
{
    const unsigned before = column > 0 && constant >> (column - 1) & 1u;
    stp_known_begin(table->known[STP_KNOWN_COUNT * column + STP_KNOWN_HOW + before], out);
    return out;
}

/* Of how sublattices change from patch to patch: a half that they do not, else all alike. */
static void sublattice_odds_begin(bool slanted, stp_odds *odds)
{
    const int count = (int)SUBLATTICES(slanted), each = CHANGE_ODDS(slanted);
    for (int s = 0; s < STP_ODDS_SYMBOLS; s++) {
        const int rest = STP_ODDS_ALL - 4 * (STP_ODDS_SYMBOLS - s);
        odds->below[s] = (int16_t)(s < count ? (1 << 14) + each * (s - 1) : rest);
    }
    odds->below[0] = 0;
}

/* ---- writing ---- */

void stp_tight_clear(stp_tight_writer *w)
{
    free(w->symbols.items);
}

static void put_columns(stp_tight_writer *w, const stp_table *table, uint64_t constant)
{
    for (unsigned c = 0; c < table->column_count; c++) {
        const int16_t value = *stp_table_column(table, c);
        const bool same = constant >> c & 1u;
        const unsigned how = !same ? HOW_VARYING : value == 0 ? HOW_ZERO : HOW_CONSTANT;
        stp_odds own;
        stp_symbol_put(&w->symbols, LANE, known_how(table, constant, c, &own), HOW_SHIFT, how, 0,
                       0);
        if (how == HOW_CONSTANT)
            stp_symbol_put_bits(&w->symbols, LANE, (uint16_t)value, CELL_BITS);
    }
}

static void put_scale(stp_symbol_writer *w, const stp_scale *scale)
{
    uint8_t bytes[STP_SCALE_BYTES];
    stp_symbol_put_bits(w, LANE, scale->step > 0.0, 1);
    if (!(scale->step > 0.0))
        return;
    stp_scale_write(scale, bytes);
    for (unsigned i = 0; i < SCALE_WORDS; i++)
        stp_symbol_put_bits(w, LANE, stp_get_u16(bytes + (size_t)2 * i), 16);
}

static stp_status put_sublattices(stp_symbol_writer *w, const stp_table *table, bool slanted,
                                  stp_error *err)
{
    stp_odds odds;
    unsigned before = 0;
    const unsigned count = SUBLATTICES(slanted);
    sublattice_odds_begin(slanted, &odds);
    const stp_status status = stp_symbols_reserve(w, table->sublattice_count, err);
    for (uint32_t i = 0; status == STP_OK && i < table->sublattice_count; i++) {
        const unsigned now = table->sublattices[i];
        stp_symbol_put(w, LANE, &odds, SUBLATTICE_SHIFT, (now + count - before) % count, 0, 0);
        before = now;
    }
    return status;
}

static unsigned greatest_sublattice(const stp_table *table)
{
    unsigned out = 0;
    for (uint32_t i = 0; table->sublattices && i < table->sublattice_count; i++)
        out = table->sublattices[i] > out ? table->sublattices[i] : out;
    return out;
}

/* What is common to the rows of a table of samples; if coarse, of both tables of a level. */
static stp_status put_grids(stp_tight_writer *w, const stp_table *table, stp_error *err)
{
    const unsigned sublattice = greatest_sublattice(table);
    const bool first = table->may_scale && !w->scaled, placed = sublattice > 0;
    const bool slanted = sublattice >= STP_SLANTED;
    if (w->coarse)
        return STP_OK;
    if (table->is_signed)
        stp_symbol_put_bits(&w->symbols, LANE, SIGNED_MARK, SHIFT_BITS);
    w->coarse = table->radius_shift > 0 || table->normal_odd > 0 || placed;
    if (w->coarse)
        stp_symbol_put_bits(&w->symbols, LANE, COARSE_MARK, SHIFT_BITS);
    if (slanted)
        stp_symbol_put_bits(&w->symbols, LANE, COARSE_MARK, SHIFT_BITS);
    if (table->normal_odd > 0)
        stp_symbol_put_bits(&w->symbols, LANE, STEP_MARK, SHIFT_BITS);
    stp_symbol_put_bits(&w->symbols, LANE, table->normal_shift, SHIFT_BITS);
    if (table->normal_odd > 0)
        stp_symbol_put_bits(&w->symbols, LANE, table->normal_odd, ODD_BITS);
    if (w->coarse)
        stp_symbol_put_bits(&w->symbols, LANE, table->radius_shift, RADIUS_BITS);
    if (first)
        put_scale(&w->symbols, &table->scale);
    w->scaled = w->scaled || first;
    if (!w->coarse || !first)
        return STP_OK;
    stp_symbol_put_bits(&w->symbols, LANE, placed, 1);
    return placed ? put_sublattices(&w->symbols, table, slanted, err) : STP_OK;
}

stp_status stp_tight_put(stp_tight_writer *w, const stp_table *table, stp_error *err)
{
    stp_status status = STP_OK;
    if (table->row_count == 0)
        return STP_OK;
    const uint64_t constant = stp_table_constants(table);
    STP_TRY(stp_symbols_reserve(&w->symbols, HEAD_ITEMS, err));
    if (table->may_shift)
        STP_TRY(put_grids(w, table, err));
    STP_TRY(stp_symbols_reserve(&w->symbols, HEAD_ITEMS, err));
    put_columns(w, table, constant);
    STP_TRY(stp_cells_put(table, constant, &w->symbols, err));
done:
    return status;
}

stp_status stp_tight_put_corners(stp_tight_writer *w, const stp_chunk *block,
                                 const stp_corners *corners, stp_error *err)
{
    const stp_status status = stp_symbols_reserve(&w->symbols, 1, err);
    if (status != STP_OK)
        return status;
    stp_symbol_put_bits(&w->symbols, LANE, CORNERS_MARK, SHIFT_BITS);
    return stp_corners_put(block, corners, LANE, &w->symbols, err);
}

/* ---- reading ---- */

bool stp_is_tight(const uint8_t *bytes, size_t size)
{
    return (size >= MARK_BYTES && stp_get_u32(bytes) & TIGHT_MARK) ||
           stp_symbols_are_sized(bytes, size, false) || stp_symbols_are_sized(bytes, size, true);
}

stp_status stp_tight_read(stp_tight_reader *r, const uint8_t *bytes, size_t size, stp_error *err)
{
    r->known = stp_symbols_are_sized(bytes, size, true);
    const bool sized = r->known || stp_symbols_are_sized(bytes, size, false);
    stp_status status = sized ? stp_symbols_begin_sized(&r->symbols, bytes, size, err)
                              : stp_symbols_begin(&r->symbols, bytes, size, err);
    if (status != STP_OK)
        return status;
    if (!sized)
        r->symbols.state[0] =
            (uint64_t)(stp_get_u32(bytes) & ~TIGHT_MARK) << 32 | stp_get_u32(bytes + 4);
    how_begin(&r->how);
    memset(r->first.known, 0, sizeof r->first.known);
    r->scaled = r->coarse = r->shift_read = false;
    r->radius_shift = 0;
    r->scale = (stp_scale){0};
    return STP_OK;
}

static stp_status get_scale(stp_symbol_reader *r, stp_scale *scale, stp_error *err)
{
    uint8_t bytes[STP_SCALE_BYTES];
    if (!stp_symbol_get_bits(r, LANE, 1))
        return STP_OK;
    for (unsigned i = 0; i < SCALE_WORDS; i++)
        stp_put_u16(bytes + (size_t)2 * i, (uint16_t)stp_symbol_get_bits(r, LANE, 16));
    return stp_scale_read(bytes, scale, err);
}

/* Reads which columns are constant, and their values. */
static stp_status get_columns(stp_tight_reader *r, const stp_table *table, uint64_t *constant,
                              stp_error *err)
{
    *constant = 0;
    for (unsigned c = 0; c < table->column_count; c++) {
        uint32_t plain;
        stp_odds own, *odds = r->known ? known_how(table, *constant, c, &own) : &r->how;
        const unsigned how = stp_symbol_get(&r->symbols, LANE, odds, HOW_SHIFT, 0, &plain);
        if (how >= HOW_COUNT)
            return stp_error_set(err, STP_CORRUPT, "a column of a table is coded in no known way");
        if (how == HOW_VARYING)
            continue;
        const uint32_t value =
            how == HOW_CONSTANT ? stp_symbol_get_bits(&r->symbols, LANE, CELL_BITS) : 0;
        int16_t *cells = stp_table_column(table, c);
        for (uint32_t i = 0; i < table->row_count; i++)
            cells[i] = (int16_t)(uint16_t)value;
        *constant |= UINT64_C(1) << c;
    }
    return STP_OK;
}

static stp_status get_sublattices(stp_symbol_reader *r, stp_table *table, bool slanted,
                                  stp_error *err)
{
    stp_odds odds;
    unsigned before = 0;
    uint32_t none;
    const unsigned count = SUBLATTICES(slanted);
    sublattice_odds_begin(slanted, &odds);
    for (uint32_t i = 0; i < table->sublattice_count; i++) {
        const unsigned change = stp_symbol_get(r, LANE, &odds, SUBLATTICE_SHIFT, 0, &none);
        if (change >= count)
            return stp_error_set(err, STP_CORRUPT, "a sublattice that there is not");
        before = (before + change) % count;
        table->sublattices[i] = (uint8_t)before;
    }
    return STP_OK;
}

/* Reads what is common to the rows of a table of samples. */
static stp_status get_grids(stp_tight_reader *r, stp_table *table, stp_error *err)
{
    stp_status status = STP_OK;
    const bool first = table->may_scale && !r->scaled, known = r->coarse;
    bool slanted = false;
    r->normal_odd = known ? r->normal_odd : 0;
    if (!known && !r->shift_read)
        r->normal_shift = stp_symbol_get_bits(&r->symbols, LANE, SHIFT_BITS);
    r->shift_read = false;
    table->is_signed = table->may_sign && r->known && r->normal_shift == SIGNED_MARK;
    if (table->is_signed)
        r->normal_shift = stp_symbol_get_bits(&r->symbols, LANE, SHIFT_BITS);
    r->coarse = known || (table->may_coarsen && r->normal_shift == COARSE_MARK);
    if (r->coarse && !known) {
        r->normal_shift = stp_symbol_get_bits(&r->symbols, LANE, SHIFT_BITS);
        slanted = first && r->normal_shift == COARSE_MARK;
        if (slanted)
            r->normal_shift = stp_symbol_get_bits(&r->symbols, LANE, SHIFT_BITS);
        if (r->normal_shift == STEP_MARK) {
            r->normal_shift = stp_symbol_get_bits(&r->symbols, LANE, SHIFT_BITS);
            r->normal_odd = stp_symbol_get_bits(&r->symbols, LANE, ODD_BITS);
        }
        r->radius_shift = stp_symbol_get_bits(&r->symbols, LANE, RADIUS_BITS);
    }
    table->normal_shift = r->normal_shift;
    table->normal_odd = r->normal_odd;
    table->radius_shift = r->radius_shift;
    STP_TRY(stp_table_check_shift(table, err));
    if (first)
        STP_TRY(get_scale(&r->symbols, &r->scale, err));
    r->scaled = r->scaled || first;
    table->scale = r->scale;
    if (r->coarse && first && stp_symbol_get_bits(&r->symbols, LANE, 1))
        STP_TRY(get_sublattices(&r->symbols, table, slanted, err));
done:
    return status;
}

stp_status stp_tight_get(stp_tight_reader *r, stp_table *table, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t constant = 0;
    table->tight = true;
    table->middles = table->is_patches;
    if (table->row_count == 0)
        return STP_OK;
    if (table->may_shift)
        STP_TRY(get_grids(r, table, err));
    STP_TRY(get_columns(r, table, &constant, err));
    STP_TRY(stp_cells_get(&r->symbols, constant, r->known ? NULL : &r->first, table, err));
done:
    return status;
}

stp_status stp_tight_get_corners(stp_tight_reader *r, const stp_chunk *block, stp_corners *out,
                                 stp_error *err)
{
    r->normal_shift = stp_symbol_get_bits(&r->symbols, LANE, SHIFT_BITS);
    r->shift_read = r->normal_shift != CORNERS_MARK;
    return r->shift_read ? STP_OK : stp_corners_get(&r->symbols, LANE, block, out, err);
}

stp_status stp_tight_end(const stp_tight_reader *r, stp_error *err)
{
    return stp_symbols_end(&r->symbols, err);
}

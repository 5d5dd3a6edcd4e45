/* Codes the columns of a table by odds. */
#include "formats/chunk/codec/odds/cells.h"

#include "base/memory.h"
#include "base/wide.h"
#include "formats/chunk/codec/odds/symbols.h"
#include "formats/chunk/codec/predict/predict.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

#define INLINE STP_INLINE
/* How large a number beside may be, if it is there: so many odds for each kind of row. */
#define SIZES_BESIDE (STP_NUMBER_BESIDES - STP_BESIDE_SMALL)
/* Rows that items are reserved for at a time. */
#define ROWS_AHEAD 16u
/* No symbol's odds are less than this at first. */
#define ODDS_LEAST 4
#define SHARED_ODDS (STP_ODDS_ALL - ODDS_LEAST * STP_ODDS_SYMBOLS)
/* The weight of magnitude 0 among the first odds. */
#define FIRST_WEIGHT 4096u
/* A cell of kinds is two halves: bits 4-7, then bits 0-3. */
#define HALF_BITS 4u
#define HALVES (1u << HALF_BITS)
/* The odds of a half that is not 0, at first; in tight tables. */
#define HALF_ODDS 512
#define HALF_ODDS_TIGHT 128
/* In tight tables the cells of some columns have one sign, as a rule: at first the weights of the
 * other sign are less by so many bits. */
#define SIDE_BITS 5
/* A column's first mean is a power of two, at most that of the greatest magnitude. */
#define FIRST_MOST (15u + STP_MEAN_BITS)

/* What a row adds to the number of its odds, if they are known. */
typedef struct row_places {
    unsigned upper, lower; /* halves of kinds */
    unsigned begin;        /* signed cells: where the odds of its child begin */
    unsigned has_elder;    /* likewise: all bits, if the row before is its elder sibling; else 0 */
} row_places;

/* How a column is coded: by odds of numbers or of kinds; or of numbers by signed cells. */
typedef enum column_way { WAY_NUMBERS, WAY_KINDS, WAY_SIGNED_ALONE, WAY_SIGNED_BESIDE } column_way;

/* A column that is coded. */
typedef struct column {
    stp_odds *odds;
    const uint8_t *curves; /* by signed cells, if its odds do not learn: these curves of `fixed` */
    const stp_odds *fixed;
    int16_t *cells;
    const struct column *beside; /* by signed cells; or `nobody` */
    unsigned side, side_before;  /* likewise: side_of the last two cells */
    const unsigned *size_beside; /* `size` of the column beside, or of none */
    unsigned before_shift;       /* of kinds: so many bits less of the last cell count */
    uint32_t mean;               /* of the magnitudes of the cells before, in 1/256 */
    unsigned size;               /* of the last cell: STP_BESIDE_SMALL and so on */
    unsigned size_least;         /* what a small cell has: STP_BESIDE_SMALL, or by the row */
    unsigned before;             /* of kinds: the last cell */
    unsigned lane, number;       /* which lane of symbols; which column of the table */
    column_way way;
    uint64_t bytes; /* that were read for its cells */
} column;

/* The odds before the first cell: magnitudes fall by `ratio` / 2^16 from one to the next. side: the
 * sign of the cells, 0 if they have both. */
static void odds_begin(uint32_t ratio, int side, stp_odds *out)
{
    uint32_t weight[STP_ODDS_SYMBOLS], below[STP_ODDS_SYMBOLS + 1] = {0}, w = FIRST_WEIGHT;
    for (int high = 0; high <= STP_NUMBER_HIGH_MOST; high++) {
        weight[STP_NUMBER_HIGH_MOST + high] = side < 0 && high > 0 ? w >> SIDE_BITS : w;
        weight[STP_NUMBER_HIGH_MOST - high] = side > 0 && high > 0 ? w >> SIDE_BITS : w;
        w = w * ratio >> 16;
    }
    weight[STP_NUMBER_FAR] = w;
    for (int s = 0; s < STP_ODDS_SYMBOLS; s++)
        below[s + 1] = below[s] + weight[s];
    /* Doubles divide several numbers at once. Their quotients, cut, are those of whole numbers. */
    const double all = below[STP_ODDS_SYMBOLS];
    for (int s = 0; s < STP_ODDS_SYMBOLS; s++)
        out->below[s] = (int16_t)((int32_t)((double)below[s] * SHARED_ODDS / all) + ODDS_LEAST * s);
}

/* By which part of 2^16 the odds fall from one magnitude to the next, by size of the mean and of
 * the cell beside. They are those of cells of such a mean. */
static const uint16_t first_ratio[STP_NUMBER_SIZES][STP_NUMBER_BESIDES] = {
    {983, 737, 983, 1327},        {2891, 2170, 2891, 3897},     {5749, 4326, 5749, 7713},
    {11246, 8542, 11246, 14840},  {20832, 16304, 20832, 26261}, {33927, 28285, 33927, 39657},
    {46343, 41561, 46343, 50585},
};

/* The odds of columns of a side, which are made once. */
const stp_number_odds *stp_number_odds_first(stp_first_odds *first, int side)
{
    stp_number_odds *out = &first->of[side + 1];
    if (first->known[side + 1])
        return out;
    first->known[side + 1] = true;
    for (unsigned i = 0; i < STP_NUMBER_SIZES; i++)
        for (unsigned b = 0; b < STP_NUMBER_BESIDES; b++)
            odds_begin(first_ratio[i][b], side, &out->of[i * STP_NUMBER_BESIDES + b]);
    return out;
}

static void half_odds_begin(int half_odds, stp_odds *out)
{
    const int halves = HALVES;
    for (int s = 0; s < STP_ODDS_SYMBOLS; s++) {
        const int above =
            s < halves ? half_odds * (halves + 1 - s) : ODDS_LEAST * (STP_ODDS_SYMBOLS - s);
        out->below[s] = (int16_t)(s == 0 ? 0 : STP_ODDS_ALL - above);
    }
}

static void kind_odds_begin(bool tight, stp_odds *out)
{
    half_odds_begin(tight ? HALF_ODDS_TIGHT : HALF_ODDS, out);
    for (unsigned i = 1; i < STP_KNOWN_KINDS; i++)
        out[i] = out[0];
}

/* ---- one cell ---- */

INLINE stp_number_way way_of(const column *c, int shift)
{
    return (stp_number_way){c->mean, *c->size_beside, c->lane, shift};
}

/* Takes what the cell is beside others, and the cell. */
INLINE void take(column *c, unsigned size, int32_t cell)
{
    c->size = c->size_least + size - STP_BESIDE_SMALL;
    c->mean = stp_mean_after(c->mean, cell);
}

INLINE void put_number(stp_symbol_writer *w, column *c, int32_t cell, int shift)
{
    const stp_number_way way = way_of(c, shift);
    take(c, stp_number_put(w, c->odds, &way, cell), cell);
}

INLINE int16_t get_number(stp_symbol_reader *r, column *c, int shift)
{
    const stp_number_way way = way_of(c, shift);
    unsigned size;
    const int16_t cell = stp_number_get(r, c->odds, &way, &size);
    take(c, size, cell);
    return cell;
}

/* The side of a high part that has a symbol: -3 and less, -2 and -1, 0, 1 and 2, and more. */
enum { SIDE_ZERO = 2, SIDES = 5 };
INLINE unsigned side_of(int32_t high)
{
    static const uint8_t side[2 * STP_NUMBER_HIGH_MOST + 1] = {
        [13] = 1, 1, SIDE_ZERO, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4};
    return side[high + STP_NUMBER_HIGH_MOST];
}

/* What is beside a column that none is beside. */
static const column nobody = {.side = SIDE_ZERO, .side_before = SIDE_ZERO};

/* Which odds a cell has by signed cells. */
INLINE unsigned signed_place(const column *c, const row_places *row)
{
    const unsigned size = stp_mean_size(c->mean);
    static const uint8_t sign[SIDES] = {1, 1, 2, 3, 3};
    if (c->way == WAY_SIGNED_ALONE)
        return 13u * size + row->begin + (row->has_elder & (1u + c->side));
    const unsigned falls = 3u * (c->beside->side_before < SIDE_ZERO);
    return 7u * (SIDES * size + c->beside->side) + (row->has_elder & (sign[c->side] + falls));
}

INLINE void take_signed(column *c, int32_t high, int32_t cell)
{
    static const uint8_t size[SIDES] = {STP_BESIDE_LARGE, STP_BESIDE_MIDDLE, STP_BESIDE_SMALL,
                                        STP_BESIDE_MIDDLE, STP_BESIDE_LARGE};
    c->side_before = c->side;
    c->side = side_of(high);
    take(c, size[c->side], cell);
}

INLINE void put_signed(stp_symbol_writer *w, column *c, const row_places *row, int32_t cell,
                       int shift)
{
    const stp_number_way way = way_of(c, shift);
    const unsigned place = signed_place(c, row);
    stp_odds *own = c->curves ? NULL : &c->odds[place];
    const stp_odds *odds = c->curves ? &c->fixed[c->curves[place]] : own;
    take_signed(c, stp_number_put_by(w, odds, own, &way, cell), cell);
}

INLINE int16_t get_signed(stp_symbol_reader *r, column *c, const row_places *row, int shift)
{
    const stp_number_way way = way_of(c, shift);
    int32_t high;
    const unsigned place = signed_place(c, row);
    stp_odds *own = c->curves ? NULL : &c->odds[place];
    const stp_odds *odds = c->curves ? &c->fixed[c->curves[place]] : own;
    const int16_t cell = stp_number_get_by(r, odds, own, &way, &high);
    take_signed(c, high, cell);
    return cell;
}

/* Which odds the lower half of a kind has: by whether the upper half, and the lower one of the cell
 * before, are not 0. */
INLINE unsigned lower_odds(const column *c, unsigned upper)
{
    return 2u * (upper != 0) + ((c->before & (HALVES - 1)) != 0);
}

/* Likewise the upper half: by that of the cell before, or what it tells beside the row. */
INLINE unsigned upper_odds(const column *c, const row_places *row)
{
    return (c->before >> HALF_BITS >> c->before_shift) + row->upper;
}

INLINE void put_kind(stp_symbol_writer *w, column *c, const row_places *row, unsigned cell,
                     int shift)
{
    const unsigned upper = cell >> HALF_BITS;
    const unsigned was = upper_odds(c, row), k = lower_odds(c, upper) + row->lower;
    stp_symbol_put(w, c->lane, &c->odds[was], shift, upper, 0, 0);
    stp_symbol_put(w, c->lane, &c->odds[HALVES + k], shift, cell & (HALVES - 1), 0, 0);
    c->before = cell;
}

INLINE int16_t get_kind(stp_symbol_reader *r, column *c, const row_places *row, int shift)
{
    const unsigned was = upper_odds(c, row);
    uint32_t none;
    const unsigned upper =
        stp_symbol_get(r, c->lane, &c->odds[was], shift, 0, &none) & (HALVES - 1);
    const unsigned k = lower_odds(c, upper) + row->lower;
    const unsigned lower =
        stp_symbol_get(r, c->lane, &c->odds[HALVES + k], shift, 0, &none) & (HALVES - 1);
    c->before = upper << HALF_BITS | lower;
    return (int16_t)((int)(c->before ^ 128u) - 128);
}

/* ---- tables ---- */

/* The columns that are coded, in order. Free `memory`. */
typedef struct columns {
    void *memory;
    column *of;
    unsigned count, number_count;
    bool known, is_signed;
    /* If odds are known: the kinds of rows, NULL if all are 0; what stands beside columns that have
     * none beside them; and the size_least of the column beside B, or of nobody. */
    const uint8_t *row_kinds;
    unsigned alone;
    unsigned *size_least_beside_b, nobody;
    const uint8_t *first; /* by column of the table: the bits of its first mean. Not NULL: the cells
                             of the first row leave means as they are */
} columns;

/* How a column of the table is coded. */
static column_way way_of_column(const stp_table *table, bool is_signed, unsigned number)
{
    if (table->beside[number] == STP_BESIDE_KINDS)
        return WAY_KINDS;
    switch (is_signed ? stp_signed_width(number) : 0) {
    case STP_SIGNED_ALONE:
        return WAY_SIGNED_ALONE;
    case STP_SIGNED_BESIDE:
        return WAY_SIGNED_BESIDE;
    default:
        return WAY_NUMBERS;
    }
}

/* How many odds it has at most. By signed cells they learn at level 0 alone. */
static unsigned odds_of_column(const stp_table *table, bool is_signed, unsigned number)
{
    const unsigned width = is_signed ? stp_signed_width(number) : 0;
    return width == 0 ? STP_KNOWN_CELLS : table->level == 0 ? width : 0;
}

/* The odds of a column before its first cell. first: NULL if they are known. */
static void column_begin(const stp_table *table, stp_first_odds *first, column *c)
{
    const int side = table->tight && table->side ? table->side[c->number] : 0;
    const bool is_b = table->row_kinds && c->number == STP_COLUMN_POSITION_B;
    const unsigned count = c->way == WAY_KINDS ? STP_KNOWN_KINDS
                           : is_b              ? STP_KNOWN_CELLS
                                               : STP_KNOWN_NUMBERS;
    const bool is_signed = c->way == WAY_SIGNED_ALONE || c->way == WAY_SIGNED_BESIDE;
    const uint8_t *curves = is_signed ? stp_signed_column(table->level, c->number) : NULL;
    c->fixed = stp_signed_curves();
    c->curves = table->level > 0 ? curves : NULL;
    if (is_signed && !c->curves)
        stp_signed_cells(curves, stp_signed_width(c->number), c->odds);
    else if (is_signed)
        return;
    else if (!first)
        stp_known_cells(table->known + (size_t)STP_KNOWN_COUNT * c->number, count, c->odds);
    else if (c->way == WAY_KINDS)
        kind_odds_begin(table->tight, c->odds);
    else
        memcpy(c->odds, stp_number_odds_first(first, side), sizeof(stp_number_odds));
}

/* Makes room for columns and, in front of them, their odds. */
static stp_status columns_alloc(const stp_table *table, uint64_t constant, columns *out,
                                stp_odds **odds, stp_error *err)
{
    size_t count = 0;
    for (unsigned k = 0; k < table->column_count; k++)
        count += constant >> k & 1u ? 0 : odds_of_column(table, out->is_signed, k);
    const size_t bytes = count * sizeof **odds + table->column_count * sizeof *out->of;
    const stp_status status =
        stp_alloc_unset(&out->memory, bytes + _Alignof(stp_odds), 1, "columns", err);
    if (status != STP_OK)
        return status;
    *odds =
        (stp_odds *)(((uintptr_t)out->memory + _Alignof(stp_odds) - 1) & ~(_Alignof(stp_odds) - 1));
    out->of = (column *)(*odds + count);
    return STP_OK;
}

static stp_status columns_create(const stp_table *table, uint64_t constant, stp_first_odds *first,
                                 columns *out, stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned *size[STP_TABLE_COLUMNS_LIMIT];
    const column *of[STP_TABLE_COLUMNS_LIMIT];
    stp_odds *odds;
    out->known = !first;
    out->size_least_beside_b = &out->nobody;
    out->row_kinds = first ? NULL : table->row_kinds;
    out->is_signed = out->row_kinds && table->is_signed;
    STP_TRY(columns_alloc(table, constant, out, &odds, err));
    out->first = table->tight ? table->tight_first : table->middles ? table->first : NULL;
    for (unsigned k = 0; k < table->column_count; k++) {
        column *c = &out->of[out->count];
        const int beside = table->beside[k];
        size[k] = &out->alone;
        of[k] = &nobody;
        if (constant >> k & 1u)
            continue;
        *c = (column){.odds = odds,
                      .cells = stp_table_column(table, k),
                      .beside = beside >= 0 ? of[beside] : &nobody,
                      .size_beside = beside >= 0 ? size[beside] : &out->alone,
                      .side = SIDE_ZERO,
                      .side_before = SIDE_ZERO,
                      .size_least = STP_BESIDE_SMALL,
                      .lane = out->count++ % STP_SYMBOL_LANES,
                      .number = k,
                      .way = way_of_column(table, out->is_signed, k)};
        odds += odds_of_column(table, out->is_signed, k);
        size[k] = &c->size;
        of[k] = c;
        out->number_count += c->way != WAY_KINDS;
        if (out->row_kinds && k == STP_COLUMN_POSITION_A)
            out->size_least_beside_b = &c->size_least;
        c->before_shift = out->row_kinds ? 2 : 0;
        column_begin(table, first, c);
    }
done:
    return status;
}

/* If the first means are known, begins them: before the first row, and again after it, whose cells
 * leave means as they are. */
INLINE void begin_known_means(const columns *all)
{
    for (unsigned k = 0; all->first && k < all->count; k++)
        all->of[k].mean = UINT32_C(1) << all->first[all->of[k].number];
}

/* The bits of the mean of the magnitudes of a column, in 1/256. */
static uint8_t first_mean(const int16_t *cells, uint32_t count)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < count; i++)
        sum += (uint64_t)abs(cells[i]);
    const uint32_t mean = count > 0 ? (uint32_t)((sum << STP_MEAN_BITS) / count) : 0;
    return (uint8_t)(stp_significant_bits(mean + mean / 2) - 1);
}

/* Takes what a row's kind tells. */
INLINE row_places row_begin(columns *all, uint32_t row)
{
    if (!all->row_kinds)
        return (row_places){0};
    static const uint8_t least[4] = {STP_BESIDE_SMALL, STP_BESIDE_SMALL,
                                     STP_BESIDE_SMALL + SIZES_BESIDE,
                                     STP_BESIDE_SMALL + 2 * SIZES_BESIDE};
    const unsigned kind = all->row_kinds[row], left = kind & 3u;
    static const uint8_t begin[4] = {0, 7, 1, 0};
    const bool has_elder = row > 0 && (all->row_kinds[row - 1] & 3u) == left + 1;
    all->alone = left;
    *all->size_least_beside_b = least[left];
    return (row_places){.upper = kind & 12u,
                        .lower = kind >> 2 & 4u,
                        .begin = begin[left],
                        .has_elder = has_elder ? UINT_MAX : 0};
}

STP_WIDE
static void put_row(stp_symbol_writer *w, columns *all, uint32_t row)
{
    const int shift = stp_odds_shift(row, all->known);
    const row_places places = row_begin(all, row);
    stp_symbol_writer own = *w; /* nothing else points to it: it stays in registers */
    column *const end = all->of + all->count;
    for (column *c = all->of; c < end; c++)
        if (c->way == WAY_KINDS)
            put_kind(&own, c, &places, (uint8_t)c->cells[row], shift);
        else if (c->way == WAY_NUMBERS)
            put_number(&own, c, c->cells[row], shift);
        else
            put_signed(&own, c, &places, c->cells[row], shift);
    *w = own;
}

static stp_status put_rows(columns *all, uint32_t rows, stp_symbol_writer *w, stp_error *err)
{
    stp_status status = STP_OK;
    begin_known_means(all);
    for (uint32_t i = 0; i < rows; i++) {
        if (i % ROWS_AHEAD == 0)
            STP_TRY(
                stp_symbols_reserve(w, (size_t)STP_NUMBER_ITEMS * all->count * ROWS_AHEAD, err));
        put_row(w, all, i);
        if (i == 0)
            begin_known_means(all);
    }
done:
    return status;
}

stp_status stp_cells_put(const stp_table *table, uint64_t constant, stp_symbol_writer *w,
                         stp_error *err)
{
    columns all = {0};
    stp_status status = columns_create(table, constant, NULL, &all, err);
    if (status == STP_OK)
        status = put_rows(&all, table->row_count, w, err);
    free(all.memory);
    return status;
}

stp_status stp_cells_encode(const stp_table *table, uint64_t constant, stp_bytes *out,
                            stp_error *err)
{
    stp_status status = STP_OK;
    stp_symbol_writer w = {0};
    columns all = {0};
    stp_first_odds first;
    memset(first.known, 0, sizeof first.known);
    STP_TRY(columns_create(table, constant, &first, &all, err));
    if (all.count == 0)
        goto done;
    for (unsigned k = 0; k < all.count && !all.first; k++) {
        const uint8_t mean = first_mean(all.of[k].cells, table->row_count);
        all.of[k].mean = UINT32_C(1) << mean;
        if (all.of[k].way != WAY_KINDS)
            STP_TRY(stp_bytes_append(out, &mean, 1, err));
    }
    STP_TRY(put_rows(&all, table->row_count, &w, err));
    STP_TRY(stp_symbols_write(&w, out, err));
done:
    free(w.items);
    free(all.memory);
    return status;
}

/* Begins the means, by bytes in front of the symbols unless they are known. *used: these bytes. */
static stp_status take_first(const uint8_t *bytes, size_t size, columns *all, size_t *used,
                             stp_error *err)
{
    *used = all->first ? 0 : all->number_count;
    begin_known_means(all);
    if (*used > size)
        return stp_error_set(err, STP_CORRUPT, "a table ends before its columns");
    for (unsigned k = 0; k < all->count && !all->first; k++) {
        if (all->of[k].way == WAY_KINDS)
            continue;
        if (*bytes > FIRST_MOST)
            return stp_error_set(err, STP_CORRUPT, "a column begins with a mean of 2^%u", *bytes);
        all->of[k].mean = UINT32_C(1) << *bytes++;
    }
    return STP_OK;
}

/* counted: adds up each column's bytes; known: odds are known. Constants in each caller. */
INLINE void decode_rows_as(stp_symbol_reader *r, columns *all, uint32_t rows, bool counted,
                           bool known)
{
    stp_symbol_reader own = *r; /* nothing else points to it: it stays in registers */
    column *const end = all->of + all->count;
    for (uint32_t i = 0; i < rows; i++) {
        const int shift = stp_odds_shift(i, known);
        const row_places places = known ? row_begin(all, i) : (row_places){0};
        for (column *c = all->of; c < end; c++) {
            const uint8_t *begin = own.next;
            c->cells[i] = c->way == WAY_KINDS     ? get_kind(&own, c, &places, shift)
                          : c->way == WAY_NUMBERS ? get_number(&own, c, shift)
                                                  : get_signed(&own, c, &places, shift);
            if (counted)
                c->bytes += (uint64_t)(own.next - begin);
        }
        if (i == 0)
            begin_known_means(all);
    }
    *r = own;
}

INLINE void decode_rows(stp_symbol_reader *r, columns *all, uint32_t rows, bool counted)
{
    if (all->known)
        decode_rows_as(r, all, rows, counted, true);
    else
        decode_rows_as(r, all, rows, counted, false);
}

#ifdef __x86_64__
/* The same for processors with wider registers, with the same results. */
__attribute__((target("avx2,bmi,bmi2,lzcnt"))) static void
decode_rows_wide(stp_symbol_reader *r, columns *all, uint32_t rows)
{
    decode_rows(r, all, rows, false);
}

#define AVX512 "avx512f,avx512bw,avx512dq,avx512vl,bmi,bmi2,lzcnt"
#ifdef __clang__
__attribute__((target(AVX512))) static void
#else
__attribute__((target(AVX512 ",prefer-vector-width=512"))) static void
#endif
decode_rows_widest(stp_symbol_reader *r, columns *all, uint32_t rows)
{
    decode_rows(r, all, rows, false);
}
#endif

static void decode_quickly(stp_symbol_reader *r, columns *all, uint32_t rows)
{
#ifdef __x86_64__
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) {
        decode_rows_widest(r, all, rows);
        return;
    }
    if (__builtin_cpu_supports("avx2")) {
        decode_rows_wide(r, all, rows);
        return;
    }
#endif
    decode_rows(r, all, rows, false);
}

/* Decodes all columns. Adds what each takes to the table's count, if somebody asks. */
static void get_rows(stp_symbol_reader *r, columns *all, const stp_table *table)
{
    if (!table->column_bytes) {
        decode_quickly(r, all, table->row_count);
        return;
    }
    decode_rows(r, all, table->row_count, true);
    for (unsigned k = 0; k < all->count; k++)
        table->column_bytes[all->of[k].number] += all->of[k].bytes;
}

stp_status stp_cells_get(stp_symbol_reader *r, uint64_t constant, stp_first_odds *first,
                         const stp_table *table, stp_error *err)
{
    columns all = {0};
    const stp_status status = columns_create(table, constant, first, &all, err);
    if (status == STP_OK) {
        begin_known_means(&all);
        get_rows(r, &all, table);
    }
    free(all.memory);
    return status;
}

stp_status stp_cells_decode(const uint8_t *bytes, size_t size, uint64_t constant, stp_table *table,
                            stp_error *err)
{
    stp_status status = STP_OK;
    stp_symbol_reader r;
    columns all = {0};
    stp_first_odds first;
    size_t used = 0;
    memset(first.known, 0, sizeof first.known);
    STP_TRY(columns_create(table, constant, &first, &all, err));
    if (all.count == 0 && size == 0)
        goto done;
    STP_TRY(take_first(bytes, size, &all, &used, err));
    STP_TRY(stp_symbols_begin(&r, bytes + used, size - used, err));
    get_rows(&r, &all, table);
    STP_TRY(stp_symbols_end(&r, err));
done:
    free(all.memory);
    return status;
}

/* Finds, encodes and decodes squares of grids. */
#include "formats/chunk/codec/square/square.h"

#include "base/memory.h"
#include "base/wide.h"
#include "formats/chunk/codec/inline.h"
#include "formats/chunk/codec/square/camera_raster.h"
#include "formats/chunk/layout.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A level raster: f64 x, y, dx, dy; u32 column, row of the first square */
#define LEVEL_BYTES 40u
/* Tilted ones: u16 count - 1; each u8 axis, 2 f64, 6 f32, 2 u32 column, row of its first square */
#define COUNT_BYTES 2u
#define TILTED_BYTES 49u
/* One that spreads has this bit beside its axis, and four floats more before column and row. */
#define SPREADS 4u
#define SPREAD_BYTES 16u
/* One whose numbers are short has this bit, and 2 f32, 6 numbers of 3 bytes, 2 u8 instead. With
 * both bits it is a camera's (camera_raster.h). */
#define SHORT 8u
#define SHORT_BYTES 29u
#define SHORT_PLACES 256u
#define MASK_BYTES 8u
/* Column and row after those of the square before; then the bytes of the mask; the raster after
 * that of the square before. */
#define LEVEL_COLUMNS (2u + MASK_BYTES)
#define RASTER_COLUMN LEVEL_COLUMNS
#define TILTED_COLUMNS (LEVEL_COLUMNS + 1u)
#define DELTA_MOST 32767
/* A block of more patches is not coded as tilted: steps from square to square of a raster, and from
 * raster to raster, are then sure to be no greater. */
#define TILTED_PATCHES_MOST 8000u
/* A sample lies this near to its place in a tilted grid, in columns and rows: else one of several
 * grids would do as well as another. */
#define TILTED_OFF_MOST 0.125
/* The same of one that spreads: a scanner's angles are rough, and the nearest raster is asked for.
 */
#define SPREAD_OFF_MOST 0.375
/* Squares of fewer samples may lie on several tilted grids by chance: they belong to the one that
 * they are nearest to. */
#define SURE_SAMPLES 8u
/* But to that of the square before, if they are this near to it: rounding takes as much. */
#define ROUNDED_OFF 0.03

static const int16_t square_beside[TILTED_COLUMNS] = {STP_BESIDE_NONE,  0,
                                                      STP_BESIDE_KINDS, STP_BESIDE_KINDS,
                                                      STP_BESIDE_KINDS, STP_BESIDE_KINDS,
                                                      STP_BESIDE_KINDS, STP_BESIDE_KINDS,
                                                      STP_BESIDE_KINDS, STP_BESIDE_KINDS,
                                                      STP_BESIDE_NONE};

/* Of tight tables: the bits of the means that odds begin with. */
static const uint8_t square_first[TILTED_COLUMNS] = {8, 8, [RASTER_COLUMN] = 5};

/* ---- finding ---- */

/* How many columns and rows samples are looked for in. */
STP_INLINE double raster_side(const stp_raster *raster)
{
    return raster->side ? raster->side : (double)STP_SQUARE_PLACES_LIMIT * STP_SQUARE_SIDE;
}

/* The column and row of a tilted raster that are nearest to a position. *off: how far it is off at
 * most, if it was less. */
STP_INLINE bool find_place(const stp_raster *raster, const double position[3], uint32_t out[2],
                           double *off)
{
    const double(*a)[6] = raster->across;
    const double off_most = stp_raster_spreads(raster) ? SPREAD_OFF_MOST : TILTED_OFF_MOST;
    const double most = raster_side(raster);
    const double height = position[raster->axis];
    double rest[2], by[2][2], place[2]; /* by column and row, at this height */
    for (unsigned k = 0; k < 2; k++) {
        rest[k] = position[(raster->axis + 1 + k) % 3] - a[k][0] - a[k][3] * height;
        for (unsigned i = 0; i < 2; i++)
            by[k][i] = a[k][1 + i] + a[k][4 + i] * height;
    }
    const double det = by[0][0] * by[1][1] - by[0][1] * by[1][0];
    place[0] = (rest[0] * by[1][1] - rest[1] * by[0][1]) / det;
    place[1] = (rest[1] * by[0][0] - rest[0] * by[1][0]) / det;
    for (unsigned k = 0; k < 2; k++) {
        const double nearest = floor(place[k] + 0.5);
        if (!(nearest >= raster->first[k] && nearest < raster->first[k] + most) ||
            fabs(place[k] - nearest) > off_most)
            return false;
        out[k] = (uint32_t)nearest;
        *off = stp_max(*off, fabs(place[k] - nearest));
    }
    return true;
}

/* The same of all samples of a patch on a level raster, where heights do not matter. */
STP_INLINE bool find_level_places(const stp_raster *raster, const stp_patch *patch,
                                  const stp_sample *samples, uint32_t out[2][STP_PATCH_SAMPLES],
                                  double *off)
{
    const double(*a)[6] = raster->across;
    const double step = stp_power_of_two(patch->exponent);
    const double det = a[0][1] * a[1][2] - a[0][2] * a[1][1];
    double rest[2][STP_PATCH_SAMPLES], apart[STP_PATCH_SAMPLES];
    int inside = 1;
    for (unsigned i = 0; i < patch->counts[0]; i++)
        for (unsigned k = 0; k < 2; k++)
            rest[k][i] = ((double)patch->origin[k] + samples[i].position[k]) * step - a[k][0];
    for (unsigned k = 0; k < 2; k++) {
        const double along = a[1 - k][2 - k], across = a[k][2 - k], first = raster->first[k];
        const double end = first + raster_side(raster);
        for (unsigned i = 0; i < patch->counts[0]; i++) {
            const double place = (rest[k][i] * along - rest[1 - k][i] * across) / det;
            const double nearest = floor(place + 0.5);
            const bool in = (nearest >= first) & (nearest < end);
            inside &= in;
            apart[i] = fabs(place - nearest);
            out[k][i] = (uint32_t)(int32_t)(in ? nearest : 0.0);
        }
        for (unsigned i = 0; i < patch->counts[0]; i++)
            *off = stp_max(*off, apart[i]);
    }
    return inside != 0;
}

/* The same on a tilted raster. */
STP_INLINE bool find_tilted_places(const stp_raster *raster, const stp_patch *patch,
                                   const stp_sample *samples, uint32_t out[2][STP_PATCH_SAMPLES],
                                   double *off)
{
    for (unsigned i = 0; i < patch->counts[0]; i++) {
        const stp_dvec3 p = stp_sample_position(&samples[i], patch);
        uint32_t at[2];
        if (!find_place(raster, (const double[3]){p.x, p.y, p.z}, at, off))
            return false;
        out[0][i] = at[0];
        out[1][i] = at[1];
    }
    return true;
}

STP_WIDE
static bool find_square(const stp_raster *raster, const stp_patch *patch, const stp_sample *samples,
                        stp_square *out, double *off)
{
    uint32_t at[2][STP_PATCH_SAMPLES];
    int before = -1;
    at[0][0] = at[1][0] = 0;
    *out = (stp_square){0};
    *off = 0.0;
    if (raster->level ? !find_level_places(raster, patch, samples, at, off)
                      : !find_tilted_places(raster, patch, samples, at, off))
        return false;
    out->column = at[0][0] / STP_SQUARE_SIDE;
    out->row = at[1][0] / STP_SQUARE_SIDE;
    for (unsigned i = 0; i < patch->counts[0]; i++) {
        const uint32_t c = at[0][i], r = at[1][i];
        const int bit = (int)stp_square_morton(c % STP_SQUARE_SIDE, r % STP_SQUARE_SIDE);
        if (bit <= before || c / STP_SQUARE_SIDE != out->column || r / STP_SQUARE_SIDE != out->row)
            return false;
        out->samples |= UINT64_C(1) << bit;
        before = bit;
    }
    return true;
}

/* Finds the square in one of the rasters: the first one, from `first` on; the nearest one, if the
 * square has few samples. */
static bool find_square_in(const stp_chunk *block, uint32_t p, uint32_t first, stp_square *out)
{
    const bool is_sure = block->patches[p].counts[0] >= SURE_SAMPLES;
    double least = INFINITY;
    for (uint32_t i = 0; i < block->raster_count; i++) {
        stp_square found;
        double off;
        const uint32_t raster = (first + i) % block->raster_count;
        if (!find_square(&block->rasters[raster], &block->patches[p],
                         block->samples[0] + block->level_begin[0][p], &found, &off) ||
            off >= least)
            continue;
        found.raster = raster;
        *out = found;
        least = off;
        if (is_sure || (i == 0 && off < ROUNDED_OFF))
            break;
    }
    return least < INFINITY;
}

static bool follows(uint32_t place, uint32_t before)
{
    return labs((long)place - (long)before) <= DELTA_MOST;
}

/* Whether a tilted raster comes back as it is. */
static bool is_of_floats(const stp_raster *raster)
{
    for (int k = 0; k < 2; k++)
        for (int i = 1; i < 6; i++)
            if ((double)(float)raster->across[k][i] != raster->across[k][i])
                return false;
    return true;
}

/* Whether a square can be coded in the block of the one before, which may be the same. */
static bool may_follow(const stp_chunk *block, const stp_square *before, const stp_square *square)
{
    const stp_raster *raster = &block->rasters[square->raster];
    if (raster->level)
        return before->raster == square->raster && follows(square->column, before->column) &&
               follows(square->row, before->row);
    return !block->rasters[before->raster].level && is_of_floats(raster) &&
           block->patch_count <= TILTED_PATCHES_MOST;
}

bool stp_squares_find(const stp_chunk *block, stp_square *out)
{
    for (uint32_t p = 0; p < block->patch_count; p++) {
        const stp_square *before = &out[p ? p - 1 : 0];
        if (!find_square_in(block, p, p ? before->raster : 0, &out[p]))
            return false;
        if (!may_follow(block, before, &out[p]))
            return false;
    }
    return true;
}

/* ---- coding ---- */

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

static stp_status put_level(const stp_raster *r, const stp_square *first, stp_bytes *out,
                            stp_error *err)
{
    uint8_t head[LEVEL_BYTES];
    const double numbers[4] = {r->across[0][0], r->across[1][0], r->across[0][1], r->across[1][2]};
    for (unsigned i = 0; i < 4; i++)
        stp_put_f64(head + 8 * i, numbers[i]);
    stp_put_u32(head + 32, first->column);
    stp_put_u32(head + 36, first->row);
    return stp_bytes_append(out, head, sizeof head, err);
}

static bool is_short(const stp_raster *r, const stp_square *first)
{
    for (unsigned k = 0; k < 2; k++) {
        if ((double)(float)r->across[k][0] != r->across[k][0])
            return false;
        for (unsigned i = 1; i < 4; i++)
            if (stp_raster_short(r->across[k][i]) != r->across[k][i])
                return false;
    }
    return !stp_raster_spreads(r) && first->column < SHORT_PLACES && first->row < SHORT_PLACES;
}

static size_t put_short(const stp_raster *r, const stp_square *first, uint8_t *to)
{
    *to++ = (uint8_t)(r->axis | SHORT);
    for (unsigned k = 0; k < 2; k++) {
        for (unsigned i = 0; i < 4; i++) {
            const unsigned left_out = i > 0;
            uint8_t bytes[4];
            stp_put_floats(bytes, (const float[1]){(float)r->across[k][i]}, 1);
            memcpy(to, bytes + left_out, 4 - left_out);
            to += 4 - left_out;
        }
    }
    to[0] = (uint8_t)first->column;
    to[1] = (uint8_t)first->row;
    return SHORT_BYTES;
}

/* Returns the bytes. */
static size_t put_tilted(const stp_raster *r, const stp_square *first, uint8_t *to)
{
    const bool spreads = stp_raster_spreads(r);
    *to++ = (uint8_t)(r->axis | (spreads ? SPREADS : 0));
    for (unsigned k = 0; k < 2; k++, to += 20) {
        const float slopes[3] = {(float)r->across[k][1], (float)r->across[k][2],
                                 (float)r->across[k][3]};
        stp_put_f64(to, r->across[k][0]);
        stp_put_floats(to + 8, slopes, 3);
    }
    for (unsigned k = 0; spreads && k < 2; k++, to += 8)
        stp_put_floats(to, (const float[2]){(float)r->across[k][4], (float)r->across[k][5]}, 2);
    stp_put_u32(to, first->column);
    stp_put_u32(to + 4, first->row);
    return TILTED_BYTES + (spreads ? SPREAD_BYTES : 0);
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

static stp_status put_rasters(const stp_chunk *block, const stp_square *squares,
                              const used_rasters *used, bool tilted, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t head[TILTED_BYTES + SPREAD_BYTES];
    if (!tilted)
        return put_level(&block->rasters[squares[0].raster], &squares[0], out, err);
    stp_put_u16(head, (uint16_t)(used->count - 1));
    STP_TRY(stp_bytes_append(out, head, COUNT_BYTES, err));
    for (uint32_t i = 0; i < used->count; i++) {
        const stp_square *first = &used->before[i];
        const stp_raster *raster = &block->rasters[first->raster];
        size_t size = stp_camera_raster_put(raster, first, head);
        if (size == 0)
            size = is_short(raster, first) ? put_short(raster, first, head)
                                           : put_tilted(raster, first, head);
        STP_TRY(stp_bytes_append(out, head, size, err));
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
    STP_TRY(put_rasters(block, squares, &used, tilted, rasters, err));
    STP_TRY(stp_squares_table(block->patch_count, tilted, table, err));
    fill_table(squares, block->patch_count, &used, tilted, table);
done:
    free(used.places);
    free(used.before);
    return status;
}

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

static stp_raster get_level(const uint8_t *bytes)
{
    return (stp_raster){.level = true,
                        .axis = 2,
                        .across = {{stp_get_f64(bytes), stp_get_f64(bytes + 16)},
                                   {stp_get_f64(bytes + 8), 0.0, stp_get_f64(bytes + 24)}}};
}

static stp_raster get_tilted(const uint8_t *bytes)
{
    const bool spreads = *bytes & SPREADS;
    stp_raster out = {.axis = *bytes++ & ~SPREADS};
    for (unsigned k = 0; k < 2; k++, bytes += 20) {
        float slopes[3];
        out.across[k][0] = stp_get_f64(bytes);
        stp_get_floats(bytes + 8, slopes, 3);
        for (unsigned i = 0; i < 3; i++)
            out.across[k][1 + i] = (double)slopes[i];
    }
    for (unsigned k = 0; spreads && k < 2; k++, bytes += 8) {
        float spread[2];
        stp_get_floats(bytes, spread, 2);
        out.across[k][4] = (double)spread[0];
        out.across[k][5] = (double)spread[1];
    }
    return out;
}

static stp_raster get_short(const uint8_t *bytes)
{
    stp_raster out = {.axis = *bytes++ & ~SHORT};
    for (unsigned k = 0; k < 2; k++)
        for (unsigned i = 0; i < 4; i++) {
            const unsigned left_out = i > 0;
            uint8_t all[4] = {0};
            float number;
            memcpy(all + left_out, bytes, 4 - left_out);
            stp_get_floats(all, &number, 1);
            out.across[k][i] = (double)number;
            bytes += 4 - left_out;
        }
    return out;
}

/* Takes the next raster and its first square. Returns the bytes; 0: there are not so many. */
static size_t get_raster(const stp_cursor *c, bool tilted, stp_raster *raster, stp_square *first)
{
    const uint8_t kind = tilted && c->left > 0 ? *c->bytes : 0;
    const size_t size = !tilted          ? LEVEL_BYTES
                        : kind & SHORT   ? SHORT_BYTES
                        : kind & SPREADS ? TILTED_BYTES + SPREAD_BYTES
                                         : TILTED_BYTES;
    if ((kind & STP_CAMERA_RASTER) == STP_CAMERA_RASTER)
        return stp_camera_raster_get(c->bytes, c->left, raster, first);
    if (size > c->left)
        return 0;
    *raster = !tilted        ? get_level(c->bytes)
              : kind & SHORT ? get_short(c->bytes)
                             : get_tilted(c->bytes);
    const uint8_t *end = c->bytes + size;
    first->column = kind & SHORT ? end[-2] : stp_get_u32(end - 8);
    first->row = kind & SHORT ? end[-1] : stp_get_u32(end - 4);
    return size;
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
        const size_t size = get_raster(c, tilted, &block->rasters[i], &(*first)[i]);
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

/* Codes the levels of a block of squares. */
#include "formats/chunk/codec/square/square_level.h"

#include "base/wide.h"
#include "formats/chunk/codec/predict/predict_normal.h"
#include "formats/chunk/codec/square/square_normal.h"
#include "formats/chunk/codec/square/square_slope.h"
#include "formats/chunk/sample/normal_grid.h"

#include <math.h>
#include <stdlib.h>

/* All that the functions of loops call with numbers is a part of them. GCC 12 leaves out vzeroupper
 * before a call of a static function that it knows to keep some registers: code for AVX2
 * (base/wide.h) then waits at each such call, and again behind it. */

/* Values that have slopes. */
enum { HEIGHT, GREEN, RED, BLUE, VALUE_COUNT };
static const uint8_t channel[VALUE_COUNT] = {[GREEN] = 1, [RED] = 0, [BLUE] = 2};

typedef struct coder {
    const stp_chunk *block;
    stp_square_map *map;
    const stp_ladder *ladder; /* NULL: none */
    const stp_level_tables *tables;
    const double *values[VALUE_COUNT]; /* of the samples of the next coarser level */
    const stp_square_grid *grid;       /* of the patch at hand */
    const stp_square_choice *choice;
    int level;
    bool heights_only; /* have slopes now: colours are coded by rows */
    bool decode;
} coder;

/* The next rows of a level's two tables. */
typedef struct rows {
    uint32_t elder, last;
} rows;

/* A row of a table: `column` at cell + column * stride. */
typedef struct table_row {
    int16_t *cell;
    size_t stride;
} table_row;

STP_INLINE table_row next_row(const coder *c, rows *r, bool youngest)
{
    const stp_table *table = youngest ? &c->tables->last : &c->tables->elder;
    return (table_row){table->values + (youngest ? r->last++ : r->elder++), table->stride};
}

/* Codes a value modulo mask + 1, with the cell of least magnitude. Returns the value. */
STP_INLINE int32_t code(const coder *c, const table_row *r, unsigned column, int32_t predicted,
                        int32_t value, int32_t mask)
{
    int16_t *cell = r->cell + column * r->stride;
    if (c->decode)
        return (predicted + *cell) & mask;
    const int32_t low = (value - predicted) & mask;
    *cell = (int16_t)(low > mask >> 1 ? low - mask - 1 : low);
    return value;
}

/* The same of a byte of a sample. Encoding writes no samples: other threads may read them. */
STP_INLINE int32_t code_byte(const coder *c, const table_row *r, unsigned column, int32_t predicted,
                             uint8_t *byte)
{
    const int32_t value = code(c, r, column, predicted, *byte, 0xff);
    if (c->decode)
        *byte = (uint8_t)value;
    return value;
}

/* ---- a family ---- */

typedef struct family {
    stp_square_field field;
    double left[VALUE_COUNT]; /* what is left of the parent's mean */
    unsigned count;
    uint32_t parent, first; /* samples */
    const stp_patch *patch;
    double steps; /* of the finest lattice in one of the patch */
    stp_patch_scale scale;
    uint64_t tied,
        loose; /* magnitudes of cells of colours, if they are not loose and if they are */
} family;

/* Sets what is expected of child k. */
STP_INLINE void expect(const coder *c, const family *f, unsigned k, double out[VALUE_COUNT])
{
    const stp_square_level *on = &c->grid->level[c->level];
    if (c->heights_only) /* loops of a constant length */
        stp_square_expect(&f->field, on, c->level, f->first + k, f->count, 1, out);
    else
        stp_square_expect(&f->field, on, c->level, f->first + k, f->count, VALUE_COUNT, out);
}

/* The position along the height, coded as a rung. */
STP_INLINE int32_t code_rung(const coder *c, const family *f, const table_row *r, double expected,
                             int32_t position)
{
    const int32_t origin = f->patch->origin[c->grid->raster->axis];
    const double least = ((double)origin + position - 0.5) * f->steps;
    const uint32_t own = c->decode ? 0 : stp_ladder_over(c->ladder, least);
    const uint32_t place = stp_ladder_nearest(c->ladder, expected);
    uint32_t rung =
        (uint32_t)code(c, r, STP_COLUMN_POSITION_C, (int32_t)place, (int32_t)own, 0xffff);
    rung = rung < c->ladder->count ? rung : c->ladder->count - 1;
    return stp_square_whole(c->ladder->rungs[rung] / f->steps - origin) & 0xffff;
}

/* The position along the height, where heights are multiples of 2^steps. expected: not rounded. */
STP_INLINE int32_t code_step(const coder *c, const family *f, const table_row *r, double expected,
                             int32_t position)
{
    const int32_t origin = f->patch->origin[c->grid->raster->axis];
    const int own_steps = f->patch->exponent - c->map->exponent, steps = (int)c->choice->steps;
    const int shift = steps > own_steps ? steps - own_steps : 0;
    const int32_t first = (int32_t)(-(uint32_t)origin & ((UINT32_C(1) << shift) - 1));
    const int32_t place = (stp_square_whole(expected) - first + (1 << shift >> 1)) >> shift;
    const int32_t own = c->decode ? 0 : (position - first) >> shift;
    const int32_t coded = code(c, r, STP_COLUMN_POSITION_C, place, own, 0xffff >> shift);
    return (first + coded * (1 << shift)) & 0xffff;
}

STP_INLINE void code_height(const coder *c, const family *f, const table_row *r, uint32_t child,
                            double expected, stp_sample *s)
{
    const unsigned axis = c->grid->raster->axis;
    const int32_t origin = f->patch->origin[axis];
    double steps = expected / f->steps - origin;
    steps = steps > -65536.0 ? steps : -65536.0;
    steps = steps < 131072.0 ? steps : 131072.0;
    int32_t position = s->position[axis];
    if (c->ladder) {
        position = code_rung(c, f, r, expected, position);
    } else if (f->scale.used) {
        const int32_t place = stp_scale_nearest(steps * f->scale.places + f->scale.offset[axis]);
        const int32_t own = c->decode ? 0 : stp_scale_place(&f->scale, (int)axis, position);
        const int32_t coded = code(c, r, STP_COLUMN_POSITION_C, place & 0xffff, own, 0xffff);
        position = c->decode ? stp_scale_position(&f->scale, (int)axis, coded) : position;
    } else if (c->choice->steps > 0) {
        position = code_step(c, f, r, steps, position);
    } else {
        position = code(c, r, STP_COLUMN_POSITION_C, stp_square_whole(steps), position, 0xffff);
    }
    if (c->decode)
        s->position[axis] = (uint16_t)position;
    c->grid->level[c->level].height[child] = ((double)origin + position) * f->steps;
}

/* Codes the position along the other axes: where the grid's place is at this height. */
STP_INLINE void code_across(const coder *c, const family *f, const table_row *r, uint32_t child,
                            stp_sample *s)
{
    const unsigned along = c->grid->raster->axis;
    for (int k = 0; k < 2; k++) {
        const unsigned axis = (along + 1 + (unsigned)k) % 3;
        const int32_t expected =
            stp_square_across(c->grid, c->level, child, k, f->patch, s->position[along]);
        const int32_t position =
            code(c, r, STP_COLUMN_POSITION_A + (unsigned)k, expected, s->position[axis], 0xffff);
        if (c->decode)
            s->position[axis] = (uint16_t)position;
    }
}

/* Codes the colours of a child. share: of what is left of the parent's. */
STP_INLINE void code_colours(const coder *c, family *f, const table_row *r,
                             const double expected[VALUE_COUNT], double share, stp_sample *s)
{
    static const uint8_t column[VALUE_COUNT] = {
        [GREEN] = STP_COLUMN_GREEN, [RED] = STP_COLUMN_RED, [BLUE] = STP_COLUMN_BLUE};
    for (int v = GREEN; v <= BLUE; v++) {
        /* NOLINTNEXTLINE(clang-analyzer-core.*): expect has set it, unless colours go by rows */
        const double tied = expected[v] + share * f->left[v];
        const int32_t value =
            code_byte(c, r, column[v], stp_square_whole(c->choice->loose ? expected[v] : tied),
                      &s->rgb[channel[v]]);
        f->left[v] += expected[v] - value;
        f->tied += c->decode ? 0 : (uint64_t)abs(value - stp_square_whole(tied));
        f->loose += c->decode ? 0 : (uint64_t)abs(value - stp_square_whole(expected[v]));
    }
}

/* Codes what a child has besides normal and radius. */
STP_INLINE void code_child(const coder *c, family *f, unsigned k, const table_row *r)
{
    const uint32_t child = f->first + k;
    const stp_sample *parent = &c->block->samples[c->level + 1][f->parent];
    stp_sample *s = &c->block->samples[c->level][child];
    double expected[VALUE_COUNT];
    const double share = 1.0 / (f->count - k);
    expect(c, f, k, expected);
    const bool same = s->flags == parent->flags && s->class_id == parent->class_id &&
                      s->intensity == parent->intensity;
    if (c->decode || !same) { /* cells are 0 */
        code_byte(c, r, STP_COLUMN_FLAGS, parent->flags, &s->flags);
        code_byte(c, r, STP_COLUMN_CLASS, parent->class_id, &s->class_id);
        code_byte(c, r, STP_COLUMN_INTENSITY, parent->intensity, &s->intensity);
    }
    if (!c->choice->rows)
        code_colours(c, f, r, expected, share, s);
    code_height(c, f, r, child, expected[HEIGHT] + share * f->left[HEIGHT], s);
    code_across(c, f, r, child, s);
    f->left[HEIGHT] += expected[HEIGHT] - c->grid->level[c->level].height[child];
}

/* Finds the family of a patch's parent j. */
static void find_family(const coder *c, uint32_t p, unsigned j, family *f)
{
    const unsigned parents = f->patch->counts[c->level + 1], children = f->patch->counts[c->level];
    const unsigned begin = stp_level_children_begin(j, parents, children);
    f->count = stp_level_children_begin(j + 1, parents, children) - begin;
    f->parent = c->block->level_begin[c->level + 1][p] + j;
    f->first = c->block->level_begin[c->level][p] + begin;
}

/* Lets slopes of heights stop at jumps of the depth. */
STP_INLINE void stop_slopes(const coder *c, family *f)
{
    const int level = c->level + 1, parent = (int)f->parent;
    const stp_slope_limit limit = stp_slope_limit_at(c->map, c->grid, level, parent);
    const stp_slope_field own =
        stp_slope_field_at(&c->grid->level[level], level, parent, &limit, c->values[HEIGHT]);
    f->field.by_column[HEIGHT] = own.by_column;
    f->field.by_row[HEIGHT] = own.by_row;
    f->field.across[HEIGHT] = own.across;
}

STP_INLINE void begin_family(const coder *c, family *f)
{
    const int level = c->level + 1;
    const stp_square_level *on = &c->grid->level[level];
    f->field = c->heights_only
                   ? stp_square_field_at(on, level, (int32_t)f->parent, c->values, 1)
                   : stp_square_field_at(on, level, (int32_t)f->parent, c->values, VALUE_COUNT);
    for (int v = 0; v < VALUE_COUNT; v++)
        f->left[v] = 0.0;
}

/* A walk over the families of a level. Begins as zeros. */
typedef struct walk {
    rows next;      /* of the tables */
    uint32_t patch; /* of the next family */
    unsigned parent;
    family f; /* at hand */
} walk;

/* Goes to the next family; false if there is none. */
static bool next_family(coder *c, walk *w)
{
    while (w->patch < c->block->patch_count &&
           w->parent == c->block->patches[w->patch].counts[c->level + 1]) {
        w->patch++;
        w->parent = 0;
    }
    if (w->patch == c->block->patch_count)
        return false;
    w->f.patch = &c->block->patches[w->patch];
    c->grid = stp_square_grid_of(c->map, w->patch);
    find_family(c, w->patch, w->parent++, &w->f);
    return true;
}

/* Returns whether colours take less if they are loose. */
STP_WIDE
static bool code_families(coder *c)
{
    walk w = {0};
    c->heights_only = c->choice->rows;
    while (next_family(c, &w)) {
        if (w.parent == 1) {
            w.f.steps = stp_square_map_steps(c->map, w.f.patch);
            w.f.scale = stp_scale_of_patch(&c->tables->last.scale, w.f.patch);
        }
        begin_family(c, &w.f);
        if (c->map->stops)
            stop_slopes(c, &w.f);
        for (unsigned k = 0; k < w.f.count; k++) {
            const table_row next = next_row(c, &w.next, k + 1 == w.f.count);
            code_child(c, &w.f, k, &next);
        }
    }
    c->heights_only = false;
    return w.f.loose < w.f.tied;
}

/* ---- normals and radii, when all heights of the level are known ---- */

STP_INLINE void code_normal(const coder *c, const table_row *r, const double direction[2],
                            stp_sample *s)
{
    const unsigned shift = c->tables->last.normal_shift;
    int32_t uv[2];
    stp_normal_codes_get(s->normal, uv);
    for (unsigned i = 0; i < 2; i++) {
        const int32_t place = stp_square_whole(direction[i] / (double)(1 << shift));
        const int32_t own = c->decode ? 0 : stp_normal_grid_place(uv[i], shift);
        const int32_t coded = code(c, r, STP_COLUMN_NORMAL_U + i, place, own, 0xffff);
        uv[i] = stp_normal_grid_code(coded, shift);
    }
    if (c->decode)
        stp_normal_codes_put(uv, s->normal);
}

/* The same of a raster that spreads. Normals that face a camera are where codes are folded. False:
 * the normal is not off by multiples of 2^stride. */
STP_INLINE bool code_folded(const coder *c, const table_row *r, const double direction[2],
                            unsigned stride, stp_sample *s)
{
    const unsigned shift = c->tables->last.normal_shift;
    const int32_t top = stp_normal_grid_place(STP_NORMAL_CODE_MAX, shift);
    int32_t uv[2], own[2], expected[2];
    stp_normal_codes_get(s->normal, uv);
    for (int i = 0; i < 2; i++) {
        expected[i] = stp_square_whole(direction[i] / (double)(1 << shift));
        own[i] = stp_normal_grid_place(uv[i], shift);
    }
    const bool fits = c->decode || stp_square_unfold(own, expected, top, c->choice->sides, stride);
    for (unsigned i = 0; i < 2; i++) {
        const int32_t off = (own[i] - expected[i]) >> stride;
        const int16_t cell = (int16_t)code(c, r, STP_COLUMN_NORMAL_U + i, 0, off, 0xffff);
        own[i] = (int16_t)(expected[i] + cell * (1 << stride));
    }
    if (!c->decode)
        return fits;
    stp_square_fold(own, top);
    for (int i = 0; i < 2; i++)
        own[i] = own[i] < 0 ? 0 : own[i] > top ? top : own[i];
    if (c->choice->sides)
        stp_normal_side(own, top);
    uv[0] = stp_normal_grid_code(own[0], shift);
    uv[1] = stp_normal_grid_code(own[1], shift);
    stp_normal_codes_put(uv, s->normal);
    return true;
}

/* Kinds of a sample for its radius: how steep it is, and whether a neighbour is missing. */
#define STEEPNESS_COUNT 5u
#define KIND_COUNT (2u * STEEPNESS_COUNT)

STP_INLINE unsigned kind_of(const coder *c, uint32_t sample)
{
    const stp_raster *raster = c->grid->raster;
    const stp_sample *s = &c->block->samples[c->level][sample];
    double tilt[2] = {0.0, 0.0};
    int32_t uv[2];
    for (int k = 0; k < 2 && !raster->level; k++)
        tilt[k] = stp_square_tilt(c->grid, c->level, sample, k);
    stp_normal_codes_get(s->normal, uv);
    const stp_ivec3 n = stp_integer_normal(uv[0], uv[1]);
    const double length = (double)(n.v[0] * n.v[0] + n.v[1] * n.v[1] + n.v[2] * n.v[2]);
    const double all = length * (1.0 + (tilt[0] * tilt[0] + tilt[1] * tilt[1]));
    const double along = n.v[raster->axis] + (tilt[0] * n.v[(raster->axis + 1) % 3] +
                                              tilt[1] * n.v[(raster->axis + 2) % 3]);
    const double upright = along * along;
    unsigned kind = 0;
    for (double ratio = M_SQRT2; kind + 1 < STEEPNESS_COUNT && all >= ratio * upright; ratio *= 2.0)
        kind++;
    return kind +
           (stp_square_is_beside_hole(c->map, c->grid, c->level, sample) ? STEEPNESS_COUNT : 0);
}

/* The last radius of each kind, in codes on the finest lattice. */
STP_INLINE void code_radius(const coder *c, const table_row *r, const stp_patch *patch,
                            uint32_t sample, int32_t last[KIND_COUNT])
{
    stp_sample *s = &c->block->samples[c->level][sample];
    const int32_t lattice = STP_RADIUS_CODES_PER_OCTAVE * (patch->exponent - c->map->exponent);
    int32_t *of_kind = &last[kind_of(c, sample)];
    const int shift = (int)c->choice->radii, half = 1 << shift >> 1;
    const int32_t place = (*of_kind - lattice - 1 + half) >> shift;
    const int32_t own = (s->radius - 1) >> shift;
    const int32_t radius =
        code(c, r, STP_COLUMN_RADIUS, place, own, 0xff >> shift) * (1 << shift) + 1;
    if (c->decode)
        s->radius = (uint8_t)radius;
    *of_kind = radius + lattice;
}

/* The slopes at a sample, by column and by row: of the window, or those of heights alone. */
STP_INLINE void find_slopes(const coder *c, const stp_square_normals *normals, uint32_t sample,
                            double out[2])
{
    if (normals->reach > 0) {
        stp_square_slopes_at(normals, c->grid, sample, out);
        return;
    }
    const stp_square_level *on = &c->grid->level[c->level];
    for (int i = 0; i < 2; i++) {
        const stp_slope_samples n = stp_slope_find(on, c->level, (int32_t)sample, i == 0, NULL);
        out[i] = stp_slope_of(&n, on->height);
    }
}

STP_INLINE stp_ivec3 unit_normal_of(const stp_sample *s)
{
    int32_t uv[2];
    stp_normal_codes_get(s->normal, uv);
    return stp_unit_normal(stp_integer_normal(uv[0], uv[1]));
}

/* Sets the parents' unit normals as values, x in the place of GREEN and so on: nobody needs their
 * colours any more. */
STP_INLINE void set_parents_normals(const coder *c)
{
    const uint32_t count = c->block->level_begin[c->level + 1][c->block->patch_count];
    for (uint32_t i = 0; i < count; i++) {
        const stp_ivec3 n = unit_normal_of(&c->block->samples[c->level + 1][i]);
        for (size_t k = 0; k < 3; k++)
            c->map->sums[k * count + i] = n.v[k];
    }
}

/* Codes the normal of child k as its parent, and those around, let expect it. Returns whether it is
 * off by whole strides. */
STP_INLINE bool code_turned(const coder *c, family *f, unsigned k, unsigned reach,
                            const table_row *r)
{
    stp_sample *s = &c->block->samples[c->level][f->first + k];
    const double share = reach == STP_SQUARE_REACH_PARENTS ? 1.0 / (f->count - k) : 0.0;
    const unsigned stride = reach == STP_SQUARE_REACH_STRIDES
                                ? stp_square_stride(c->level, c->tables->last.normal_shift)
                                : 0;
    double expected[VALUE_COUNT] = {0.0}, toward[3], direction[2];
    expect(c, f, k, expected);
    for (int i = 0; i < 3; i++)
        toward[i] = expected[GREEN + i] + share * f->left[GREEN + i];
    stp_square_direction(toward, direction);
    const bool fits = code_folded(c, r, direction, stride, s);
    const stp_ivec3 own = unit_normal_of(s);
    for (int i = 0; i < 3; i++)
        f->left[GREEN + i] += expected[GREEN + i] - own.v[i];
    return fits;
}

STP_INLINE void code_by_slopes(const coder *c, const stp_square_normals *normals, uint32_t sample,
                               const table_row *r)
{
    stp_sample *s = &c->block->samples[c->level][sample];
    double slopes[2], direction[2];
    stp_square_place at = {0}; /* level grids do not ask for it */
    if (!stp_square_code_at(normals, c->grid, sample, direction)) {
        find_slopes(c, normals, sample, slopes);
        if (!c->grid->raster->level)
            at = stp_square_place_of(normals, c->grid, sample);
        stp_square_normal_of(normals, c->grid->raster, &at, slopes, direction);
    }
    if (stp_raster_spreads(c->grid->raster))
        (void)code_folded(c, r, direction, 0, s);
    else
        code_normal(c, r, direction, s);
}

/* False: some are not off by whole strides. */
STP_WIDE
static bool code_normals(coder *c, unsigned reach)
{
    walk w = {0};
    bool fit = true;
    const bool by_parents = reach >= STP_SQUARE_REACH_PARENTS;
    const stp_square_normals normals =
        stp_square_normals_begin(c->map, c->level, by_parents ? 0 : reach);
    if (by_parents)
        set_parents_normals(c);
    while (next_family(c, &w)) {
        if (by_parents)
            begin_family(c, &w.f);
        for (unsigned k = 0; k < w.f.count; k++) {
            const table_row next = next_row(c, &w.next, k + 1 == w.f.count);
            if (by_parents)
                fit = code_turned(c, &w.f, k, reach, &next) && fit;
            else
                code_by_slopes(c, &normals, w.f.first + k, &next);
        }
    }
    return fit;
}

/* When all normals are known. */
STP_WIDE
static void code_radii(coder *c)
{
    walk w = {0};
    int32_t last[KIND_COUNT];
    for (unsigned k = 0; k < KIND_COUNT; k++)
        last[k] = c->block->patches[0].radius[c->level];
    while (next_family(c, &w))
        for (unsigned k = 0; k < w.f.count; k++) {
            const table_row next = next_row(c, &w.next, k + 1 == w.f.count);
            code_radius(c, &next, w.f.patch, w.f.first + k, last);
        }
}

/* ---- levels ---- */

/* Sets the heights of a level that is there. */
static void set_heights(const stp_chunk *block, int level, const stp_square_map *map)
{
    for (uint32_t p = 0; p < block->patch_count; p++) {
        const stp_patch *patch = &block->patches[p];
        const stp_square_grid *grid = stp_square_grid_of(map, p);
        const unsigned axis = grid->raster->axis;
        const double steps = stp_square_map_steps(map, patch);
        for (uint32_t i = block->level_begin[level][p]; i < block->level_begin[level][p + 1]; i++)
            grid->level[level].height[i] =
                ((double)patch->origin[axis] + block->samples[level][i].position[axis]) * steps;
    }
}

static uint64_t normals_cost(const stp_level_tables *tables)
{
    const stp_table *both[2] = {&tables->elder, &tables->last};
    uint64_t sum = 0;
    for (int t = 0; t < 2; t++)
        for (uint32_t i = 0; i < both[t]->row_count; i++)
            sum += (uint64_t)abs(stp_table_column(both[t], STP_COLUMN_NORMAL_U)[i]) +
                   (uint64_t)abs(stp_table_column(both[t], STP_COLUMN_NORMAL_V)[i]);
    return sum;
}

/* Lets normals follow from what they are nearest to, the given reach if in doubt. That one is tried
 * late, since it need not be coded again then. Where heights tell normals to a step of the grid,
 * the parents' are not tried. */
static void choose_reach(coder *c, stp_square_choice *choice)
{
    const bool spreads = stp_raster_spreads(stp_square_grid_of(c->map, 0)->raster);
    const unsigned reaches[5] = {0, choice->reach, STP_SQUARE_REACH_PARENTS, STP_SQUARE_REACH_LOOSE,
                                 STP_SQUARE_REACH_STRIDES};
    const unsigned end = !spreads ? 3 : c->level > 1 || !choice->tight ? 4 : 5;
    const uint32_t count = c->tables->elder.row_count + c->tables->last.row_count;
    unsigned coded = 0;
    uint64_t least = UINT64_MAX;
    for (unsigned i = c->level > 0 || spreads ? 0 : 1; i < end; i++) {
        if (i == 2 && !spreads && least <= count)
            break;
        const bool fit = code_normals(c, reaches[i]);
        coded = reaches[i];
        const uint64_t cost = fit ? normals_cost(c->tables) : UINT64_MAX;
        if (cost < least || (i == 1 && cost == least)) {
            choice->reach = coded;
            least = cost;
        }
    }
    if (coded != choice->reach)
        (void)code_normals(c, choice->reach);
}

/* Sets what the level's parents tell. Their colours take the place of the map's sums. */
static coder coder_begin(const stp_chunk *block, int level, stp_square_map *map,
                         const stp_ladder *ladder, const stp_square_choice *choice,
                         const stp_level_tables *tables, bool decode)
{
    const uint32_t count = block->level_begin[level + 1][block->patch_count];
    const stp_sample *parents = block->samples[level + 1];
    double *colours = map->sums;
    /* All grids have the same heights. */
    const double *heights = stp_square_grid_of(map, 0)->level[level + 1].height;
    coder c = {block, map,    ladder, tables, {[HEIGHT] = heights},
               NULL,  choice, level,  false,  decode};
    set_heights(block, level + 1, map);
    for (int v = GREEN; v <= BLUE; v++, colours += count) {
        for (uint32_t i = 0; i < count && !choice->rows; i++)
            colours[i] = parents[i].rgb[channel[v]];
        c.values[v] = colours;
    }
    return c;
}

void stp_square_level_encode(const stp_chunk *block, int level, stp_square_map *map,
                             const stp_ladder *ladder, stp_square_choice *choice,
                             const stp_level_tables *tables)
{
    stp_square_choice_find(block, level, map, tables->last.normal_shift, choice);
    coder c = coder_begin(block, level, map, ladder, choice, tables, false);
    choice->loose = code_families(&c) && !choice->rows;
    if (choice->loose)
        code_families(&c);
    choose_reach(&c, choice);
    code_radii(&c);
    choice->follow = !choice->rows && stp_square_colours_follow(&tables->elder);
    if (choice->follow)
        stp_square_colours_move(&tables->elder, -1);
}

void stp_square_level_decode(stp_chunk *block, int level, stp_square_map *map,
                             const stp_ladder *ladder, const stp_square_choice *choice,
                             const stp_level_tables *tables)
{
    coder c = coder_begin(block, level, map, ladder, choice, tables, true);
    if (choice->follow)
        stp_square_colours_move(&tables->elder, 1);
    code_families(&c);
    (void)code_normals(&c, choice->reach);
    code_radii(&c);
}

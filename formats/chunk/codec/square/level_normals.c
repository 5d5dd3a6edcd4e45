/* Codes normals of a level of squares, when all its heights are known, then radii. */
#include "formats/chunk/codec/square/level_coder.h"

#include "base/wide.h"
#include "formats/chunk/codec/predict/predict_normal.h"
#include "formats/chunk/codec/square/square_normal.h"
#include "formats/chunk/sample/normal_grid.h"

#include <stdlib.h>

STP_INLINE void code_normal(const stp_level_coder *c, const stp_level_row *r,
                            const double direction[2], stp_sample *s)
{
    const unsigned shift = c->tables->last.normal_shift;
    int32_t uv[2];
    stp_normal_codes_get(s->normal, uv);
    for (unsigned i = 0; i < 2; i++) {
        const int32_t place = stp_square_whole(direction[i] / (double)(1 << shift));
        const int32_t own = c->decode ? 0 : stp_normal_grid_place(uv[i], shift);
        const int32_t coded = stp_level_code(c, r, STP_COLUMN_NORMAL_U + i, place, own, 0xffff);
        uv[i] = stp_normal_grid_code(coded, shift);
    }
    if (c->decode)
        stp_normal_codes_put(uv, s->normal);
}

/* The same of a raster that spreads. Normals that face a camera are where codes are folded. False:
 * the normal is not off by multiples of 2^stride. */
STP_INLINE bool code_folded(const stp_level_coder *c, const stp_level_row *r,
                            const double direction[2], unsigned stride, stp_sample *s)
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
        const int16_t cell = (int16_t)stp_level_code(c, r, STP_COLUMN_NORMAL_U + i, 0, off, 0xffff);
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

/* The slopes at a sample, by column and by row: of the window, or those of heights alone. */
STP_INLINE void find_slopes(const stp_level_coder *c, const stp_square_normals *normals,
                            uint32_t sample, double out[2])
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

/* Sets the parents' unit normals as values, x in the place of STP_GREEN and so on: nobody needs
 * their colours any more. */
STP_INLINE void set_parents_normals(const stp_level_coder *c)
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
STP_INLINE bool code_turned(const stp_level_coder *c, stp_level_family *f, unsigned k,
                            unsigned reach, const stp_level_row *r)
{
    stp_sample *s = &c->block->samples[c->level][f->first + k];
    const double share = reach == STP_SQUARE_REACH_PARENTS ? 1.0 / (f->count - k) : 0.0;
    const unsigned stride = reach == STP_SQUARE_REACH_STRIDES
                                ? stp_square_stride(c->level, c->tables->last.normal_shift)
                                : 0;
    double expected[STP_LEVEL_VALUES] = {0.0}, toward[3], direction[2];
    stp_level_expect(c, f, k, expected);
    for (int i = 0; i < 3; i++)
        toward[i] = expected[STP_GREEN + i] + share * f->left[STP_GREEN + i];
    stp_square_direction(toward, direction);
    const bool fits = code_folded(c, r, direction, stride, s);
    const stp_ivec3 own = unit_normal_of(s);
    for (int i = 0; i < 3; i++)
        f->left[STP_GREEN + i] += expected[STP_GREEN + i] - own.v[i];
    return fits;
}

STP_INLINE void code_by_slopes(const stp_level_coder *c, const stp_square_normals *normals,
                               uint32_t sample, const stp_level_row *r)
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
bool stp_level_code_normals(stp_level_coder *c, unsigned reach)
{
    stp_level_walk w = {0};
    bool fit = true;
    const bool by_parents = reach >= STP_SQUARE_REACH_PARENTS;
    const stp_square_normals normals =
        stp_square_normals_begin(c->map, c->level, by_parents ? 0 : reach);
    if (by_parents)
        set_parents_normals(c);
    while (stp_level_next_family(c, &w)) {
        if (by_parents)
            stp_level_begin_family(c, &w.f);
        for (unsigned k = 0; k < w.f.count; k++) {
            const stp_level_row next = stp_level_next_row(c, &w, k);
            if (by_parents)
                fit = code_turned(c, &w.f, k, reach, &next) && fit;
            else
                code_by_slopes(c, &normals, w.f.first + k, &next);
        }
    }
    return fit;
}

/* ---- radii ---- */

/* Kinds of a sample for its radius: how steep it is, and whether a neighbour is missing. */
#define STEEPNESS_COUNT 5u
#define KIND_COUNT (2u * STEEPNESS_COUNT)

STP_INLINE unsigned kind_of(const stp_level_coder *c, uint32_t sample)
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
STP_INLINE void code_radius(const stp_level_coder *c, const stp_level_row *r,
                            const stp_patch *patch, uint32_t sample, int32_t last[KIND_COUNT])
{
    stp_sample *s = &c->block->samples[c->level][sample];
    const int32_t lattice = STP_RADIUS_CODES_PER_OCTAVE * (patch->exponent - c->map->exponent);
    int32_t *of_kind = &last[kind_of(c, sample)];
    const int shift = (int)c->choice->radii, half = 1 << shift >> 1;
    const int32_t place = (*of_kind - lattice - 1 + half) >> shift;
    const int32_t own = (s->radius - 1) >> shift;
    const int32_t radius =
        stp_level_code(c, r, STP_COLUMN_RADIUS, place, own, 0xff >> shift) * (1 << shift) + 1;
    if (c->decode)
        s->radius = (uint8_t)radius;
    *of_kind = radius + lattice;
}

/* When all normals are known. */
STP_WIDE
void stp_level_code_radii(stp_level_coder *c)
{
    stp_level_walk w = {0};
    int32_t last[KIND_COUNT];
    for (unsigned k = 0; k < KIND_COUNT; k++)
        last[k] = c->block->patches[0].radius[c->level];
    while (stp_level_next_family(c, &w))
        for (unsigned k = 0; k < w.f.count; k++) {
            const stp_level_row next = stp_level_next_row(c, &w, k);
            code_radius(c, &next, w.f.patch, w.f.first + k, last);
        }
}

/* Codes heights, positions, colours, flags, class and intensity of a level of squares. */
#include "formats/chunk/codec/square/level_coder.h"

#include "base/wide.h"

#include <stdlib.h>

/* The same of a byte of a sample. Encoding writes no samples: other threads may read them. */
STP_INLINE int32_t code_byte(const stp_level_coder *c, const stp_level_row *r, unsigned column,
                             int32_t predicted, uint8_t *byte)
{
    const int32_t value = stp_level_code(c, r, column, predicted, *byte, 0xff);
    if (c->decode)
        *byte = (uint8_t)value;
    return value;
}

/* The position along the height, coded as a rung. */
STP_INLINE int32_t code_rung(const stp_level_coder *c, const stp_level_family *f,
                             const stp_level_row *r, double expected, int32_t position)
{
    const int32_t origin = f->patch->origin[c->grid->raster->axis];
    const double least = ((double)origin + position - 0.5) * f->steps;
    const uint32_t own = c->decode ? 0 : stp_ladder_over(c->ladder, least);
    const uint32_t place = stp_ladder_nearest(c->ladder, expected);
    uint32_t rung =
        (uint32_t)stp_level_code(c, r, STP_COLUMN_POSITION_C, (int32_t)place, (int32_t)own, 0xffff);
    rung = rung < c->ladder->count ? rung : c->ladder->count - 1;
    return stp_square_whole(c->ladder->rungs[rung] / f->steps - origin) & 0xffff;
}

/* The position along the height, where heights are multiples of 2^steps. expected: not rounded. */
STP_INLINE int32_t code_step(const stp_level_coder *c, const stp_level_family *f,
                             const stp_level_row *r, double expected, int32_t position)
{
    const int32_t origin = f->patch->origin[c->grid->raster->axis];
    const int own_steps = f->patch->exponent - c->map->exponent, steps = (int)c->choice->steps;
    const int shift = steps > own_steps ? steps - own_steps : 0;
    const int32_t first = (int32_t)(-(uint32_t)origin & ((UINT32_C(1) << shift) - 1));
    const int32_t place = (stp_square_whole(expected) - first + (1 << shift >> 1)) >> shift;
    const int32_t own = c->decode ? 0 : (position - first) >> shift;
    const int32_t coded = stp_level_code(c, r, STP_COLUMN_POSITION_C, place, own, 0xffff >> shift);
    return (first + coded * (1 << shift)) & 0xffff;
}

STP_INLINE void code_height(const stp_level_coder *c, const stp_level_family *f,
                            const stp_level_row *r, uint32_t child, double expected, stp_sample *s)
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
        const int32_t coded =
            stp_level_code(c, r, STP_COLUMN_POSITION_C, place & 0xffff, own, 0xffff);
        position = c->decode ? stp_scale_position(&f->scale, (int)axis, coded) : position;
    } else if (c->choice->steps > 0) {
        position = code_step(c, f, r, steps, position);
    } else {
        position =
            stp_level_code(c, r, STP_COLUMN_POSITION_C, stp_square_whole(steps), position, 0xffff);
    }
    if (c->decode)
        s->position[axis] = (uint16_t)position;
    c->grid->level[c->level].height[child] = ((double)origin + position) * f->steps;
}

/* Codes the position along the other axes: where the grid's place is at this height. */
STP_INLINE void code_across(const stp_level_coder *c, const stp_level_family *f,
                            const stp_level_row *r, uint32_t child, stp_sample *s)
{
    const unsigned along = c->grid->raster->axis;
    for (int k = 0; k < 2; k++) {
        const unsigned axis = (along + 1 + (unsigned)k) % 3;
        const int32_t expected =
            stp_square_across(c->grid, c->level, child, k, f->patch, s->position[along]);
        const int32_t position = stp_level_code(c, r, STP_COLUMN_POSITION_A + (unsigned)k, expected,
                                                s->position[axis], 0xffff);
        if (c->decode)
            s->position[axis] = (uint16_t)position;
    }
}

/* Codes the colours of a child. share: of what is left of the parent's. */
STP_INLINE void code_colours(const stp_level_coder *c, stp_level_family *f, const stp_level_row *r,
                             const double expected[STP_LEVEL_VALUES], double share, stp_sample *s)
{
    static const uint8_t column[STP_LEVEL_VALUES] = {
        [STP_GREEN] = STP_COLUMN_GREEN, [STP_RED] = STP_COLUMN_RED, [STP_BLUE] = STP_COLUMN_BLUE};
    for (int v = STP_GREEN; v <= STP_BLUE; v++) {
        /* NOLINTNEXTLINE(clang-analyzer-core.*): expect has set it, unless colours go by rows */
        const double tied = expected[v] + share * f->left[v];
        const int32_t value =
            code_byte(c, r, column[v], stp_square_whole(c->choice->loose ? expected[v] : tied),
                      &s->rgb[stp_level_channel[v]]);
        f->left[v] += expected[v] - value;
        f->tied += c->decode ? 0 : (uint64_t)abs(value - stp_square_whole(tied));
        f->loose += c->decode ? 0 : (uint64_t)abs(value - stp_square_whole(expected[v]));
    }
}

/* Codes what a child has besides normal and radius. */
STP_INLINE void code_child(const stp_level_coder *c, stp_level_family *f, unsigned k,
                           const stp_level_row *r)
{
    const uint32_t child = f->first + k;
    const stp_sample *parent = &c->block->samples[c->level + 1][f->parent];
    stp_sample *s = &c->block->samples[c->level][child];
    double expected[STP_LEVEL_VALUES];
    const double share = 1.0 / (f->count - k);
    stp_level_expect(c, f, k, expected);
    const bool same = s->flags == parent->flags && s->class_id == parent->class_id &&
                      s->intensity == parent->intensity;
    if (c->decode || !same) { /* cells are 0 */
        code_byte(c, r, STP_COLUMN_FLAGS, parent->flags, &s->flags);
        code_byte(c, r, STP_COLUMN_CLASS, parent->class_id, &s->class_id);
        code_byte(c, r, STP_COLUMN_INTENSITY, parent->intensity, &s->intensity);
    }
    if (!c->choice->rows)
        code_colours(c, f, r, expected, share, s);
    code_height(c, f, r, child, expected[STP_HEIGHT] + share * f->left[STP_HEIGHT], s);
    code_across(c, f, r, child, s);
    f->left[STP_HEIGHT] += expected[STP_HEIGHT] - c->grid->level[c->level].height[child];
}

/* Lets slopes of heights stop at jumps of the depth. */
STP_INLINE void stop_slopes(const stp_level_coder *c, stp_level_family *f)
{
    const int level = c->level + 1, parent = (int)f->parent;
    const stp_slope_limit limit = stp_slope_limit_at(c->map, c->grid, level, parent);
    const stp_slope_field own =
        stp_slope_field_at(&c->grid->level[level], level, parent, &limit, c->values[STP_HEIGHT]);
    f->field.by_column[STP_HEIGHT] = own.by_column;
    f->field.by_row[STP_HEIGHT] = own.by_row;
    f->field.across[STP_HEIGHT] = own.across;
}

/* Returns whether colours take less if they are loose. */
STP_WIDE
bool stp_level_code_values(stp_level_coder *c)
{
    stp_level_walk w = {0};
    c->heights_only = c->choice->rows;
    while (stp_level_next_family(c, &w)) {
        if (w.parent == 1) {
            w.f.steps = stp_square_map_steps(c->map, w.f.patch);
            w.f.scale = stp_scale_of_patch(&c->tables->last.scale, w.f.patch);
        }
        stp_level_begin_family(c, &w.f);
        if (c->map->stops)
            stop_slopes(c, &w.f);
        for (unsigned k = 0; k < w.f.count; k++) {
            const stp_level_row next = stp_level_next_row(c, &w, k);
            code_child(c, &w.f, k, &next);
        }
    }
    c->heights_only = false;
    return w.f.loose < w.f.tied;
}

/* Collects the discs of patches whose bounds meet those of a chunk's patches. */
#include "formats/chunk/measure/surroundings.h"

#include "base/memory.h"
#include "formats/chunk/measure/patch_bounds.h"

#include <stdlib.h>

stp_flat_disc stp_flat_disc_from_sample(const stp_sample *sample, const stp_patch *patch)
{
    stp_flat_disc out = {.centre = stp_sample_position(sample, patch),
                         .radius = stp_sample_radius(sample, patch)};
    if (stp_sample_is_flat(sample))
        out.normal = stp_dvec3_normalize(stp_dvec3_from_float(stp_normal_decode(sample->normal)));
    return out;
}

static stp_patch_ball ball_of(const stp_placed_chunk *placed, uint32_t p)
{
    const stp_patch *patch = &placed->chunk->patches[p];
    stp_sample at = {
        .position = {patch->bound_centre[0], patch->bound_centre[1], patch->bound_centre[2]}};
    return (stp_patch_ball){stp_dvec3_add(placed->origin, stp_sample_position(&at, patch)),
                            stp_radius_decode(patch->bound_radius, patch->exponent)};
}

static stp_dbox box_of(const stp_patch_ball *b)
{
    stp_dvec3 c = b->centre;
    double r = b->radius;
    return (stp_dbox){{c.x - r, c.y - r, c.z - r}, {c.x + r, c.y + r, c.z + r}};
}

static void add_box(stp_dbox *sum, const stp_patch_ball *b)
{
    stp_dbox box = box_of(b);
    stp_dbox_join(sum, &box);
}

stp_dbox stp_placed_patch_box(const stp_placed_chunk *placed, uint32_t patch)
{
    const stp_patch_ball ball = ball_of(placed, patch);
    return box_of(&ball);
}

stp_dbox stp_placed_chunk_box(const stp_placed_chunk *placed)
{
    stp_dbox box = stp_dbox_empty();
    for (uint32_t p = 0; p < placed->chunk->patch_count; p++) {
        stp_patch_ball ball = ball_of(placed, p);
        add_box(&box, &ball);
    }
    return box;
}

/* Begins without any disc. */
static stp_status begin(stp_surroundings *out, const stp_placed_chunk *middle, stp_error *err)
{
    stp_status status = STP_OK;
    stp_surroundings s = {.middle = *middle, .box = stp_dbox_empty()};
    uint32_t count = middle->chunk->patch_count;
    STP_TRY(stp_alloc(&s.balls, count, sizeof *s.balls, "patches", err));
    STP_TRY(stp_alloc(&s.blocks, count / STP_BALLS_A_BLOCK + 1, sizeof *s.blocks, "patches", err));
    for (uint32_t p = 0; p < count; p++) {
        stp_dbox *block = &s.blocks[p / STP_BALLS_A_BLOCK];
        if (p % STP_BALLS_A_BLOCK == 0)
            *block = stp_dbox_empty();
        s.balls[p] = ball_of(middle, p);
        add_box(block, &s.balls[p]);
        add_box(&s.box, &s.balls[p]);
    }
done:
    *out = s;
    return status;
}

static bool balls_meet(const stp_patch_ball *a, const stp_patch_ball *b)
{
    stp_dvec3 way = stp_dvec3_sub(a->centre, b->centre);
    double reach = a->radius + b->radius;
    return stp_dvec3_dot(way, way) <= reach * reach;
}

static bool touches(const stp_surroundings *s, const stp_patch_ball *ball)
{
    uint32_t count = s->middle.chunk->patch_count;
    stp_dbox box = box_of(ball);
    if (!stp_dbox_meet(&s->box, &box))
        return false;
    for (uint32_t begin = 0; begin < count; begin += STP_BALLS_A_BLOCK) {
        if (!stp_dbox_meet(&s->blocks[begin / STP_BALLS_A_BLOCK], &box))
            continue;
        for (uint32_t p = begin; p < count && p < begin + STP_BALLS_A_BLOCK; p++)
            if (balls_meet(&s->balls[p], ball))
                return true;
    }
    return false;
}

static stp_status add_disc(stp_surroundings *s, const stp_flat_disc *disc, const stp_carry *carry,
                           stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_grow(&s->discs, &s->disc_capacity, (size_t)s->count + 1, sizeof *s->discs, "discs",
                     err));
    if (carry) {
        STP_TRY(stp_grow(&s->carry, &s->carry_capacity, (size_t)s->count + 1, sizeof *s->carry,
                         "discs", err));
        s->carry[s->count] = *carry;
    }
    s->discs[s->count++] = *disc;
done:
    return status;
}

static bool is_full(const stp_surroundings *s)
{
    return s->count >= STP_SURROUNDINGS_LIMIT;
}

stp_status stp_surroundings_add(stp_surroundings *s, const stp_placed_chunk *other, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk *chunk = other->chunk;
    stp_sample_lanes lanes;
    stp_dvec3 offset = stp_dvec3_sub(other->origin, s->middle.origin);
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        stp_patch_ball ball = ball_of(other, p);
        if (is_full(s))
            break;
        if (chunk->patches[p].flags & STP_PATCH_SHAPES || !touches(s, &ball))
            continue;
        uint32_t first = chunk->level_begin[0][p], count = chunk->patches[p].counts[0];
        stp_samples_decode(&chunk->samples[0][first], count, &chunk->patches[p], &lanes);
        for (uint32_t i = 0; i < count; i++) {
            stp_flat_disc disc = stp_flat_disc_from_lanes(&lanes, i);
            disc.centre = stp_dvec3_add(disc.centre, offset);
            STP_TRY(add_disc(s, &disc, other->carry ? &other->carry[first + i] : NULL, err));
        }
    }
done:
    return status;
}

stp_status stp_surroundings_find(stp_surroundings *out, const stp_placed_chunk *middle,
                                 uint32_t self, const stp_surrounding_chunks *chunks,
                                 stp_error *err)
{
    stp_status status = begin(out, middle, err);
    for (uint32_t i = 0; status == STP_OK && !is_full(out); i++) {
        i = stp_chunk_boxes_next(chunks->boxes, &out->box, i);
        if (i == STP_CHUNK_NONE)
            break;
        if (i != self)
            status = chunks->add(chunks->context, i, out, err);
    }
    return status;
}

void stp_surroundings_clear(stp_surroundings *s)
{
    free(s->balls);
    free(s->blocks);
    free(s->discs);
    free(s->carry);
    *s = (stp_surroundings){0};
}

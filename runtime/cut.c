/* Cut selection: descend while a child's coarsest level, which its parent shows, is too coarse. */
#include "runtime/cut.h"

#include "base/memory.h"
#include "runtime/level_rule.h"

#include <stdlib.h>

static stp_rule_bound entry_bound(const stp_chunk_entry *e, stp_dvec3 eye)
{
    vec3s half = glms_vec3_scale(glms_vec3_sub(e->box_max, e->box_min), 0.5f);
    vec3s centre = glms_vec3_add(e->box_min, half);
    stp_dvec3 c = stp_dvec3_sub(stp_dvec3_add(e->origin, stp_dvec3_from_float(centre)), eye);
    return (stp_rule_bound){
        .centre = {(float)c.x, (float)c.y, (float)c.z},
        .radius = glms_vec3_norm(half) * 1.000001f,
        .cone_axis = {e->cone_axis.x, e->cone_axis.y, e->cone_axis.z},
        .cone_cos = e->cone_angle >= 3.14159f ? -1.0f : cosf(e->cone_angle),
        .two_sided = (e->flags & STP_PATCH_TWO_SIDED) != 0,
    };
}

/* Greatest error of a level, pixels; infinite where nothing bounds it. */
static float level_error(const stp_rule_sight *sight, const stp_chunk_entry *e, int level)
{
    if (sight->scale < 0.0f)
        return INFINITY;
    return stp_rule_error(sight->scale, sight->sin_alpha, e->error[level],
                          e->tangential_error[level]);
}

/* A child is wanted where its coarsest level, all that its parent has of it, would show. */
static bool child_wanted(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                         const stp_chunk_entry *child)
{
    float threshold = frame->quality[0];
    return threshold <= 0.0f || level_error(sight, child, STP_LEVEL_COUNT - 1) > threshold ||
           child->radius_max * sight->scale > frame->quality[1];
}

/* Finest level that any patch of the chunk can ask for. */
static int finest_needed(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                         const stp_chunk_entry *e)
{
    float threshold = frame->quality[0];
    if (threshold <= 0.0f || e->radius_max * sight->scale > frame->quality[1])
        return 0;
    for (int level = STP_LEVEL_COUNT - 2; level > 0; level--)
        if (level_error(sight, e, level) <= threshold)
            return level;
    return 0;
}

static stp_status add_miss(stp_cut *cut, stp_miss miss, stp_error *err)
{
    stp_status status = stp_grow(&cut->misses, &cut->miss_capacity, cut->miss_count + 1,
                                 sizeof *cut->misses, "a list of missing chunks", err);
    if (status == STP_OK)
        cut->misses[cut->miss_count++] = miss;
    return status;
}

/* Decides the children of a chunk: draws, leaves to the parent, or notes as missing. */
static stp_status visit_children(stp_cut *cut, const stp_cut_params *params, stp_draw *draw,
                                 size_t *stack_count, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_entry *e = &params->model->entries[draw->chunk];
    STP_TRY(stp_grow(&cut->stack, &cut->stack_capacity, *stack_count + e->child_count,
                     sizeof *cut->stack, "a stack of chunks", err));
    for (uint32_t k = 0; k < e->child_count; k++) {
        uint32_t id = e->first_child + k;
        const stp_chunk_entry *child = &params->model->entries[id];
        stp_rule_bound bound = entry_bound(child, params->eye);
        float eye[3];
        if (!stp_rule_visible(params->frame, &bound, eye)) {
            draw->drawn_children |= UINT64_C(1) << k;
            continue;
        }
        stp_rule_sight sight = stp_rule_look(params->frame, &bound);
        if (!child_wanted(params->frame, &sight, child))
            continue;
        int finest = finest_needed(params->frame, &sight, child);
        int available = params->available(params->context, id);
        if (available > finest) {
            float priority = level_error(&sight, child, STP_LEVEL_COUNT - 1);
            STP_TRY(add_miss(cut, (stp_miss){id, finest, priority}, err));
        }
        if (available >= STP_LEVEL_COUNT)
            continue;
        draw->drawn_children |= UINT64_C(1) << k;
        cut->stack[(*stack_count)++] = id;
    }
done:
    return status;
}

static uint64_t all_children(uint32_t count)
{
    return count >= 64 ? UINT64_MAX : (UINT64_C(1) << count) - 1;
}

static int compare_draws(const void *a, const void *b)
{
    uint32_t x = ((const stp_draw *)a)->chunk, y = ((const stp_draw *)b)->chunk;
    return (x > y) - (x < y);
}

static int compare_misses(const void *a, const void *b)
{
    const stp_miss *x = a, *y = b;
    if (x->priority != y->priority)
        return x->priority < y->priority ? 1 : -1;
    return (x->chunk > y->chunk) - (x->chunk < y->chunk);
}

stp_status stp_cut_select(stp_cut *cut, const stp_cut_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    size_t stack_count = 0;
    cut->draw_count = cut->miss_count = cut->passed_count = 0;
    STP_TRY(stp_grow(&cut->stack, &cut->stack_capacity, 1, sizeof *cut->stack, "a stack of chunks",
                     err));
    cut->stack[stack_count++] = 0;
    while (stack_count > 0) {
        stp_draw draw = {.chunk = cut->stack[--stack_count]};
        const stp_chunk_entry *e = &params->model->entries[draw.chunk];
        stp_rule_bound bound = entry_bound(e, params->eye);
        float eye[3];
        if (!stp_rule_visible(params->frame, &bound, eye))
            continue;
        stp_rule_sight sight = stp_rule_look(params->frame, &bound);
        draw.scale = sight.scale;
        draw.finest = finest_needed(params->frame, &sight, e);
        if (draw.chunk != 0) {
            int available = params->available(params->context, draw.chunk);
            draw.finest = available > draw.finest ? available : draw.finest;
        }
        STP_TRY(visit_children(cut, params, &draw, &stack_count, err));
        if (e->child_count > 0 && draw.drawn_children == all_children(e->child_count)) {
            STP_TRY(stp_grow(&cut->passed, &cut->passed_capacity, cut->passed_count + 1,
                             sizeof *cut->passed, "a list of chunks", err));
            cut->passed[cut->passed_count++] = draw.chunk;
            continue;
        }
        STP_TRY(stp_grow(&cut->draws, &cut->draw_capacity, cut->draw_count + 1, sizeof *cut->draws,
                         "a list of chunks", err));
        cut->draws[cut->draw_count++] = draw;
    }
    if (cut->draw_count > 0)
        qsort(cut->draws, cut->draw_count, sizeof *cut->draws, compare_draws);
    if (cut->miss_count > 0)
        qsort(cut->misses, cut->miss_count, sizeof *cut->misses, compare_misses);
done:
    return status;
}

void stp_cut_destroy(stp_cut *cut)
{
    free(cut->draws);
    free(cut->misses);
    free(cut->passed);
    free(cut->stack);
    *cut = (stp_cut){0};
}

stp_gpu_chunk stp_gpu_chunk_from_draw(const stp_model *model, const stp_draw *draw, stp_dvec3 eye)
{
    const stp_chunk_entry *e = &model->entries[draw->chunk];
    stp_dvec3 offset = stp_dvec3_sub(e->origin, eye);
    return (stp_gpu_chunk){
        .offset = {(float)offset.x, (float)offset.y, (float)offset.z},
        .finest = (uint32_t)draw->finest,
        .id = draw->chunk,
        .depth = e->depth,
    };
}

bool stp_patch_refined(const stp_draw *draw, const stp_gpu_patch *patch)
{
    return draw->drawn_children != 0 && patch->child < 64 &&
           (draw->drawn_children >> patch->child & 1) != 0;
}

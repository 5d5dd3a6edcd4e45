/* Selects the cut: descends to a child while the child's coarsest level (its parent's samples) is
 * too coarse. */
#include "runtime/cut/cut.h"

#include "base/memory.h"
#include "runtime/cut/level_rule.h"

#include <stdlib.h>

static stp_rule_bound entry_bound(const stp_chunk_entry *e, stp_dvec3 eye)
{
    stp_ball ball = stp_entry_ball(e, eye);
    return (stp_rule_bound){
        .centre = {(float)ball.centre.x, (float)ball.centre.y, (float)ball.centre.z},
        .radius = (float)ball.radius,
        .cone_axis = {e->cone_axis.x, e->cone_axis.y, e->cone_axis.z},
        .cone_cos = e->cone_angle >= 3.14159f ? -1.0f : cosf(e->cone_angle),
        .two_sided = (e->flags & STP_PATCH_TWO_SIDED) != 0,
        .closed = (e->flags & STP_CHUNK_CLOSED) != 0,
    };
}

/* The greatest error of a level, pixels; infinite if nothing bounds the projection. */
static float level_error(const stp_rule_sight *sight, const stp_chunk_entry *e, int level)
{
    if (sight->scale < 0.0f)
        return INFINITY;
    return stp_rule_error(sight->scale, sight->sin_alpha, e->error[level],
                          e->tangential_error[level]);
}

/* Whether a level is fine enough for every patch of the chunk. */
static bool level_does(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                       const stp_chunk_entry *e, int level, float threshold, float cap)
{
    return threshold > 0.0f && sight->scale >= 0.0f &&
           stp_rule_fits(level_error(sight, e, level), sight->scale * e->radius_max,
                         e->colour_error[level] / 255.0f, sight->error_weight, frame->terms[0],
                         threshold, cap);
}

/* A child is wanted if its coarsest level is too coarse: the parent shows no more of it. */
static bool child_wanted(const stp_cut_params *params, const stp_rule_sight *sight, uint32_t id)
{
    const stp_chunk_entry *child = &params->scene->entries[id];
    const stp_cut_source *source = &params->source;
    float threshold = params->frame->quality[0], cap = params->frame->quality[1];
    if (source->was_drawn != NULL && source->was_drawn(source->context, id)) {
        threshold *= STP_CUT_HYSTERESIS;
        cap *= STP_CUT_HYSTERESIS;
    }
    return !level_does(params->frame, sight, child, STP_LEVEL_COUNT - 1, threshold, cap);
}

/* The finest level that any patch of the chunk can ask for. */
static int finest_needed(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                         const stp_chunk_entry *e)
{
    for (int level = STP_LEVEL_COUNT - 2; level > 0; level--)
        if (level_does(frame, sight, e, level, frame->quality[0], frame->quality[1]))
            return level;
    return 0;
}

/* An error beyond this gains no more: the picture does not get worse. */
#define GAIN_ERROR_MOST_PX 256.0f

/* The improvement per byte read, as stp_miss.gain. bound: in sight, relative to the eye. */
static float gain_of(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                     const stp_rule_bound *bound, const stp_chunk_entry *e, int finest)
{
    float screen = frame->viewport[0] * frame->viewport[1];
    float error = fminf(level_error(sight, e, STP_LEVEL_COUNT - 1), GAIN_ERROR_MOST_PX);
    float reach = bound->radius * sight->scale;
    float area = sight->scale < 0.0f ? screen : fminf(3.14159265f * reach * reach, screen);
    return area * fmaxf(error, 1.0f) / (float)(1 + stp_chunk_payload_bytes(e, finest));
}

/* A chunk to visit. Below a missing chunk, the cut goes on looking for further misses. */
typedef struct stp_cut_visit {
    uint32_t chunk;
    bool missing;
    float gain; /* if missing: of the miss above */
} stp_cut_visit;

static stp_status add_miss(stp_cut *cut, stp_miss miss, stp_error *err)
{
    stp_status status = stp_grow(&cut->misses, &cut->miss_capacity, cut->miss_count + 1,
                                 sizeof *cut->misses, "a list of missing chunks", err);
    if (status == STP_OK)
        cut->misses[cut->miss_count++] = miss;
    return status;
}

static stp_status push(stp_cut *cut, size_t *count, stp_cut_visit visit, stp_error *err)
{
    stp_status status = stp_grow(&cut->stack, &cut->stack_capacity, *count + 1, sizeof *cut->stack,
                                 "a stack of chunks", err);
    if (status == STP_OK)
        cut->stack[(*count)++] = visit;
    return status;
}

/* Decides whether a child is drawn, left to its parent, or missing. *drawn: drawn or out of
 * sight. */
static stp_status visit_child(stp_cut *cut, const stp_cut_params *params, stp_cut_visit parent,
                              uint32_t id, bool *drawn, size_t *stack_count, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_entry *child = &params->scene->entries[id];
    stp_rule_bound bound = entry_bound(child, params->eye);
    stp_cut_visit visit = {id, parent.missing, parent.gain};
    float eye[3];
    *drawn = !stp_rule_visible(params->frame, &bound, eye);
    if (*drawn)
        return STP_OK;
    stp_rule_sight sight = stp_rule_look(params->frame, &bound);
    if (!child_wanted(params, &sight, id))
        return STP_OK;
    int finest = finest_needed(params->frame, &sight, child);
    int available = params->source.available(params->source.context, id);
    if (available > finest) {
        float gain = gain_of(params->frame, &sight, &bound, child, finest);
        visit.gain = parent.missing ? fminf(gain, 0.99f * parent.gain) : gain;
        STP_TRY(add_miss(cut, (stp_miss){id, finest, visit.gain}, err));
    }
    visit.missing = parent.missing || available >= STP_LEVEL_COUNT;
    *drawn = !visit.missing;
    if (available != STP_CUT_NEVER)
        STP_TRY(push(cut, stack_count, visit, err));
done:
    return status;
}

/* Decides about all children of a chunk. */
static stp_status visit_children(stp_cut *cut, const stp_cut_params *params, stp_cut_visit visit,
                                 stp_draw *draw, size_t *stack_count, stp_error *err)
{
    const stp_chunk_entry *e = &params->scene->entries[visit.chunk];
    for (uint32_t k = 0; k < e->child_count; k++) {
        bool drawn = false;
        stp_status status =
            visit_child(cut, params, visit, e->first_child + k, &drawn, stack_count, err);
        if (status != STP_OK)
            return status;
        draw->drawn_children |= (uint64_t)drawn << k;
    }
    return STP_OK;
}

/* Whether each child of a chunk is drawn or out of sight. */
static bool passes(const stp_draw *draw, const stp_chunk_entry *e)
{
    uint64_t all = e->child_count >= 64 ? UINT64_MAX : (UINT64_C(1) << e->child_count) - 1;
    return e->child_count > 0 && draw->drawn_children == all;
}

static int compare_draws(const void *a, const void *b)
{
    uint32_t x = ((const stp_draw *)a)->chunk, y = ((const stp_draw *)b)->chunk;
    return (x > y) - (x < y);
}

static int compare_misses(const void *a, const void *b)
{
    const stp_miss *x = a, *y = b;
    if (x->gain != y->gain)
        return x->gain < y->gain ? 1 : -1;
    return (x->chunk > y->chunk) - (x->chunk < y->chunk);
}

static stp_status add_draw(stp_cut *cut, const stp_draw *draw, stp_error *err)
{
    stp_status status = stp_grow(&cut->draws, &cut->draw_capacity, cut->draw_count + 1,
                                 sizeof *cut->draws, "a list of chunks", err);
    if (status == STP_OK)
        cut->draws[cut->draw_count++] = *draw;
    return status;
}

/* Visits a chunk from the stack; it is wanted. */
static stp_status visit_chunk(stp_cut *cut, const stp_cut_params *params, stp_cut_visit visit,
                              size_t *stack_count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_draw draw = {.chunk = visit.chunk, .parent_link = STP_LINK_NONE};
    const stp_chunk_entry *e = &params->scene->entries[draw.chunk];
    stp_rule_bound bound = entry_bound(e, params->eye);
    float eye[3];
    if (!stp_rule_visible(params->frame, &bound, eye))
        return STP_OK;
    stp_rule_sight sight = stp_rule_look(params->frame, &bound);
    draw.finest = finest_needed(params->frame, &sight, e);
    if (!visit.missing && e->parent != STP_CHUNK_NONE) {
        int available = params->source.available(params->source.context, draw.chunk);
        draw.finest = available > draw.finest ? available : draw.finest;
    }
    STP_TRY(visit_children(cut, params, visit, &draw, stack_count, err));
    if (!visit.missing)
        STP_TRY(add_draw(cut, &draw, err));
done:
    return status;
}

/* The index of the first draw whose chunk number is >= chunk. */
static size_t find_draw(const stp_cut *cut, uint32_t chunk)
{
    size_t low = 0, high = cut->draw_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (cut->draws[middle].chunk < chunk)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Links a draw to the draws of its children, which are linked before it. A child is not linked, and
 * draws all of its patches, if one of its own children does. */
static void link_draw(stp_cut *cut, const stp_scene *scene, stp_draw *draw)
{
    const stp_chunk_entry *e = &scene->entries[draw->chunk];
    if (draw->drawn_children == 0)
        return;
    size_t child = find_draw(cut, e->first_child), link = cut->link_count;
    draw->links = link;
    for (uint32_t k = 0; k < e->child_count; k++) {
        uint32_t id = e->first_child + k;
        if (child < cut->draw_count && cut->draws[child].chunk == id) {
            stp_draw *below = &cut->draws[child++];
            bool linked = (e->flags & STP_CHUNK_LINKED) != 0 && !below->has_whole;
            below->parent_link = linked ? link : STP_LINK_NONE;
            draw->linked_children |= (uint64_t)linked << k;
            draw->has_whole |= !linked;
        }
        link += scene->entries[id].patch_count;
    }
    if (draw->linked_children != 0)
        cut->link_count = link;
}

/* Moves the chunks that have nothing left to draw from draws to passed. */
static stp_status take_passed(stp_cut *cut, const stp_scene *scene, stp_error *err)
{
    stp_status status = STP_OK;
    size_t kept = 0;
    for (size_t i = 0; i < cut->draw_count; i++) {
        const stp_draw *draw = &cut->draws[i];
        if (!passes(draw, &scene->entries[draw->chunk]) || draw->linked_children != 0) {
            cut->draws[kept++] = *draw;
            continue;
        }
        STP_TRY(stp_grow(&cut->passed, &cut->passed_capacity, cut->passed_count + 1,
                         sizeof *cut->passed, "a list of chunks", err));
        cut->passed[cut->passed_count++] = draw->chunk;
    }
    cut->draw_count = kept;
done:
    return status;
}

stp_status stp_cut_select(stp_cut *cut, const stp_cut_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    size_t stack_count = 0;
    cut->draw_count = cut->miss_count = cut->passed_count = cut->link_count = 0;
    for (size_t i = 0; i < params->scene->model_count; i++)
        if (!(params->hidden_models >> i & 1))
            STP_TRY(push(cut, &stack_count,
                         (stp_cut_visit){.chunk = params->scene->models[i].first}, err));
    while (stack_count > 0) {
        stp_cut_visit visit = cut->stack[--stack_count];
        STP_TRY(visit_chunk(cut, params, visit, &stack_count, err));
    }
    if (cut->draw_count > 0)
        qsort(cut->draws, cut->draw_count, sizeof *cut->draws, compare_draws);
    if (cut->miss_count > 0)
        qsort(cut->misses, cut->miss_count, sizeof *cut->misses, compare_misses);
    if (params->frame->quality[0] > 0.0f) /* otherwise no parent's patch is fine enough */
        for (size_t i = cut->draw_count; i > 0; i--)
            link_draw(cut, params->scene, &cut->draws[i - 1]);
    STP_TRY(take_passed(cut, params->scene, err));
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

stp_gpu_chunk stp_gpu_chunk_from_draw(const stp_chunk_entry *e, const stp_draw *draw, stp_dvec3 eye)
{
    stp_dvec3 offset = stp_dvec3_sub(e->origin, eye);
    return (stp_gpu_chunk){
        .offset = {(float)offset.x, (float)offset.y, (float)offset.z},
        .finest = (uint32_t)draw->finest,
        .id = draw->chunk,
        .depth = e->depth,
    };
}

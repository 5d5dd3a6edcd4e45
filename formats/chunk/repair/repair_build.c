/* Builds and measures the chunks of a repaired file that differ from the damaged one. */
#include "formats/chunk/repair/repair_build.h"

#include "base/memory.h"
#include "formats/chunk/measure/raise.h"
#include "formats/chunk/repair/stand_in.h"

#include <stdlib.h>
#include <string.h>

#define REPLACED_BYTES_LIMIT ((size_t)1 << 30)

/* A chunk of the output: a new chunk of the plan, or one that is read for a while (own). */
typedef struct loan {
    const stp_chunk *chunk;
    stp_chunk *own;
    stp_dvec3 origin;
} loan;

static stp_status borrow(const stp_repair_plan *plan, uint32_t id, int finest_level, loan *out,
                         stp_error *err)
{
    const stp_repair_node *node = &plan->nodes[id];
    *out = (loan){node->chunk, NULL, node->origin};
    if (node->chunk)
        return STP_OK;
    stp_status status = stp_damaged_chunk(plan->damaged, id, finest_level, &out->own, err);
    out->chunk = out->own;
    out->origin = plan->damaged->entries[id].origin;
    return status;
}

static void give_back(loan *l)
{
    stp_chunk_destroy(&l->own);
}

static stp_status keep(stp_repair_plan *plan, uint32_t id, stp_chunk *chunk, stp_dvec3 origin,
                       stp_error *err)
{
    stp_repair_node *node = &plan->nodes[id];
    node->chunk = chunk;
    node->origin = origin;
    chunk->id = id;
    const stp_dbox box = stp_placed_chunk_box(&(stp_placed_chunk){chunk, origin, NULL});
    stp_chunk_boxes_set(&plan->boxes, id, &box);
    plan->replaced_bytes += chunk->memory_bytes;
    if (plan->replaced_bytes > REPLACED_BYTES_LIMIT)
        return stp_error_set(err, STP_LIMIT,
                             "%s: cannot be repaired: more than 1 GiB of it has to be rebuilt; "
                             "copy it again",
                             plan->damaged->path);
    return stp_progress_update(plan->damaged->params->progress, "rebuild", id, 0, err);
}

/* ---- building ---- */

static stp_status build_coarse(stp_repair_plan *plan, uint32_t id, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_damaged *d = plan->damaged;
    stp_chunk *prefix = NULL, *chunk = NULL;
    STP_TRY(stp_damaged_chunk(d, id, d->finest[id], &prefix, err));
    STP_TRY(stp_stand_in_coarse(prefix, &chunk, err));
    STP_TRY(keep(plan, id, chunk, d->entries[id].origin, err));
done:
    stp_chunk_destroy(&prefix);
    return status;
}

static stp_status build_from_parent(stp_repair_plan *plan, uint32_t id, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_damaged *d = plan->damaged;
    const stp_repair_node *node = &plan->nodes[id];
    stp_chunk *parent = NULL, *chunk = NULL;
    STP_TRY(stp_damaged_chunk(d, node->parent, d->finest[node->parent], &parent, err));
    STP_TRY(stp_stand_in_samples(parent, node->child_index, &chunk, err));
    STP_TRY(keep(plan, id, chunk, d->entries[node->parent].origin, err));
done:
    stp_chunk_destroy(&parent);
    return status;
}

static stp_status build_parent(stp_repair_plan *plan, uint32_t id, stp_error *err)
{
    stp_status status = STP_OK;
    stp_repair_node *node = &plan->nodes[id];
    loan loans[STP_CHUNK_CHILDREN_LIMIT] = {{0}};
    stp_placed_chunk children[STP_CHUNK_CHILDREN_LIMIT] = {{0}};
    stp_chunk *chunk = NULL;
    stp_dvec3 origin = {0.0, 0.0, 0.0};
    uint32_t count = 0;
    for (uint32_t c = id + 1; c < plan->count; c++) {
        if (plan->nodes[c].parent != id || plan->nodes[c].fate == STP_FATE_GONE)
            continue;
        if (count == STP_CHUNK_CHILDREN_LIMIT) {
            status = stp_error_set(err, STP_CORRUPT,
                                   "%s: cannot be repaired: chunk %u has too "
                                   "many children",
                                   plan->damaged->path, id);
            goto done;
        }
        STP_TRY(borrow(plan, c, 2, &loans[count], err));
        children[count] = (stp_placed_chunk){loans[count].chunk, loans[count].origin, NULL};
        count++;
    }
    STP_TRY(
        plan->damaged->params->build_parent(children, count, &chunk, &origin, &node->carry, err));
    STP_TRY(keep(plan, id, chunk, origin, err));
done:
    for (uint32_t c = 0; c < count; c++)
        give_back(&loans[c]);
    return status;
}

/* ---- what a parent promises of its children ---- */

/* A patch vertex in the world, and its errors. */
typedef struct vertex {
    double at[3];
    double error, tangential_error;
} vertex;

static int compare_vertices(const void *a, const void *b)
{
    const vertex *x = a, *y = b;
    for (int i = 0; i < 3; i++)
        if (x->at[i] != y->at[i])
            return x->at[i] < y->at[i] ? -1 : 1;
    return 0;
}

static vertex vertex_of(const loan *l, uint32_t p, int level, uint32_t i)
{
    const stp_patch *patch = &l->chunk->patches[p];
    stp_dvec3 at =
        stp_dvec3_add(l->origin, stp_sample_position(&l->chunk->samples[level][i], patch));
    return (vertex){{at.x, at.y, at.z},
                    stp_error_decode(patch->error[level], patch->exponent),
                    stp_error_decode(patch->tangential_error[level], patch->exponent)};
}

/* The greatest errors of all vertices at one place. */
static vertex greatest_at(const vertex *sorted, uint32_t count, vertex place)
{
    uint32_t low = 0, high = count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (compare_vertices(&sorted[middle], &place) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    for (; low < count && compare_vertices(&sorted[low], &place) == 0; low++) {
        place.error = stp_max(place.error, sorted[low].error);
        place.tangential_error = stp_max(place.tangential_error, sorted[low].tangential_error);
    }
    return place;
}

/* Raises a parent's errors to those of a child's patch vertices. */
static stp_status raise_by_child(stp_chunk *parent, const loan *placed, const loan *child,
                                 uint32_t child_index, bool *raised, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = child->chunk->patch_count;
    vertex *sorted = NULL;
    STP_TRY(stp_alloc(&sorted, count, sizeof *sorted, "patches", err));
    for (uint32_t p = 0; p < count; p++)
        sorted[p] = vertex_of(child, p, STP_LEVEL_COUNT - 1, p);
    qsort(sorted, count, sizeof *sorted, compare_vertices);
    for (uint32_t p = 0; p < parent->patch_count; p++) {
        stp_patch *patch = &parent->patches[p];
        for (uint32_t i = parent->level_begin[0][p];
             patch->child == child_index && i < parent->level_begin[0][p + 1]; i++) {
            vertex v = greatest_at(sorted, count, vertex_of(placed, p, 0, i));
            *raised |= stp_patch_raise(patch, stp_error_encode(v.error, patch->exponent),
                                       stp_error_encode(v.tangential_error, patch->exponent));
        }
    }
done:
    free(sorted);
    return status;
}

static stp_status raise_by_children(stp_repair_plan *plan, uint32_t id, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    bool raised = false;
    const stp_chunk_entry *e = &plan->damaged->entries[id];
    const stp_dvec3 origin = e->origin;
    for (uint32_t c = e->first_child; c < e->first_child + e->child_count; c++) {
        const stp_repair_node *child = &plan->nodes[c];
        if (child->parent != id || !child->chunk)
            continue;
        if (!chunk)
            STP_TRY(stp_damaged_chunk(plan->damaged, id, 0, &chunk, err));
        const loan placed = {chunk, NULL, origin}, below = {child->chunk, NULL, child->origin};
        STP_TRY(raise_by_child(chunk, &placed, &below, child->child_index, &raised, err));
    }
    if (raised) {
        plan->nodes[id].raised = true;
        stp_chunk *kept = chunk;
        chunk = NULL;
        STP_TRY(keep(plan, id, kept, origin, err));
    }
done:
    stp_chunk_destroy(&chunk);
    return status;
}

/* ---- tangential errors ---- */

/* Whose surroundings are sought. */
typedef struct seeker {
    const stp_repair_plan *plan;
    uint32_t id;
    bool with_carry; /* also the errors that the samples around carry */
} seeker;

static stp_status add_surrounding(void *context, uint32_t id, stp_surroundings *out, stp_error *err)
{
    stp_status status = STP_OK;
    const seeker *s = context;
    loan other = {0};
    stp_carry *carry = NULL;
    if (s->plan->nodes[id].depth != s->plan->nodes[s->id].depth)
        return STP_OK;
    STP_TRY(borrow(s->plan, id, 0, &other, err));
    if (s->with_carry)
        STP_TRY(stp_carry_tell(other.chunk, &carry, err));
    STP_TRY(stp_surroundings_add(out, &(stp_placed_chunk){other.chunk, other.origin, carry}, err));
done:
    free(carry);
    give_back(&other);
    return status;
}

/* Finds surroundings as verify does: from all chunks of the same depth, in the output's order. */
static stp_status find_surroundings(seeker *s, const loan *middle, stp_surroundings *out,
                                    stp_error *err)
{
    const stp_placed_chunk placed = {middle->chunk, middle->origin, NULL};
    const stp_surrounding_chunks chunks = {&s->plan->boxes, add_surrounding, s};
    return stp_surroundings_find(out, &placed, s->id, &chunks, err);
}

static stp_status measure(const stp_repair_plan *plan, uint32_t id, stp_chunk *chunk,
                          stp_dvec3 origin, const stp_carry *carry, stp_error *err)
{
    stp_status status = STP_OK;
    stp_surroundings around = {0};
    const loan middle = {chunk, NULL, origin};
    STP_TRY(find_surroundings(&(seeker){plan, id, carry != NULL}, &middle, &around, err));
    STP_TRY(stp_overhang_raise(chunk, carry, &around, err));
done:
    stp_surroundings_clear(&around);
    return status;
}

/* Whether verify would refute a kept chunk's stored errors, now that other chunks changed. */
static stp_status is_refuted(const stp_repair_plan *plan, uint32_t id, const loan *l, bool *out,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_surroundings around = {0};
    uint32_t patch = STP_CHUNK_NONE;
    STP_TRY(find_surroundings(&(seeker){plan, id, false}, l, &around, err));
    STP_TRY(stp_overhang_check(&patch, l->chunk, &around, err));
    *out = patch != STP_CHUNK_NONE;
done:
    stp_surroundings_clear(&around);
    return status;
}

static stp_status recheck(stp_repair_plan *plan, uint32_t id, stp_error *err)
{
    stp_status status = STP_OK;
    stp_repair_node *node = &plan->nodes[id];
    loan l = {0};
    stp_carry *carry = NULL;
    bool refuted = false;
    STP_TRY(borrow(plan, id, 0, &l, err));
    STP_TRY(is_refuted(plan, id, &l, &refuted, err));
    if (!refuted)
        goto done;
    if (plan->damaged->entries[id].child_count > 0)
        STP_TRY(stp_carry_tell(l.chunk, &carry, err));
    stp_chunk *chunk = l.own;
    l.own = NULL;
    if (chunk)
        STP_TRY(keep(plan, id, chunk, l.origin, err));
    node->raised = true;
    STP_TRY(measure(plan, id, node->chunk, node->origin, carry, err));
done:
    free(carry);
    give_back(&l);
    return status;
}

/* ---- a tier ---- */

/* Boxes where a tier's surface changed: of its new chunks, and of the old ones that they replace.
 */
static stp_status find_changed(const stp_repair_plan *plan, uint32_t depth, stp_dbox **boxes,
                               size_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    size_t capacity = 0;
    const stp_dbox everywhere = {{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
    for (uint32_t id = 0; id < plan->count; id++) {
        const stp_repair_node *node = &plan->nodes[id];
        bool lost = node->fate == STP_FATE_GONE && node->parent == STP_CHUNK_NONE;
        if ((node->depth != depth && !lost) || node->fate == STP_FATE_KEPT)
            continue;
        STP_TRY(stp_grow(boxes, &capacity, *count + 2, sizeof **boxes, "boxes", err));
        if (!plan->damaged->known[id]) /* unknown place: the chunk may have been anywhere */
            (*boxes)[(*count)++] = everywhere;
        if (node->chunk)
            (*boxes)[(*count)++] = plan->boxes.boxes[id];
        if (plan->damaged->known[id])
            (*boxes)[(*count)++] = stp_chunk_entry_box(&plan->damaged->entries[id]);
    }
done:
    return status;
}

static bool meets_any(const stp_dbox *box, const stp_dbox *boxes, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (stp_dbox_meet(box, &boxes[i]))
            return true;
    return false;
}

static stp_status build_tier(stp_repair_plan *plan, uint32_t depth, stp_error *err)
{
    stp_status status = STP_OK;
    for (uint32_t id = 0; id < plan->count && status == STP_OK; id++) {
        if (plan->nodes[id].depth != depth)
            continue;
        switch (plan->nodes[id].fate) {
        case STP_FATE_COARSE:
            status = build_coarse(plan, id, err);
            break;
        case STP_FATE_PARENT:
            status = build_from_parent(plan, id, err);
            break;
        case STP_FATE_REBUILT:
            status = build_parent(plan, id, err);
            break;
        case STP_FATE_KEPT:
            if (plan->damaged->entries[id].child_count > 0)
                status = raise_by_children(plan, id, err);
            break;
        case STP_FATE_GONE:
            break;
        }
    }
    return status;
}

static stp_status measure_tier(stp_repair_plan *plan, uint32_t depth, stp_error *err)
{
    stp_status status = STP_OK;
    stp_dbox *changed = NULL;
    size_t count = 0;
    for (uint32_t id = 0; id < plan->count; id++) {
        stp_repair_node *node = &plan->nodes[id];
        if (node->depth == depth && node->chunk && node->fate != STP_FATE_KEPT)
            STP_TRY(measure(plan, id, node->chunk, node->origin, node->carry, err));
    }
    STP_TRY(find_changed(plan, depth, &changed, &count, err));
    for (uint32_t id = 0; id < plan->count && count > 0; id++) {
        if (plan->nodes[id].depth == depth && plan->nodes[id].fate == STP_FATE_KEPT &&
            meets_any(&plan->boxes.boxes[id], changed, count))
            STP_TRY(recheck(plan, id, err));
    }
done:
    free(changed);
    return status;
}

stp_status stp_repair_build(stp_repair_plan *plan, stp_error *err)
{
    stp_status status = STP_OK;
    for (uint32_t depth = plan->depth; depth-- > 0;) {
        STP_TRY(build_tier(plan, depth, err));
        STP_TRY(measure_tier(plan, depth, err));
    }
done:
    return status;
}

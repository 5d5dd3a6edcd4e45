/* Builds and measures the new chunks of a tier, and checks those beside them. */
#include "preprocess/append/append_tree.h"

#include "base/memory.h"
#include "formats/chunk/measure/raise.h"

#include <inttypes.h>
#include <stdlib.h>

/* ---- leaves ---- */

static stp_status build_leaf(const stp_growth *g, stp_grown_node *node, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cell *cell = &g->a->job.cloud.cells[node->cell];
    const uint32_t count = (uint32_t)(cell->end - cell->begin);
    stp_item *items = NULL;
    STP_TRY(stp_alloc(&items, count, sizeof *items, "samples", err));
    stp_append_items(g->a, items, (uint32_t)cell->begin, count, &g->items);
    const stp_item_group group = {.items = items, .count = count};
    STP_TRY(stp_chunk_build_leaf(&node->built, &group, &g->items, err));
    node->points_under = count;
done:
    free(items);
    return status;
}

/* ---- chunks above ---- */

/* What a chunk is made of: its children, and the chunk whose patches stay. */
typedef struct parts {
    stp_item_group groups[STP_CHUNK_CHILDREN_LIMIT];
    stp_kept_patches kept[STP_CHUNK_CHILDREN_LIMIT];
    stp_chunk *read[STP_CHUNK_CHILDREN_LIMIT]; /* children from the file */
} parts;

/* Fails if patches of a chunk refer to patches that the child has not. */
static stp_status check_links(const stp_append *a, uint32_t id, const stp_kept_patches *kept,
                              stp_error *err)
{
    const stp_chunk *above = kept->above.chunk;
    for (uint32_t p = 0; p < above->patch_count; p++) {
        const stp_patch *patch = &above->patches[p];
        if (patch->child == kept->child &&
            (uint32_t)patch->first_below + patch->counts[0] > kept->below->patch_count)
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: chunk %" PRIu32 ": patch %" PRIu32
                                 " refers to patches that its child has not: the file was written "
                                 "wrong",
                                 a->job.path, id, p);
    }
    return STP_OK;
}

/* A child that is in the file brings the patches that it has above it. */
static stp_status add_kept(const stp_growth *g, parts *p, uint32_t at, const stp_grown_node *child,
                           stp_placed_chunk above, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_append *a = g->a;
    if (child->kept)
        STP_TRY(stp_chunk_file_read(a->file, child->old, 2, &p->read[at], err));
    p->kept[at] = (stp_kept_patches){.above = above,
                                     .below = child->kept ? p->read[at] : child->built.chunk,
                                     .child = child->old - a->entries[child->parent].first_child};
    STP_TRY(check_links(a, child->parent, &p->kept[at], err));
    p->groups[at] = (stp_item_group){.kept = &p->kept[at]};
done:
    return status;
}

static stp_status build_inner(const stp_growth *g, stp_grown_node *node, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk *above = NULL;
    stp_placed_chunk placed = {0};
    parts *p = NULL;
    STP_TRY(stp_alloc(&p, 1, sizeof *p, "chunks", err));
    if (node->was != STP_CHUNK_NONE) {
        STP_TRY(stp_shelf_take(g->shelf, node->was, &above, err));
        placed = (stp_placed_chunk){above, g->a->entries[node->was].origin, NULL};
    }
    for (uint32_t i = 0; i < node->child_count; i++) {
        const stp_grown_node *child = &g->below.nodes[node->first_child + i];
        if (above && child->old != STP_CHUNK_NONE)
            STP_TRY(add_kept(g, p, i, child, placed, err));
        else
            p->groups[i] = (stp_item_group){.items = child->built.vertices,
                                            .count = child->built.vertex_count,
                                            .run_ends = child->built.run_ends,
                                            .run_count = child->built.run_count};
    }
    STP_TRY(stp_chunk_build_inner(&node->built, p->groups, node->child_count, err));
done:
    for (uint32_t i = 0; p && i < node->child_count; i++)
        stp_chunk_destroy(&p->read[i]);
    free(p);
    if (above)
        stp_shelf_give(g->shelf, node->was);
    return status;
}

static stp_status build_one(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    stp_growth *g = context;
    const uint32_t at = g->todo[index];
    stp_grown_node *node = &g->tier.nodes[at];
    (void)worker;
    STP_TRY(g->tier.leaves ? build_leaf(g, node, err) : build_inner(g, node, err));
    node->vertex_count = node->built.vertex_count;
    free(node->built.sources);
    node->built.sources = NULL;
    const stp_placed_chunk placed = stp_built_chunk_place(&node->built);
    g->tier.boxes.boxes[at] = stp_placed_chunk_box(&placed);
    STP_TRY(stp_built_chunk_stow(&node->built, g->a->job.spill, err));
done:
    return status;
}

/* ---- errors ---- */

/* Whose surroundings are sought. */
typedef struct seeker {
    const stp_growth *g;
    bool carries; /* also what the samples around carry */
} seeker;

static stp_status add_surrounding(void *context, uint32_t index, stp_surroundings *out,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    const seeker *s = context;
    const stp_grown_node *node = &s->g->tier.nodes[index];
    const stp_chunk *chunk = NULL;
    stp_carry *told = NULL;
    if (!node->kept) {
        stp_placed_chunk own = stp_built_chunk_place(&node->built);
        own.carry = s->carries ? own.carry : NULL;
        return stp_surroundings_add(out, &own, err);
    }
    STP_TRY(stp_shelf_take(s->g->shelf, node->old, &chunk, err));
    if (s->carries)
        STP_TRY(stp_carry_tell(chunk, &told, err));
    const stp_placed_chunk placed = {chunk, s->g->a->entries[node->old].origin, told};
    STP_TRY(stp_surroundings_add(out, &placed, err));
done:
    free(told);
    if (chunk)
        stp_shelf_give(s->g->shelf, node->old);
    return status;
}

static stp_status find_around(const stp_growth *g, uint32_t at, const stp_placed_chunk *middle,
                              bool carries, stp_surroundings *out, stp_error *err)
{
    seeker s = {g, carries};
    const stp_surrounding_chunks others = {&g->tier.boxes, add_surrounding, &s};
    return stp_surroundings_find(out, middle, at, &others, err);
}

static stp_status measure_one(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    stp_growth *g = context;
    const uint32_t at = g->todo[index];
    stp_built_chunk *built = &g->tier.nodes[at].built;
    const stp_placed_chunk middle = stp_built_chunk_place(built);
    stp_surroundings around = {0};
    (void)worker;
    STP_TRY(find_around(g, at, &middle, !g->tier.leaves, &around, err));
    STP_TRY(stp_built_chunk_measure(built, &around, NULL, err));
done:
    stp_surroundings_clear(&around);
    return status;
}

/* Measures a kept chunk again and raises its errors. */
static stp_status raise(const stp_growth *g, uint32_t at, stp_built_chunk *out, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t id = g->tier.nodes[at].old;
    stp_surroundings around = {0};
    stp_built_chunk built = {.origin = g->a->entries[id].origin};
    STP_TRY(stp_chunk_file_read(g->a->file, id, 0, &built.chunk, err));
    if (!g->tier.leaves)
        STP_TRY(stp_carry_tell(built.chunk, &built.carry, err));
    const stp_placed_chunk middle = stp_built_chunk_place(&built);
    STP_TRY(find_around(g, at, &middle, !g->tier.leaves, &around, err));
    STP_TRY(stp_overhang_raise(built.chunk, built.carry, &around, err));
    *out = built;
    built = (stp_built_chunk){0};
done:
    stp_built_chunk_clear(&built);
    stp_surroundings_clear(&around);
    return status;
}

/* Raises a kept chunk's errors if they do not hold beside what changed. */
static stp_status check_one(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    stp_growth *g = context;
    const uint32_t at = g->todo[index], id = g->tier.nodes[at].old;
    const stp_chunk *chunk = NULL;
    stp_surroundings around = {0};
    uint32_t refuted = STP_CHUNK_NONE;
    (void)worker;
    STP_TRY(stp_shelf_take(g->shelf, id, &chunk, err));
    const stp_placed_chunk middle = {chunk, g->a->entries[id].origin, NULL};
    STP_TRY(find_around(g, at, &middle, false, &around, err));
    STP_TRY(stp_overhang_check(&refuted, chunk, &around, err));
    if (refuted != STP_CHUNK_NONE)
        STP_TRY(raise(g, at, &g->raised[index], err));
done:
    stp_surroundings_clear(&around);
    if (chunk)
        stp_shelf_give(g->shelf, id);
    return status;
}

static stp_status encode_one(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    stp_growth *g = context;
    stp_grown_node *node = &g->tier.nodes[g->todo[index]];
    const stp_codec codec = g->a->job.tree.codec;
    (void)worker;
    if (node->old == STP_CHUNK_NONE && !stp_growth_is_root(g)) /* the root has no parent */
        STP_TRY(stp_built_chunk_cut(&node->built, codec, err));
    STP_TRY(stp_chunk_encode(node->built.chunk, codec, &node->payload, &node->entry, err));
    node->entry.origin = node->built.origin;
    node->entry.points_under = node->points_under;
done:
    return status;
}

/* ---- the steps ---- */

static void list_nodes(stp_growth *g, bool kept)
{
    g->todo_count = 0;
    for (uint32_t i = 0; i < g->tier.count; i++)
        if (g->tier.nodes[i].kept == kept)
            g->todo[g->todo_count++] = i;
}

static stp_status run(stp_growth *g, stp_pool_task *task, stp_error *err)
{
    return stp_cloud_run(&g->a->job.cloud, g->a->job.pool, g->todo_count, task, g, err);
}

/* Lists the kept chunks whose boxes meet that of a new chunk, or of one that is gone. */
static stp_status list_beside(stp_growth *g, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_grown_tier *t = &g->tier;
    stp_chunk_boxes changed = {0};
    STP_TRY(stp_chunk_boxes_create(&changed, 2 * t->count, err));
    for (uint32_t i = 0; i < t->count; i++) {
        const stp_grown_node *node = &t->nodes[i];
        if (node->kept)
            continue;
        changed.boxes[2 * i] = t->boxes.boxes[i];
        if (node->was != STP_CHUNK_NONE)
            changed.boxes[2 * i + 1] = stp_chunk_entry_box(&g->a->entries[node->was]);
    }
    stp_chunk_boxes_join(&changed);
    g->todo_count = 0;
    for (uint32_t i = 0; i < t->count; i++)
        if (t->nodes[i].kept &&
            stp_chunk_boxes_next(&changed, &t->boxes.boxes[i], 0) != STP_CHUNK_NONE)
            g->todo[g->todo_count++] = i;
done:
    stp_chunk_boxes_clear(&changed);
    return status;
}

static stp_status check_beside(stp_growth *g, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(list_beside(g, err));
    STP_TRY(stp_alloc(&g->raised, g->todo_count, sizeof *g->raised, "chunks", err));
    STP_TRY(run(g, check_one, err));
    for (uint32_t i = 0; i < g->todo_count; i++) {
        stp_grown_node *node = &g->tier.nodes[g->todo[i]];
        if (!g->raised[i].chunk)
            continue;
        node->built = g->raised[i];
        node->kept = false;
        g->raised[i] = (stp_built_chunk){0};
        g->a->result->raised_chunks++;
    }
done:
    if (status == STP_OK) {
        free(g->raised);
        g->raised = NULL;
    }
    return status;
}

stp_status stp_growth_build(stp_growth *g, stp_error *err)
{
    stp_status status = STP_OK;
    stp_grown_tier *t = &g->tier;
    free(g->todo);
    g->todo = NULL;
    STP_TRY(stp_alloc(&g->todo, t->count, sizeof *g->todo, "chunks", err));
    STP_TRY(stp_chunk_boxes_create(&t->boxes, t->count, err));
    for (uint32_t i = 0; i < t->count; i++)
        if (t->nodes[i].kept)
            t->boxes.boxes[i] = stp_chunk_entry_box(&g->a->entries[t->nodes[i].old]);
    list_nodes(g, false);
    STP_TRY(run(g, build_one, err));
    stp_chunk_boxes_join(&t->boxes);
    STP_TRY(run(g, measure_one, err));
    STP_TRY(check_beside(g, err));
    list_nodes(g, false);
    STP_TRY(run(g, encode_one, err));
done:
    return status;
}

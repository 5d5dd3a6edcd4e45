/* Lists the tiers of a model that grows. */
#include "preprocess/append/append_tree.h"

#include "base/memory.h"

#include <stdlib.h>

/* A new leaf beside an old one. */
typedef struct free_cell {
    uint32_t leaf, cell;
} free_cell;

static int compare_free(const void *a, const void *b)
{
    const free_cell *x = a, *y = b;
    if (x->leaf != y->leaf)
        return x->leaf < y->leaf ? -1 : 1;
    return (x->cell > y->cell) - (x->cell < y->cell);
}

/* Square of the distance between two boxes. */
static double gap(const stp_dbox *a, const stp_dbox *b)
{
    const double way[3] = {stp_max(a->min.x - b->max.x, b->min.x - a->max.x),
                           stp_max(a->min.y - b->max.y, b->min.y - a->max.y),
                           stp_max(a->min.z - b->max.z, b->min.z - a->max.z)};
    double sum = 0.0;
    for (int i = 0; i < 3; i++)
        sum += way[i] > 0.0 ? way[i] * way[i] : 0.0;
    return sum;
}

static uint32_t nearest_leaf(const stp_append *a, const stp_dbox *box)
{
    uint32_t best = 0;
    double least = INFINITY;
    for (uint32_t i = 0; i < a->leaf_count; i++) {
        const stp_dbox other = stp_chunk_entry_box(stp_append_leaf(a, i));
        const double own = gap(box, &other);
        if (own < least) {
            least = own;
            best = i;
        }
    }
    return best;
}

/* Finds beside which leaf each cell of points that join none lies. */
static stp_status list_free(const stp_append *a, free_cell **out, uint32_t *count, stp_error *err)
{
    const stp_cloud *cloud = &a->job.cloud;
    stp_status status = stp_alloc(out, cloud->cell_count, sizeof **out, "chunks", err);
    for (uint32_t c = 0; status == STP_OK && c < cloud->cell_count; c++)
        if (a->cell_leaf[c] == STP_LEAF_FREE)
            (*out)[(*count)++] = (free_cell){nearest_leaf(a, &cloud->cells[c].box), c};
    if (status == STP_OK)
        qsort(*out, *count, sizeof **out, compare_free);
    return status;
}

static void add_new(stp_grown_tier *t, const stp_append *a, uint32_t leaf, uint32_t cell, bool free)
{
    const uint32_t id = a->first_leaf + leaf;
    t->nodes[t->count++] = (stp_grown_node){.old = STP_CHUNK_NONE,
                                            .was = free ? STP_CHUNK_NONE : id,
                                            .parent = a->entries[id].parent,
                                            .cell = cell};
}

static stp_grown_node kept_node(const stp_append *a, uint32_t id)
{
    const stp_chunk_entry *e = &a->entries[id];
    return (stp_grown_node){.old = id,
                            .was = STP_CHUNK_NONE,
                            .parent = e->parent,
                            .kept = true,
                            .vertex_count = e->patch_count,
                            .points_under = e->points_under};
}

stp_status stp_growth_leaves(stp_growth *g, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_append *a = g->a;
    const stp_cloud *cloud = &a->job.cloud;
    stp_grown_tier t = {.leaves = true};
    free_cell *beside = NULL;
    uint32_t free_count = 0, at = 0, cell = 0;
    STP_TRY(list_free(a, &beside, &free_count, err));
    STP_TRY(stp_alloc(&t.nodes, (size_t)a->leaf_count + cloud->cell_count, sizeof *t.nodes,
                      "chunks", err));
    for (uint32_t i = 0; i < a->leaf_count; i++) {
        if (!a->touched[i])
            t.nodes[t.count++] = kept_node(a, a->first_leaf + i);
        for (; cell < cloud->cell_count && a->cell_leaf[cell] == i; cell++)
            add_new(&t, a, i, cell, false);
        for (; at < free_count && beside[at].leaf == i; at++)
            add_new(&t, a, i, beside[at].cell, true);
    }
    g->tier = t;
done:
    free(beside);
    return status;
}

bool stp_growth_is_root(const stp_growth *g)
{
    return g->tier.count == 1 && g->tier.nodes[0].parent == STP_CHUNK_NONE;
}

/* ---- the next tier ---- */

/* Where a chunk above ends that begins with child `begin`: it has at most `most` children. */
static uint32_t span_end(const stp_grown_tier *t, uint32_t begin, uint32_t end, uint32_t most)
{
    uint64_t sum = 0;
    uint32_t i = begin;
    for (; i < end && i - begin < most; i++) {
        sum += t->nodes[i].vertex_count;
        if (i > begin && sum > STP_CHUNK_SAMPLES_LIMIT)
            break;
    }
    return i;
}

static uint32_t span_count(const stp_grown_tier *t, uint32_t begin, uint32_t end)
{
    uint32_t count = 0;
    for (; begin < end; count++)
        begin = span_end(t, begin, end, STP_CHUNK_CHILDREN_LIMIT);
    return count;
}

/* Whether the children [begin, end) are those that the chunk `parent` has, unchanged. */
static bool is_unchanged(const stp_growth *g, uint32_t parent, uint32_t begin, uint32_t end)
{
    if (parent == STP_CHUNK_NONE || end - begin != g->a->entries[parent].child_count)
        return false;
    for (uint32_t i = begin; i < end; i++)
        if (!g->below.nodes[i].kept)
            return false;
    return true;
}

/* Lists the chunks above children of one parent. */
static void rise_over(stp_growth *g, uint32_t begin, uint32_t end)
{
    const stp_append *a = g->a;
    const stp_grown_tier *below = &g->below;
    const uint32_t parent = below->nodes[begin].parent;
    if (is_unchanged(g, parent, begin, end)) {
        stp_grown_node *out = &g->tier.nodes[g->tier.count++];
        *out = kept_node(a, parent);
        out->first_child = begin;
        out->child_count = end - begin;
        return;
    }
    const uint32_t parts = span_count(below, begin, end);
    const uint32_t most = (end - begin + parts - 1) / parts; /* about as many in each */
    while (begin < end) {
        const uint32_t to = span_end(below, begin, end, most);
        stp_grown_node *out = &g->tier.nodes[g->tier.count++];
        *out = (stp_grown_node){.old = STP_CHUNK_NONE,
                                .was = parent,
                                .parent = parent == STP_CHUNK_NONE ? STP_CHUNK_NONE
                                                                   : a->entries[parent].parent,
                                .first_child = begin,
                                .child_count = to - begin};
        for (uint32_t i = begin; i < to; i++)
            out->points_under += below->nodes[i].points_under;
        begin = to;
    }
}

static void clear_tier(stp_grown_tier *t)
{
    for (uint32_t i = 0; t->nodes && i < t->count; i++) {
        stp_built_chunk_clear(&t->nodes[i].built);
        free(t->nodes[i].payload);
    }
    free(t->nodes);
    stp_chunk_boxes_clear(&t->boxes);
    *t = (stp_grown_tier){0};
}

stp_status stp_growth_rise(stp_growth *g, stp_error *err)
{
    clear_tier(&g->below);
    g->below = g->tier;
    g->tier = (stp_grown_tier){0};
    const stp_grown_tier *below = &g->below;
    stp_status status =
        stp_alloc(&g->tier.nodes, below->count, sizeof *g->tier.nodes, "chunks", err);
    for (uint32_t begin = 0, end = 0; status == STP_OK && begin < below->count; begin = end) {
        while (end < below->count && below->nodes[end].parent == below->nodes[begin].parent)
            end++;
        rise_over(g, begin, end);
    }
    if (status == STP_OK && below->nodes[0].parent == STP_CHUNK_NONE &&
        g->tier.count >= below->count)
        status = stp_error_set(err, STP_LIMIT,
                               "%s: its patches do not group: its points lie too far apart to be "
                               "merged",
                               g->a->job.path);
    return status;
}

void stp_growth_clear(stp_growth *g)
{
    clear_tier(&g->below);
    clear_tier(&g->tier);
    for (uint32_t i = 0; g->raised && i < g->todo_count; i++)
        stp_built_chunk_clear(&g->raised[i]);
    free(g->raised);
    free(g->todo);
    stp_shelf_destroy(&g->shelf);
}

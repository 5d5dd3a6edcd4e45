/* Boxes over runs of points. */
#include "preprocess/cloud/box_tree.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_blocks.h"

#include <stdlib.h>
#include <string.h>

#define LEAF_POINTS 64u
#define FANOUT 16u
/* Leaves that one task makes. */
#define TASK_LEAVES 1024u

_Static_assert(STP_BLOCK_POINTS % LEAF_POINTS == 0, "a leaf lies in one block");

typedef struct planting {
    const stp_cloud *cloud;
    stp_box_tree tree;
} planting;

static uint64_t parts(uint64_t count, uint64_t size)
{
    return count / size + (count % size != 0);
}

static uint64_t cloud_end(const stp_cloud *cloud)
{
    return cloud->first + cloud->count;
}

static uint64_t leaf_begin(const stp_cloud *cloud, uint64_t leaf)
{
    return cloud->first + leaf * LEAF_POINTS;
}

static uint64_t leaf_end(const stp_cloud *cloud, uint64_t leaf)
{
    const uint64_t begin = leaf_begin(cloud, leaf), end = cloud_end(cloud);
    return end - begin < LEAF_POINTS ? end : begin + LEAF_POINTS;
}

/* Makes the boxes of this process's points; an empty box where it has none. */
static stp_status make_leaves(void *context, size_t task, unsigned worker, stp_error *err)
{
    planting *p = context;
    const stp_rank_part own = stp_cloud_own(p->cloud);
    const uint64_t last = (task + 1) * (uint64_t)TASK_LEAVES;
    (void)worker;
    (void)err;
    for (uint64_t i = task * (uint64_t)TASK_LEAVES; i < last && i < p->tree.begin[1]; i++) {
        uint64_t begin = leaf_begin(p->cloud, i), end = leaf_end(p->cloud, i);
        begin = begin > own.begin ? begin : own.begin;
        end = end < own.end ? end : own.end;
        p->tree.boxes[i] =
            begin < end ? stp_points_box(p->cloud->points + begin, end - begin) : stp_dbox_empty();
    }
    return STP_OK;
}

/* Gives each rank's leaves to all. A leaf between two runs is the box of both parts. */
static stp_status share_leaves(planting *p, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cloud_blocks *b = p->cloud->blocks;
    stp_dbox *boxes = NULL;
    STP_TRY(stp_alloc(&boxes, TASK_LEAVES, sizeof *boxes, "boxes", err));
    for (unsigned rank = 0; rank < b->ranks->count; rank++) {
        const uint64_t first = p->cloud->first;
        const uint64_t end = parts(b->begins[rank + 1] - first, LEAF_POINTS);
        for (uint64_t at = (b->begins[rank] - first) / LEAF_POINTS; at < end; at += TASK_LEAVES) {
            const uint64_t count = end - at < TASK_LEAVES ? end - at : TASK_LEAVES;
            memcpy(boxes, p->tree.boxes + at, count * sizeof *boxes);
            STP_TRY(stp_ranks_broadcast(b->ranks, rank, boxes, count * sizeof *boxes, err));
            for (uint64_t i = 0; i < count; i++)
                stp_dbox_join(&p->tree.boxes[at + i], &boxes[i]);
        }
    }
done:
    free(boxes);
    return status;
}

static void make_nodes(stp_box_tree *tree)
{
    for (unsigned tier = 1; tier < tree->tier_count; tier++) {
        const stp_dbox *below = tree->boxes + tree->begin[tier - 1];
        uint64_t below_count = tree->begin[tier] - tree->begin[tier - 1];
        for (uint64_t i = tree->begin[tier]; i < tree->begin[tier + 1]; i++)
            tree->boxes[i] = stp_dbox_empty();
        for (uint64_t i = 0; i < below_count; i++)
            stp_dbox_join(&tree->boxes[tree->begin[tier] + i / FANOUT], &below[i]);
    }
}

stp_status stp_box_tree_create(stp_box_tree *out, const stp_cloud *cloud, stp_pool *pool,
                               stp_error *err)
{
    planting p = {.cloud = cloud};
    const uint64_t count = parts(cloud->count, LEAF_POINTS);
    for (uint64_t in_tier = count; in_tier > 0;
         in_tier = in_tier > 1 ? parts(in_tier, FANOUT) : 0) {
        unsigned tier = p.tree.tier_count++;
        p.tree.begin[tier + 1] = p.tree.begin[tier] + in_tier;
    }
    stp_status status =
        stp_spill_alloc(cloud->spill, &p.tree.boxes, p.tree.begin[p.tree.tier_count],
                        sizeof *p.tree.boxes, "boxes", err);
    if (status == STP_OK)
        status = stp_cloud_run(cloud, pool, parts(count, TASK_LEAVES), make_leaves, &p, err);
    if (status == STP_OK && cloud->blocks)
        status = share_leaves(&p, err);
    if (status != STP_OK) {
        stp_box_tree_clear(&p.tree, cloud->spill);
        return status;
    }
    make_nodes(&p.tree);
    *out = p.tree;
    return STP_OK;
}

void stp_box_tree_clear(stp_box_tree *tree, stp_spill *spill)
{
    stp_spill_free(spill, tree->boxes);
    *tree = (stp_box_tree){0};
}

/* The children, in the tier below, of a tier's i-th node: *first and the returned count. */
static uint32_t children_of(const stp_box_tree *tree, unsigned tier, uint64_t i, uint64_t *first)
{
    uint64_t below = tree->begin[tier] - tree->begin[tier - 1];
    *first = i * FANOUT;
    return below - *first < FANOUT ? (uint32_t)(below - *first) : FANOUT;
}

typedef struct nearest_search {
    const stp_cloud *cloud;
    stp_dvec3 from;
    double reach; /* squared */
    stp_nearest_list *list;
} nearest_search;

static void try_point(nearest_search *s, uint64_t i)
{
    stp_dvec3 d = stp_dvec3_sub(s->cloud->points[i].position, s->from);
    double squared = stp_dvec3_dot(d, d);
    if (squared == 0.0 || squared > s->reach || stp_cloud_repeats(s->cloud, i))
        return;
    stp_nearest_list_insert(s->list, squared, i, s->cloud->points[i].source);
    s->reach = stp_min(s->reach, stp_nearest_list_reach(s->list));
}

/* Whether all points of a node are at one position. Then the first one in the cloud stands for all.
 */
static bool is_spot(const stp_dbox *box)
{
    return box->min.x == box->max.x && box->min.y == box->max.y && box->min.z == box->max.z;
}

static uint64_t first_point(const stp_cloud *cloud, unsigned tier, uint64_t i)
{
    for (; tier > 0; tier--)
        i *= FANOUT;
    return leaf_begin(cloud, i);
}

/* Whether a leaf's points are here, and the one before: it tells whether the first one repeats. */
static bool has_leaf(const stp_cloud *cloud, uint64_t begin)
{
    const bool here = stp_cloud_has(cloud, begin);
    return (begin == cloud->first || stp_cloud_has(cloud, begin - 1)) && here;
}

/* Searches a node, nearest children first. */
static void search_node(nearest_search *s, unsigned tier, uint64_t i)
{
    const stp_box_tree *tree = &s->cloud->tree;
    uint64_t order[FANOUT], first = 0;
    double distances[FANOUT];
    if (is_spot(&tree->boxes[tree->begin[tier] + i])) {
        if (has_leaf(s->cloud, first_point(s->cloud, tier, i)))
            try_point(s, first_point(s->cloud, tier, i));
        return;
    }
    if (tier == 0) {
        if (!has_leaf(s->cloud, leaf_begin(s->cloud, i)))
            return;
        for (uint64_t at = leaf_begin(s->cloud, i); at < leaf_end(s->cloud, i); at++)
            try_point(s, at);
        return;
    }
    uint32_t count = children_of(tree, tier, i, &first);
    for (uint32_t c = 0; c < count; c++) {
        double distance =
            stp_dbox_distance_squared(&tree->boxes[tree->begin[tier - 1] + first + c], s->from);
        uint32_t at = c;
        for (; at > 0 && distance < distances[at - 1]; at--) {
            distances[at] = distances[at - 1];
            order[at] = order[at - 1];
        }
        distances[at] = distance;
        order[at] = first + c;
    }
    for (uint32_t c = 0; c < count && distances[c] <= s->reach; c++)
        search_node(s, tier - 1, order[c]);
}

void stp_box_tree_nearest(const stp_cloud *cloud, uint64_t self, stp_nearest_list *list)
{
    nearest_search s = {.cloud = cloud,
                        .from = cloud->points[self].position,
                        .reach = stp_nearest_list_reach(list),
                        .list = list};
    list->count = 0;
    if (cloud->tree.tier_count > 0)
        search_node(&s, cloud->tree.tier_count - 1, 0);
}

typedef struct walk {
    const stp_cloud *cloud;
    bool (*test)(void *, const stp_dbox *);
    bool (*visit)(void *, uint64_t, uint64_t);
    void *context;
} walk;

static bool walk_node(const walk *w, unsigned tier, uint64_t i)
{
    const stp_box_tree *tree = &w->cloud->tree;
    uint64_t first = 0;
    if (!w->test(w->context, &tree->boxes[tree->begin[tier] + i]))
        return true;
    if (tier == 0 && !has_leaf(w->cloud, leaf_begin(w->cloud, i)))
        return true;
    if (tier == 0)
        return w->visit(w->context, leaf_begin(w->cloud, i), leaf_end(w->cloud, i));
    uint32_t count = children_of(tree, tier, i, &first);
    for (uint32_t c = 0; c < count; c++)
        if (!walk_node(w, tier - 1, first + c))
            return false;
    return true;
}

bool stp_box_tree_walk(const stp_cloud *cloud, bool (*test)(void *, const stp_dbox *),
                       bool (*visit)(void *, uint64_t, uint64_t), void *context)
{
    const walk w = {cloud, test, visit, context};
    return cloud->tree.tier_count == 0 || walk_node(&w, cloud->tree.tier_count - 1, 0);
}

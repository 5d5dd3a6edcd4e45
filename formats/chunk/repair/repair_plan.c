/* Plans what becomes of each chunk of a damaged file. */
#include "formats/chunk/repair/repair_plan.h"

#include "base/memory.h"

#include <stdlib.h>

#define NO_DEPTH UINT32_MAX

/* Links chunks by their entries: by their own, or by the entry of the parent that lists them. */
static void link_known(stp_repair_plan *plan)
{
    const stp_damaged *d = plan->damaged;
    for (uint32_t id = 0; id < plan->count; id++) {
        const stp_chunk_entry *e = &d->entries[id];
        if (!d->known[id])
            continue;
        plan->nodes[id].parent = e->parent;
        plan->nodes[id].depth = e->depth;
        for (uint32_t c = 0; c < e->child_count; c++) {
            stp_repair_node *child = &plan->nodes[e->first_child + c];
            child->parent = id;
            child->child_index = c;
            child->depth = e->depth + 1u;
        }
    }
    /* an unknown chunk is one level above the chunks that name it */
    for (uint32_t id = plan->count; id-- > 1;) {
        uint32_t parent = plan->nodes[id].parent;
        if (plan->nodes[id].depth != NO_DEPTH && parent != STP_CHUNK_NONE &&
            plan->nodes[parent].depth == NO_DEPTH && plan->nodes[id].depth > 0)
            plan->nodes[parent].depth = plan->nodes[id].depth - 1;
    }
}

/* In breadth-first order parents do not decrease: all chunks between two children of one chunk are
 * its children, too. */
static void link_between(stp_repair_plan *plan)
{
    uint32_t before = STP_CHUNK_NONE;
    plan->nodes[0].depth = 0;
    plan->nodes[0].parent = STP_CHUNK_NONE;
    for (uint32_t id = 1; id < plan->count; id++) {
        stp_repair_node *node = &plan->nodes[id];
        uint32_t after = id + 1;
        if (node->parent == STP_CHUNK_NONE && node->depth == 1)
            node->parent = 0;
        while (after < plan->count && plan->nodes[after].parent == STP_CHUNK_NONE)
            after++;
        if (node->parent == STP_CHUNK_NONE && before != STP_CHUNK_NONE && after < plan->count &&
            plan->nodes[after].parent == before)
            node->parent = before;
        if (node->parent != STP_CHUNK_NONE) {
            before = node->parent;
            node->depth = plan->nodes[before].depth + 1;
        }
    }
}

/* Cuts links to a parent that does not come before its child; else loops over the tree would not
 * end. */
static void cut_wrong_links(stp_repair_plan *plan)
{
    plan->depth = 0;
    for (uint32_t id = 1; id < plan->count; id++) {
        stp_repair_node *node = &plan->nodes[id];
        if (node->parent >= id || plan->nodes[node->parent].depth >= STP_DEPTH_LIMIT - 1) {
            node->parent = STP_CHUNK_NONE;
            node->depth = 0;
            continue;
        }
        node->depth = plan->nodes[node->parent].depth + 1;
        plan->depth = node->depth > plan->depth ? node->depth : plan->depth;
    }
    plan->depth++;
}

static bool can_show(const stp_repair_plan *plan, uint32_t parent)
{
    const stp_damaged *d = plan->damaged;
    return parent != STP_CHUNK_NONE && d->known[parent] && d->finest[parent] < STP_NOTHING_READABLE;
}

/* Chooses fates, children first. child_rebuilt: by id, whether a child's level 3 changes. */
static void choose_fates(stp_repair_plan *plan, bool *child_rebuilt)
{
    const stp_damaged *d = plan->damaged;
    for (uint32_t id = plan->count; id-- > 0;) {
        stp_repair_node *node = &plan->nodes[id];
        bool whole = d->known[id] && d->finest[id] == 0;
        if (id > 0 && node->parent == STP_CHUNK_NONE)
            node->fate = STP_FATE_GONE;
        else if (whole && !child_rebuilt[id])
            node->fate = STP_FATE_KEPT;
        else if (node->child_count > 0)
            node->fate = STP_FATE_REBUILT;
        else if (d->known[id] && d->finest[id] < STP_NOTHING_READABLE)
            node->fate = STP_FATE_COARSE;
        else
            node->fate = can_show(plan, node->parent) ? STP_FATE_PARENT : STP_FATE_GONE;
        if (node->fate == STP_FATE_GONE || id == 0)
            continue;
        plan->nodes[node->parent].child_count++;
        child_rebuilt[node->parent] |= node->fate == STP_FATE_REBUILT;
    }
}

static stp_status place_boxes(stp_repair_plan *plan, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_chunk_boxes_create(&plan->boxes, plan->count, err));
    for (uint32_t id = 0; id < plan->count; id++)
        if (plan->nodes[id].fate != STP_FATE_GONE)
            plan->boxes.boxes[id] = stp_chunk_entry_box(&plan->damaged->entries[id]);
    stp_chunk_boxes_join(&plan->boxes);
done:
    return status;
}

stp_status stp_repair_plan_make(stp_repair_plan *out, const stp_damaged *d, stp_error *err)
{
    stp_status status = STP_OK;
    stp_repair_plan plan = {.damaged = d, .count = d->header.chunk_count};
    bool *child_rebuilt = NULL;
    STP_TRY(stp_alloc(&plan.nodes, plan.count, sizeof *plan.nodes, "chunks", err));
    STP_TRY(stp_alloc(&child_rebuilt, plan.count, sizeof *child_rebuilt, "chunks", err));
    for (uint32_t id = 0; id < plan.count; id++) {
        plan.nodes[id].parent = STP_CHUNK_NONE;
        plan.nodes[id].depth = NO_DEPTH;
    }
    link_known(&plan);
    link_between(&plan);
    cut_wrong_links(&plan);
    choose_fates(&plan, child_rebuilt);
    STP_TRY(place_boxes(&plan, err));
    if (plan.nodes[0].fate == STP_FATE_GONE)
        status = stp_error_set(err, STP_CORRUPT,
                               "%s: cannot be repaired: neither the root nor any chunk under it "
                               "can be read; copy it again",
                               d->path);
done:
    free(child_rebuilt);
    if (status != STP_OK)
        stp_repair_plan_clear(&plan);
    *out = plan;
    return status;
}

void stp_repair_plan_clear(stp_repair_plan *plan)
{
    for (uint32_t id = 0; plan->nodes && id < plan->count; id++) {
        stp_chunk_destroy(&plan->nodes[id].chunk);
        free(plan->nodes[id].carry);
    }
    free(plan->nodes);
    stp_chunk_boxes_clear(&plan->boxes);
    *plan = (stp_repair_plan){0};
}

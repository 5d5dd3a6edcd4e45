/* Writes a model that grows: new chunks behind its end, then the rest. */
#include "preprocess/append/append_tree.h"

#include "base/memory.h"
#include "preprocess/tree/cell_cut.h"

#include <stdlib.h>

/* Chunks of the file that are kept decoded for those beside them. */
#define SHELF_ROOM 24

/* The tree by the writer's handles. */
typedef struct handles {
    uint32_t **children;
    uint32_t *counts;
    size_t children_capacity, count_capacity;
    uint32_t count;
} handles;

static stp_status add_handle(handles *h, const stp_growth *g, const stp_grown_node *node,
                             stp_error *err)
{
    stp_status status = STP_OK;
    const size_t needed = (size_t)node->handle + 1;
    STP_TRY(
        stp_grow(&h->children, &h->children_capacity, needed, sizeof *h->children, "chunks", err));
    STP_TRY(stp_grow(&h->counts, &h->count_capacity, needed, sizeof *h->counts, "chunks", err));
    h->children[node->handle] = NULL;
    h->counts[node->handle] = node->child_count;
    h->count = node->handle + 1;
    if (node->child_count > 0)
        STP_TRY(stp_alloc(&h->children[node->handle], node->child_count, sizeof(uint32_t), "chunks",
                          err));
    for (uint32_t i = 0; i < node->child_count; i++)
        h->children[node->handle][i] = g->below.nodes[node->first_child + i].handle;
done:
    return status;
}

/* Counts what is written of a new chunk. */
static void count_new(const stp_growth *g, const stp_grown_node *node, stp_dbox *box)
{
    stp_tree_stats *stats = &g->a->job.stats->tree;
    g->a->result->new_chunks++;
    stats->patch_count += node->entry.patch_count;
    if (!g->tier.leaves)
        return;
    stp_chunk_box(node->built.chunk, node->built.origin, box);
    if (node->old == STP_CHUNK_NONE)
        stp_displacement_join(&stats->displacement, &node->built.displacement);
}

static stp_status write_tier(const stp_growth *g, stp_chunk_writer *writer, handles *h,
                             stp_dbox *box, stp_error *err)
{
    stp_status status = STP_OK;
    for (uint32_t i = 0; i < g->tier.count; i++) {
        stp_grown_node *node = &g->tier.nodes[i];
        if (node->kept) {
            STP_TRY(stp_chunk_writer_keep(writer, node->old, &node->handle, err));
            g->a->result->kept_chunks++;
        } else {
            STP_TRY(
                stp_chunk_writer_append(writer, node->payload, &node->entry, &node->handle, err));
            count_new(g, node, box);
            free(node->payload);
            node->payload = NULL;
        }
        STP_TRY(add_handle(h, g, node, err));
    }
done:
    return status;
}

static stp_status make_writer(stp_append *a, stp_chunk_writer **out, stp_error *err)
{
    const uint32_t given = stp_prep_given(a->job.source);
    const stp_chunk_writer_params params = {.codec = a->job.tree.codec,
                                            .attributes =
                                                a->info->attributes | given | STP_HAS_FITS,
                                            .orientation = a->job.stats->orientation,
                                            .lambda = a->job.tree.lambda};
    return stp_chunk_writer_extend(out, &a->output, a->file, &params, &a->result->unused_bytes,
                                   err);
}

/* Cuts cells that are too wide for a chunk, and notes which leaf each one joins. */
static stp_status finish_cells(stp_append *a, const stp_point_item_params *items, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud *cloud = &a->job.cloud;
    STP_TRY(stp_cells_cut(cloud, items, a->job.pool, err));
    STP_TRY(stp_alloc(&a->cell_leaf, cloud->cell_count, sizeof *a->cell_leaf, "cells", err));
    for (uint32_t c = 0; c < cloud->cell_count; c++)
        a->cell_leaf[c] = a->leaf_of[cloud->points[cloud->cells[c].begin].source];
done:
    return status;
}

static stp_status write_tiers(stp_growth *g, stp_chunk_writer *writer, handles *h, stp_dbox *box,
                              stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_growth_leaves(g, err));
    for (;;) {
        STP_TRY(stp_growth_build(g, err));
        STP_TRY(write_tier(g, writer, h, box, err));
        if (stp_growth_is_root(g))
            break;
        STP_TRY(stp_growth_rise(g, err));
    }
done:
    return status;
}

stp_status stp_append_write(stp_append *a, stp_error *err)
{
    stp_status status = STP_OK;
    stp_growth g = {.a = a};
    stp_chunk_writer *writer = NULL;
    stp_tree_stats *stats = &a->job.stats->tree;
    stp_dbox box = a->info->box, all = box;
    handles h = {0};
    char *json = NULL;
    stp_dbox_join(&all, &a->job.stats->box);
    g.items = stp_tree_item_params(&a->job.tree, &all);
    STP_TRY(finish_cells(a, &g.items, err));
    STP_TRY(stp_shelf_create(&g.shelf, a->file, SHELF_ROOM, err));
    STP_TRY(make_writer(a, &writer, err));
    STP_TRY(write_tiers(&g, writer, &h, &box, err));
    stats->chunk_count = h.count;
    a->result->points_after = g.tier.nodes[0].points_under;
    json = stp_append_metadata(a, stats);
    if (!json) {
        status = stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the metadata");
        goto done;
    }
    STP_TRY(stp_chunk_writer_finish(&writer, g.tier.nodes[0].handle,
                                    (const uint32_t *const *)h.children, h.counts, &box, json,
                                    &stats->file_bytes, err));
done:
    stp_chunk_writer_destroy(&writer);
    stp_growth_clear(&g);
    for (uint32_t i = 0; i < h.count; i++)
        free(h.children[i]);
    free(h.children);
    free(h.counts);
    free(json);
    return status;
}

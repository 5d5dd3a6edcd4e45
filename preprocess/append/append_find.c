/* Finds the leaves that new points touch. */
#include "preprocess/append/append_job.h"

#include "base/memory.h"

#include <stdatomic.h>
#include <stdlib.h>

/* A point joins a leaf if it lies within this part of the leaf's longest side. */
#define NEAR_PARTS 16.0
#define SLICE_POINTS 4096u
/* Leaves times points that are compared at most. */
#define COMPARED_MOST UINT64_C(1000000000)

/* A leaf's blocks, in the world. */
typedef struct leaf_blocks {
    stp_dbox *boxes;
    uint32_t count;
} leaf_blocks;

typedef struct finder {
    stp_append *a;
    stp_chunk_boxes boxes, wide; /* of the leaves; the same with what is near */
    leaf_blocks *blocks;         /* by leaf; empty: no new point is near */
    atomic_bool *touched;        /* by leaf */
    bool *far; /* by leaf: a block is around a new point, but no disc is; NULL: not known yet */
} finder;

/* A measure of a box, also of a flat one. */
static double size_of(const stp_dbox *box)
{
    return box->max.x - box->min.x + (box->max.y - box->min.y) + (box->max.z - box->min.z);
}

/* The leaf of the least block around the point, or of the least box if no block is around it.
 * STP_LEAF_FREE if no leaf is. Touches all leaves with a block around the point. */
static uint32_t leaf_around(const finder *f, stp_dvec3 p)
{
    const stp_dbox at = {p, p};
    uint32_t best = STP_LEAF_FREE;
    double least = INFINITY, least_block = INFINITY;
    for (uint32_t i = stp_chunk_boxes_next(&f->boxes, &at, 0); i != STP_CHUNK_NONE;
         i = stp_chunk_boxes_next(&f->boxes, &at, i + 1)) {
        const leaf_blocks *blocks = &f->blocks[i];
        if (f->far && f->far[i])
            continue;
        for (uint32_t b = 0; b < blocks->count; b++) {
            if (!stp_dbox_meet(&blocks->boxes[b], &at))
                continue;
            atomic_store_explicit(&f->touched[i], true, memory_order_relaxed);
            if (size_of(&blocks->boxes[b]) < least_block) {
                least_block = size_of(&blocks->boxes[b]);
                best = i;
            }
        }
        if (least_block == INFINITY && size_of(&f->boxes.boxes[i]) < least) {
            least = size_of(&f->boxes.boxes[i]);
            best = i;
        }
    }
    return best;
}

static uint32_t leaf_beside(const finder *f, stp_dvec3 p)
{
    const stp_dbox at = {p, p};
    uint32_t best = STP_LEAF_FREE;
    double least = INFINITY;
    for (uint32_t i = stp_chunk_boxes_next(&f->wide, &at, 0); i != STP_CHUNK_NONE;
         i = stp_chunk_boxes_next(&f->wide, &at, i + 1)) {
        const double squared = stp_dbox_distance_squared(&f->boxes.boxes[i], p);
        if (squared < least) {
            least = squared;
            best = i;
        }
    }
    return best;
}

static stp_status find_slice(void *context, size_t index, unsigned worker, stp_error *err)
{
    const finder *f = context;
    const stp_cloud *cloud = &f->a->job.cloud;
    const uint32_t begin = (uint32_t)index * SLICE_POINTS;
    (void)worker;
    (void)err;
    for (uint32_t i = begin; i < cloud->count && i < begin + SLICE_POINTS; i++) {
        const stp_cloud_point *p = &cloud->points[i];
        uint32_t leaf = leaf_around(f, p->position);
        if (leaf == STP_LEAF_FREE)
            leaf = leaf_beside(f, p->position);
        if (leaf != STP_LEAF_FREE)
            atomic_store_explicit(&f->touched[leaf], true, memory_order_relaxed);
        f->a->leaf_of[p->source] = leaf;
    }
    return STP_OK;
}

/* ---- discs ---- */

/* Boxes of a leaf's level-0 discs, in their order. */
static stp_status box_discs(stp_chunk_boxes *out, const stp_chunk *chunk, stp_dvec3 origin,
                            stp_error *err)
{
    stp_status status = stp_chunk_boxes_create(out, chunk->level_begin[0][chunk->patch_count], err);
    for (uint32_t p = 0; status == STP_OK && p < chunk->patch_count; p++)
        for (uint32_t i = chunk->level_begin[0][p]; i < chunk->level_begin[0][p + 1]; i++) {
            const stp_sample *sample = &chunk->samples[0][i];
            const double r = stp_sample_radius(sample, &chunk->patches[p]);
            const stp_dvec3 at =
                stp_dvec3_add(origin, stp_sample_position(sample, &chunk->patches[p]));
            out->boxes[i] = stp_dbox_grown(&(stp_dbox){at, at}, r);
        }
    if (status == STP_OK)
        stp_chunk_boxes_join(out);
    return status;
}

/* The bounds of merged discs make blocks wider than their points. Asks the discs. */
static stp_status refine_leaf(void *context, size_t leaf, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    const finder *f = context;
    const stp_cloud *cloud = &f->a->job.cloud;
    stp_chunk_boxes discs = {0};
    stp_chunk *chunk = NULL;
    bool near = false;
    (void)worker;
    if (!atomic_load_explicit(&f->touched[leaf], memory_order_relaxed))
        return STP_OK;
    const uint32_t id = f->a->first_leaf + (uint32_t)leaf;
    STP_TRY(stp_chunk_file_read(f->a->file, id, 0, &chunk, err));
    STP_TRY(box_discs(&discs, chunk, f->a->entries[id].origin, err));
    for (uint32_t i = 0; i < cloud->count && !near; i++) {
        const stp_dbox at = {cloud->points[i].position, cloud->points[i].position};
        near = stp_dbox_meet(&f->boxes.boxes[leaf], &at) &&
               stp_chunk_boxes_next(&discs, &at, 0) != STP_CHUNK_NONE;
    }
    f->far[leaf] = !near;
done:
    stp_chunk_boxes_clear(&discs);
    stp_chunk_destroy(&chunk);
    return status;
}

/* Leaves out the leaves without a disc around a new point. Their points go to other leaves, if
 * there are such. */
static stp_status refine(finder *f, stp_error *err)
{
    stp_status status = STP_OK;
    stp_append *a = f->a;
    const stp_cloud *cloud = &a->job.cloud;
    uint64_t touched = 0;
    for (uint32_t i = 0; i < a->leaf_count; i++)
        touched += atomic_load(&f->touched[i]);
    if (touched * cloud->count > COMPARED_MOST)
        return STP_OK;
    STP_TRY(stp_alloc(&f->far, a->leaf_count, sizeof *f->far, "chunks", err));
    STP_TRY(stp_cloud_run(cloud, a->job.pool, a->leaf_count, refine_leaf, f, err));
    for (uint32_t i = 0; i < a->leaf_count; i++)
        if (f->far[i])
            atomic_store(&f->touched[i], false);
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i)) {
        uint32_t *leaf = &a->leaf_of[cloud->points[i].source];
        if (*leaf == STP_LEAF_FREE ||
            atomic_load_explicit(&f->touched[*leaf], memory_order_relaxed))
            continue;
        const uint32_t other = leaf_around(f, cloud->points[i].position);
        if (other != STP_LEAF_FREE)
            *leaf = other;
        atomic_store_explicit(&f->touched[*leaf], true, memory_order_relaxed);
    }
done:
    return status;
}

/* ---- blocks ---- */

stp_status stp_append_blocks(const stp_append *a, uint32_t leaf, stp_block **out, uint32_t *count,
                             stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t id = a->first_leaf + leaf;
    stp_block *blocks = NULL;
    STP_TRY(stp_chunk_file_block_count(a->file, id, count, err));
    STP_TRY(stp_alloc(&blocks, *count, sizeof *blocks, "blocks", err));
    STP_TRY(stp_chunk_file_blocks(a->file, id, blocks, err));
    *out = blocks;
    blocks = NULL;
done:
    free(blocks);
    return status;
}

static stp_status load_blocks(const finder *f, uint32_t leaf, stp_error *err)
{
    stp_status status = STP_OK;
    leaf_blocks *out = &f->blocks[leaf];
    stp_block *blocks = NULL;
    uint32_t count = 0;
    STP_TRY(stp_append_blocks(f->a, leaf, &blocks, &count, err));
    STP_TRY(stp_alloc(&out->boxes, count, sizeof *out->boxes, "blocks", err));
    for (uint32_t b = 0; b < count; b++)
        out->boxes[b] = stp_block_box(&blocks[b], stp_append_leaf(f->a, leaf)->origin);
    out->count = count;
done:
    free(blocks);
    return status;
}

/* Prepares the boxes, and the blocks of leaves whose boxes meet that of the new points. */
static stp_status begin(finder *f, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_append *a = f->a;
    STP_TRY(stp_chunk_boxes_create(&f->boxes, a->leaf_count, err));
    STP_TRY(stp_chunk_boxes_create(&f->wide, a->leaf_count, err));
    STP_TRY(stp_alloc(&f->blocks, a->leaf_count, sizeof *f->blocks, "blocks", err));
    STP_TRY(stp_alloc(&f->touched, a->leaf_count, sizeof *f->touched, "chunks", err));
    for (uint32_t i = 0; i < a->leaf_count; i++) {
        const stp_dbox box = stp_chunk_entry_box(stp_append_leaf(a, i));
        f->boxes.boxes[i] = box;
        f->wide.boxes[i] = stp_dbox_grown(&box, stp_dbox_side(&box) / NEAR_PARTS);
        if (stp_dbox_meet(&box, &a->job.stats->box))
            STP_TRY(load_blocks(f, i, err));
    }
    stp_chunk_boxes_join(&f->boxes);
    stp_chunk_boxes_join(&f->wide);
done:
    return status;
}

stp_status stp_append_find(stp_append *a, stp_error *err)
{
    stp_status status = STP_OK;
    finder f = {.a = a};
    const stp_cloud *cloud = &a->job.cloud;
    const bool is_root =
        a->leaf_count == 1; /* no chunk above it has its patches: it is made anew */
    STP_TRY(begin(&f, err));
    STP_TRY(stp_alloc(&a->touched, a->leaf_count, sizeof *a->touched, "chunks", err));
    STP_TRY(stp_cloud_run(cloud, a->job.pool,
                          ((size_t)cloud->count + SLICE_POINTS - 1) / SLICE_POINTS, find_slice, &f,
                          err));
    STP_TRY(refine(&f, err));
    for (uint32_t i = 0; i < a->leaf_count; i++)
        a->touched[i] = is_root || atomic_load(&f.touched[i]);
done:
    for (uint32_t i = 0; f.blocks && i < a->leaf_count; i++)
        free(f.blocks[i].boxes);
    free(f.blocks);
    free((void *)f.touched);
    free(f.far);
    stp_chunk_boxes_clear(&f.boxes);
    stp_chunk_boxes_clear(&f.wide);
    return status;
}

/* Gathers the new points, the old points of touched leaves, and old points around them. */
#include "preprocess/append/append_job.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_cells.h"

#include <stdlib.h>
#include <string.h>

/* How far the context reaches: so many spacings of a leaf, but no more than this part of its side.
 * A plane through 16 neighbours that noise widens twice, and the graph's ring, reach 8 spacings. */
#define REACH_SPACINGS 12.0
#define REACH_PARTS 8.0

/* A leaf that is read, and where its points go. */
typedef struct taken {
    uint32_t leaf;
    uint32_t begin; /* among the old points */
    uint32_t count; /* of points that were taken */
    uint32_t joins; /* of all its points: the leaf, or STP_LEAF_CONTEXT */
    double radii;   /* sum */
} taken;

typedef struct gatherer {
    stp_append *a;
    stp_cloud *cloud;
    uint32_t first; /* place of the first old point in the cloud */
    taken *touched, *around;
    uint32_t touched_count, around_count;
    stp_chunk_boxes regions;   /* of touched leaves */
    stp_chunk_boxes new_boxes; /* not joined; by leaf: of the new points that join it */
} gatherer;

/* ---- reading ---- */

/* Takes a sample as a point of the cloud. */
static void take(const gatherer *g, taken *t, const stp_sample *sample, const stp_patch *patch,
                 stp_dvec3 at)
{
    const uint32_t place = t->begin + t->count++;
    const double radius = stp_sample_radius(sample, patch);
    const bool given = g->a->job.orient.from_file && sample->flags & STP_SAMPLE_HAS_NORMAL;
    g->a->old[place] =
        (stp_old_point){.radius = radius,
                        .exponent = patch->exponent,
                        .normal = {sample->normal[0], sample->normal[1], sample->normal[2]},
                        .flags = sample->flags,
                        .class_id = sample->class_id,
                        .intensity = sample->intensity};
    t->radii += radius;
    g->cloud->points[g->first + place] = (stp_cloud_point){
        .position = at,
        .normal = given ? stp_normal_decode(sample->normal) : (vec3s){{0.0f, 0.0f, 0.0f}},
        .rgb = {(uint16_t)(sample->rgb[0] * 257u), (uint16_t)(sample->rgb[1] * 257u),
                (uint16_t)(sample->rgb[2] * 257u)},
        .class_id = sample->class_id,
        .given = given ? STP_GIVEN_INPUT : STP_GIVEN_NOT};
}

/* Takes the level-0 samples of a chunk or a block. regions: where; NULL: everywhere. */
static void take_all(const gatherer *g, taken *t, const stp_chunk *chunk, stp_dvec3 origin,
                     const stp_chunk_boxes *regions)
{
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (uint32_t i = chunk->level_begin[0][p]; i < chunk->level_begin[0][p + 1]; i++) {
            const stp_sample *sample = &chunk->samples[0][i];
            const stp_dvec3 at =
                stp_dvec3_add(origin, stp_sample_position(sample, &chunk->patches[p]));
            const stp_dbox box = {at, at};
            if (!regions || stp_chunk_boxes_next(regions, &box, 0) != STP_CHUNK_NONE)
                take(g, t, sample, &chunk->patches[p], at);
        }
}

static stp_status read_touched(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    const gatherer *g = context;
    taken *t = &g->touched[index];
    stp_chunk *chunk = NULL;
    (void)worker;
    STP_TRY(stp_chunk_file_read(g->a->file, g->a->first_leaf + t->leaf, 0, &chunk, err));
    take_all(g, t, chunk, stp_append_leaf(g->a, t->leaf)->origin, NULL);
done:
    stp_chunk_destroy(&chunk);
    return status;
}

static stp_status read_block(const gatherer *g, taken *t, const stp_block *block, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t size = stp_block_payload_bytes(block, 0);
    uint8_t *payload = NULL;
    stp_chunk *chunk = NULL;
    STP_TRY(stp_alloc(&payload, (size_t)size + 1, 1, "a block", err));
    STP_TRY(stp_block_fetch(g->a->file, block, 0, size, payload, err));
    STP_TRY(stp_block_decode(g->a->file, block, 0, payload, NULL, &chunk, err));
    take_all(g, t, chunk, stp_append_leaf(g->a, t->leaf)->origin, &g->regions);
done:
    stp_chunk_destroy(&chunk);
    free(payload);
    return status;
}

static stp_status read_around(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    const gatherer *g = context;
    taken *t = &g->around[index];
    stp_block *blocks = NULL;
    uint32_t count = 0;
    (void)worker;
    STP_TRY(stp_append_blocks(g->a, t->leaf, &blocks, &count, err));
    for (uint32_t b = 0; b < count; b++) {
        const stp_dbox box = stp_block_box(&blocks[b], stp_append_leaf(g->a, t->leaf)->origin);
        if (stp_chunk_boxes_next(&g->regions, &box, 0) != STP_CHUNK_NONE)
            STP_TRY(read_block(g, t, &blocks[b], err));
    }
done:
    free(blocks);
    return status;
}

/* ---- what is read ---- */

/* The box of a touched leaf and of the new points that join it. */
static stp_dbox box_of(const gatherer *g, uint32_t leaf)
{
    stp_dbox box = stp_chunk_entry_box(stp_append_leaf(g->a, leaf));
    stp_dbox_join(&box, &g->new_boxes.boxes[leaf]);
    return box;
}

/* Lists the touched leaves, and those that lie near enough to be looked at. *count: points of all.
 */
static stp_status list_leaves(gatherer *g, uint64_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_append *a = g->a;
    stp_chunk_boxes near = {0};
    STP_TRY(stp_alloc(&g->touched, a->leaf_count, sizeof *g->touched, "chunks", err));
    STP_TRY(stp_alloc(&g->around, a->leaf_count, sizeof *g->around, "chunks", err));
    STP_TRY(stp_chunk_boxes_create(&near, a->leaf_count, err));
    for (uint32_t i = 0; i < a->leaf_count; i++) {
        if (!a->touched[i])
            continue;
        const stp_dbox box = box_of(g, i);
        near.boxes[i] = stp_dbox_grown(&box, stp_dbox_side(&box) / REACH_PARTS);
        g->touched[g->touched_count++] = (taken){.leaf = i, .begin = (uint32_t)*count, .joins = i};
        *count += stp_append_leaf(a, i)->sample_count[0];
    }
    stp_chunk_boxes_join(&near);
    for (uint32_t i = 0; i < a->leaf_count; i++) {
        const stp_dbox box = stp_chunk_entry_box(stp_append_leaf(a, i));
        if (a->touched[i] || stp_chunk_boxes_next(&near, &box, 0) == STP_CHUNK_NONE)
            continue;
        g->around[g->around_count++] =
            (taken){.leaf = i, .begin = (uint32_t)*count, .joins = STP_LEAF_CONTEXT};
        *count += stp_append_leaf(a, i)->sample_count[0];
    }
done:
    stp_chunk_boxes_clear(&near);
    return status;
}

static stp_status box_new_points(gatherer *g, stp_error *err)
{
    const stp_cloud *cloud = &g->a->job.cloud;
    stp_status status = stp_chunk_boxes_create(&g->new_boxes, g->a->leaf_count, err);
    for (uint32_t i = 0; status == STP_OK && i < cloud->count;
         i++, stp_cloud_step(cloud->spill, i)) {
        const uint32_t leaf = g->a->leaf_of[cloud->points[i].source];
        if (leaf != STP_LEAF_FREE)
            stp_dbox_add(&g->new_boxes.boxes[leaf], cloud->points[i].position);
    }
    return status;
}

static stp_status place_regions(gatherer *g, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_chunk_boxes_create(&g->regions, g->touched_count > 0 ? g->touched_count : 1, err));
    for (uint32_t i = 0; i < g->touched_count; i++) {
        const taken *t = &g->touched[i];
        const stp_dbox box = box_of(g, t->leaf);
        const double spacing = t->radii / (g->a->job.tree.lambda * (double)t->count);
        g->regions.boxes[i] =
            stp_dbox_grown(&box, fmin(REACH_SPACINGS * spacing, stp_dbox_side(&box) / REACH_PARTS));
    }
    stp_chunk_boxes_join(&g->regions);
done:
    return status;
}

/* ---- the cloud ---- */

/* Moves the new points into the cloud of all, and frees the one that they were read into. */
static void move_new(gatherer *g)
{
    stp_append *a = g->a;
    stp_cloud *from = &a->job.cloud;
    memcpy(g->cloud->points, from->points, (size_t)from->count * sizeof *from->points);
    g->first = (uint32_t)from->count;
    g->cloud->count = from->count;
    stp_cloud_clear(from);
    stp_spill_destroy(&a->read_spill);
}

/* Closes the gaps between the points of leaves, and gives the points their sources. */
static void close_gaps(gatherer *g)
{
    stp_append *a = g->a;
    uint32_t at = 0;
    for (uint32_t i = 0; i < g->touched_count + g->around_count; i++) {
        const taken *t = i < g->touched_count ? &g->touched[i] : &g->around[i - g->touched_count];
        for (uint32_t j = 0; j < t->count; j++, at++) {
            stp_cloud_point *to = &g->cloud->points[g->first + at];
            *to = g->cloud->points[g->first + t->begin + j];
            to->source = a->read_count + at;
            a->old[at] = a->old[t->begin + j];
            a->leaf_of[to->source] = t->joins;
        }
    }
    g->cloud->count = g->first + at;
}

/* Makes room for all points, in a spill of their own. */
static stp_status make_room(gatherer *g, stp_cloud *cloud, uint64_t old_count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_append *a = g->a;
    stp_prep_job *job = &a->job;
    const uint64_t all = a->read_count + old_count;
    const stp_prep_size size = {.points = all};
    uint32_t *leaf_of = NULL;
    if (all >= UINT32_MAX - 1)
        return stp_error_set(err, STP_LIMIT,
                             "%s: more than %u points are new or near new ones: append them in "
                             "several runs",
                             job->path, UINT32_MAX - 1);
    a->read_spill = job->spill;
    job->spill = NULL;
    STP_TRY(stp_prep_plan_room(job, &size, err));
    STP_TRY(stp_cloud_create(cloud, 0, job->cloud.count + old_count, job->spill, err));
    STP_TRY(stp_spill_alloc(job->spill, &a->old, (size_t)old_count, sizeof *a->old, "points", err));
    STP_TRY(stp_spill_alloc(job->spill, &leaf_of, (size_t)all, sizeof *leaf_of, "points", err));
    memcpy(leaf_of, a->leaf_of, a->read_count * sizeof *leaf_of);
    stp_spill_free(a->read_spill, a->leaf_of);
    a->leaf_of = leaf_of;
done:
    return status;
}

stp_status stp_append_gather(stp_append *a, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud cloud = {0};
    gatherer g = {.a = a, .cloud = &cloud};
    uint64_t old_count = 0;
    STP_TRY(box_new_points(&g, err));
    STP_TRY(list_leaves(&g, &old_count, err));
    STP_TRY(make_room(&g, &cloud, old_count, err));
    move_new(&g);
    STP_TRY(stp_cloud_run(&cloud, a->job.pool, g.touched_count, read_touched, &g, err));
    STP_TRY(place_regions(&g, err));
    STP_TRY(stp_cloud_run(&cloud, a->job.pool, g.around_count, read_around, &g, err));
    close_gaps(&g);
    a->job.cloud = cloud;
    cloud = (stp_cloud){0};
done:
    stp_cloud_clear(&cloud);
    stp_chunk_boxes_clear(&g.regions);
    stp_chunk_boxes_clear(&g.new_boxes);
    free(g.touched);
    free(g.around);
    return status;
}

/* The cells of a cloud in Morton order. */
#include "preprocess/cloud.h"

#include "base/memory.h"
#include "preprocess/morton.h"

#include <stdlib.h>

typedef struct cutter {
    stp_cloud *cloud;
    const stp_morton_key *keys;
    size_t capacity;
} cutter;

static stp_status add_cell(cutter *c, uint32_t begin, uint32_t end, stp_error *err)
{
    stp_cloud *cloud = c->cloud;
    stp_status status = stp_grow(&cloud->cells, &c->capacity, (size_t)cloud->cell_count + 1,
                                 sizeof *cloud->cells, "cells", err);
    if (status != STP_OK)
        return status;
    cloud->cells[cloud->cell_count++] = (stp_cell){.begin = begin, .end = end};
    return STP_OK;
}

/* First index in [begin, end) whose octant at this depth is at least `octant`. */
static uint32_t octant_begin(const cutter *c, uint32_t begin, uint32_t end, unsigned shift,
                             uint64_t octant)
{
    while (begin < end) {
        uint32_t middle = begin + (end - begin) / 2;
        if ((c->keys[middle].code >> shift & 7) < octant)
            begin = middle + 1;
        else
            end = middle;
    }
    return begin;
}

/* Cuts an octree node into its octants; octants that fit together stay one cell. */
static stp_status cut(cutter *c, uint32_t begin, uint32_t end, int depth, stp_error *err)
{
    stp_status status = STP_OK;
    if (end - begin <= STP_CELL_POINTS)
        return end > begin ? add_cell(c, begin, end, err) : STP_OK;
    if (depth == STP_MORTON_BITS) { /* a pile of points closer than the grid */
        for (uint32_t at = begin; at < end && status == STP_OK; at += STP_CELL_POINTS)
            status = add_cell(c, at, end - at < STP_CELL_POINTS ? end : at + STP_CELL_POINTS, err);
        return status;
    }
    unsigned shift = (unsigned)(3 * (STP_MORTON_BITS - 1 - depth));
    uint32_t open = begin; /* start of the cell being gathered */
    uint32_t from = begin;
    for (uint64_t octant = 1; octant <= 8 && status == STP_OK; octant++) {
        uint32_t to = octant == 8 ? end : octant_begin(c, from, end, shift, octant);
        if (to - from > STP_CELL_POINTS || to - open > STP_CELL_POINTS) {
            if (from > open)
                status = add_cell(c, open, from, err);
            open = from;
            if (status == STP_OK && to - from > STP_CELL_POINTS) {
                status = cut(c, from, to, depth + 1, err);
                open = to;
            }
        }
        from = to;
    }
    if (status == STP_OK && end > open)
        status = add_cell(c, open, end, err);
    return status;
}

static stp_status find_cell_box(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_cloud *cloud = context;
    stp_cell *cell = &cloud->cells[index];
    (void)worker;
    (void)err;
    cell->box = stp_dbox_empty();
    for (uint32_t i = cell->begin; i < cell->end; i++)
        stp_dbox_add(&cell->box, cloud->points[i].position);
    return STP_OK;
}

stp_status stp_cloud_sort(stp_cloud *cloud, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    stp_morton_key *keys = NULL;
    stp_cloud_point *sorted = NULL;
    STP_TRY(stp_alloc(&keys, cloud->count, sizeof *keys, "sort keys", err));
    STP_TRY(stp_alloc(&sorted, cloud->count, sizeof *sorted, "points", err));
    STP_TRY(stp_morton_sort(cloud->points, cloud->count, sorted, keys, &cloud->box, pool, err));
    free(cloud->points);
    cloud->points = sorted;
    cloud->capacity = cloud->count;
    sorted = NULL;
    cutter c = {.cloud = cloud, .keys = keys};
    STP_TRY(cut(&c, 0, cloud->count, 0, err));
    STP_TRY(stp_pool_run(pool, cloud->cell_count, find_cell_box, cloud, err));
done:
    free(sorted);
    free(keys);
    return status;
}

void stp_cloud_clear(stp_cloud *cloud)
{
    free(cloud->points);
    free(cloud->cells);
    *cloud = (stp_cloud){0};
}

/* The cells of a cloud in Morton order. */
#include "preprocess/cloud/cloud_cells.h"

#include "base/memory.h"
#include "preprocess/cloud/box_tree.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/cloud/morton.h"

#include <stdlib.h>

typedef struct cutter {
    stp_cloud *cloud;
    size_t capacity;
    bool thinned; /* points are missing, so that piles are not in the order of their own grids */
    stp_rank_part own; /* points whose cells are cut here */
} cutter;

/* An octree node over a grid: points whose codes are equal down to this depth. */
typedef struct octant {
    uint64_t begin, end;
    int depth;
} octant;

/* Adds a cell, unless another rank has its first point. */
static stp_status add_cell(cutter *c, uint64_t begin, uint64_t end, stp_error *err)
{
    stp_cloud *cloud = c->cloud;
    if (begin < c->own.begin || begin >= c->own.end)
        return STP_OK;
    stp_status status = stp_grow(&cloud->cells, &c->capacity, (size_t)cloud->cell_count + 1,
                                 sizeof *cloud->cells, "cells", err);
    if (status != STP_OK)
        return status;
    cloud->cells[cloud->cell_count++] = (stp_cell){.begin = begin, .end = end};
    return STP_OK;
}

/* First index in [begin, end) whose octant at this depth is at least `wanted`. */
static uint64_t octant_begin(const cutter *c, const stp_morton_grid *grid, int depth,
                             uint64_t begin, uint64_t end, uint64_t wanted)
{
    unsigned shift = (unsigned)(3 * (STP_MORTON_BITS - 1 - depth));
    stp_spill_relieve(c->cloud->spill); /* few points are read, but each lies on its own page */
    while (begin < end) {
        uint64_t middle = begin + (end - begin) / 2;
        uint64_t code = stp_morton_code(grid, c->cloud->points[middle].position);
        if ((code >> shift & 7) < wanted)
            begin = middle + 1;
        else
            end = middle;
    }
    return begin;
}

/* Finds where a node's octants end. Ranks that share it count each its own points. */
static stp_status find_octants(const cutter *c, const stp_morton_grid *grid, octant node,
                               uint64_t ends[8], stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t counts[8];
    const uint64_t begin = node.begin > c->own.begin ? node.begin : c->own.begin;
    const uint64_t end = node.end < c->own.end ? node.end : c->own.end;
    uint64_t from = begin;
    for (uint64_t next = 1; next <= 8; next++) {
        if (begin < end)
            from = next == 8 ? end : octant_begin(c, grid, node.depth, from, end, next);
        counts[next - 1] = begin < end ? from - begin : 0;
    }
    if (begin != node.begin || end != node.end)
        STP_TRY(stp_cloud_sum(c->cloud, counts, 8, err));
    for (int i = 0; i < 8; i++)
        ends[i] = node.begin + counts[i];
done:
    return status;
}

/* Whether one rank, another one, has all of a node's points. */
static bool is_elsewhere(const cutter *c, octant node)
{
    const stp_cloud_blocks *b = c->cloud->blocks;
    for (unsigned rank = 0; b && rank < b->ranks->count; rank++)
        if (node.begin >= b->begins[rank] && node.end <= b->begins[rank + 1])
            return rank != b->ranks->self;
    return false;
}

static stp_status cut(cutter *c, const stp_morton_grid *grid, octant node, stp_error *err);

/* Cuts a pile, points closer than the grid, by the pile's own grid, as it is sorted. */
static stp_status cut_pile(cutter *c, octant node, stp_error *err)
{
    stp_status status = STP_OK;
    stp_dbox box = stp_points_box(c->cloud->points + node.begin, node.end - node.begin);
    stp_morton_grid grid = stp_morton_grid_of(&box);
    if (grid.scale > 0.0 && !c->thinned)
        return cut(c, &grid, (octant){node.begin, node.end, 0}, err);
    for (uint64_t at = node.begin; at < node.end && status == STP_OK; at += STP_CELL_POINTS)
        status =
            add_cell(c, at, node.end - at < STP_CELL_POINTS ? node.end : at + STP_CELL_POINTS, err);
    return status;
}

/* Cuts a node into its octants. Consecutive octants that fit into one cell stay together. */
static stp_status cut(cutter *c, const stp_morton_grid *grid, octant node, stp_error *err)
{
    stp_status status = STP_OK;
    if (is_elsewhere(c, node))
        return STP_OK;
    if (node.end - node.begin <= STP_CELL_POINTS)
        return node.end > node.begin ? add_cell(c, node.begin, node.end, err) : STP_OK;
    if (node.depth == STP_MORTON_BITS)
        return cut_pile(c, node, err);
    uint64_t open = node.begin; /* start of the cell being gathered */
    uint64_t from = node.begin, ends[8];
    status = find_octants(c, grid, node, ends, err);
    for (int next = 0; next < 8 && status == STP_OK; next++) {
        uint64_t to = ends[next];
        if (to - from > STP_CELL_POINTS || to - open > STP_CELL_POINTS) {
            if (from > open)
                status = add_cell(c, open, from, err);
            open = from;
            if (status == STP_OK && to - from > STP_CELL_POINTS) {
                status = cut(c, grid, (octant){from, to, node.depth + 1}, err);
                open = to;
            }
        }
        from = to;
    }
    if (status == STP_OK && node.end > open)
        status = add_cell(c, open, node.end, err);
    return status;
}

static stp_status find_cell_box(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_cloud *cloud = context;
    stp_cell *cell = &cloud->cells[index];
    (void)worker;
    (void)err;
    cell->box = stp_points_box(cloud->points + cell->begin, cell->end - cell->begin);
    return STP_OK;
}

stp_status stp_cloud_create(stp_cloud *out, uint64_t first, uint64_t capacity, stp_spill *spill,
                            stp_error *err)
{
    stp_cloud cloud = {.first = first,
                       .first_record = first,
                       .count = capacity,
                       .capacity = capacity,
                       .spill = spill};
    stp_status status = stp_cloud_array(&cloud, &cloud.points, sizeof *cloud.points, "points", err);
    cloud.count = 0;
    if (status == STP_OK)
        *out = cloud;
    return status;
}

stp_status stp_cloud_sort(stp_cloud *cloud, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud_point *points = stp_cloud_begin(cloud);
    STP_TRY(stp_morton_box(&cloud->box, points, cloud->count, cloud->spill, pool, err));
    STP_TRY(stp_morton_sort(points, cloud->count, cloud->spill, &cloud->box, pool, err));
    STP_TRY(stp_cloud_arrange(cloud, pool, err));
done:
    return status;
}

/* Lets each rank own the points of the cells that begin in its run. */
static stp_status own_cells(stp_cloud *cloud, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = cloud->blocks->ranks;
    uint64_t *begins = NULL;
    const uint64_t end = cloud->first + cloud->count;
    STP_TRY(stp_alloc(&begins, (size_t)ranks->count + 1, sizeof *begins, "ranks", err));
    begins[ranks->count] = end;
    for (unsigned rank = 0; rank < ranks->count; rank++) {
        const uint64_t first = stp_cloud_cells(cloud, ranks, rank).begin;
        begins[rank] = first < cloud->cell_count ? cloud->cells[first].begin : end;
    }
    for (uint64_t i = begins[ranks->self]; i < begins[ranks->self + 1]; i++)
        (void)stp_cloud_has(cloud, i);
    STP_TRY(stp_cloud_fetch(cloud, err));
    stp_cloud_move_runs(cloud, begins);
done:
    free(begins);
    return status;
}

/* Gives the boxes of each rank's cells to all. */
static stp_status share_boxes(stp_cloud *cloud, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = cloud->blocks->ranks;
    for (unsigned rank = 0; rank < ranks->count; rank++) {
        const stp_rank_part part = stp_cloud_cells(cloud, ranks, rank);
        STP_TRY(stp_ranks_broadcast(ranks, rank, cloud->cells + part.begin,
                                    (part.end - part.begin) * sizeof *cloud->cells, err));
    }
done:
    return status;
}

stp_status stp_cloud_settle_cells(stp_cloud *cloud, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    if (cloud->blocks)
        STP_TRY(own_cells(cloud, err));
    STP_TRY(stp_cloud_run_own(cloud, pool, find_cell_box, cloud, err));
    if (cloud->blocks)
        STP_TRY(share_boxes(cloud, err));
done:
    return status;
}

stp_status stp_cloud_arrange(stp_cloud *cloud, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    cutter c = {.cloud = cloud, .own = stp_cloud_own(cloud)};
    stp_morton_grid grid = stp_morton_grid_of(&cloud->box);
    STP_TRY(cut(&c, &grid, (octant){cloud->first, cloud->first + cloud->count, 0}, err));
    STP_TRY(stp_cloud_join_cells(cloud, &cloud->cells, &cloud->cell_count, err));
    STP_TRY(stp_cloud_settle_cells(cloud, pool, err));
    STP_TRY(stp_box_tree_create(&cloud->tree, cloud, pool, err));
    STP_TRY(stp_cloud_array(cloud, &cloud->sheets, sizeof *cloud->sheets, "sheets", err));
    STP_TRY(stp_cloud_array(cloud, &cloud->marks, sizeof *cloud->marks, "marks", err));
done:
    return status;
}

stp_status stp_cloud_cut(stp_cloud *cloud, uint64_t begin, uint64_t end, stp_error *err)
{
    cutter c = {
        .cloud = cloud, .capacity = cloud->cell_count, .thinned = true, .own = {begin, end}};
    const uint32_t first = cloud->cell_count;
    const stp_morton_grid grid = stp_morton_grid_of(&cloud->box);
    stp_status status = cut(&c, &grid, (octant){begin, end, 0}, err);
    for (uint32_t i = first; status == STP_OK && i < cloud->cell_count; i++)
        cloud->cells[i].box = stp_points_box(cloud->points + cloud->cells[i].begin,
                                             cloud->cells[i].end - cloud->cells[i].begin);
    return status;
}

void stp_cloud_forget(stp_cloud *cloud, const stp_cell *cell)
{
    const size_t count = cell->end - cell->begin;
    stp_spill_forget(cloud->spill, cloud->points + cell->begin, count * sizeof *cloud->points);
    stp_spill_forget(cloud->spill, cloud->sheets + cell->begin, count * sizeof *cloud->sheets);
    stp_spill_forget(cloud->spill, cloud->marks + cell->begin, count * sizeof *cloud->marks);
}

void stp_cloud_unsort(stp_cloud *cloud)
{
    stp_box_tree_clear(&cloud->tree, cloud->spill);
    stp_spill_free(cloud->spill, cloud->sheets);
    stp_spill_free(cloud->spill, cloud->marks);
    free(cloud->cells);
    cloud->sheets = NULL;
    cloud->marks = NULL;
    cloud->cells = NULL;
    cloud->cell_count = 0;
}

void stp_cloud_clear(stp_cloud *cloud)
{
    stp_cloud_unsort(cloud);
    stp_cloud_blocks_destroy(cloud->blocks);
    stp_spill_free(cloud->spill, cloud->points);
    stp_spill_free(cloud->spill, cloud->pixels);
    *cloud = (stp_cloud){0};
}

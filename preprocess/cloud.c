/* Morton order and cells. */
#include "preprocess/cloud.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

#define MORTON_BITS 21

typedef struct morton_key {
    uint64_t code;
    uint32_t index;
} morton_key;

/* Spreads 21 bits so that two zeros stand between each pair. */
static uint64_t spread(uint64_t v)
{
    v &= 0x1fffff;
    v = (v | v << 32) & 0x1f00000000ffff;
    v = (v | v << 16) & 0x1f0000ff0000ff;
    v = (v | v << 8) & 0x100f00f00f00f00f;
    v = (v | v << 4) & 0x10c30c30c30c30c3;
    return (v | v << 2) & 0x1249249249249249;
}

static uint64_t grid_coordinate(double value, double origin, double scale)
{
    double cell = (value - origin) * scale;
    double last = (double)((1 << MORTON_BITS) - 1);
    return (uint64_t)(cell < 0.0 ? 0.0 : cell > last ? last : cell);
}

/* Least significant digit radix sort by code, stable, 11 bits a pass. */
static void radix_sort(morton_key *keys, morton_key *scratch, uint32_t count)
{
    for (unsigned shift = 0; shift < 3 * MORTON_BITS; shift += 11) {
        size_t histogram[2048] = {0};
        for (uint32_t i = 0; i < count; i++)
            histogram[keys[i].code >> shift & 2047]++;
        size_t sum = 0;
        for (size_t digit = 0; digit < 2048; digit++) {
            size_t here = histogram[digit];
            histogram[digit] = sum;
            sum += here;
        }
        for (uint32_t i = 0; i < count; i++)
            scratch[histogram[keys[i].code >> shift & 2047]++] = keys[i];
        memcpy(keys, scratch, (size_t)count * sizeof *keys);
    }
}

static int compare_points(const void *a, const void *b)
{
    const stp_cloud_point *p = a;
    const stp_cloud_point *q = b;
    if (p->position.x != q->position.x)
        return p->position.x < q->position.x ? -1 : 1;
    if (p->position.y != q->position.y)
        return p->position.y < q->position.y ? -1 : 1;
    if (p->position.z != q->position.z)
        return p->position.z < q->position.z ? -1 : 1;
    return p->source < q->source ? -1 : p->source > q->source;
}

/* Points with equal codes in an order that does not depend on the input's. */
static void sort_ties(stp_cloud_point *points, const morton_key *keys, uint32_t count)
{
    for (uint32_t begin = 0; begin < count;) {
        uint32_t end = begin + 1;
        while (end < count && keys[end].code == keys[begin].code)
            end++;
        if (end - begin > 1)
            qsort(points + begin, end - begin, sizeof *points, compare_points);
        begin = end;
    }
}

typedef struct cutter {
    stp_cloud *cloud;
    const morton_key *keys;
    size_t capacity;
} cutter;

static stp_status add_cell(cutter *c, uint32_t begin, uint32_t end, stp_error *err)
{
    stp_cloud *cloud = c->cloud;
    stp_status status = stp_grow(&cloud->cells, &c->capacity, (size_t)cloud->cell_count + 1,
                                 sizeof *cloud->cells, "cells", err);
    if (status != STP_OK)
        return status;
    stp_cell *cell = &cloud->cells[cloud->cell_count++];
    *cell = (stp_cell){.begin = begin, .end = end, .box = stp_dbox_empty()};
    for (uint32_t i = begin; i < end; i++)
        stp_dbox_add(&cell->box, cloud->points[i].position);
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
    if (depth == MORTON_BITS) { /* a pile of points closer than the grid */
        for (uint32_t at = begin; at < end && status == STP_OK; at += STP_CELL_POINTS)
            status = add_cell(c, at, end - at < STP_CELL_POINTS ? end : at + STP_CELL_POINTS, err);
        return status;
    }
    unsigned shift = (unsigned)(3 * (MORTON_BITS - 1 - depth));
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

static void fill_keys(const stp_cloud *cloud, morton_key *keys)
{
    stp_dvec3 low = cloud->box.min;
    stp_dvec3 size = stp_dvec3_sub(cloud->box.max, low);
    double side = fmax(size.x, fmax(size.y, size.z));
    double scale = side > 0.0 ? (double)(1 << MORTON_BITS) / side : 0.0;
    for (uint32_t i = 0; i < cloud->count; i++) {
        stp_dvec3 p = cloud->points[i].position;
        keys[i].code = spread(grid_coordinate(p.x, low.x, scale)) |
                       spread(grid_coordinate(p.y, low.y, scale)) << 1 |
                       spread(grid_coordinate(p.z, low.z, scale)) << 2;
        keys[i].index = i;
    }
}

stp_status stp_cloud_sort(stp_cloud *cloud, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    morton_key *keys = NULL;
    morton_key *scratch = NULL;
    stp_cloud_point *sorted = NULL;
    (void)pool;
    STP_TRY(stp_alloc(&keys, cloud->count, sizeof *keys, "sort keys", err));
    STP_TRY(stp_alloc(&scratch, cloud->count, sizeof *scratch, "sort keys", err));
    STP_TRY(stp_alloc(&sorted, cloud->count, sizeof *sorted, "points", err));
    cloud->box = stp_dbox_empty();
    for (uint32_t i = 0; i < cloud->count; i++)
        stp_dbox_add(&cloud->box, cloud->points[i].position);
    fill_keys(cloud, keys);
    radix_sort(keys, scratch, cloud->count);
    for (uint32_t i = 0; i < cloud->count; i++)
        sorted[i] = cloud->points[keys[i].index];
    sort_ties(sorted, keys, cloud->count);
    free(cloud->points);
    cloud->points = sorted;
    cloud->capacity = cloud->count;
    sorted = NULL;
    cutter c = {.cloud = cloud, .keys = keys};
    STP_TRY(cut(&c, 0, cloud->count, 0, err));
done:
    free(sorted);
    free(scratch);
    free(keys);
    return status;
}

void stp_cloud_clear(stp_cloud *cloud)
{
    free(cloud->points);
    free(cloud->cells);
    *cloud = (stp_cloud){0};
}

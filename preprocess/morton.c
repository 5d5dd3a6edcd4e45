/* Points along the Morton curve of their bounding cube. */
#include "preprocess/morton.h"

#include "base/memory.h"
#include "base/prefix_sum.h"

#include <stdlib.h>
#include <string.h>

#define BLOCK 65536u
/* The first digit: 16 cells an axis. */
#define BUCKET_SHIFT 51
#define BUCKET_COUNT 4096u
/* Digits of what is left. */
#define DIGIT_BITS 11
#define DIGIT_COUNT 2048u
/* Buckets that a comparison sort is faster for. */
#define SMALL_BUCKET 256u

typedef struct sorter {
    const stp_cloud_point *points;
    uint32_t count;
    uint32_t block_count;
    stp_dvec3 low;
    double scale;
    stp_dbox *boxes;                      /* of each block */
    uint32_t (*histograms)[BUCKET_COUNT]; /* of each block, then where its keys go */
    uint32_t *bucket_begin;               /* BUCKET_COUNT + 1 */
    stp_morton_key *unsorted;
    stp_morton_key *keys;
    stp_cloud_point *sorted;
} sorter;

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
    double last = (double)((1 << STP_MORTON_BITS) - 1);
    return (uint64_t)(cell > 0.0 ? stp_min(cell, last) : 0.0); /* not NaN, of an endless box */
}

static uint32_t block_end(const sorter *s, uint32_t begin)
{
    return s->count - begin < BLOCK ? s->count : begin + BLOCK;
}

static stp_status find_box(void *context, size_t block, unsigned worker, stp_error *err)
{
    sorter *s = context;
    uint32_t begin = (uint32_t)block * BLOCK;
    (void)worker;
    (void)err;
    s->boxes[block] = stp_dbox_empty();
    for (uint32_t i = begin; i < block_end(s, begin); i++)
        stp_dbox_add(&s->boxes[block], s->points[i].position);
    return STP_OK;
}

static stp_status fill_keys(void *context, size_t block, unsigned worker, stp_error *err)
{
    sorter *s = context;
    uint32_t begin = (uint32_t)block * BLOCK;
    uint32_t *histogram = s->histograms[block];
    (void)worker;
    (void)err;
    for (uint32_t i = begin; i < block_end(s, begin); i++) {
        stp_dvec3 p = s->points[i].position;
        uint64_t code = spread(grid_coordinate(p.x, s->low.x, s->scale)) |
                        spread(grid_coordinate(p.y, s->low.y, s->scale)) << 1 |
                        spread(grid_coordinate(p.z, s->low.z, s->scale)) << 2;
        s->unsorted[i] = (stp_morton_key){code, i};
        histogram[code >> BUCKET_SHIFT]++;
    }
    return STP_OK;
}

/* Turns counts into places: bucket by bucket, in each block by block. */
static void place_buckets(sorter *s)
{
    uint32_t sum = 0;
    for (uint32_t bucket = 0; bucket < BUCKET_COUNT; bucket++) {
        s->bucket_begin[bucket] = sum;
        for (uint32_t block = 0; block < s->block_count; block++) {
            uint32_t here = s->histograms[block][bucket];
            s->histograms[block][bucket] = sum;
            sum += here;
        }
    }
    s->bucket_begin[BUCKET_COUNT] = sum;
}

static stp_status scatter_keys(void *context, size_t block, unsigned worker, stp_error *err)
{
    sorter *s = context;
    uint32_t begin = (uint32_t)block * BLOCK;
    uint32_t *place = s->histograms[block];
    (void)worker;
    (void)err;
    for (uint32_t i = begin; i < block_end(s, begin); i++)
        s->keys[place[s->unsorted[i].code >> BUCKET_SHIFT]++] = s->unsorted[i];
    return STP_OK;
}

static int compare_keys(const void *a, const void *b)
{
    const stp_morton_key *p = a;
    const stp_morton_key *q = b;
    return p->code < q->code ? -1 : p->code > q->code;
}

/* Least significant digit first, stable. */
static void radix_sort(stp_morton_key *keys, stp_morton_key *scratch, uint32_t count)
{
    for (unsigned shift = 0; shift < BUCKET_SHIFT; shift += DIGIT_BITS) {
        size_t place[DIGIT_COUNT] = {0};
        for (uint32_t i = 0; i < count; i++)
            place[keys[i].code >> shift & (DIGIT_COUNT - 1)]++;
        (void)stp_prefix_sum(place, DIGIT_COUNT);
        for (uint32_t i = 0; i < count; i++)
            scratch[place[keys[i].code >> shift & (DIGIT_COUNT - 1)]++] = keys[i];
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
static void sort_ties(stp_cloud_point *points, const stp_morton_key *keys, uint32_t count)
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

static stp_status sort_bucket(void *context, size_t bucket, unsigned worker, stp_error *err)
{
    sorter *s = context;
    uint32_t begin = s->bucket_begin[bucket];
    uint32_t count = s->bucket_begin[bucket + 1] - begin;
    stp_morton_key *keys = s->keys + begin;
    stp_cloud_point *sorted = s->sorted + begin;
    (void)worker;
    (void)err;
    if (count > SMALL_BUCKET)
        radix_sort(keys, s->unsorted + begin, count);
    else if (count > 0)
        qsort(keys, count, sizeof *keys, compare_keys);
    for (uint32_t i = 0; i < count; i++)
        sorted[i] = s->points[keys[i].index];
    sort_ties(sorted, keys, count);
    return STP_OK;
}

static void set_grid(sorter *s, stp_dbox *box)
{
    *box = stp_dbox_empty();
    for (uint32_t block = 0; block < s->block_count; block++) {
        stp_dbox_add(box, s->boxes[block].min);
        stp_dbox_add(box, s->boxes[block].max);
    }
    stp_dvec3 size = stp_dvec3_sub(box->max, box->min);
    double side = fmax(size.x, fmax(size.y, size.z));
    s->low = box->min;
    s->scale = side > 0.0 ? (double)(1 << STP_MORTON_BITS) / side : 0.0;
}

stp_status stp_morton_sort(const stp_cloud_point *points, uint32_t count, stp_cloud_point *sorted,
                           stp_morton_key *keys, stp_dbox *box, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    sorter s = {.points = points,
                .count = count,
                .block_count = (uint32_t)(((uint64_t)count + BLOCK - 1) / BLOCK),
                .keys = keys,
                .sorted = sorted};
    STP_TRY(stp_alloc(&s.unsorted, count, sizeof *s.unsorted, "sort keys", err));
    STP_TRY(stp_alloc(&s.boxes, s.block_count, sizeof *s.boxes, "sort keys", err));
    STP_TRY(stp_alloc(&s.histograms, s.block_count, sizeof *s.histograms, "sort keys", err));
    STP_TRY(stp_alloc(&s.bucket_begin, BUCKET_COUNT + 1, sizeof *s.bucket_begin, "sort keys", err));
    STP_TRY(stp_pool_run(pool, s.block_count, find_box, &s, err));
    set_grid(&s, box);
    STP_TRY(stp_pool_run(pool, s.block_count, fill_keys, &s, err));
    place_buckets(&s);
    STP_TRY(stp_pool_run(pool, s.block_count, scatter_keys, &s, err));
    STP_TRY(stp_pool_run(pool, BUCKET_COUNT, sort_bucket, &s, err));
done:
    free(s.bucket_begin);
    free(s.histograms);
    free(s.boxes);
    free(s.unsorted);
    return status;
}

/* A sample sort: samples of all ranks say which run of the curve each rank sorts. */
#include "preprocess/cloud/cloud_parts.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/cloud/morton.h"

#include <stdlib.h>
#include <string.h>

/* Samples of each rank: runs are then as long as each other, within some percent. */
#define SAMPLES 2048u
/* Points of all ranks in one round of the exchange, and of one rank at most: a rank has one block
 * of points beside its run, and no round gives a rank more than MPI counts. */
#define ROUND_POINTS (1u << 20)
#define BLOCK_POINTS 65536u

typedef struct parts {
    stp_cloud *cloud;
    const stp_cloud_point *own; /* the part that this rank has */
    stp_ranks *ranks;
    stp_morton_grid grid;
    uint64_t *splitters;    /* by rank: the code where its run begins; the first one is 0 */
    uint64_t *counts;       /* by rank: points of its run */
    stp_cloud_point *run;   /* this rank's, among all */
    stp_cloud_point *block; /* points of a round, by rank that they go to */
    uint64_t *block_counts;
    size_t *sent, *received; /* bytes of a round, by rank */
} parts;

static int compare_codes(const void *a, const void *b)
{
    const uint64_t p = *(const uint64_t *)a, q = *(const uint64_t *)b;
    return (p > q) - (p < q);
}

static uint64_t code_of(const parts *p, uint64_t i)
{
    return stp_morton_code(&p->grid, p->own[i].position);
}

/* The rank whose run has the point. Equal codes are in one run. */
static unsigned rank_of(const parts *p, uint64_t i)
{
    const uint64_t code = code_of(p, i);
    unsigned low = 0, high = p->ranks->count - 1;
    while (low < high) {
        const unsigned middle = low + (high - low + 1) / 2;
        if (p->splitters[middle] <= code)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

/* Finds the box of the points of all ranks, and how many there are. */
static stp_status join_boxes(parts *p, uint64_t *total, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud *cloud = p->cloud;
    struct {
        stp_dbox box;
        uint64_t count;
    } own = {.count = cloud->count}, other;
    STP_TRY(stp_morton_box(&own.box, p->own, cloud->count, cloud->spill, pool, err));
    cloud->box = stp_dbox_empty();
    for (unsigned rank = 0; rank < p->ranks->count; rank++) {
        other = own;
        STP_TRY(stp_ranks_broadcast(p->ranks, rank, &other, sizeof other, err));
        stp_dbox_join(&cloud->box, &other.box);
        *total += other.count;
    }
    p->grid = stp_morton_grid_of(&cloud->box);
done:
    return status;
}

/* Chooses where runs begin. Each rank has samples in proportion to its points. */
static stp_status choose_splitters(parts *p, uint64_t total, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = p->ranks;
    const uint64_t stride = total / ((uint64_t)SAMPLES * ranks->count) + 1;
    stp_bytes all = {0};
    for (uint64_t i = 0; i < p->cloud->count; i += stride) {
        const uint64_t code = code_of(p, i);
        stp_cloud_stride(p->cloud->spill, i, stride);
        STP_TRY(stp_bytes_append(&all, &code, sizeof code, err));
    }
    STP_TRY(stp_ranks_join(ranks, &all, err));
    uint64_t *codes = NULL;
    const size_t count = all.size / sizeof *codes;
    STP_TRY(stp_alloc(&codes, count, sizeof *codes, "sort keys", err));
    if (count > 0) {
        memcpy(codes, all.data, all.size);
        qsort(codes, count, sizeof *codes, compare_codes);
    }
    for (unsigned rank = 1; rank < ranks->count && count > 0; rank++)
        p->splitters[rank] = codes[count * rank / ranks->count];
    free(codes);
done:
    free(all.data);
    return status;
}

/* Counts the points of all runs. */
static stp_status count_runs(parts *p, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t *other = NULL;
    const unsigned count = p->ranks->count;
    uint64_t moved = 0;
    STP_TRY(stp_alloc(&other, count, sizeof *other, "ranks", err));
    for (uint64_t i = 0; i < p->cloud->count; i++, stp_cloud_step(p->cloud->spill, i))
        p->block_counts[rank_of(p, i)]++;
    for (unsigned rank = 0; rank < count; rank++) {
        memcpy(other, p->block_counts, count * sizeof *other);
        STP_TRY(stp_ranks_broadcast(p->ranks, rank, other, count * sizeof *other, err));
        for (unsigned to = 0; to < count; to++) {
            p->counts[to] += other[to];
            moved += to != rank ? other[to] : 0;
        }
    }
    p->ranks->sent_bytes += moved * sizeof *p->run;
done:
    free(other);
    return status;
}

/* Puts points [begin, end) into the block, by rank. */
static void fill_block(parts *p, uint64_t begin, uint64_t end)
{
    const unsigned count = p->ranks->count;
    memset(p->block_counts, 0, count * sizeof *p->block_counts);
    for (uint64_t i = begin; i < end; i++)
        p->block_counts[rank_of(p, i)]++;
    uint64_t sum = 0;
    for (unsigned rank = 0; rank < count; rank++) {
        const uint64_t here = p->block_counts[rank];
        p->sent[rank] = here * sizeof *p->block;
        p->block_counts[rank] = sum;
        sum += here;
    }
    for (uint64_t i = begin; i < end; i++)
        p->block[p->block_counts[rank_of(p, i)]++] = p->own[i];
}

/* Moves all points to the ranks whose runs have them, a block of each rank a round. */
static stp_status exchange(parts *p, uint64_t most, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = p->ranks;
    const uint32_t share = ROUND_POINTS / ranks->count + 1;
    const uint32_t block = share < BLOCK_POINTS ? share : BLOCK_POINTS;
    size_t at = 0;
    STP_TRY(stp_alloc(&p->block, block, sizeof *p->block, "points", err));
    for (uint64_t begin = 0; begin < most; begin += block) {
        const uint64_t count = p->cloud->count;
        const uint64_t from = begin < count ? begin : count;
        fill_block(p, from, count - from < block ? count : from + block);
        stp_spill_relieve(p->cloud->spill);
        STP_TRY(stp_ranks_exchange(ranks, p->block, p->sent, p->run + at, p->received, err));
        for (unsigned rank = 0; rank < ranks->count; rank++)
            at += p->received[rank] / sizeof *p->run;
    }
done:
    return status;
}

/* The most points that a rank has. */
static stp_status find_most(const parts *p, uint64_t *most, stp_error *err)
{
    stp_status status = STP_OK;
    for (unsigned rank = 0; rank < p->ranks->count; rank++) {
        uint64_t count = p->cloud->count;
        STP_TRY(stp_ranks_broadcast(p->ranks, rank, &count, sizeof count, err));
        *most = count > *most ? count : *most;
    }
done:
    return status;
}

/* Makes room for this rank's run in its place among all points. */
static stp_status make_room(parts *p, uint64_t total, stp_cloud *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t *begins = NULL;
    const unsigned count = p->ranks->count;
    STP_TRY(stp_alloc(&begins, (size_t)count + 1, sizeof *begins, "ranks", err));
    begins[0] = p->cloud->first;
    for (unsigned rank = 0; rank < count; rank++)
        begins[rank + 1] = begins[rank] + p->counts[rank];
    const uint64_t begin = begins[p->ranks->self];
    *out = (stp_cloud){.first = begins[0],
                       .first_record = p->cloud->first_record,
                       .count = total,
                       .capacity = total,
                       .spill = p->cloud->spill};
    STP_TRY(stp_cloud_share(out, total, begins, p->ranks, err));
    STP_TRY(stp_cloud_array(out, &out->points, sizeof *out->points, "points", err));
    p->run = out->points + begin;
done:
    return status;
}

static stp_status sort_runs(parts *p, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud *cloud = p->cloud, all = {0};
    const uint64_t *own = &p->counts[p->ranks->self];
    uint64_t total = 0, most = 0;
    STP_TRY(join_boxes(p, &total, pool, err));
    STP_TRY(choose_splitters(p, total, err));
    STP_TRY(count_runs(p, err));
    STP_TRY(find_most(p, &most, err));
    STP_TRY(make_room(p, total, &all, err));
    STP_TRY(exchange(p, most, err));
    all.box = cloud->box;
    all.pixels = cloud->pixels;
    cloud->pixels = NULL;
    stp_cloud_clear(cloud);
    *cloud = all;
    all = (stp_cloud){0};
    STP_TRY(stp_morton_sort(p->run, *own, cloud->spill, &cloud->box, pool, err));
done:
    stp_cloud_clear(&all);
    return status;
}

stp_status stp_cloud_sort_parts(stp_cloud *cloud, stp_ranks *ranks, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    parts p = {.cloud = cloud, .own = stp_cloud_begin(cloud), .ranks = ranks};
    STP_TRY(stp_alloc(&p.splitters, ranks->count, sizeof *p.splitters, "ranks", err));
    STP_TRY(stp_alloc(&p.counts, ranks->count, sizeof *p.counts, "ranks", err));
    STP_TRY(stp_alloc(&p.block_counts, ranks->count, sizeof *p.block_counts, "ranks", err));
    STP_TRY(stp_alloc(&p.sent, ranks->count, sizeof *p.sent, "ranks", err));
    STP_TRY(stp_alloc(&p.received, ranks->count, sizeof *p.received, "ranks", err));
    status = sort_runs(&p, pool, err);
done:
    free(p.received);
    free(p.sent);
    free(p.block_counts);
    free(p.counts);
    free(p.splitters);
    free(p.block);
    return status == STP_OK ? stp_cloud_arrange(cloud, pool, err) : status;
}

stp_status stp_cloud_sort_again(stp_cloud *cloud, unsigned without, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud part = {0};
    stp_ranks *ranks = cloud->blocks->ranks;
    const stp_rank_part own = stp_cloud_own(cloud);
    STP_TRY(stp_cloud_create(&part, cloud->first, own.end - own.begin, cloud->spill, err));
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i))
        if (without == 0 || !(cloud->marks[i] & without))
            part.points[part.first + part.count++] = cloud->points[i];
    part.pixels = cloud->pixels;
    cloud->pixels = NULL;
    stp_cloud_clear(cloud);
    *cloud = part;
    STP_TRY(stp_cloud_sort_parts(cloud, ranks, pool, err));
done:
    return status;
}

/* Blocks of points from rank to rank. */
#include "preprocess/cloud/cloud_blocks.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

/* Blocks that all ranks ask for in one round, about: 16 MB. */
#define ROUND_BLOCKS 64u

/* One round of fetching. */
typedef struct round {
    stp_cloud *cloud;
    unsigned arrays; /* STP_ARRAY_* */
    uint64_t *asked; /* blocks, rank after rank */
    size_t *counts;  /* by rank: of these */
    stp_bytes in;    /* arrays that come */
} round_of_blocks;

static uint64_t least(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

static uint64_t greatest(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

/* Blocks that an array of so many places has. */
static uint32_t block_count(uint64_t places)
{
    return (uint32_t)((places + STP_BLOCK_POINTS - 1) / STP_BLOCK_POINTS);
}

static uint64_t end_of(const stp_cloud *cloud)
{
    return cloud->first + cloud->count;
}

/* Those points of a run that are in a block; begin >= end: none. */
static stp_rank_part cut_run(stp_rank_part run, uint32_t block)
{
    const uint64_t begin = (uint64_t)block * STP_BLOCK_POINTS;
    return (stp_rank_part){greatest(begin, run.begin), least(begin + STP_BLOCK_POINTS, run.end)};
}

/* The points of a block that a rank owns; begin >= end: none. */
static stp_rank_part part_of(const stp_cloud *cloud, uint32_t block, unsigned rank)
{
    const uint64_t *begins = cloud->blocks->begins;
    return cut_run((stp_rank_part){begins[rank], begins[rank + 1]}, block);
}

static bool owns_some(const stp_cloud *cloud, uint32_t block)
{
    const stp_rank_part part = cut_run(stp_cloud_own(cloud), block);
    return part.begin < part.end;
}

static bool owns_all(const stp_cloud *cloud, uint32_t block)
{
    const stp_rank_part part = cut_run(stp_cloud_own(cloud), block);
    return part.begin % STP_BLOCK_POINTS == 0 && part.begin < part.end &&
           (part.end == end_of(cloud) || part.end - part.begin == STP_BLOCK_POINTS);
}

/* The array's bytes of a block. */
static void *block_at(void *array, size_t size, uint32_t block)
{
    return (char *)array + (size_t)block * STP_BLOCK_POINTS * size;
}

static stp_status claim_block(stp_cloud *c, uint32_t block, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_spill_claim(c->spill, block_at(c->points, sizeof *c->points, block),
                            STP_BLOCK_POINTS * sizeof *c->points, "points", err));
    if (c->sheets)
        STP_TRY(stp_spill_claim(c->spill, block_at(c->sheets, sizeof *c->sheets, block),
                                STP_BLOCK_POINTS * sizeof *c->sheets, "sheets", err));
    if (c->marks)
        STP_TRY(stp_spill_claim(c->spill, block_at(c->marks, sizeof *c->marks, block),
                                STP_BLOCK_POINTS * sizeof *c->marks, "marks", err));
    if (c->blocks->numbers)
        STP_TRY(stp_spill_claim(c->spill, block_at(c->blocks->numbers, sizeof(uint32_t), block),
                                STP_BLOCK_POINTS * sizeof(uint32_t), "points", err));
done:
    return status;
}

static void forget_block(stp_cloud *c, uint32_t block)
{
    stp_spill_forget(c->spill, block_at(c->points, sizeof *c->points, block),
                     STP_BLOCK_POINTS * sizeof *c->points);
    if (c->sheets)
        stp_spill_forget(c->spill, block_at(c->sheets, sizeof *c->sheets, block),
                         STP_BLOCK_POINTS * sizeof *c->sheets);
    if (c->marks)
        stp_spill_forget(c->spill, block_at(c->marks, sizeof *c->marks, block),
                         STP_BLOCK_POINTS * sizeof *c->marks);
    if (c->blocks->numbers)
        stp_spill_forget(c->spill, block_at(c->blocks->numbers, sizeof(uint32_t), block),
                         STP_BLOCK_POINTS * sizeof(uint32_t));
}

stp_status stp_cloud_share(stp_cloud *cloud, uint64_t count, uint64_t *begins, stp_ranks *ranks,
                           stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud_blocks *b = NULL;
    STP_TRY(stp_alloc(&b, 1, sizeof *b, "blocks", err));
    b->ranks = ranks;
    b->begins = begins;
    b->count = block_count(cloud->first + count);
    begins = NULL;
    STP_TRY(stp_alloc(&b->states, b->count, sizeof *b->states, "blocks", err));
    cloud->count = count;
    cloud->blocks = b;
    b = NULL;
    for (uint32_t i = 0; i < cloud->blocks->count; i++)
        atomic_init(&cloud->blocks->states[i], owns_all(cloud, i) ? STP_BLOCK_OWN : STP_BLOCK_AWAY);
done:
    stp_cloud_blocks_destroy(b);
    free(begins);
    return status;
}

void stp_cloud_blocks_destroy(stp_cloud_blocks *b)
{
    if (!b)
        return;
    free(b->begins);
    free((void *)b->states);
    free(b);
}

void stp_cloud_move_runs(stp_cloud *cloud, const uint64_t *begins)
{
    stp_cloud_blocks *b = cloud->blocks;
    const size_t bytes = ((size_t)b->ranks->count + 1) * sizeof *begins;
    for (uint32_t i = 0; i < b->count; i++) /* 1: holds points */
        b->states[i] = b->states[i] == STP_BLOCK_HERE || owns_some(cloud, i);
    memcpy(b->begins, begins, bytes);
    for (uint32_t i = 0; i < b->count; i++) {
        if (b->states[i] == 1 && !owns_some(cloud, i))
            forget_block(cloud, i);
        b->states[i] = owns_all(cloud, i) ? STP_BLOCK_OWN : STP_BLOCK_AWAY;
    }
}

stp_status stp_cloud_array(const stp_cloud *cloud, void *out, size_t size, const char *what,
                           stp_error *err)
{
    stp_status status = STP_OK;
    void *array = NULL;
    if (!cloud->blocks && cloud->first == 0)
        return stp_spill_alloc(cloud->spill, out, cloud->count, size, what, err);
    const uint32_t count = block_count(end_of(cloud));
    STP_TRY(stp_spill_alloc_sparse(cloud->spill, &array, (size_t)count * STP_BLOCK_POINTS, size,
                                   what, err));
    for (uint32_t i = 0; i < count; i++)
        if (owns_some(cloud, i))
            STP_TRY(stp_spill_claim(cloud->spill, block_at(array, size, i), STP_BLOCK_POINTS * size,
                                    what, err));
    memcpy(out, &array, sizeof array);
    array = NULL;
done:
    stp_spill_free(cloud->spill, array);
    return status;
}

bool stp_cloud_ask(const stp_cloud *cloud, uint64_t i)
{
    atomic_uchar *state = &cloud->blocks->states[i / STP_BLOCK_POINTS];
    const unsigned char now = atomic_load_explicit(state, memory_order_relaxed);
    if (now >= STP_BLOCK_HERE)
        return true;
    if (now == STP_BLOCK_AWAY)
        atomic_store_explicit(state, STP_BLOCK_WANTED, memory_order_relaxed);
    if (cloud->missed)
        *cloud->missed = true;
    return false;
}

stp_rank_part stp_cloud_own(const stp_cloud *cloud)
{
    const stp_cloud_blocks *b = cloud->blocks;
    return b ? (stp_rank_part){b->begins[b->ranks->self], b->begins[b->ranks->self + 1]}
             : (stp_rank_part){cloud->first, end_of(cloud)};
}

stp_rank_part stp_cloud_part(const stp_cloud *cloud, const stp_ranks *ranks, unsigned rank)
{
    const stp_rank_part part = stp_ranks_part(ranks, rank, cloud->count);
    return (stp_rank_part){cloud->first + part.begin, cloud->first + part.end};
}

stp_rank_part stp_cloud_cells(const stp_cloud *cloud, const stp_ranks *ranks, unsigned rank)
{
    const uint64_t *begins = cloud->blocks ? cloud->blocks->begins : NULL;
    const stp_rank_part points = begins ? (stp_rank_part){begins[rank], begins[rank + 1]}
                                        : stp_cloud_part(cloud, ranks, rank);
    stp_rank_part cells = {0, 0};
    while (cells.begin < cloud->cell_count && cloud->cells[cells.begin].begin < points.begin)
        cells.begin++;
    cells.end = cells.begin;
    while (cells.end < cloud->cell_count && cloud->cells[cells.end].begin < points.end)
        cells.end++;
    return cells;
}

stp_rank_part stp_cloud_own_cells(const stp_cloud *cloud)
{
    return cloud->blocks ? stp_cloud_cells(cloud, cloud->blocks->ranks, cloud->blocks->ranks->self)
                         : (stp_rank_part){0, cloud->cell_count};
}

stp_status stp_cloud_join_cells(const stp_cloud *cloud, stp_cell **cells, uint32_t *count,
                                stp_error *err)
{
    stp_status status = STP_OK;
    stp_bytes all = {0};
    stp_cell *joined = NULL;
    if (!cloud->blocks)
        return STP_OK;
    STP_TRY(stp_bytes_append(&all, *cells, *count * sizeof *joined, err));
    STP_TRY(stp_ranks_join(cloud->blocks->ranks, &all, err));
    stp_cursor from = {all.data, all.size};
    STP_TRY(stp_packet_take_array(&from, &joined, all.size / sizeof *joined, sizeof *joined, err));
    free(*cells);
    *cells = joined;
    *count = (uint32_t)(all.size / sizeof *joined);
done:
    free(all.data);
    return status;
}

/* Appends points [begin, end) of an array to a packet, or takes them from it. */
static stp_status pack(stp_bytes *out, const void *array, size_t size, stp_rank_part part,
                       stp_error *err)
{
    return stp_bytes_append(out, (const char *)array + part.begin * size,
                            (part.end - part.begin) * size, err);
}

static stp_status take(stp_cursor *from, void *array, size_t size, stp_rank_part part,
                       stp_error *err)
{
    return stp_packet_take(from, (char *)array + part.begin * size, (part.end - part.begin) * size,
                           err);
}

/* Lists which of the blocks to ask of which rank. */
static void ask(round_of_blocks *r, const uint32_t *list, uint32_t count)
{
    const stp_ranks *ranks = r->cloud->blocks->ranks;
    size_t at = 0;
    for (unsigned rank = 0; rank < ranks->count; rank++) {
        const size_t before = at;
        for (uint32_t i = 0; i < count && rank != ranks->self; i++) {
            const stp_rank_part part = part_of(r->cloud, list[i], rank);
            if (part.begin < part.end)
                r->asked[at++] = list[i];
        }
        r->counts[rank] = at - before;
    }
}

/* Packs what this rank has of a block that another one asks for. */
static stp_status answer(const void *context, uint64_t block, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    const round_of_blocks *r = context;
    const stp_cloud *cloud = r->cloud;
    const stp_rank_part part = part_of(cloud, (uint32_t)block, cloud->blocks->ranks->self);
    if (r->arrays & STP_ARRAY_POINTS)
        STP_TRY(pack(out, cloud->points, sizeof *cloud->points, part, err));
    if (r->arrays & STP_ARRAY_SHEETS)
        STP_TRY(pack(out, cloud->sheets, sizeof *cloud->sheets, part, err));
    if (r->arrays & STP_ARRAY_MARKS)
        STP_TRY(pack(out, cloud->marks, sizeof *cloud->marks, part, err));
    if (r->arrays & STP_ARRAY_NUMBERS)
        STP_TRY(pack(out, cloud->blocks->numbers, sizeof(uint32_t), part, err));
done:
    return status;
}

static stp_status take_all(const round_of_blocks *r, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud *cloud = r->cloud;
    stp_cursor from = {r->in.data, r->in.size};
    const uint64_t *block = r->asked;
    for (unsigned rank = 0; rank < cloud->blocks->ranks->count; rank++)
        for (size_t i = 0; i < r->counts[rank]; i++, block++) {
            const stp_rank_part part = part_of(cloud, (uint32_t)*block, rank);
            if (r->arrays & STP_ARRAY_POINTS)
                STP_TRY(take(&from, cloud->points, sizeof *cloud->points, part, err));
            if (r->arrays & STP_ARRAY_SHEETS)
                STP_TRY(take(&from, cloud->sheets, sizeof *cloud->sheets, part, err));
            if (r->arrays & STP_ARRAY_MARKS)
                STP_TRY(take(&from, cloud->marks, sizeof *cloud->marks, part, err));
            if (r->arrays & STP_ARRAY_NUMBERS)
                STP_TRY(take(&from, cloud->blocks->numbers, sizeof(uint32_t), part, err));
        }
done:
    return status;
}

/* Copies some blocks: a round. */
static stp_status run_round(round_of_blocks *r, const uint32_t *list, uint32_t count,
                            stp_error *err)
{
    stp_status status = STP_OK;
    ask(r, list, count);
    stp_spill_relieve(r->cloud->spill);
    STP_TRY(stp_ranks_ask(r->cloud->blocks->ranks, r->asked, r->counts, answer, r, &r->in, err));
    STP_TRY(take_all(r, err));
done:
    return status;
}

/* Copies the arrays of blocks from their owners. */
static stp_status copy_blocks(stp_cloud *cloud, const uint32_t *list, uint32_t count,
                              unsigned arrays, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = cloud->blocks->ranks;
    const uint32_t share = ranks->count < ROUND_BLOCKS ? ROUND_BLOCKS / ranks->count : 1;
    round_of_blocks r = {.cloud = cloud, .arrays = arrays};
    /* a block lies in one run, or once more in each run that ends in it */
    STP_TRY(stp_alloc(&r.asked, (size_t)share + ranks->count, sizeof *r.asked, "blocks", err));
    STP_TRY(stp_alloc(&r.counts, ranks->count, sizeof *r.counts, "ranks", err));
    for (uint32_t at = 0;;) {
        uint64_t left = count - at;
        STP_TRY(stp_ranks_sum(ranks, &left, 1, err));
        if (left == 0)
            break;
        const uint32_t here = share < count - at ? share : count - at;
        STP_TRY(run_round(&r, list + at, here, err));
        at += here;
    }
done:
    free(r.asked);
    free(r.counts);
    free(r.in.data);
    return status;
}

/* Lists the blocks in a state. */
static stp_status list_blocks(const stp_cloud *cloud, stp_block_state state, uint32_t **out,
                              uint32_t *count, stp_error *err)
{
    const stp_cloud_blocks *b = cloud->blocks;
    *count = 0;
    for (uint32_t i = 0; i < b->count; i++)
        *count += b->states[i] == state;
    const stp_status status = stp_alloc(out, *count, sizeof **out, "blocks", err);
    for (uint32_t i = 0, at = 0; status == STP_OK && i < b->count; i++)
        if (b->states[i] == state)
            (*out)[at++] = i;
    return status;
}

static unsigned arrays_of(const stp_cloud *cloud)
{
    return STP_ARRAY_POINTS | (cloud->sheets ? STP_ARRAY_SHEETS : 0u) |
           (cloud->marks ? STP_ARRAY_MARKS : 0u) |
           (cloud->blocks->numbers ? STP_ARRAY_NUMBERS : 0u);
}

stp_status stp_cloud_fetch(stp_cloud *cloud, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t *list = NULL, count = 0;
    if (!cloud->blocks)
        return STP_OK;
    STP_TRY(list_blocks(cloud, STP_BLOCK_WANTED, &list, &count, err));
    for (uint32_t i = 0; i < count; i++) {
        if (!owns_some(cloud, list[i]))
            STP_TRY(claim_block(cloud, list[i], err));
        cloud->blocks->states[list[i]] = STP_BLOCK_HERE;
    }
    STP_TRY(copy_blocks(cloud, list, count, arrays_of(cloud), err));
done:
    free(list);
    return status;
}

stp_status stp_cloud_refresh(stp_cloud *cloud, unsigned arrays, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t *list = NULL, count = 0;
    if (!cloud->blocks)
        return STP_OK;
    STP_TRY(list_blocks(cloud, STP_BLOCK_HERE, &list, &count, err));
    STP_TRY(copy_blocks(cloud, list, count, arrays, err));
done:
    free(list);
    return status;
}

void stp_cloud_let_go(stp_cloud *cloud)
{
    stp_cloud_blocks *b = cloud->blocks;
    for (uint32_t i = 0; b && i < b->count; i++) {
        if (b->states[i] == STP_BLOCK_HERE && !owns_some(cloud, i))
            forget_block(cloud, i);
        if (b->states[i] != STP_BLOCK_OWN)
            b->states[i] = STP_BLOCK_AWAY;
    }
}

stp_status stp_cloud_sum(const stp_cloud *cloud, uint64_t *numbers, size_t count, stp_error *err)
{
    return cloud->blocks ? stp_ranks_sum(cloud->blocks->ranks, numbers, count, err) : STP_OK;
}

stp_status stp_cloud_in_turn(const stp_cloud *cloud, void (*add)(void *), void *context, void *data,
                             size_t bytes, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = cloud->blocks ? cloud->blocks->ranks : NULL;
    const unsigned self = ranks ? ranks->self : 0, last = stp_ranks_count(ranks) - 1;
    if (self > 0)
        STP_TRY(ranks->send(ranks, self - 1, self, data, bytes, err));
    add(context);
    if (self < last)
        STP_TRY(ranks->send(ranks, self, self + 1, data, bytes, err));
    if (last > 0) {
        ranks->sent_bytes += last * bytes;
        STP_TRY(stp_ranks_broadcast(ranks, last, data, bytes, err));
    }
done:
    return status;
}

stp_status stp_cloud_every(const stp_cloud *cloud, uint64_t stride, stp_cloud_point **out,
                           uint32_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud_point *list = NULL;
    stp_ranks *ranks = cloud->blocks ? cloud->blocks->ranks : NULL;
    const stp_rank_part whole = {cloud->first, end_of(cloud)};
    *count = (uint32_t)((cloud->count - 1) / stride + 1);
    STP_TRY(stp_alloc(&list, *count, sizeof *list, "points", err));
    for (unsigned rank = 0; rank < stp_ranks_count(ranks); rank++) {
        const uint64_t *begins = ranks ? cloud->blocks->begins + rank : NULL;
        const stp_rank_part run = begins ? (stp_rank_part){begins[0], begins[1]} : whole;
        const uint64_t first = (run.begin - cloud->first + stride - 1) / stride;
        const uint64_t end = (run.end - cloud->first + stride - 1) / stride;
        for (uint64_t i = first; i < end && (!ranks || rank == ranks->self); i++) {
            stp_cloud_stride(cloud->spill, i * stride, stride);
            list[i] = cloud->points[cloud->first + i * stride];
        }
        STP_TRY(stp_ranks_broadcast(ranks, rank, list + first, (end - first) * sizeof *list, err));
    }
    *out = list;
    list = NULL;
done:
    free(list);
    return status;
}

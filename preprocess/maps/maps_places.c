/* Which points belong to which list, and what becomes of them. */
#include "base/memory.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/maps/maps_work.h"

#include <stdlib.h>
#include <string.h>

/* A point of a list of another rank. */
typedef struct member {
    uint32_t list, place;
} member;

static unsigned rank_of_member(const void *context, const void *item)
{
    const stp_maps_work *w = context;
    return stp_ranks_find(w->ranks, w->list_firsts, ((const member *)item)->list);
}

static unsigned rank_of_place(const void *context, const void *item)
{
    const stp_maps_work *w = context;
    return stp_ranks_find(w->ranks, w->cloud->blocks->begins, *(const uint32_t *)item);
}

static unsigned rank_of_guest(const void *context, const void *item)
{
    return rank_of_place(context, &((const stp_map_guest *)item)->place);
}

static unsigned rank_of_host(const void *context, const void *item)
{
    const stp_maps_work *w = context;
    return stp_ranks_find(w->ranks, w->list_firsts, ((const stp_map_guest *)item)->list);
}

stp_status stp_maps_number_lists(stp_maps_work *w, const uint32_t *roots, stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned ranks = stp_ranks_count(w->ranks);
    const stp_rank_part own = stp_cloud_own(w->cloud);
    uint32_t *lists = NULL; /* by root */
    unsigned rank = 0;
    STP_TRY(stp_alloc(&lists, w->part_count, sizeof *lists, "maps", err));
    STP_TRY(stp_alloc(&w->begins, (size_t)w->part_count + 1, sizeof *w->begins, "maps", err));
    STP_TRY(stp_alloc(&w->list_firsts, (size_t)ranks + 1, sizeof *w->list_firsts, "ranks", err));
    for (uint32_t p = 0; p < w->part_count; p++) {
        for (; rank + 1 < ranks && p >= w->part_firsts[rank + 1]; rank++)
            w->list_firsts[rank + 1] = w->list_count;
        lists[p] = STP_PART_NONE;
        if (roots[p] != p || w->parts[p].points < STP_MAP_POINTS_LEAST)
            continue;
        lists[p] = w->list_count++;
        w->begins[w->list_count] = w->begins[w->list_count - 1] + w->parts[p].points;
    }
    while (rank < ranks)
        w->list_firsts[++rank] = w->list_count;
    const unsigned self = w->ranks ? w->ranks->self : 0;
    w->own = (stp_rank_part){w->list_firsts[self], w->list_firsts[self + 1]};
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(w->cloud->spill, i))
        if (w->numbers[i] != STP_PART_NONE)
            w->numbers[i] = lists[roots[w->numbers[i]]];
done:
    free(lists);
    return status;
}

/* The first point of a list is its rank's, so others come from ranks behind: places ascend. */
stp_status stp_maps_find_places(stp_maps_work *w, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cloud *cloud = w->cloud;
    const stp_rank_part own = stp_cloud_own(cloud);
    const size_t count = w->begins[w->own.end] - w->begins[w->own.begin];
    stp_bytes others = {0};
    size_t *at = NULL; /* by own list: where its next place goes */
    STP_TRY(stp_spill_alloc(cloud->spill, &w->places, count, sizeof *w->places, "maps", err));
    STP_TRY(stp_spill_alloc(cloud->spill, &w->taken, count, sizeof *w->taken, "maps", err));
    STP_TRY(stp_alloc(&at, w->own.end - w->own.begin, sizeof *at, "maps", err));
    for (uint32_t m = (uint32_t)w->own.begin; m < w->own.end; m++)
        at[m - w->own.begin] = stp_maps_place_begin(w, m);
    for (uint32_t i = (uint32_t)own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i)) {
        const member point = {w->numbers[i], i};
        if (point.list >= w->own.begin && point.list < w->own.end)
            w->places[at[point.list - w->own.begin]++] = i;
        else if (point.list != STP_PART_NONE)
            STP_TRY(stp_bytes_append(&others, &point, sizeof point, err));
    }
    STP_TRY(stp_ranks_deal(w->ranks, &others, sizeof(member), rank_of_member, w, err));
    for (stp_cursor from = {others.data, others.size}; from.left > 0;) {
        member point;
        STP_TRY(stp_packet_take(&from, &point, sizeof point, err));
        w->places[at[point.list - w->own.begin]++] = point.place;
    }
done:
    free(at);
    free(others.data);
    return status;
}

stp_status stp_maps_mark_taken(stp_maps_work *w, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_rank_part own = stp_cloud_own(w->cloud);
    const uint32_t count = w->begins[w->own.end] - w->begins[w->own.begin];
    stp_bytes others = {0};
    for (uint32_t k = 0; k < count; k++, stp_cloud_step(w->cloud->spill, k)) {
        const uint32_t place = w->places[k];
        if (!w->taken[k])
            continue;
        if (place >= own.begin && place < own.end)
            w->mapped[place] = true;
        else
            STP_TRY(stp_bytes_append(&others, &place, sizeof place, err));
    }
    STP_TRY(stp_ranks_deal(w->ranks, &others, sizeof(uint32_t), rank_of_place, w, err));
    for (stp_cursor from = {others.data, others.size}; from.left > 0;) {
        uint32_t place = 0;
        STP_TRY(stp_packet_take(&from, &place, sizeof place, err));
        w->mapped[place] = true;
    }
done:
    free(others.data);
    return status;
}

static int compare_guests(const void *a, const void *b)
{
    const stp_map_guest *p = a, *q = b;
    if (p->place != q->place)
        return p->place < q->place ? -1 : 1;
    if (p->distance != q->distance)
        return p->distance < q->distance ? -1 : 1;
    return (p->list > q->list) - (p->list < q->list);
}

/* Lists the guests of own lists. */
static stp_status list_guests(const stp_maps_work *w, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    for (uint32_t m = (uint32_t)w->own.begin; m < w->own.end; m++)
        for (size_t i = 0; i < w->lists[m].guest_count; i++) {
            stp_map_guest guest = w->lists[m].guests[i];
            guest.list = m;
            STP_TRY(stp_bytes_append(out, &guest, sizeof guest, err));
        }
done:
    return status;
}

/* A list adds up its guests in the order of their places, whatever ranks have them. */
stp_status stp_maps_settle_guests(stp_maps_work *w, stp_error *err)
{
    stp_status status = STP_OK;
    stp_bytes guests = {0};
    size_t kept = 0;
    STP_TRY(list_guests(w, &guests, err));
    STP_TRY(stp_ranks_deal(w->ranks, &guests, sizeof(stp_map_guest), rank_of_guest, w, err));
    stp_map_guest *list = (stp_map_guest *)guests.data;
    const size_t count = guests.size / sizeof *list;
    if (count > 0)
        qsort(list, count, sizeof *list, compare_guests);
    for (size_t i = 0; i < count; i++) {
        if (w->mapped[list[i].place])
            continue;
        w->numbers[list[i].place] = list[i].list;
        w->mapped[list[i].place] = true;
        list[kept++] = list[i];
    }
    guests.size = kept * sizeof *list;
    STP_TRY(stp_ranks_deal(w->ranks, &guests, sizeof(stp_map_guest), rank_of_host, w, err));
    for (stp_cursor from = {guests.data, guests.size}; from.left > 0;) {
        stp_map_guest guest;
        STP_TRY(stp_packet_take(&from, &guest, sizeof guest, err));
        stp_maps_counts_add(&w->lists[guest.list].counts, guest.distance);
    }
done:
    free(guests.data);
    return status;
}

/* Moves the own points that stay to the front of the run. kept: by cell, how many. */
static void keep_own(const stp_maps_work *w, uint32_t *kept)
{
    stp_cloud *cloud = w->cloud;
    const stp_rank_part own = stp_cloud_own_cells(cloud);
    uint64_t to = stp_cloud_own(cloud).begin;
    for (uint64_t c = own.begin; c < own.end; c++) {
        const uint64_t before = to;
        for (uint64_t i = cloud->cells[c].begin; i < cloud->cells[c].end; i++) {
            if (w->mapped[i])
                continue;
            cloud->points[to] = cloud->points[i];
            cloud->sheets[to] = cloud->sheets[i];
            cloud->marks[to++] = cloud->marks[i];
        }
        kept[c] = (uint32_t)(to - before);
        stp_spill_relieve(cloud->spill);
    }
}

/* Tells all ranks what each has kept; begins: by rank, where its run begins now. */
static stp_status share_kept(const stp_maps_work *w, uint32_t *kept, uint64_t *begins,
                             stp_error *err)
{
    stp_status status = STP_OK;
    for (unsigned rank = 0; rank < w->ranks->count; rank++) {
        const stp_rank_part part = stp_cloud_cells(w->cloud, w->ranks, rank);
        STP_TRY(stp_ranks_broadcast(w->ranks, rank, kept + part.begin,
                                    (part.end - part.begin) * sizeof *kept, err));
        begins[rank + 1] = begins[rank];
        for (uint64_t c = part.begin; c < part.end; c++)
            begins[rank + 1] += kept[c];
    }
done:
    return status;
}

/* Puts this rank's points where they are among those that all ranks keep. Takes begins. */
static stp_status move_own(stp_cloud *cloud, stp_ranks *ranks, uint64_t *begins, stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t total = begins[ranks->count], from = stp_cloud_own(cloud).begin;
    stp_cloud to = {.capacity = total, .spill = cloud->spill, .box = cloud->box};
    if (total == 0) { /* nothing is shared */
        free(begins);
    } else {
        STP_TRY(stp_cloud_share(&to, total, begins, ranks, err));
        STP_TRY(stp_cloud_array(&to, &to.points, sizeof *to.points, "points", err));
        STP_TRY(stp_cloud_array(&to, &to.sheets, sizeof *to.sheets, "sheets", err));
        STP_TRY(stp_cloud_array(&to, &to.marks, sizeof *to.marks, "marks", err));
        const stp_rank_part own = stp_cloud_own(&to);
        const size_t count = own.end - own.begin;
        memcpy(to.points + own.begin, cloud->points + from, count * sizeof *to.points);
        memcpy(to.sheets + own.begin, cloud->sheets + from, count * sizeof *to.sheets);
        memcpy(to.marks + own.begin, cloud->marks + from, count * sizeof *to.marks);
    }
    to.cells = cloud->cells;
    to.cell_count = cloud->cell_count;
    cloud->cells = NULL;
    stp_cloud_clear(cloud);
    *cloud = to;
    to = (stp_cloud){0};
done:
    stp_cloud_clear(&to);
    return status;
}

stp_status stp_maps_keep_others(stp_maps_work *w, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud *cloud = w->cloud;
    const unsigned ranks = stp_ranks_count(w->ranks);
    uint32_t *kept = NULL, cells = 0;
    uint64_t *begins = NULL, count = 0;
    STP_TRY(stp_alloc(&kept, cloud->cell_count, sizeof *kept, "cells", err));
    STP_TRY(stp_alloc(&begins, (size_t)ranks + 1, sizeof *begins, "ranks", err));
    keep_own(w, kept);
    if (w->ranks)
        STP_TRY(share_kept(w, kept, begins, err));
    for (uint32_t c = 0; c < cloud->cell_count; c++) {
        const uint64_t begin = count;
        count += kept[c];
        if (kept[c] == 0)
            continue;
        if (cells > 0 && count - cloud->cells[cells - 1].begin <= STP_CELL_POINTS)
            cloud->cells[cells - 1].end = count;
        else
            cloud->cells[cells++] = (stp_cell){.begin = begin, .end = count};
    }
    if (w->ranks) {
        uint64_t *taken = begins;
        begins = NULL;
        STP_TRY(move_own(cloud, w->ranks, taken, err));
    }
    cloud->count = count;
    cloud->cell_count = cells;
    STP_TRY(stp_cloud_settle_cells(cloud, pool, err));
done:
    free(kept);
    free(begins);
    return status;
}

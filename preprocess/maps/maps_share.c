/* Packs parts and maps, and takes them from packets. */
#include "preprocess/maps/maps_share.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_blocks.h"

#include <stdlib.h>
#include <string.h>

/* A packet ends with the item that makes it as long. */
#define PACKET_BYTES (1u << 22)
/* Maps that a rank asks for at a time: some have 2 MB. */
#define ROUND_MAPS 8u

/* What is given to all: parts of cells, or maps of lists. */
typedef struct giving {
    stp_ranks *ranks;
    const stp_cloud *cloud;
    stp_cell_parts *cells;
    stp_map_list *lists;
    const uint64_t *firsts;
    bool samples;
    stp_rank_part (*part)(const struct giving *, unsigned rank); /* the items that a rank has */
    stp_status (*pack)(const struct giving *, uint32_t index, stp_bytes *, stp_error *);
    stp_status (*take)(struct giving *, uint32_t index, stp_cursor *, stp_error *);
} giving;

/* Gives the items that rank `from` has to all others. */
static stp_status give(giving *g, unsigned from, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_rank_part part = g->part(g, from);
    uint32_t begin = (uint32_t)part.begin;
    const uint32_t end = (uint32_t)part.end;
    stp_bytes packet = {0};
    while (begin < end) {
        packet.size = 0;
        for (; from == g->ranks->self && begin < end && packet.size < PACKET_BYTES; begin++)
            STP_TRY(g->pack(g, begin, &packet, err));
        stp_spill_relieve(g->cloud->spill);
        STP_TRY(stp_ranks_broadcast_bytes(g->ranks, from, &packet, err));
        stp_cursor cursor = {packet.data, packet.size};
        for (; from != g->ranks->self && begin < end && cursor.left > 0; begin++)
            STP_TRY(g->take(g, begin, &cursor, err));
    }
done:
    free(packet.data);
    return status;
}

static stp_status give_all(giving *g, stp_error *err)
{
    const unsigned count = stp_ranks_count(g->ranks);
    stp_status status = STP_OK;
    for (unsigned rank = 0; rank < count && count > 1 && status == STP_OK; rank++)
        status = give(g, rank, err);
    return status;
}

/* ---- parts of cells ---- */

static stp_rank_part cells_of(const giving *g, unsigned rank)
{
    return stp_cloud_cells(g->cloud, g->ranks, rank);
}

static stp_status pack_cell(const giving *g, uint32_t index, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cell_parts *c = &g->cells[index];
    const uint64_t counts[] = {c->part_count, c->pair_count};
    STP_TRY(stp_bytes_append(out, counts, sizeof counts, err));
    STP_TRY(stp_bytes_append(out, c->parts, c->part_count * sizeof *c->parts, err));
    for (uint32_t i = 0; i < c->part_count; i++)
        STP_TRY(stp_bytes_append(out, c->parts[i].corners,
                                 c->parts[i].corner_count * sizeof *c->parts[i].corners, err));
    STP_TRY(stp_bytes_append(out, c->pairs, c->pair_count * sizeof *c->pairs, err));
done:
    return status;
}

static stp_status take_cell(giving *g, uint32_t index, stp_cursor *from, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cell_parts *c = &g->cells[index];
    uint64_t counts[2];
    STP_TRY(stp_packet_take(from, counts, sizeof counts, err));
    STP_TRY(stp_packet_take_array(from, &c->parts, counts[0], sizeof *c->parts, err));
    for (uint32_t i = 0; i < counts[0]; i++)
        c->parts[i].corners = NULL; /* the other rank's */
    c->part_count = (uint32_t)counts[0];
    for (uint32_t i = 0; i < c->part_count; i++)
        STP_TRY(stp_packet_take_array(from, &c->parts[i].corners, c->parts[i].corner_count,
                                      sizeof *c->parts[i].corners, err));
    STP_TRY(stp_packet_take_array(from, &c->pairs, counts[1], sizeof *c->pairs, err));
    c->pair_count = counts[1];
done:
    return status;
}

stp_status stp_cell_parts_share(stp_ranks *ranks, const stp_cloud *cloud, stp_cell_parts *cells,
                                stp_error *err)
{
    giving g = {.ranks = ranks,
                .cloud = cloud,
                .cells = cells,
                .part = cells_of,
                .pack = pack_cell,
                .take = take_cell};
    return give_all(&g, err);
}

/* ---- maps of lists ---- */

static size_t sample_bytes(const stp_map *map)
{
    return (size_t)map->columns * map->rows * sizeof *map->samples;
}

static stp_status take_samples(stp_map *map, stp_cursor *from, stp_spill *spill, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t count = (size_t)map->columns * map->rows;
    STP_TRY(stp_packet_take_array(from, &map->samples, count, sizeof *map->samples, err));
    STP_TRY(stp_spill_move(spill, &map->samples, count, sizeof *map->samples, "maps", err));
done:
    return status;
}

static stp_status pack_list(const giving *g, uint32_t index, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_map_list *l = &g->lists[index];
    const uint64_t count = l->count;
    STP_TRY(stp_bytes_append(out, &count, sizeof count, err));
    STP_TRY(stp_bytes_append(out, &l->counts, sizeof l->counts, err));
    STP_TRY(stp_bytes_append(out, &l->box, sizeof l->box, err));
    STP_TRY(stp_bytes_append(out, l->maps, l->count * sizeof *l->maps, err));
    for (size_t i = 0; i < l->count && g->samples; i++)
        STP_TRY(stp_bytes_append(out, l->maps[i].samples, sample_bytes(&l->maps[i]), err));
done:
    return status;
}

static stp_status take_list(giving *g, uint32_t index, stp_cursor *from, stp_error *err)
{
    stp_status status = STP_OK;
    stp_map_list *l = &g->lists[index];
    uint64_t count = 0;
    STP_TRY(stp_packet_take(from, &count, sizeof count, err));
    STP_TRY(stp_packet_take(from, &l->counts, sizeof l->counts, err));
    STP_TRY(stp_packet_take(from, &l->box, sizeof l->box, err));
    STP_TRY(stp_packet_take_array(from, &l->maps, count, sizeof *l->maps, err));
    for (size_t i = 0; i < count; i++)
        l->maps[i].samples = NULL; /* the other rank's */
    l->count = l->capacity = count;
    for (size_t i = 0; i < count && g->samples; i++)
        STP_TRY(take_samples(&l->maps[i], from, g->cloud->spill, err));
done:
    return status;
}

static stp_rank_part lists_of(const giving *g, unsigned rank)
{
    return (stp_rank_part){g->firsts[rank], g->firsts[rank + 1]};
}

stp_status stp_map_lists_share(stp_ranks *ranks, const stp_cloud *cloud, stp_map_list *lists,
                               const uint64_t *firsts, bool samples, stp_error *err)
{
    giving g = {.ranks = ranks,
                .cloud = cloud,
                .lists = lists,
                .firsts = firsts,
                .samples = samples,
                .part = lists_of,
                .pack = pack_list,
                .take = take_list};
    return give_all(&g, err);
}

/* ---- samples that a rank needs ---- */

static stp_status pack_samples(const void *context, uint64_t map, stp_bytes *out, stp_error *err)
{
    const stp_maps *maps = context;
    stp_spill_relieve(maps->spill);
    return stp_bytes_append(out, maps->maps[map].samples, sample_bytes(&maps->maps[map]), err);
}

/* Gets some maps: a round. */
static stp_status fetch_some(const stp_maps *maps, const uint64_t *list, uint32_t count,
                             size_t *counts, stp_bytes *in, stp_error *err)
{
    stp_status status = STP_OK;
    memset(counts, 0, maps->ranks->count * sizeof *counts);
    for (uint32_t i = 0; i < count; i++)
        counts[stp_ranks_find(maps->ranks, maps->firsts, list[i])]++;
    STP_TRY(stp_ranks_ask(maps->ranks, list, counts, pack_samples, maps, in, err));
    stp_cursor from = {in->data, in->size};
    for (uint32_t i = 0; i < count; i++)
        STP_TRY(take_samples(&maps->maps[list[i]], &from, maps->spill, err));
done:
    return status;
}

stp_status stp_maps_fetch(const stp_maps *maps, const bool *wanted, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t *list = NULL;
    uint32_t count = 0;
    size_t *counts = NULL;
    stp_bytes in = {0};
    if (!maps->ranks)
        return STP_OK;
    STP_TRY(stp_alloc(&list, maps->count, sizeof *list, "maps", err));
    STP_TRY(stp_alloc(&counts, maps->ranks->count, sizeof *counts, "ranks", err));
    for (uint32_t i = 0; i < maps->count; i++)
        if (wanted[i] && !maps->maps[i].samples)
            list[count++] = i;
    for (uint32_t at = 0;;) {
        uint64_t left = count - at;
        STP_TRY(stp_ranks_sum(maps->ranks, &left, 1, err));
        if (left == 0)
            break;
        const uint32_t here = count - at < ROUND_MAPS ? count - at : ROUND_MAPS;
        STP_TRY(fetch_some(maps, list + at, here, counts, &in, err));
        at += here;
    }
done:
    free(list);
    free(counts);
    free(in.data);
    return status;
}

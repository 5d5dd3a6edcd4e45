/* Packs parts and maps, and takes them from packets. */
#include "preprocess/maps/maps_share.h"

#include "preprocess/cloud/cloud_blocks.h"

#include <stdlib.h>

/* A packet ends with the item that makes it as long. */
#define PACKET_BYTES (1u << 22)

/* What is given: parts of cells, or maps of merged parts. */
typedef struct giving {
    stp_ranks *ranks;
    const stp_cloud *cloud;
    stp_cell_parts *cells;
    uint32_t *numbers;
    stp_map_list *lists;
    const uint32_t *begins, *places;
    bool *mapped;
    uint32_t list_count;
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
    const stp_cell *cell = &g->cloud->cells[index];
    const stp_cell_parts *c = &g->cells[index];
    const uint64_t counts[] = {c->part_count, c->pair_count, c->border_count};
    STP_TRY(stp_bytes_append(out, counts, sizeof counts, err));
    STP_TRY(stp_bytes_append(out, c->parts, c->part_count * sizeof *c->parts, err));
    for (uint32_t i = 0; i < c->part_count; i++)
        STP_TRY(stp_bytes_append(out, c->parts[i].corners,
                                 c->parts[i].corner_count * sizeof *c->parts[i].corners, err));
    STP_TRY(stp_bytes_append(out, c->pairs, c->pair_count * sizeof *c->pairs, err));
    STP_TRY(stp_bytes_append(out, c->borders, c->border_count * sizeof *c->borders, err));
    STP_TRY(stp_bytes_append(out, g->numbers + cell->begin,
                             (cell->end - cell->begin) * sizeof *g->numbers, err));
done:
    return status;
}

static stp_status take_cell(giving *g, uint32_t index, stp_cursor *from, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cell *cell = &g->cloud->cells[index];
    stp_cell_parts *c = &g->cells[index];
    uint64_t counts[3];
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
    STP_TRY(stp_packet_take_array(from, &c->borders, counts[2], sizeof *c->borders, err));
    c->border_count = counts[2];
    STP_TRY(stp_packet_take(from, g->numbers + cell->begin,
                            (cell->end - cell->begin) * sizeof *g->numbers, err));
done:
    return status;
}

stp_status stp_cell_parts_share(stp_ranks *ranks, const stp_cloud *cloud, stp_cell_parts *cells,
                                uint32_t *numbers, stp_error *err)
{
    giving g = {.ranks = ranks,
                .cloud = cloud,
                .cells = cells,
                .part = cells_of,
                .pack = pack_cell,
                .take = take_cell};
    g.numbers = numbers;
    return give_all(&g, err);
}

/* ---- maps of merged parts ---- */

static stp_status pack_list(const giving *g, uint32_t index, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_map_list *l = &g->lists[index];
    const uint32_t begin = g->begins[index], end = g->begins[index + 1];
    uint64_t counts[] = {l->count, l->guest_count, 0};
    for (uint32_t i = begin; i < end; i++)
        counts[2] += g->mapped[g->places[i]];
    STP_TRY(stp_bytes_append(out, counts, sizeof counts, err));
    STP_TRY(stp_bytes_append(out, &l->counts, sizeof l->counts, err));
    STP_TRY(stp_bytes_append(out, &l->box, sizeof l->box, err));
    STP_TRY(stp_bytes_append(out, l->maps, l->count * sizeof *l->maps, err));
    for (size_t i = 0; i < l->count; i++)
        STP_TRY(stp_bytes_append(
            out, l->maps[i].samples,
            (size_t)l->maps[i].columns * l->maps[i].rows * sizeof *l->maps[i].samples, err));
    STP_TRY(stp_bytes_append(out, l->guests, l->guest_count * sizeof *l->guests, err));
    for (uint32_t i = begin; i < end; i++)
        if (g->mapped[g->places[i]])
            STP_TRY(stp_bytes_append(out, &g->places[i], sizeof *g->places, err));
done:
    return status;
}

static stp_status take_maps(stp_map_list *l, stp_cursor *from, size_t count, stp_spill *spill,
                            stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_packet_take_array(from, &l->maps, count, sizeof *l->maps, err));
    for (size_t i = 0; i < count; i++)
        l->maps[i].samples = NULL; /* the other rank's */
    l->count = l->capacity = count;
    for (size_t i = 0; i < count; i++) {
        stp_map *map = &l->maps[i];
        const size_t samples = (size_t)map->columns * map->rows;
        STP_TRY(stp_packet_take_array(from, &map->samples, samples, sizeof *map->samples, err));
        STP_TRY(stp_spill_move(spill, &map->samples, samples, sizeof *map->samples, "maps", err));
    }
done:
    return status;
}

static stp_status take_list(giving *g, uint32_t index, stp_cursor *from, stp_error *err)
{
    stp_status status = STP_OK;
    stp_map_list *l = &g->lists[index];
    uint64_t counts[3];
    STP_TRY(stp_packet_take(from, counts, sizeof counts, err));
    STP_TRY(stp_packet_take(from, &l->counts, sizeof l->counts, err));
    STP_TRY(stp_packet_take(from, &l->box, sizeof l->box, err));
    STP_TRY(take_maps(l, from, counts[0], g->cloud->spill, err));
    STP_TRY(stp_packet_take_array(from, &l->guests, counts[1], sizeof *l->guests, err));
    l->guest_count = l->guest_capacity = counts[1];
    for (uint64_t i = 0; i < counts[2]; i++) {
        uint32_t place = 0;
        STP_TRY(stp_packet_take(from, &place, sizeof place, err));
        g->mapped[place] = true;
    }
done:
    return status;
}

stp_rank_part stp_maps_rank_part(const stp_ranks *ranks, unsigned rank, const uint32_t *begins,
                                 uint32_t count)
{
    const stp_rank_part points = stp_ranks_part(ranks, rank, begins[count]);
    stp_rank_part out = {0, 0};
    while (out.begin < count && begins[out.begin] < points.begin)
        out.begin++;
    out.end = out.begin;
    while (out.end < count && begins[out.end] < points.end)
        out.end++;
    return out;
}

static stp_rank_part lists_of(const giving *g, unsigned rank)
{
    return stp_maps_rank_part(g->ranks, rank, g->begins, g->list_count);
}

stp_status stp_map_lists_share(stp_ranks *ranks, const stp_cloud *cloud, stp_map_list *lists,
                               const uint32_t *begins, uint32_t count, const uint32_t *places,
                               bool *mapped, stp_error *err)
{
    giving g = {.ranks = ranks,
                .cloud = cloud,
                .lists = lists,
                .begins = begins,
                .places = places,
                .list_count = count,
                .part = lists_of,
                .pack = pack_list,
                .take = take_list};
    g.mapped = mapped;
    return give_all(&g, err);
}

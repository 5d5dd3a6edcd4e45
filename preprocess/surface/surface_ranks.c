/* Gives what each rank found of the surface to all ranks, cell by cell. */
#include "preprocess/surface/surface_ranks.h"

#include "preprocess/cloud/cloud_blocks.h"

#include <stdlib.h>

static stp_status pack_graph(stp_bytes *out, const stp_graph *g, stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t counts[] = {g->piece_count, g->edge_count, g->kept_count, g->list_bytes};
    STP_TRY(stp_bytes_append(out, counts, sizeof counts, err));
    STP_TRY(stp_bytes_append(out, g->sizes, g->piece_count * sizeof *g->sizes, err));
    STP_TRY(stp_bytes_append(out, g->edges, g->edge_count * sizeof *g->edges, err));
    STP_TRY(stp_bytes_append(out, g->kept, g->kept_count * sizeof *g->kept, err));
    STP_TRY(stp_bytes_append(out, g->lists, g->list_bytes, err));
done:
    return status;
}

static stp_status take_graph(stp_cursor *from, stp_graph *out, stp_spill *spill, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t counts[4];
    STP_TRY(stp_packet_take(from, counts, sizeof counts, err));
    out->piece_count = (uint32_t)counts[0];
    out->edge_count = counts[1];
    out->kept_count = (uint32_t)counts[2];
    out->list_bytes = counts[3];
    STP_TRY(stp_packet_take_array(from, &out->sizes, out->piece_count, sizeof *out->sizes, err));
    STP_TRY(stp_packet_take_array(from, &out->edges, out->edge_count, sizeof *out->edges, err));
    STP_TRY(stp_packet_take_array(from, &out->kept, out->kept_count, sizeof *out->kept, err));
    STP_TRY(stp_packet_take_array(from, &out->lists, out->list_bytes, 1, err));
    STP_TRY(stp_graph_stow(out, spill, err));
done:
    return status;
}

static stp_status pack_sizes(stp_bytes *out, const stp_graph *g, stp_error *err)
{
    return stp_bytes_append(out, g->sizes, g->piece_count * sizeof *g->sizes, err);
}

static stp_status take_sizes(stp_cursor *from, stp_graph *out, stp_spill *spill, stp_error *err)
{
    stp_status status = STP_OK;
    out->piece_count = (uint32_t)(from->left / sizeof *out->sizes);
    STP_TRY(stp_packet_take_array(from, &out->sizes, out->piece_count, sizeof *out->sizes, err));
    STP_TRY(stp_graph_stow(out, spill, err));
done:
    return status;
}

static stp_status pack_cell(stp_bytes *out, const stp_cloud *cloud, uint64_t index,
                            const stp_surface_arrays *a, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cell *cell = &cloud->cells[index];
    const size_t count = cell->end - cell->begin;
    out->size = 0;
    if (cloud->blocks)
        return a->graphs ? pack_sizes(out, &a->graphs[index], err) : STP_OK;
    for (uint64_t i = cell->begin; i < cell->end; i++) {
        STP_TRY(stp_bytes_append(out, &cloud->points[i].normal, sizeof(vec3s), err));
        STP_TRY(stp_bytes_append(out, &cloud->points[i].spacing, sizeof(float), err));
    }
    STP_TRY(stp_bytes_append(out, cloud->marks + cell->begin, count, err));
    if (a->averaged)
        STP_TRY(stp_bytes_append(out, a->averaged + cell->begin, count * sizeof(vec3s), err));
    if (a->shifts)
        STP_TRY(stp_bytes_append(out, a->shifts + cell->begin, count * sizeof(vec3s), err));
    if (a->graphs) {
        STP_TRY(stp_bytes_append(out, cloud->sheets + cell->begin, count * sizeof(uint32_t), err));
        STP_TRY(pack_graph(out, &a->graphs[index], err));
    }
done:
    return status;
}

static stp_status take_cell(stp_cursor from, stp_cloud *cloud, uint64_t index,
                            const stp_surface_arrays *a, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cell *cell = &cloud->cells[index];
    const size_t count = cell->end - cell->begin;
    if (cloud->blocks)
        return a->graphs ? take_sizes(&from, &a->graphs[index], cloud->spill, err) : STP_OK;
    for (uint64_t i = cell->begin; i < cell->end; i++) {
        STP_TRY(stp_packet_take(&from, &cloud->points[i].normal, sizeof(vec3s), err));
        STP_TRY(stp_packet_take(&from, &cloud->points[i].spacing, sizeof(float), err));
    }
    STP_TRY(stp_packet_take(&from, cloud->marks + cell->begin, count, err));
    if (a->averaged)
        STP_TRY(stp_packet_take(&from, a->averaged + cell->begin, count * sizeof(vec3s), err));
    if (a->shifts)
        STP_TRY(stp_packet_take(&from, a->shifts + cell->begin, count * sizeof(vec3s), err));
    if (a->graphs) {
        STP_TRY(stp_packet_take(&from, cloud->sheets + cell->begin, count * sizeof(uint32_t), err));
        STP_TRY(take_graph(&from, &a->graphs[index], cloud->spill, err));
    }
done:
    return status;
}

stp_status stp_surface_share(stp_ranks *ranks, stp_cloud *cloud, const stp_surface_arrays *arrays,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_bytes packet = {0};
    for (unsigned rank = 0; rank < stp_ranks_count(ranks) && stp_ranks_count(ranks) > 1; rank++) {
        const stp_rank_part cells = stp_cloud_cells(cloud, ranks, rank);
        for (uint64_t c = cells.begin; c < cells.end; c++) {
            stp_spill_relieve(cloud->spill);
            if (rank == ranks->self)
                STP_TRY(pack_cell(&packet, cloud, c, arrays, err));
            STP_TRY(stp_ranks_broadcast_bytes(ranks, rank, &packet, err));
            if (rank != ranks->self)
                STP_TRY(take_cell((stp_cursor){packet.data, packet.size}, cloud, c, arrays, err));
        }
    }
done:
    free(packet.data);
    return status;
}

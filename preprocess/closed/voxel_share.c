/* Each rank gives what it set to all others. */
#include "preprocess/closed/voxel_share.h"

#include <stdlib.h>
#include <string.h>

stp_status stp_voxel_share_claims(stp_voxel_grid *grid, stp_ranks *ranks, stp_error *err)
{
    stp_status status = STP_OK;
    stp_bytes packet = {0};
    const size_t places = stp_voxel_place_count(grid);
    for (unsigned rank = 0; rank < stp_ranks_count(ranks) && stp_ranks_count(ranks) > 1; rank++) {
        packet.size = 0;
        for (uint32_t i = 0; rank == ranks->self && i < places; i++)
            if (stp_voxel_number(grid, i) != 0)
                STP_TRY(stp_bytes_append(&packet, &i, sizeof i, err));
        STP_TRY(stp_ranks_broadcast_bytes(ranks, rank, &packet, err));
        for (size_t at = 0; at < packet.size; at += sizeof(uint32_t)) {
            uint32_t place;
            int low[3], high[3];
            memcpy(&place, packet.data + at, sizeof place);
            stp_voxel_place_split(grid, place, low);
            for (int i = 0; i < 3; i++) {
                low[i] *= STP_VOXEL_BLOCK;
                high[i] = low[i];
            }
            stp_voxel_grid_claim(grid, low, high);
        }
    }
done:
    free(packet.data);
    return status;
}

static void add_rows(stp_voxel_bits *bits, const stp_voxel_bits *more)
{
    for (int z = 0; z < STP_VOXEL_BLOCK; z++)
        for (int y = 0; y < STP_VOXEL_BLOCK; y++)
            bits->row[z][y] |= more->row[z][y];
}

stp_status stp_voxel_share_occupied(stp_voxel_grid *grid, stp_ranks *ranks, stp_error *err)
{
    static const stp_voxel_bits none;
    stp_status status = STP_OK;
    stp_bytes own = {0}, packet = {0};
    stp_voxel_bits rows;
    for (uint32_t i = 0; stp_ranks_count(ranks) > 1 && i < grid->block_count; i++) {
        if (memcmp(&grid->occupied[i], &none, sizeof none) == 0)
            continue;
        STP_TRY(stp_bytes_append(&own, &i, sizeof i, err));
        STP_TRY(stp_bytes_append(&own, &grid->occupied[i], sizeof none, err));
    }
    for (unsigned rank = 0; rank < stp_ranks_count(ranks) && stp_ranks_count(ranks) > 1; rank++) {
        uint32_t block;
        packet.size = 0;
        if (rank == ranks->self)
            STP_TRY(stp_bytes_append(&packet, own.data, own.size, err));
        STP_TRY(stp_ranks_broadcast_bytes(ranks, rank, &packet, err));
        for (stp_cursor at = {packet.data, packet.size}; at.left > 0;) {
            STP_TRY(stp_packet_take(&at, &block, sizeof block, err));
            STP_TRY(stp_packet_take(&at, &rows, sizeof rows, err));
            add_rows(&grid->occupied[block], &rows);
        }
    }
done:
    free(packet.data);
    free(own.data);
    return status;
}

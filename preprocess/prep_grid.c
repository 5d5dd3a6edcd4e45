/* Grids of heights: what takes the place of the stages of points. If ranks share a grid, each reads
 * a part of the records, and makes leaves of some of the tiles. */
#include "preprocess/prep_grid.h"

#include "base/memory.h"
#include "formats/chunk/sample/normal_grid.h"
#include "preprocess/grid/grid_range.h"
#include "preprocess/prep_rejects.h"
#include "preprocess/surface/normal_error.h"
#include "preprocess/viewpoint/first_view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Bits of a grid's normals at most: 0.16 degrees. The heights tell them in any case. */
#define GRID_NORMAL_BITS 10u
/* Their heights, if they are floats, are off by at most the greatest of their noise, their range
 * and a cell's side over these. */
#define GRID_NOISE_PARTS 4.0
#define GRID_RANGE_PARTS 131072.0
#define GRID_CELL_PARTS 2048.0 /* 8 x 8 cells fit the 16 bits of a patch */
#define GRID_PLACE_PARTS 512.0 /* of a cell: samples of a bent grid are moved by no more */

/* Where the records of all files lie in the whole, file after file. */
static stp_status find_parts(const stp_prep_source *source, stp_grid_part **out, size_t *count,
                             stp_error *err)
{
    uint64_t first = 0;
    stp_grid_part *parts = NULL;
    const stp_status status = stp_alloc(&parts, source->file_count, sizeof *parts, "grids", err);
    if (status != STP_OK)
        return status;
    *count = 0;
    for (size_t i = 0; i < source->file_count; i++) {
        if (source->files[i].unreadable)
            continue;
        parts[*count] = stp_grid_part_at(&source->raster, &source->files[i].raster, first);
        first += parts[*count].count;
        ++*count;
    }
    *out = parts;
    return STP_OK;
}

stp_status stp_prep_no_grid(stp_error *err)
{
    return stp_error_set(err, STP_INVALID_ARGUMENT,
                         "--holes grow: the input does not stay one grid of heights, nor images of "
                         "pixels on rays, so nobody knows where samples are missing: leave it out");
}

stp_status stp_prep_grid_check(const stp_prep_job *job, stp_error *err)
{
    if (!job->params->holes_grow)
        return STP_OK;
    bool grids = job->stats->keeps_grid;
    for (size_t i = 0; i < job->source->file_count; i++)
        grids |= job->source->files[i].grid.columns > 0 || job->source->files[i].image_count > 0;
    return grids && !job->stats->makes_maps ? STP_OK : stp_prep_no_grid(err);
}

stp_status stp_prep_grid_begin(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_prep_source *source = job->source;
    const bool coloured = source->attributes & STP_POINT_HAS_COLOUR;
    stp_grid_part *parts = NULL;
    size_t count = 0;
    STP_TRY(stp_height_grid_create(&job->grid, &source->raster, source->raster_nodes, coloured,
                                   job->in_parts, job->spill, err));
    if (job->in_parts) {
        STP_TRY(find_parts(source, &parts, &count, err));
        return stp_grid_records_create(&job->grid_records, &source->raster, parts, count,
                                       job->records, source->raster_nodes, coloured, job->spill,
                                       err);
    }
    for (uint64_t i = 0;
         stp_prep_grid_has_parts(job) && i < source->raster.columns * (uint64_t)source->raster.rows;
         i++)
        stp_height_grid_leave_out(&job->grid, i);
done:
    return status;
}

void stp_prep_grid_clear(stp_prep_job *job)
{
    stp_height_grid_clear(&job->grid);
    stp_grid_part_clear(&job->part);
    stp_grid_records_clear(&job->grid_records);
}

/* Notes odd heights and where to look first. Errors: OUT_OF_MEMORY, IO, CANCELLED. */
static stp_status grid_look(stp_prep_job *job, stp_error *err)
{
    stp_prep_stats *stats = job->stats;
    stp_grid_range range;
    const stp_status status = stp_grid_range_measure(&range, &job->grid, job->params->ranks, err);
    if (status != STP_OK)
        return status;
    stp_first_view_of_heights(&stats->first, &job->grid.box, range.low, range.high, range.share,
                              job->source);
    for (int i = 0; i < 2; i++) {
        stats->odd_heights[i] = range.odd[i];
        stats->odd_shares[i] = range.odd_share[i];
    }
    return STP_OK;
}

bool stp_prep_grid_has_parts(const stp_prep_job *job)
{
    return job->stats->keeps_grid && job->source->file_count > 1 && !job->in_parts;
}

void stp_prep_grid_add(stp_prep_job *job, const stp_point *point, uint64_t record,
                       stp_reject *reject)
{
    stp_height_grid *grid = &job->grid;
    if (job->in_parts) {
        if (*reject == STP_REJECT_NONE)
            stp_grid_records_set(&job->grid_records, record, point);
        else
            stp_grid_records_leave_out(&job->grid_records, record);
        return;
    }
    const bool parts = stp_prep_grid_has_parts(job);
    const uint64_t place =
        parts ? stp_grid_part_place(&job->part, &grid->raster, record - job->part.first)
              : stp_scan_raster_place(&grid->raster, record);
    if (parts && *reject == STP_REJECT_NONE && !isnan(grid->z[place]))
        *reject = STP_REJECT_TWICE;
    if (*reject == STP_REJECT_NONE)
        stp_height_grid_set(grid, place, point);
    else if (!parts) /* else there is none unless a file gives it */
        stp_height_grid_leave_out(grid, place);
}

size_t stp_prep_grid_take(stp_prep_job *job, const stp_point *points, size_t count)
{
    stp_prep_stats *stats = job->stats;
    stp_height_grid *grid = &job->grid;
    const uint64_t most = job->source->point_count, first = stats->points_in;
    if (!stats->keeps_grid || job->in_parts || stp_prep_grid_has_parts(job) ||
        grid->raster.order != 0 || grid->xy || first >= most)
        return 0;
    const size_t taken =
        stp_height_grid_take(grid, first, points, count < most - first ? count : most - first);
    stp_dbox_join(&stats->box, &grid->box);
    stats->points_in += taken;
    return taken;
}

stp_status stp_prep_grid_sift(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    stp_prep_stats *stats = job->stats;
    stp_ranks *ranks = job->params->ranks;
    stp_bytes twice = {0};
    stp_dbox own = stp_dbox_empty();
    if (!stats->keeps_grid || !job->grid_records.overlap)
        return STP_OK;
    STP_TRY(stp_grid_records_sift(&job->grid_records, ranks, &twice, &own, err));
    uint64_t count = twice.size / sizeof(uint32_t);
    for (uint64_t i = 0; i < count; i++) {
        uint32_t record;
        memcpy(&record, twice.data + i * sizeof record, sizeof record);
        STP_TRY(stp_prep_reject(job, record, STP_REJECT_TWICE, err));
    }
    STP_TRY(stp_ranks_sum(ranks, &count, 1, err));
    stats->rejected[STP_REJECT_TWICE] += count;
    stats->points_out -= count;
    stats->box = stp_dbox_empty();
    for (unsigned rank = 0; rank < ranks->count; rank++) {
        stp_dbox box = own;
        STP_TRY(stp_ranks_broadcast(ranks, rank, &box, sizeof box, err));
        stp_dbox_join(&stats->box, &box);
    }
done:
    free(twice.data);
    return status;
}

/* Finds which rank makes the leaf of each tile. */
static stp_status find_owners(const stp_prep_job *job, uint32_t *owners, stp_error *err)
{
    stp_leaf_place *leaves = NULL;
    uint32_t count = 0;
    const stp_ranks *ranks = job->params->ranks;
    const stp_status status = stp_leaf_order(&job->cloud, &job->tree.sources, &leaves, &count, err);
    if (status != STP_OK)
        return status;
    for (uint32_t tile = 0; tile < stp_height_grid_tile_count(&job->grid); tile++)
        owners[tile] = STP_TILE_OF_NONE;
    for (unsigned rank = 0; rank < ranks->count; rank++) {
        const stp_rank_part part = stp_ranks_part(ranks, rank, count);
        for (uint64_t i = part.begin; i < part.end; i++)
            if (leaves[i].kind == STP_LEAF_TILE)
                owners[leaves[i].index] = rank;
    }
    free(leaves);
    return STP_OK;
}

/* Gives each rank the samples of the tiles that it will make leaves of. Errors: those of
 * stp_grid_records_give and stp_leaf_order. */
static stp_status grid_share(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = job->params->ranks;
    stp_height_grid *grid = &job->grid;
    uint32_t *owners = NULL;
    uint64_t most = 0;
    const uint32_t tiles = stp_height_grid_tile_count(grid);
    if (!job->in_parts)
        return STP_OK;
    STP_TRY(stp_grid_records_count(&job->grid_records, grid, ranks, err));
    grid->count = (uint32_t)job->stats->points_out;
    grid->box = job->stats->box;
    STP_TRY(stp_alloc(&owners, tiles, sizeof *owners, "tiles", err));
    STP_TRY(stp_alloc(&grid->own, tiles, sizeof *grid->own, "tiles", err));
    STP_TRY(find_owners(job, owners, err));
    for (uint32_t tile = 0; tile < tiles; tile++)
        grid->own[tile] = owners[tile] == ranks->self;
    for (unsigned rank = 0; rank < ranks->count; rank++)
        if (job->begins[rank + 1] - job->begins[rank] > most)
            most = job->begins[rank + 1] - job->begins[rank];
    STP_TRY(stp_grid_records_give(&job->grid_records, grid, owners, most, ranks, err));
    stp_grid_records_clear(&job->grid_records);
done:
    free(owners);
    return status;
}

void stp_prep_set_normal_bits(stp_prep_job *job, unsigned bits)
{
    job->stats->normal_bits = job->tree.normal_bits = bits;
    job->stats->normal_step = job->tree.normal_step = stp_normal_bits_step(bits);
}

unsigned stp_prep_grid_bits(unsigned bits)
{
    return bits < GRID_NORMAL_BITS ? bits : GRID_NORMAL_BITS;
}

void stp_prep_height_precision(stp_prep_job *job, double noise, double finest)
{
    const stp_dbox *box = &job->stats->box;
    const double told =
        fmax(noise / GRID_NOISE_PARTS, (box->max.z - box->min.z) / GRID_RANGE_PARTS);
    if (job->params->precision > 0.0 || job->source->coordinate_step > 0.0)
        return;
    job->tree.resolution.precision = fmax(told, finest);
    job->stats->resolution = job->tree.resolution;
}

stp_status stp_prep_treat_grid(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    stp_prep_stats *stats = job->stats;
    const unsigned wanted = job->params->normal_bits;
    const double cell = stp_raster_cell(&job->grid.raster, job->grid.nodes);
    job->tree.sources.grid = &job->grid;
    STP_TRY(grid_share(job, err));
    stats->each_has_all = stp_ranks_count(job->params->ranks) > 1 && !job->grid.own;
    STP_TRY(
        stp_height_grid_finish(&job->grid, job->source->coordinate_step, job->params->ranks, err));
    STP_TRY(grid_look(job, err));
    if (stats->holes_grow)
        STP_TRY(stp_height_grid_keep_open(&job->grid, job->params->ranks, err));
    stp_prep_height_precision(job, job->grid.noise, cell / GRID_CELL_PARTS);
    if (!(job->params->precision > 0.0 || job->params->exact))
        job->grid.move_most = cell / GRID_PLACE_PARTS;
    stats->normals_wide.normal_error = job->grid.normal_error;
    const unsigned bits = stp_normal_bits_for(job->grid.normal_error, false);
    stp_prep_set_normal_bits(job, wanted ? wanted : stp_prep_grid_bits(bits));
    stats->orientation = STP_ORIENTATION_FILE;
    STP_TRY(stp_prep_agree(job, "found another surface than", err));
    STP_TRY(stp_prep_end_stage(job, STP_STAGE_SURFACE, err));
done:
    return status;
}

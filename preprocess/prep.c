/* All of preprocessing: scans, lines and triangles in, one chunk file out. `run`, below, has the
 * stages in order; those of points are in prep_points.c, those of a grid in prep_grid.c. */
#include "preprocess/prep.h"

#include "base/clock.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/maps/maps_make.h"
#include "preprocess/prep_grid.h"
#include "preprocess/prep_intensity.h"
#include "preprocess/prep_metadata.h"
#include "preprocess/prep_points.h"
#include "preprocess/prep_read.h"
#include "preprocess/prep_read_part.h"
#include "preprocess/prep_shapes.h"

#include <math.h>
#include <stdlib.h>

#define DEFAULT_LAMBDA 1.7

uint32_t stp_prep_given(const stp_prep_source *source)
{
    uint32_t out = source->attributes & STP_POINT_HAS_COLOUR ? STP_HAS_COLOUR : 0u;
    out |= source->attributes & STP_POINT_HAS_INTENSITY ? STP_HAS_INTENSITY : 0u;
    out |= source->attributes & STP_POINT_HAS_CLASS ? STP_HAS_CLASS : 0u;
    return out;
}

static uint32_t attributes_of(const stp_prep_source *source, const stp_prep_stats *stats)
{
    uint32_t out = stp_prep_given(source);
    out |= stats->outliers == STP_OUTLIERS_MARK ? STP_HAS_OUTLIERS : 0u;
    out |= stats->lines.strips > 0 ? STP_HAS_LINES : 0u;
    out |= stats->triangles.triangles > 0 ? STP_HAS_TRIANGLES : 0u;
    const bool fits = source->attributes & STP_POINT_HAS_NORMAL || source->some_normals ||
                      stats->normals_wide.grown > 0 || stats->normals_seen > 0 || stats->keeps_grid;
    out |= fits ? STP_HAS_FITS : 0u;
    out |= stats->closed_count > 0 ? STP_HAS_CLOSED : 0u;
    return out;
}

const stp_dvec3 *stp_prep_stations(const stp_prep_job *job)
{
    const stp_prep_params *params = job->params;
    return params->orient == STP_ORIENT_POSITION ? &params->orient_position : job->source->stations;
}

static stp_status write_tree(stp_prep_job *job, stp_error *err)
{
    const stp_prep_source *source = job->source;
    const stp_prep_params *params = job->params;
    const stp_tree_params *tree = &job->tree;
    stp_prep_stats *stats = job->stats;
    stp_chunk_writer *writer = NULL;
    stp_chunk_writer_params out = {.force = params->force,
                                   .shared = stp_ranks_count(params->ranks) > 1,
                                   .codec = tree->codec,
                                   .attributes = attributes_of(source, stats),
                                   .orientation = stats->orientation,
                                   .lambda = tree->lambda};
    stp_status status = STP_OK;
    if (stp_ranks_is_first(params->ranks))
        status = stp_chunk_writer_create(&writer, job->path, &out, err);
    if (status != STP_OK)
        return status;
    stp_prep_facts about = {source,
                            stats,
                            stp_prep_stations(job),
                            &job->outside,
                            job->k,
                            tree->lambda,
                            params->maps ? params->maps->cone_deg : 0.0,
                            params->unlit};
    status = stp_tree_write(&writer, &job->cloud, tree, stp_prep_metadata, &about, job->pool,
                            job->progress, &stats->tree, err);
    stp_chunk_writer_destroy(&writer);
    return status;
}

/* A precision coarser than the limit of coordinates allows nothing more than the limit does, and
 * the error of a lattice that coarse would exceed what a file may say. */
static stp_resolution resolution_of(const stp_prep_source *source, const stp_prep_params *params)
{
    const double precision =
        params->precision > 0.0 ? params->precision : 0.5 * source->coordinate_step;
    return (stp_resolution){.step = source->coordinate_step,
                            .precision = fmin(precision, STP_COORDINATE_LIMIT),
                            .exact = params->exact,
                            .floats = source->floats};
}

void stp_prep_job_begin(stp_prep_job *job)
{
    const stp_prep_params *params = job->params;
    job->k = params->neighbour_count ? params->neighbour_count : STP_PREP_NEIGHBOURS;
    job->tree = (stp_tree_params){.lambda = params->lambda > 0.0 ? params->lambda : DEFAULT_LAMBDA,
                                  .resolution = resolution_of(job->source, params),
                                  .codec = params->format == 1 ? params->codec
                                                               : stp_codec_in_blocks(params->codec),
                                  .ranks = params->ranks};
    job->orient = (stp_orient_params){.mode = params->orient,
                                      .position = params->orient_position,
                                      .from_file = job->source->attributes & STP_POINT_HAS_NORMAL};
    *job->stats = (stp_prep_stats){.box = stp_dbox_empty(),
                                   .resolution = job->tree.resolution,
                                   .rank_count = params->ranks ? params->ranks->count : 0,
                                   .keeps_grid = stp_prep_size_of(job->source, params).grid,
                                   .holes_grow = params->holes_grow,
                                   .join_layers = params->join_layers,
                                   .makes_maps = params->maps != NULL,
                                   .fills_gaps = params->maps && params->maps->fill,
                                   .outliers = params->outliers,
                                   .outlier_distance = params->outlier_distance > 0.0
                                                           ? params->outlier_distance
                                                           : STP_OUTLIER_DISTANCE};
}

/* Attributes as the model keeps them: 255 in a sample stands for intensity_max. */
static void decide_attributes(stp_prep_job *job)
{
    const bool has_shapes = job->tree.sources.lines || job->tree.sources.triangles;
    if (!job->source->kept || job->source->kept->count == 0)
        return;
    job->kept = *job->source->kept;
    for (uint32_t i = 0; i < job->kept.count; i++) {
        stp_attribute *a = &job->kept.items[i];
        a->derived = a->coarse != STP_COARSE_NOT && !(job->unlike >> i & 1);
        if (a->coarse == STP_COARSE_INTENSITY) {
            a->coarse_scale *= job->stats->intensity_max / 255.0;
            /* Each number has an 8-bit step of its own, if there are 256 numbers or fewer. */
            a->derived = a->derived && a->coarse_scale < 1.0 + 1e-9 && !has_shapes &&
                         job->stats->intensity_greatest <= job->stats->intensity_max;
        }
    }
    job->tree.numbers = (stp_point_numbers){
        &job->kept, job->params->first_place + job->records.begin, job->numbers, job->begins};
}

static stp_status run(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    stp_prep_stats *stats = job->stats;
    STP_TRY(stp_prep_choose_parts(job, err));
    const stp_prep_size size = stp_prep_job_size(job);
    STP_TRY(stp_prep_plan_room(job, &size, err));
    if (job->params->planned)
        job->params->planned(&job->plan);
    STP_TRY(stp_prep_read(job, err));
    if (!job->in_parts)
        STP_TRY(stp_prep_agree(job, "read other points than", err));
    STP_TRY(stp_prep_cut_shapes(job, err));
    STP_TRY(stp_prep_end_stage(job, STP_STAGE_READ, err));
    if (stats->keeps_grid)
        STP_TRY(stp_prep_treat_grid(job, err));
    else if (stats->points_out > 0)
        STP_TRY(stp_prep_treat_points(job, err));
    STP_TRY(stp_prep_decide_intensity(job, err));
    decide_attributes(job);
    STP_TRY(write_tree(job, err));
    STP_TRY(stp_prep_end_stage(job, STP_STAGE_PATCHES, err));
    stats->temporary_bytes = stp_spill_most_file_bytes(job->spill);
done:
    return status;
}

stp_status stp_prep_run(const char *path, const stp_prep_source *source,
                        const stp_prep_params *params, stp_pool *pool, const stp_progress *progress,
                        stp_prep_stats *stats, stp_error *err)
{
    const double start = stp_clock_seconds();
    stp_prep_job job = {.path = path,
                        .source = source,
                        .params = params,
                        .pool = pool,
                        .progress = progress,
                        .stats = stats,
                        .since = start};
    stp_prep_job_begin(&job);
    stp_status status = stp_prep_check_count(source, params, err);
    if (status == STP_OK)
        status = stp_prep_grid_check(&job, err);
    if (status != STP_OK)
        return status;
    status = run(&job, err);
    stats->seconds = job.since - start;
    stp_outside_clear(&job.outside);
    stp_prep_clear_shapes(&job.shapes);
    stp_spill_free(job.spill, job.numbers);
    free(job.begins);
    free(job.rejects.data);
    stp_maps_clear(&job.maps);
    stp_cloud_clear(&job.cloud);
    stp_prep_grid_clear(&job);
    stp_spill_destroy(&job.spill);
    stp_prep_plan_clear(&job.plan);
    return status;
}

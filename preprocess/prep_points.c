/* The stages of points: from the stations that files claim to maps and images. */
#include "preprocess/prep_points.h"

#include "formats/chunk/sample/normal_grid.h"
#include "preprocess/closed/enclosure.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/cloud/scan_lines.h"
#include "preprocess/grid/depth_holes.h"
#include "preprocess/maps/maps_make.h"
#include "preprocess/orient/pixel_sheets.h"
#include "preprocess/prep_grid.h"
#include "preprocess/prep_outliers.h"
#include "preprocess/prep_read_part.h"
#include "preprocess/prep_shapes.h"
#include "preprocess/surface/image_normals.h"
#include "preprocess/surface/normal_error.h"
#include "preprocess/surface/scattered.h"
#include "preprocess/surface/surface.h"
#include "preprocess/viewpoint/claims.h"
#include "preprocess/viewpoint/first_view.h"

#include <limits.h>
#include <math.h>

/* Memory of a unit per point; the part of the memory for all units. */
#define UNIT_POINT_BYTES 448u
#define UNIT_ROOM 8u
#define UNIT_POINTS_MAX (4u * STP_CELL_POINTS)
#define POINTS_CELL_PARTS 512.0 /* of grids that become points: each coordinate costs bits */

void stp_prep_choose_stations(stp_prep_job *job)
{
    stp_orient_params *orient = &job->orient;
    const stp_prep_source *source = job->source;
    stp_prep_stats *stats = job->stats;
    bool named = source->attributes & STP_POINT_HAS_STATION || source->station_count > 0;
    bool wanted = orient->mode == STP_ORIENT_AUTO && !orient->from_file && named;
    if (orient->mode == STP_ORIENT_POSITION)
        stats->station_count = 1;
    if (wanted && stats->points_unstationed < stats->points_out) {
        orient->stations = source->stations;
        stats->station_count = source->station_count;
    } else if (!wanted || stats->stations_off > 0) {
        /* not asked for, or no file named a scanner and stations were only guessed */
        stats->points_unstationed = 0;
    }
}

/* Points of a unit: those of all threads must fit in memory beside everything else. */
static uint32_t unit_points(const stp_prep_job *job)
{
    const unsigned threads = stp_pool_thread_count(job->pool);
    const uint64_t lists = job->k > STP_PREP_NEIGHBOURS ? job->k / STP_PREP_NEIGHBOURS : 1;
    const uint64_t points = job->plan.memory_bytes / (UNIT_ROOM * UNIT_POINT_BYTES * threads);
    return (uint32_t)((points < UNIT_POINTS_MAX ? points : UNIT_POINTS_MAX) / lists);
}

stp_surface_params stp_prep_surface_params(const stp_prep_job *job)
{
    return (stp_surface_params){.k = job->k,
                                .pieces = !stp_orient_by_file(&job->orient),
                                .stations = stp_orient_stations(&job->orient),
                                .unit_points = unit_points(job),
                                .ranks = job->params->ranks};
}

/* Chooses the grids that normals are rounded to. */
static void choose_normal_bits(stp_prep_job *job)
{
    const unsigned wanted = job->params->normal_bits;
    const stp_surface_counts *found = &job->stats->normals_wide;
    const bool seen = job->stats->normals_seen > found->computed;
    const bool quiet = !seen && 2 * found->grown < found->computed;
    const double error = seen ? STP_IMAGE_NORMAL_ERROR : found->normal_error;
    job->tree.given_bits = wanted ? wanted : STP_NORMAL_BITS;
    stp_prep_set_normal_bits(job, wanted ? wanted : stp_normal_bits_for(error, quiet));
    if (!wanted && job->params->format != 1) /* which codes whole bits in fewer bytes */
        job->stats->normal_step = job->tree.normal_step = stp_normal_step_for(error, quiet);
}

/* The file does not tell the orientation if most of its normals are none: programs write zeros for
 * want of any. */
static stp_status check_given(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cloud *cloud = &job->cloud;
    const stp_rank_part own = stp_cloud_own(cloud);
    uint64_t given = 0;
    if (!job->orient.from_file)
        return STP_OK;
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i))
        given += cloud->points[i].given != STP_GIVEN_NOT;
    STP_TRY(stp_cloud_sum(cloud, &given, 1, err));
    job->orient.from_file = 2 * given > cloud->count;
done:
    return status;
}

/* Finds spacings, normals, their signs, and sheets. */
static stp_status find_surface(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    stp_graph *graphs = NULL;
    stp_cloud *cloud = &job->cloud;
    stp_prep_stats *stats = job->stats;
    const stp_surface_params params = stp_prep_surface_params(job);
    STP_TRY(stp_surface_find(&graphs, cloud, &params, &stats->normals_wide, job->pool,
                             job->progress, err));
    STP_TRY(stp_scattered_limit(cloud, err));
    choose_normal_bits(job);
    STP_TRY(stp_prep_end_stage(job, STP_STAGE_SURFACE, err));
    STP_TRY(stp_orientation_find(cloud, job->k, &graphs, &job->orient, job->pool,
                                 &stats->orientation, err));
    if (stats->orientation == STP_ORIENTATION_UNKNOWN)
        stats->station_count = 0; /* no normal was turned */
    if (stats->normals_seen > 0)
        STP_TRY(stp_pixel_sheets_join(cloud, job->source, err));
    STP_TRY(stp_prep_end_stage(job, STP_STAGE_ORIENTATION, err));
done:
    stp_surface_clear(&graphs, cloud);
    return status;
}

/* Finds points whose backs nobody sees. If signs were guessed, they are known only for these
 * points. */
static stp_status find_closed(stp_prep_job *job, stp_error *err)
{
    stp_prep_stats *stats = job->stats;
    bool guessed =
        stats->orientation == STP_ORIENTATION_PROPAGATED ||
        (stats->orientation == STP_ORIENTATION_MIXED && !stp_orient_stations(&job->orient));
    const stp_enclosure_params params = {
        .lambda = job->tree.lambda,
        .guessed = guessed,
        .ranks = job->params->ranks,
    };
    const stp_status status =
        stp_enclosure_find(&job->outside, &job->cloud, &params, job->pool, err);
    if (status != STP_OK)
        return status;
    stats->closed_count = job->outside.point_count;
    if (guessed)
        stats->orientation = stats->closed_count == 0                 ? STP_ORIENTATION_UNKNOWN
                             : stats->closed_count < job->cloud.count ? STP_ORIENTATION_MIXED
                                                                      : STP_ORIENTATION_PROPAGATED;
    return stp_prep_end_stage(job, STP_STAGE_CLOSED, err);
}

/* Lets normals of leaves that are grids have no more bits than these need. */
static void limit_normal_bits(stp_prep_job *job)
{
    const unsigned bits = job->tree.normal_bits;
    stp_prep_set_normal_bits(job, job->params->normal_bits == 0 ? stp_prep_grid_bits(bits) : bits);
}

/* Makes elevation maps of the surface. A sample's back counts as hidden if that of the nearest
 * point is. */
static stp_status make_maps(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    stp_prep_stats *stats = job->stats;
    stp_cloud *cloud = &job->cloud;
    if (!stats->makes_maps)
        return STP_OK;
    stp_maps_params params = *job->params->maps;
    if (!stats->join_layers) /* which moves the points off the faces */
        params.mesh = job->source->mesh;
    STP_TRY(stp_maps_make(&job->maps, cloud, &params, job->pool, job->progress, err));
    stats->maps = job->maps.counts;
    if (job->maps.count > 0) {
        STP_TRY(stp_map_leaves_create(&job->shapes.map_leaves, &job->maps, job->tree.lambda,
                                      &job->tree.resolution, err));
        job->tree.sources.maps = &job->shapes.map_leaves;
        limit_normal_bits(job);
        STP_TRY(stp_prep_fill_maps(job, err));
    }
    STP_TRY(stp_prep_end_stage(job, STP_STAGE_MAPS, err));
done:
    return status;
}

/* Depth cameras' images stay grids of pixels. */
static stp_status keep_images(stp_prep_job *job, stp_error *err)
{
    stp_depth_images *depths = &job->shapes.depths;
    const stp_point_item_params items = {.lambda = job->tree.lambda,
                                         .resolution = job->tree.resolution,
                                         .vertex_least = INT_MIN / 2};
    if (job->stats->makes_maps)
        return STP_OK;
    stp_status status = stp_depth_images_create(depths, &job->cloud, job->source,
                                                job->stats->normals_seen > 0, &items, err);
    if (status == STP_OK && job->stats->holes_grow)
        status = depths->leaf_count > 0 ? stp_depth_images_keep_open(depths, err)
                                        : stp_prep_no_grid(err);
    if (depths->leaf_count > 0) {
        job->stats->images = depths->image_count;
        job->stats->pixels_loose = depths->loose_count;
        for (size_t i = 0; i < depths->pixels.count; i++)
            job->stats->images_turned += depths->cameras[i].turned ? 1u : 0u;
        job->tree.sources.depths = depths;
        limit_normal_bits(job);
        const bool noisy = job->stats->normals_seen > 0 && job->params->normal_bits == 0;
        depths->least_bits = noisy ? STP_NORMAL_BITS_LEAST : job->tree.normal_bits;
    }
    return status;
}

/* The least cell, if all points are those of grids of heights; else 0. */
static double least_cell(const stp_prep_source *source)
{
    double cell = source->point_count > 0 ? INFINITY : 0.0;
    for (size_t i = 0; i < source->file_count; i++) {
        const stp_prep_file *f = &source->files[i];
        const bool is_grid = f->raster.columns > 0;
        cell = fmin(cell, is_grid ? stp_raster_cell(&f->raster, f->raster_nodes) : 0.0);
    }
    return cell;
}

stp_status stp_prep_treat_points(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    stp_prep_stats *stats = job->stats;
    const double cell = least_cell(job->source);
    if (cell > 0.0) /* grids that become points, since their cells differ or they are treated */
        stp_prep_height_precision(job, 0.0, cell / POINTS_CELL_PARTS);
    if (job->in_parts) {
        STP_TRY(stp_prep_sort_parts(job, err));
    } else {
        STP_TRY(stp_claims_check(&stats->first, &job->cloud, job->source, NULL, NULL, job->pool,
                                 stats, err));
        STP_TRY(stp_cloud_sort(&job->cloud, job->pool, err));
    }
    stats->each_has_all = stp_ranks_count(job->params->ranks) > 1 && !job->cloud.blocks;
    STP_TRY(stp_prep_end_stage(job, STP_STAGE_SORT, err));
    if (stats->join_layers) {
        const stp_surface_params surface = stp_prep_surface_params(job);
        STP_TRY(
            stp_layers_join(&stats->joined, &job->cloud, &surface, job->pool, job->progress, err));
        STP_TRY(stp_prep_end_stage(job, STP_STAGE_LAYERS, err));
    }
    if (stats->outliers != STP_OUTLIERS_KEEP) {
        STP_TRY(stp_prep_treat_outliers(job, err));
        STP_TRY(stp_prep_end_stage(job, STP_STAGE_OUTLIERS, err));
    }
    if (job->params->neighbour_count == 0) {
        STP_TRY(stp_scan_lines_choose(&job->k, STP_PREP_NEIGHBOURS, &job->cloud, err));
        stats->line_neighbours = job->k > STP_PREP_NEIGHBOURS ? job->k : 0;
    }
    STP_TRY(check_given(job, err));
    stp_prep_choose_stations(job);
    STP_TRY(find_surface(job, err));
    STP_TRY(find_closed(job, err));
    STP_TRY(stp_prep_agree(job, "found another surface than", err));
    STP_TRY(stp_first_view_of_points(&stats->first, &job->cloud, job->source, err));
    STP_TRY(make_maps(job, err));
    STP_TRY(keep_images(job, err));
done:
    return status;
}

/* All of preprocessing: scans, lines and triangles in, one chunk file out. */
#include "preprocess/prep.h"

#include "base/clock.h"
#include "base/memory.h"
#include "formats/chunk/normal_grid.h"
#include "preprocess/closed/enclosure.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/cloud/cloud_parts.h"
#include "preprocess/cloud/scan_lines.h"
#include "preprocess/grid/depth_holes.h"
#include "preprocess/maps/maps_make.h"
#include "preprocess/orient/pixel_sheets.h"
#include "preprocess/prep_job.h"
#include "preprocess/prep_metadata.h"
#include "preprocess/surface/image_normals.h"
#include "preprocess/surface/normal_error.h"
#include "preprocess/surface/scattered.h"
#include "preprocess/surface/surface.h"
#include "preprocess/viewpoint/claims.h"
#include "preprocess/viewpoint/first_view.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#define DEFAULT_LAMBDA 1.7
/* Memory of a unit per point; the part of the memory for all units. */
#define UNIT_POINT_BYTES 448u
#define UNIT_ROOM 8u
#define UNIT_POINTS_MAX (4u * STP_CELL_POINTS)
/* Bits of a grid's normals at most: 0.16 degrees. The heights tell them in any case. */
#define GRID_NORMAL_BITS 10u
/* Their heights, if they are floats, are off by at most the greatest of their noise, their range
 * and a cell's side over these. */
#define GRID_NOISE_PARTS 4.0
#define GRID_RANGE_PARTS 131072.0
#define GRID_CELL_PARTS 2048.0  /* 8 x 8 cells fit the 16 bits of a patch */
#define GRID_PLACE_PARTS 512.0  /* of a cell: samples of a bent grid are moved by no more */
#define POINTS_CELL_PARTS 512.0 /* of grids that become points: each coordinate costs bits */

const char *const stp_prep_stage_names[STP_PREP_STAGE_COUNT] = {
    "read", "sort", "layers", "outliers", "surface", "orientation", "closed", "maps", "patches"};

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
    const bool fits = source->attributes & STP_POINT_HAS_NORMAL || stats->normals_wide.grown > 0 ||
                      stats->normals_seen > 0 || stats->keeps_grid;
    out |= fits ? STP_HAS_FITS : 0u;
    out |= stats->closed_count > 0 ? STP_HAS_CLOSED : 0u;
    return out;
}

/* Whether a stage is left out in this run. */
static bool is_left_out(int stage, const stp_prep_stats *stats)
{
    return (stage == STP_STAGE_LAYERS && !stats->join_layers) ||
           (stage == STP_STAGE_OUTLIERS && stats->outliers == STP_OUTLIERS_KEEP) ||
           (stage == STP_STAGE_MAPS && !stats->makes_maps) ||
           (stats->keeps_grid && (stage == STP_STAGE_SORT || stage == STP_STAGE_ORIENTATION ||
                                  stage == STP_STAGE_CLOSED));
}

stp_status stp_prep_end_stage(stp_prep_job *job, int stage, stp_error *err)
{
    stp_prep_stats *stats = job->stats;
    double now = stp_clock_seconds();
    stats->stage_seconds[stage] = now - job->since;
    stats->stage_peak_bytes[stage] = stp_peak_rss_bytes();
    if (job->params->ranks) {
        stats->stage_sent_bytes[stage] = job->params->ranks->sent_bytes;
        job->params->ranks->sent_bytes = 0;
    }
    job->since = now;
    int next = stage + 1;
    while (is_left_out(next, stats))
        next++;
    if (next >= STP_PREP_STAGE_COUNT)
        return STP_OK;
    return stp_progress_update(job->progress, stp_prep_stage_names[next], 0, stats->points_out,
                               err);
}

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
    job->tree.normal_bits = wanted ? wanted : stp_normal_bits_for(error, quiet);
    job->stats->normal_bits = job->tree.normal_bits;
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

static unsigned grid_bits(unsigned bits)
{
    return bits < GRID_NORMAL_BITS ? bits : GRID_NORMAL_BITS;
}

/* Lets normals of leaves that are grids have no more bits than these need. */
static void limit_normal_bits(stp_prep_job *job)
{
    if (job->params->normal_bits == 0)
        job->tree.normal_bits = grid_bits(job->tree.normal_bits);
    job->stats->normal_bits = job->tree.normal_bits;
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

/* Heights that are floats have no step, and how far apart they are says little about how fine they
 * are: they keep a quarter of their noise and a 16th bit of their range, but no more than a part of
 * a cell: `finest`. */
static void choose_height_precision(stp_prep_job *job, double noise, double finest)
{
    const stp_dbox *box = &job->stats->box;
    const double told =
        fmax(noise / GRID_NOISE_PARTS, (box->max.z - box->min.z) / GRID_RANGE_PARTS);
    if (job->params->precision > 0.0 || job->source->coordinate_step > 0.0)
        return;
    job->tree.resolution.precision = fmax(told, finest);
    job->stats->resolution = job->tree.resolution;
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

/* The hash of an array by point; of nothing if there is none, or if ranks share it. */
static uint64_t hash_array(const stp_cloud *c, const void *array, size_t size)
{
    const bool here = array && !c->blocks;
    return XXH3_64bits(here ? (const char *)array + c->first * size : NULL,
                       here ? c->count * size : 0);
}

/* Fails unless the points, and what is known of them, are the same on all ranks: else their parts
 * would not fit together. Files may differ, or processors whose mathematics round otherwise. If
 * ranks share the points, the cells tell. */
static stp_status agree(const stp_prep_job *job, const char *what, stp_error *err)
{
    const stp_prep_stats *stats = job->stats;
    const stp_cloud *c = &job->cloud;
    const size_t numbers = job->numbers && !job->in_parts
                               ? stats->points_in * stp_attribute_list_bytes(job->source->kept)
                               : 0;
    if (!job->params->ranks)
        return STP_OK;
    const uint64_t found[] = {hash_array(c, c->points, sizeof *c->points),
                              hash_array(c, c->marks, sizeof *c->marks),
                              hash_array(c, c->sheets, sizeof *c->sheets),
                              XXH3_64bits(c->cells, c->cell_count * sizeof *c->cells),
                              XXH3_64bits(job->numbers, numbers),
                              XXH3_64bits(&stats->box, sizeof stats->box),
                              XXH3_64bits(&job->grid.noise, sizeof job->grid.noise),
                              stats->points_in};
    return stp_ranks_agree(job->params->ranks, XXH3_64bits(found, sizeof found), what, err);
}

/* Runs all stages from the stations that files claim to the first view. */
static stp_status treat_points(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    stp_prep_stats *stats = job->stats;
    const double cell = least_cell(job->source);
    if (cell > 0.0) /* grids that become points, since their cells differ or they are treated */
        choose_height_precision(job, 0.0, cell / POINTS_CELL_PARTS);
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
    STP_TRY(agree(job, "found another surface than", err));
    STP_TRY(stp_first_view_of_points(&stats->first, &job->cloud, job->source, err));
    STP_TRY(make_maps(job, err));
    STP_TRY(keep_images(job, err));
done:
    return status;
}

/* A grid's neighbours are known, so all stages up to the first view have nothing to find. */
static stp_status treat_grid(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    stp_prep_stats *stats = job->stats;
    const unsigned wanted = job->params->normal_bits;
    const double cell = stp_raster_cell(&job->grid.raster, job->grid.nodes);
    job->tree.sources.grid = &job->grid;
    STP_TRY(stp_prep_grid_share(job, err));
    stats->each_has_all = stp_ranks_count(job->params->ranks) > 1 && !job->grid.own;
    STP_TRY(
        stp_height_grid_finish(&job->grid, job->source->coordinate_step, job->params->ranks, err));
    STP_TRY(stp_prep_grid_look(job, err));
    if (stats->holes_grow)
        STP_TRY(stp_height_grid_keep_open(&job->grid, job->params->ranks, err));
    choose_height_precision(job, job->grid.noise, cell / GRID_CELL_PARTS);
    if (!(job->params->precision > 0.0 || job->params->exact))
        job->grid.move_most = cell / GRID_PLACE_PARTS;
    stats->normals_wide.normal_error = job->grid.normal_error;
    const unsigned bits = stp_normal_bits_for(job->grid.normal_error, false);
    job->tree.normal_bits = wanted ? wanted : grid_bits(bits);
    stats->normal_bits = job->tree.normal_bits;
    stats->orientation = STP_ORIENTATION_FILE;
    STP_TRY(agree(job, "found another surface than", err));
    STP_TRY(stp_prep_end_stage(job, STP_STAGE_SURFACE, err));
done:
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
        STP_TRY(agree(job, "read other points than", err));
    STP_TRY(stp_prep_cut_shapes(job, err));
    STP_TRY(stp_prep_end_stage(job, STP_STAGE_READ, err));
    if (stats->keeps_grid)
        STP_TRY(treat_grid(job, err));
    else if (stats->points_out > 0)
        STP_TRY(treat_points(job, err));
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

/* Adds points to a model: the order of the stages. */
#include "preprocess/append/append_job.h"

#include "base/clock.h"
#include "base/memory.h"
#include "formats/chunk/attribute/attribute_file.h"
#include "formats/chunk/sample/normal_grid.h"
#include "formats/chunk/verify/verify_tree.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/prep_grid.h"
#include "preprocess/prep_points.h"
#include "preprocess/prep_read.h"
#include "preprocess/prep_shapes.h"
#include "preprocess/surface/scattered.h"
#include "preprocess/surface/surface.h"
#include "preprocess/viewpoint/claims.h"

#include <stdlib.h>
#include <string.h>

/* ---- the model ---- */

/* Why points cannot be added to the model, or NULL. */
static const char *refusal(const stp_append *a)
{
    const stp_chunk_file_info *info = a->info;
    if (info->version_major < 2)
        return "it is of version 1, which cannot grow: convert it first (stipple convert "
               "--format 2)";
    if (stp_chunk_file_is_newer(info->version_major, info->version_minor))
        return "it is newer than this program: use a newer stipple";
    if (info->attributes & (STP_HAS_LINES | STP_HAS_TRIANGLES))
        return "it has lines or triangles: prepare all inputs at once";
    return stp_append_refusal(info);
}

/* All leaves must have one depth, as prep makes them. */
static stp_status find_leaves(stp_append *a, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = a->info->chunk_count;
    STP_TRY(stp_alloc(&a->entries, count, sizeof *a->entries, "directory", err));
    for (uint32_t id = 0; id < count; id++)
        STP_TRY(stp_chunk_file_entry(a->file, id, &a->entries[id], err));
    STP_TRY(stp_verify_tree_entries(a->file, a->entries, err));
    a->first_leaf = count;
    for (uint32_t id = count; id-- > 0 && a->entries[id].depth + 1u == a->info->depth;)
        a->first_leaf = id;
    a->leaf_count = count - a->first_leaf;
    for (uint32_t id = 0; id < count && status == STP_OK; id++)
        if ((a->entries[id].child_count == 0) != (id >= a->first_leaf) ||
            (a->entries[id].child_count > 0 && !(a->entries[id].flags & STP_CHUNK_LINKED)))
            status = stp_error_set(err, STP_UNSUPPORTED,
                                   "%s: points cannot be added: its chunks are not linked, or its "
                                   "leaves not of one depth: prepare all inputs at once",
                                   a->job.path);
done:
    return status;
}

static stp_status open_model(stp_append *a, stp_error *err)
{
    stp_status status = STP_OK;
    stp_attribute_file *attributes = NULL;
    STP_TRY(stp_output_reopen(&a->output, a->job.path, err));
    STP_TRY(stp_chunk_file_open(&a->file, a->job.path, err));
    a->info = stp_chunk_file_get_info(a->file);
    const char *why = refusal(a);
    if (why) {
        status =
            stp_error_set(err, STP_UNSUPPORTED, "%s: points cannot be added: %s", a->job.path, why);
        goto done;
    }
    STP_TRY(stp_attribute_file_open(&attributes, a->file, err));
    if (stp_attribute_file_list(attributes)->count > 0) {
        status = stp_error_set(err, STP_UNSUPPORTED,
                               "%s: points cannot be added: it has attributes: prepare all inputs "
                               "at once, or make a model without (stipple convert "
                               "--drop-attributes)",
                               a->job.path);
        goto done;
    }
    STP_TRY(find_leaves(a, err));
    a->result->points_before = a->info->point_count;
    a->result->leaf_count = a->leaf_count;
done:
    stp_attribute_file_close(&attributes);
    return status;
}

/* ---- what the model decides ---- */

static void take_parameters(stp_append *a)
{
    stp_tree_params *tree = &a->job.tree;
    tree->lambda = a->info->lambda;
    tree->codec = stp_codec_in_blocks((stp_codec)a->entries[0].codec);
    a->job.stats->keeps_grid = false;
}

/* Brings intensities to the model's scale: what is greater becomes its greatest. */
static void limit_intensity(stp_append *a)
{
    stp_cloud *cloud = &a->job.cloud;
    const double model = stp_append_noted(a, "intensity_max");
    a->job.tree.intensity_max = a->job.stats->intensity_max;
    if (!(a->info->attributes & STP_HAS_INTENSITY) || !(model >= 1.0 && model <= 65535.0))
        return;
    const uint16_t greatest = (uint16_t)model;
    a->job.tree.intensity_max = greatest;
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i))
        if (cloud->points[i].intensity > greatest)
            cloud->points[i].intensity = greatest;
}

static void take_normal_bits(stp_append *a)
{
    stp_prep_job *job = &a->job;
    const double model = stp_append_noted(a, "normal_bits");
    const unsigned wanted = job->params->normal_bits;
    const bool told = model >= STP_NORMAL_BITS_LEAST && model <= STP_NORMAL_BITS;
    job->tree.given_bits = wanted ? wanted : STP_NORMAL_BITS;
    stp_prep_set_normal_bits(job, wanted ? wanted : told ? (unsigned)model : STP_NORMAL_BITS);
    const double step = stp_append_noted(a, "normal_step"), finer = job->tree.normal_step;
    if (!wanted && told && step > finer && step < 2.0 * finer)
        job->stats->normal_step = job->tree.normal_step = (unsigned)step;
}

/* ---- stages ---- */

static stp_status read_points(stp_append *a, stp_error *err)
{
    stp_status status = STP_OK;
    stp_prep_job *job = &a->job;
    const stp_prep_source *source = job->source;
    const stp_prep_size size = {.points = source->point_count};
    double side = 0.0;
    if (source->point_count >= UINT32_MAX - 1)
        return stp_error_set(err, STP_LIMIT,
                             "%s: more than %u points cannot be appended at a time: append them in "
                             "several runs",
                             source->files[0].name, UINT32_MAX - 2);
    STP_TRY(stp_prep_plan_room(job, &size, err));
    STP_TRY(stp_prep_read(job, err));
    STP_TRY(stp_prep_side(&side, source, job->stats, err));
    limit_intensity(a);
    a->read_count = (uint32_t)job->stats->points_in;
    STP_TRY(
        stp_spill_alloc(job->spill, &a->leaf_of, a->read_count, sizeof *a->leaf_of, "points", err));
    STP_TRY(stp_claims_check(&job->stats->first, &job->cloud, source, NULL, NULL, job->pool,
                             job->stats, err));
    STP_TRY(stp_prep_end_stage(job, STP_STAGE_READ, err));
done:
    return status;
}

/* Joins what the model says of its normals with what was found for the new points. */
static stp_orientation joined_orientation(const stp_append *a)
{
    const stp_cloud *cloud = &a->job.cloud;
    uint64_t known = 0, all = 0;
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i))
        if (cloud->points[i].source < a->read_count) {
            all++;
            known += cloud->marks[i] & STP_MARK_ORIENTED ? 1 : 0;
        }
    if (known == all && a->info->orientation == a->job.stats->orientation)
        return a->info->orientation;
    if (known == 0 && a->info->orientation == STP_ORIENTATION_UNKNOWN)
        return STP_ORIENTATION_UNKNOWN;
    return known == all && a->info->orientation == STP_ORIENTATION_PROPAGATED
               ? STP_ORIENTATION_PROPAGATED
               : STP_ORIENTATION_MIXED;
}

static stp_status find_surface(stp_append *a, stp_error *err)
{
    stp_status status = STP_OK;
    stp_prep_job *job = &a->job;
    stp_graph *graphs = NULL;
    const stp_surface_params params = stp_prep_surface_params(job);
    const bool by_file = stp_orient_by_file(&job->orient);
    STP_TRY(stp_surface_find(&graphs, &job->cloud, &params, &job->stats->normals_wide, job->pool,
                             job->progress, err));
    STP_TRY(stp_scattered_limit(&job->cloud, err));
    take_normal_bits(a);
    STP_TRY(stp_prep_end_stage(job, STP_STAGE_SURFACE, err));
    STP_TRY(stp_orientation_find(&job->cloud, job->k, &graphs, &job->orient, job->pool,
                                 &job->stats->orientation, err));
    if (!by_file && job->orient.mode != STP_ORIENT_NONE)
        STP_TRY(stp_append_sign(a, stp_orient_stations(&job->orient) == NULL, err));
    job->stats->orientation = joined_orientation(a);
    STP_TRY(stp_prep_end_stage(job, STP_STAGE_ORIENTATION, err));
done:
    stp_surface_clear(&graphs, &job->cloud);
    return status;
}

static stp_status run(stp_append *a, stp_error *err)
{
    stp_status status = STP_OK;
    stp_prep_job *job = &a->job;
    STP_TRY(open_model(a, err));
    take_parameters(a);
    STP_TRY(read_points(a, err));
    STP_TRY(stp_append_find(a, err));
    STP_TRY(stp_append_gather(a, err));
    STP_TRY(stp_cloud_sort(&job->cloud, job->pool, err));
    STP_TRY(stp_prep_end_stage(job, STP_STAGE_SORT, err));
    stp_prep_choose_stations(job);
    STP_TRY(find_surface(a, err));
    STP_TRY(stp_append_cut(a, err));
    for (uint32_t i = 0; i < a->leaf_count; i++)
        a->result->touched_leaves += a->touched[i];
    STP_TRY(stp_append_write(a, err));
    STP_TRY(stp_prep_end_stage(job, STP_STAGE_PATCHES, err));
    job->stats->temporary_bytes = stp_spill_most_file_bytes(job->spill);
done:
    return status;
}

static void clear(stp_append *a)
{
    stp_prep_job *job = &a->job;
    /* until the points are gathered, what is known of them lies where they were read */
    stp_spill_free(a->read_spill ? a->read_spill : job->spill, a->leaf_of);
    stp_spill_free(job->spill, a->old);
    stp_cloud_clear(&job->cloud);
    stp_spill_free(a->read_spill ? a->read_spill : job->spill, job->numbers);
    stp_spill_destroy(&a->read_spill);
    stp_spill_destroy(&job->spill);
    stp_prep_plan_clear(&job->plan);
    free(a->cell_leaf);
    free(a->touched);
    free(a->entries);
    stp_chunk_file_close(&a->file);
    stp_output_destroy(&a->output);
}

stp_status stp_append_run(const char *path, const stp_prep_source *source,
                          const stp_prep_params *params, stp_pool *pool,
                          const stp_progress *progress, stp_prep_stats *stats,
                          stp_append_result *result, stp_error *err)
{
    const double start = stp_clock_seconds();
    stp_append a = {.result = result,
                    .job = {.path = path,
                            .source = source,
                            .params = params,
                            .pool = pool,
                            .progress = progress,
                            .stats = stats,
                            .since = start}};
    *result = (stp_append_result){0};
    stp_prep_job_begin(&a.job);
    if ((source->lines && source->lines->strip_count > 0) ||
        (source->triangles && source->triangles->triangle_count > 0))
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: only points can be added to a model, and it has lines or "
                             "triangles: prepare all inputs at once",
                             source->files[0].name);
    if (source->point_count >= UINT32_MAX - 1)
        return stp_error_set(err, STP_LIMIT, "%s: more than %u points: append them in several runs",
                             source->files[0].name, UINT32_MAX - 1);
    stp_status status = run(&a, err);
    stats->seconds = a.job.since - start;
    clear(&a);
    return status;
}

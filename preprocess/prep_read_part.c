/* Reads the points of a source by several ranks, a part each. */
#include "preprocess/prep_read_part.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/cloud/cloud_parts.h"
#include "preprocess/prep_grid.h"
#include "preprocess/prep_rejects.h"
#include "preprocess/viewpoint/claims.h"

#include <stdlib.h>
#include <string.h>

/* What a rank read. */
typedef struct part_counts {
    uint64_t in, stored, unstationed, rejected[STP_REJECT_COUNT], unlike;
    stp_dbox box;
    uint32_t intensity_max;
    uint32_t failed; /* 1: its part could not be read */
} part_counts;

stp_status stp_prep_choose_parts(stp_prep_job *job, stp_error *err)
{
    const stp_prep_source *source = job->source;
    stp_status status = STP_OK;
    stp_ranks *ranks = job->params->ranks;
    const uint64_t first = job->params->first_place;
    job->lists_rejects = source->rejected;
    job->in_parts = stp_ranks_count(ranks) > 1 && source->part_begin;
    STP_TRY(stp_ranks_broadcast(ranks, 0, &job->lists_rejects, sizeof job->lists_rejects, err));
    if (!job->in_parts)
        return STP_OK;
    STP_TRY(stp_alloc(&job->begins, (size_t)ranks->count + 1, sizeof *job->begins, "ranks", err));
    for (unsigned rank = 0; rank < ranks->count; rank++)
        job->begins[rank] =
            first + source->part_begin(source->context, source->point_count * rank / ranks->count);
    job->begins[ranks->count] = first + source->point_count;
done:
    return status;
}

stp_prep_size stp_prep_job_size(const stp_prep_job *job)
{
    const stp_prep_source *source = job->source;
    stp_prep_size size = stp_prep_size_of(source, job->params);
    size.shared = job->in_parts;
    if (job->in_parts) {
        const uint64_t *own = job->begins + job->params->ranks->self;
        size.read = own[1] - own[0];
    }
    return size;
}

/* Puts what all ranks read into the statistics. *failed: one of them could not read its part. */
static stp_status add_up(stp_prep_job *job, const part_counts *own, bool *failed, stp_error *err)
{
    stp_status status = STP_OK;
    stp_prep_stats *stats = job->stats;
    stp_ranks *ranks = job->params->ranks;
    stats->points_in = 0;
    *failed = false;
    for (unsigned rank = 0; rank < ranks->count; rank++) {
        part_counts part = *own;
        STP_TRY(stp_ranks_broadcast(ranks, rank, &part, sizeof part, err));
        stats->points_in += part.in;
        stats->points_out += part.stored;
        stats->points_unstationed += rank == ranks->self ? 0 : part.unstationed;
        for (int i = 0; i < STP_REJECT_COUNT; i++)
            stats->rejected[i] += rank == ranks->self ? 0 : part.rejected[i];
        stp_dbox_join(&stats->box, &part.box);
        if (part.intensity_max > stats->intensity_max)
            stats->intensity_max = (uint16_t)part.intensity_max;
        job->unlike |= part.unlike;
        *failed = *failed || part.failed;
    }
done:
    return status;
}

/* Gives the pixels that points tell to all ranks. */
static stp_status share_pixels(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = job->params->ranks;
    uint32_t *pixels = job->cloud.pixels;
    for (unsigned rank = 0; pixels && rank < ranks->count; rank++)
        STP_TRY(stp_ranks_broadcast(
            ranks, rank, pixels + job->begins[rank] - job->params->first_place,
            (size_t)(job->begins[rank + 1] - job->begins[rank]) * sizeof *pixels, err));
done:
    return status;
}

stp_status stp_prep_read_part(stp_prep_job *job, stp_status (*read)(stp_prep_job *, stp_error *),
                              stp_error *err)
{
    stp_status status = STP_OK;
    bool failed = false;
    stp_error why = {0};
    stp_prep_stats *stats = job->stats;
    const stp_prep_source *source = job->source;
    const stp_ranks *ranks = job->params->ranks;
    const stp_prep_stats before = *stats;
    const uint64_t first = job->params->first_place;
    const uint64_t begin = job->begins[ranks->self] - first;
    const uint64_t end = job->begins[ranks->self + 1] - first;
    STP_TRY(stp_prep_make_room(job, begin, end, err));
    stats->points_in = begin; /* numbers the records */
    status = source->read_part(source->context, begin, end, &why);
    if (status == STP_OK && stats->keeps_grid) /* files now have the counts of their headers */
        status = stp_prep_grid_begin(job, &why);
    if (status == STP_OK)
        status = read(job, &why);
    if (status == STP_CANCELLED)
        return stp_error_set(err, status, "%s", why.message);
    part_counts own = {.in = stats->points_in - begin,
                       .stored = job->cloud.count + job->grid_records.count,
                       .unstationed = stats->points_unstationed,
                       .box = stats->box,
                       .intensity_max = stats->intensity_max,
                       .unlike = job->unlike,
                       .failed = status != STP_OK || stats->points_in != end};
    for (int i = 0; i < STP_REJECT_COUNT; i++)
        own.rejected[i] = stats->rejected[i];
    STP_TRY(add_up(job, &own, &failed, err));
    if (!failed) {
        STP_TRY(share_pixels(job, err));
        STP_TRY(stp_prep_grid_sift(job, err));
        return stp_prep_give_rejects(job, err);
    }
    *stats = before;
    stp_cloud_clear(&job->cloud);
    stp_prep_grid_clear(job);
    stp_spill_free(job->spill, job->numbers);
    free(job->begins);
    job->rejects.size = 0;
    job->numbers = NULL;
    job->begins = NULL;
    job->unlike = 0;
    job->in_parts = false;
    stp_spill_destroy(&job->spill);
    const stp_prep_size size = stp_prep_job_size(job);
    STP_TRY(stp_prep_plan_room(job, &size, err));
    STP_TRY(stp_prep_make_room(job, 0, source->point_count, err));
    STP_TRY(source->read_part(source->context, 0, UINT64_MAX, err));
    if (stats->keeps_grid)
        STP_TRY(stp_prep_grid_begin(job, err));
    STP_TRY(read(job, err));
done:
    return status;
}

/* Checks the claims of the files that this rank read, and adds up what all ranks found. */
static stp_status check_claims(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    stp_prep_stats *stats = job->stats;
    stp_ranks *ranks = job->params->ranks;
    const stp_prep_stats before = *stats;
    stp_first_camera first = {0};
    STP_TRY(stp_claims_check(&first, &job->cloud, job->source, ranks, job->begins, job->pool, stats,
                             err));
    uint64_t found[] = {stats->points_unstationed - before.points_unstationed, stats->stations_off,
                        stats->stations_refused, stats->normals_seen};
    STP_TRY(stp_ranks_sum(ranks, found, sizeof found / sizeof *found, err));
    stats->points_unstationed = before.points_unstationed + found[0];
    stats->stations_off = (uint32_t)found[1];
    stats->stations_refused = (uint32_t)found[2];
    stats->normals_seen = found[3];
    for (unsigned rank = 0; rank < ranks->count; rank++) {
        stp_first_camera other = first;
        STP_TRY(stp_ranks_broadcast(ranks, rank, &other, sizeof other, err));
        if (stats->first.why == STP_FIRST_WHOLE)
            stats->first = other;
    }
done:
    return status;
}

stp_status stp_prep_sort_parts(stp_prep_job *job, stp_error *err)
{
    const stp_status status = check_claims(job, err);
    return status == STP_OK ? stp_cloud_sort_parts(&job->cloud, job->params->ranks, job->pool, err)
                            : status;
}

/* Reads the points of a source by several ranks, a part each. */
#include "preprocess/prep_job.h"

/* What a rank read. */
typedef struct part_counts {
    uint64_t in, stored, unstationed, rejected[STP_REJECT_COUNT];
    stp_dbox box;
    uint32_t intensity_max;
    uint32_t failed; /* 1: its part could not be read */
} part_counts;

stp_status stp_prep_choose_parts(stp_prep_job *job, stp_error *err)
{
    const stp_prep_source *source = job->source;
    stp_ranks *ranks = job->params->ranks;
    job->in_parts = stp_ranks_count(ranks) > 1 && source->part_begin && !job->stats->keeps_grid &&
                    !(source->kept && source->kept->count > 0) && !job->params->maps;
    for (size_t f = 0; f < source->file_count; f++)
        job->in_parts = job->in_parts && source->files[f].station_count != 1 &&
                        source->files[f].grid.columns == 0;
    /* only rank 0 writes a list of rejects */
    return stp_ranks_broadcast(ranks, 0, &job->in_parts, sizeof job->in_parts, err);
}

/* Where the part of a rank begins. */
static uint64_t begin_of(const stp_prep_source *source, const stp_ranks *ranks, unsigned rank)
{
    const uint64_t count = source->point_count;
    return rank == ranks->count ? count
                                : source->part_begin(source->context, count * rank / ranks->count);
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
        *failed = *failed || part.failed;
    }
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
    const uint64_t begin = begin_of(source, ranks, ranks->self);
    const uint64_t end = begin_of(source, ranks, ranks->self + 1);
    const stp_prep_stats before = *stats;
    STP_TRY(stp_cloud_create(&job->cloud, (uint32_t)(end - begin), job->spill, err));
    stats->points_in = begin; /* numbers the records */
    status = source->read_part(source->context, begin, end, &why);
    if (status == STP_OK)
        status = read(job, &why);
    if (status == STP_CANCELLED)
        return stp_error_set(err, status, "%s", why.message);
    part_counts own = {.in = stats->points_in - begin,
                       .stored = job->cloud.count,
                       .unstationed = stats->points_unstationed,
                       .box = stats->box,
                       .intensity_max = stats->intensity_max,
                       .failed = status != STP_OK || stats->points_in != end};
    for (int i = 0; i < STP_REJECT_COUNT; i++)
        own.rejected[i] = stats->rejected[i];
    STP_TRY(add_up(job, &own, &failed, err));
    if (!failed)
        return STP_OK;
    *stats = before;
    stp_cloud_clear(&job->cloud);
    job->in_parts = false;
    STP_TRY(stp_cloud_create(&job->cloud, (uint32_t)source->point_count, job->spill, err));
    STP_TRY(source->read_part(source->context, 0, UINT64_MAX, err));
    STP_TRY(read(job, err));
done:
    return status;
}

/* Marks or drops outliers. */
#include "preprocess/prep_outliers.h"

#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/prep_read.h"
#include "preprocess/prep_rejects.h"

/* Counts the stored points again after some were removed. */
static stp_status recount(const stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cloud *cloud = &job->cloud;
    stp_prep_stats *stats = job->stats;
    const stp_rank_part own = stp_cloud_own(cloud);
    stats->points_out = cloud->count;
    stats->points_unstationed = 0;
    stats->intensity_max = 0;
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i))
        stp_prep_count(stats, &cloud->points[i]);
    STP_TRY(stp_cloud_sum(cloud, &stats->points_unstationed, 1, err));
    const uint16_t intensity_max = stats->intensity_max;
    for (unsigned rank = 0; rank < stp_ranks_count(job->params->ranks); rank++) {
        uint16_t other = intensity_max;
        STP_TRY(stp_ranks_broadcast(job->params->ranks, rank, &other, sizeof other, err));
        stats->intensity_max = other > stats->intensity_max ? other : stats->intensity_max;
    }
done:
    return status;
}

stp_status stp_prep_treat_outliers(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud *cloud = &job->cloud;
    stp_prep_stats *stats = job->stats;
    uint64_t count = 0, own = 0, *sources = NULL;
    STP_TRY(stp_outliers_find(cloud, job->k, stats->outlier_distance, job->pool, job->progress,
                              &count, err));
    stats->outlier_count = count;
    if (stats->outliers == STP_OUTLIERS_DROP && count > 0) {
        STP_TRY(stp_outliers_drop(cloud, count, job->pool, &sources, &own, err));
        stats->rejected[STP_REJECT_OUTLIER] = count;
        /* if all points are on every rank, rank 0 tells of all */
        const bool tells = cloud->blocks || stp_ranks_is_first(job->params->ranks);
        for (uint64_t i = 0; tells && i < own; i++)
            STP_TRY(stp_prep_reject(job, sources[i], STP_REJECT_OUTLIER, err));
        if (job->in_parts)
            STP_TRY(stp_prep_give_rejects(job, err));
        STP_TRY(recount(job, err));
    }
done:
    stp_spill_free(cloud->spill, sources);
    return status;
}

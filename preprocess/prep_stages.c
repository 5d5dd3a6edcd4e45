/* The ends of stages: their times and memory, and whether all ranks found the same. */
#include "preprocess/prep_job.h"

#include "base/clock.h"
#include "preprocess/cloud/cloud_blocks.h"

#include <xxhash.h>

const char *const stp_prep_stage_names[STP_PREP_STAGE_COUNT] = {
    "read", "sort", "layers", "outliers", "surface", "orientation", "closed", "maps", "patches"};

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

/* The hash of an array by point; of nothing if there is none, or if ranks share it. */
static uint64_t hash_array(const stp_cloud *c, const void *array, size_t size)
{
    const bool here = array && !c->blocks;
    return XXH3_64bits(here ? (const char *)array + c->first * size : NULL,
                       here ? c->count * size : 0);
}

stp_status stp_prep_agree(const stp_prep_job *job, const char *what, stp_error *err)
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

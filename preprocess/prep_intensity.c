/* Decides what 255 stands for in a sample's intensity. */
#include "preprocess/prep_intensity.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_blocks.h"

#include <stdlib.h>

/* Reflectors, signs and wet metal are many times as bright as everything else, and would leave it
 * a few of 255 steps. If the greatest is more than BRIGHT_TIMES what all but a BRIGHT_SHARE of the
 * points reach, ROOM_TIMES that is what 255 stands for. */
#define BRIGHT_SHARE 0.01
#define BRIGHT_TIMES 4u
#define ROOM_TIMES 2u
#define LOOKED_AT 65536u
/* Sources of 8 bits keep their steps. */
#define FULL_8_BIT 255.0

static int by_value(const void *a, const void *b)
{
    const uint16_t x = *(const uint16_t *)a, y = *(const uint16_t *)b;
    return (x > y) - (x < y);
}

/* What all but a BRIGHT_SHARE of the points reach. */
static stp_status usual_of(const stp_cloud *cloud, uint32_t *usual, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud_point *points = NULL;
    uint16_t *values = NULL;
    uint32_t count = 0;
    STP_TRY(stp_cloud_every(cloud, cloud->count / LOOKED_AT + 1, &points, &count, err));
    STP_TRY(stp_alloc(&values, count, sizeof *values, "intensities", err));
    for (uint32_t i = 0; i < count; i++)
        values[i] = points[i].intensity;
    qsort(values, count, sizeof *values, by_value);
    *usual = values[count - 1 - (uint32_t)(BRIGHT_SHARE * (count - 1))];
done:
    free(values);
    free(points);
    return status;
}

stp_status stp_prep_decide_intensity(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    stp_prep_stats *stats = job->stats;
    const stp_leaf_sources *from = &job->tree.sources;
    const double full = job->source->intensity_full;
    const bool points_only = !from->lines && !from->triangles && !stats->keeps_grid;
    uint32_t usual = 0;
    if (from->lines && from->lines->intensity_max > stats->intensity_max)
        stats->intensity_max = from->lines->intensity_max;
    if (from->triangles && from->triangles->intensity_max > stats->intensity_max)
        stats->intensity_max = from->triangles->intensity_max;
    stats->intensity_greatest = stats->intensity_max;
    if (points_only && job->cloud.count > 0 && stats->intensity_max > 0 &&
        !(full > 0.0 && full <= FULL_8_BIT))
        STP_TRY(usual_of(&job->cloud, &usual, err));
    if (usual > 0 && stats->intensity_max > BRIGHT_TIMES * usual)
        stats->intensity_max = (uint16_t)(ROOM_TIMES * usual);
    job->tree.intensity_max = stats->intensity_max;
done:
    return status;
}

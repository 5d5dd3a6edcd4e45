/* Normals to the stations that saw their points. */
#include "preprocess/facing.h"

#include "base/memory.h"
#include "formats/chunk/sample.h"
#include "preprocess/relation.h"

#include <stdlib.h>

/* Logarithm of the odds that a normal leans to its station, over the cosine: as measured on the
 * statue and the sheet, 1 M points each, with several stations. */
#define ODDS_OF_COSINE 25.0f
/* Of a point seen more steeply the neighbours are not asked. */
#define PLAIN_ODDS 12.5f
/* What settles one point may unsettle another. */
#define SWEEPS 3

typedef struct settling {
    stp_cloud *cloud;
    const stp_neighbours *neighbours;
    const stp_dvec3 *stations;
    uint8_t *wrong; /* by point: turned after the sweep */
} settling;

double stp_facing(const stp_cloud_point *p, const stp_dvec3 *stations)
{
    if (!stations || p->station == 0)
        return 0.0;
    stp_dvec3 d = stp_dvec3_sub(stations[p->station - 1], p->position);
    double cosine = stp_dvec3_dot(stp_dvec3_normalize(d), stp_dvec3_from_float(p->normal));
    return isfinite(cosine) ? cosine : 0.0; /* too far away for a double */
}

static float own_odds(const settling *s, uint32_t point)
{
    return ODDS_OF_COSINE * (float)stp_facing(&s->cloud->points[point], s->stations);
}

/* What a neighbour says is no surer than the neighbour itself. */
static float said_odds(const settling *s, uint32_t self, uint32_t other)
{
    stp_relation r = stp_relate(s->cloud, self, other);
    if (r.rank >= STP_RANK_NONE)
        return 0.0f;
    float sure = fabsf(own_odds(s, other)), odds = stp_relation_odds(r);
    return fmaxf(-sure, fminf(odds, sure));
}

static stp_status weigh_cell(void *context, size_t index, unsigned worker, stp_error *err)
{
    settling *s = context;
    const stp_cell *cell = &s->cloud->cells[index];
    (void)worker;
    (void)err;
    for (uint32_t i = cell->begin; i < cell->end; i++) {
        float sum = own_odds(s, i);
        const uint32_t *list = s->neighbours->indices + (size_t)i * s->neighbours->k;
        bool asked = fabsf(sum) < PLAIN_ODDS && s->cloud->points[i].flags & STP_SAMPLE_ORIENTED;
        for (unsigned n = 0; asked && n < s->neighbours->k && list[n] != STP_NEIGHBOUR_NONE; n++)
            sum += said_odds(s, i, list[n]);
        s->wrong[i] = asked && sum < 0.0f;
    }
    return STP_OK;
}

stp_status stp_facing_settle(stp_cloud *cloud, const stp_neighbours *neighbours,
                             const stp_dvec3 *stations, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    settling s = {.cloud = cloud, .neighbours = neighbours, .stations = stations};
    STP_TRY(stp_spill_alloc(cloud->spill, &s.wrong, cloud->count, sizeof *s.wrong, "signs", err));
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        STP_TRY(stp_cloud_run(cloud, pool, cloud->cell_count, weigh_cell, &s, err));
        for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i))
            if (s.wrong[i])
                cloud->points[i].normal = glms_vec3_negate(cloud->points[i].normal);
    }
done:
    stp_spill_free(cloud->spill, s.wrong);
    return status;
}

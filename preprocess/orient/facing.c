/* Turns normals to the stations that saw their points. */
#include "preprocess/orient/facing.h"

#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/cloud/nearest_list.h"
#include "preprocess/orient/kept_walk.h"

/* Log odds that a normal leans to its station, per unit of cosine. Measured on the statue and the
 * sheet, 1 M points each, with several stations. */
#define ODDS_OF_COSINE 25.0f
/* If a point's own log odds are at least this, its neighbours are not asked. */
#define PLAIN_ODDS 12.5f
/* Turning one point may make another wrong. */
#define SWEEPS 3

typedef struct facing_check {
    const stp_sheets *sheets;
    const stp_dvec3 *stations;
    uint8_t *wrong; /* by kept point: is turned after the sweep */
} facing_check;

double stp_facing(const stp_cloud_point *p, vec3s normal, const stp_dvec3 *stations)
{
    if (!stations || p->station == 0)
        return 0.0;
    stp_dvec3 d = stp_dvec3_sub(stations[p->station - 1], p->position);
    double cosine = stp_dvec3_dot(stp_dvec3_normalize(d), stp_dvec3_from_float(normal));
    return isfinite(cosine) ? cosine : 0.0; /* not finite: too far away for a double */
}

static bool is_plain(float odds)
{
    return fabsf(odds) >= PLAIN_ODDS;
}

bool stp_facing_plainly(const stp_cloud_point *p, const stp_dvec3 *stations)
{
    return is_plain(ODDS_OF_COSINE * (float)stp_facing(p, p->normal, stations));
}

static float own_odds(const facing_check *check, uint64_t point)
{
    const stp_cloud *cloud = check->sheets->cloud;
    return ODDS_OF_COSINE * (float)stp_facing(&cloud->points[point], stp_cloud_normal(cloud, point),
                                              check->stations);
}

/* A neighbour's word is no surer than the neighbour itself. */
static float said_odds(const facing_check *check, uint64_t self, uint64_t other)
{
    stp_relation r = stp_relate_marked(check->sheets->cloud, self, other);
    if (r.rank >= STP_RANK_NONE)
        return 0.0f;
    float sure = fabsf(own_odds(check, other)), odds = stp_relation_odds(r);
    return fmaxf(-sure, fminf(odds, sure));
}

static stp_status weigh_cell(void *context, size_t index, unsigned worker, stp_error *err)
{
    facing_check *check = context;
    const stp_sheets *s = check->sheets;
    (void)worker;
    (void)err;
    for (stp_kept_walk kept = stp_kept_begin(s, index); stp_kept_next(&kept);) {
        float sum = own_odds(check, kept.self);
        bool asked = !is_plain(sum) && s->cloud->marks[kept.self] & STP_MARK_ORIENTED;
        for (unsigned n = 0; asked && n < s->k && kept.neighbours[n] != STP_PLACE_NONE; n++)
            sum += said_odds(check, kept.self, kept.neighbours[n]);
        check->wrong[kept.number] = asked && sum < 0.0f;
    }
    return STP_OK;
}

static void turn_wrong(const facing_check *check)
{
    const stp_sheets *s = check->sheets;
    for (uint32_t c = 0; c < s->cloud->cell_count; c++) {
        stp_spill_relieve(s->cloud->spill);
        for (uint32_t i = 0; i < s->graphs[c].kept_count; i++)
            if (check->wrong[s->kept_begin[c] + i])
                s->cloud->marks[s->cloud->cells[c].begin + s->graphs[c].kept[i]] ^= STP_MARK_TURNED;
    }
}

stp_status stp_facing_correct(const stp_sheets *s, const stp_dvec3 *stations, stp_pool *pool,
                              stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t cell_count = s->cloud->cell_count;
    facing_check check = {.sheets = s, .stations = stations};
    STP_TRY(stp_spill_alloc(s->cloud->spill, &check.wrong, s->kept_begin[cell_count],
                            sizeof *check.wrong, "signs", err));
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        STP_TRY(stp_cloud_run_own(s->cloud, pool, weigh_cell, &check, err));
        turn_wrong(&check);
        STP_TRY(stp_cloud_refresh(s->cloud, STP_ARRAY_MARKS, err));
    }
done:
    stp_spill_free(s->cloud->spill, check.wrong);
    return status;
}

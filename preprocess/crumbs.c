/* Crumbs between the sheets. */
#include "preprocess/crumbs.h"

#include "base/memory.h"
#include "formats/chunk/sample.h"
#include "preprocess/relation.h"

#include <stdlib.h>
#include <string.h>

#define BLOCK 4096u
/* Crumbs lie beside crumbs: what settles one may unsettle another. */
#define SWEEPS 3

/* The big sheet among a point's neighbours whose planes are least far from it on the mean; its own
 * if there is none. */
static uint32_t adopt(const stp_cloud *cloud, const stp_neighbours *neighbours,
                      const stp_forest *forest, uint32_t self)
{
    struct {
        uint32_t root;
        float offset, count;
    } candidates[STP_NEIGHBOURS_LIMIT];
    const stp_cloud_point *p = &cloud->points[self];
    const uint32_t *list = neighbours->indices + (size_t)self * neighbours->k;
    unsigned count = 0, best = 0;
    for (unsigned i = 0; i < neighbours->k && list[i] != STP_NEIGHBOUR_NONE; i++) {
        const stp_cloud_point *q = &cloud->points[list[i]];
        uint32_t root = forest->parent[list[i]];
        vec3s d = stp_dvec3_to_float(stp_dvec3_sub(p->position, q->position));
        if (forest->size[root] <= STP_CRUMB_POINTS)
            continue;
        unsigned at = 0;
        while (at < count && candidates[at].root != root)
            at++;
        if (at == count) {
            candidates[at].root = root;
            candidates[at].offset = candidates[at].count = 0.0f;
            count++;
        }
        candidates[at].offset += fabsf(glms_vec3_dot(q->normal, d));
        candidates[at].count += 1.0f;
    }
    for (unsigned i = 1; i < count; i++)
        if (candidates[i].offset * candidates[best].count <
            candidates[best].offset * candidates[i].count)
            best = i;
    return count ? candidates[best].root : forest->parent[self];
}

static bool on_crumb(const stp_forest *forest, uint32_t point)
{
    return forest->size[forest->parent[point]] <= STP_CRUMB_POINTS;
}

/* Room for all, since there may be nothing but crumbs. */
static stp_status list_crumbs(stp_crumbs *out, const stp_forest *forest, uint32_t count,
                              stp_error *err)
{
    stp_spill *spill = out->spill;
    stp_status status = STP_OK;
    uint32_t *numbers = NULL;
    for (uint32_t i = 0; i < count; i++, stp_cloud_step(spill, i))
        out->point_count += on_crumb(forest, i);
    STP_TRY(
        stp_spill_alloc(spill, &out->points, out->point_count, sizeof *out->points, "pieces", err));
    STP_TRY(
        stp_spill_alloc(spill, &out->pieces, out->point_count, sizeof *out->pieces, "pieces", err));
    STP_TRY(stp_spill_alloc(spill, &numbers, count, sizeof *numbers, "pieces", err));
    uint32_t at = 0;
    for (uint32_t i = 0; i < count;
         i++, stp_cloud_step(spill, i)) { /* a root is its piece's first point */
        if (!on_crumb(forest, i))
            continue;
        if (forest->parent[i] == i)
            numbers[i] = out->piece_count++;
        out->points[at] = i;
        out->pieces[at++] = numbers[forest->parent[i]];
    }
done:
    stp_spill_free(spill, numbers);
    return status;
}

/* What noise has put off its surface goes with the sheet it lies nearest to: edges would lead from
 * one side of a thin plate to the other through such points. */
stp_status stp_crumbs_find(stp_crumbs *out, stp_cloud *cloud, const stp_neighbours *neighbours,
                           stp_forest *forest, stp_error *err)
{
    stp_crumbs crumbs = {.spill = cloud->spill};
    for (uint32_t i = 0; i < cloud->count;
         i++, stp_cloud_step(cloud->spill, i)) { /* makes every parent a root */
        uint8_t parity = 0;
        (void)stp_forest_find(forest, i, &parity);
    }
    stp_status status = list_crumbs(&crumbs, forest, cloud->count, err);
    if (status != STP_OK) {
        stp_crumbs_clear(&crumbs);
        return status;
    }
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i)) {
        stp_cloud_point *p = &cloud->points[i];
        p->sheet = on_crumb(forest, i) ? adopt(cloud, neighbours, forest, i) : forest->parent[i];
        if (!(p->flags & STP_SAMPLE_HAS_NORMAL))
            p->sheet = STP_SHEET_NONE;
    }
    *out = crumbs;
    return STP_OK;
}

typedef struct settling {
    const stp_crumbs *crumbs;
    const stp_cloud *cloud;
    const stp_neighbours *neighbours;
    float *odds;    /* by crumb point: logarithm, above 0 where its neighbours agree */
    uint32_t *spot; /* by point: its crumb, STP_SHEET_NONE on a sheet */
} settling;

static float odds_of(const settling *s, uint32_t self)
{
    const uint32_t *list = s->neighbours->indices + (size_t)self * s->neighbours->k;
    float sum = 0.0f;
    for (unsigned i = 0; i < s->neighbours->k && list[i] != STP_NEIGHBOUR_NONE; i++) {
        bool own = s->spot[self] == s->spot[list[i]];
        if (own || !(s->cloud->points[list[i]].flags & STP_SAMPLE_ORIENTED))
            continue;
        stp_relation r = stp_relate(s->cloud, self, list[i]);
        if (r.rank < STP_RANK_NONE)
            sum += stp_relation_odds(r);
    }
    return sum;
}

static stp_status weigh_block(void *context, size_t block, unsigned worker, stp_error *err)
{
    settling *s = context;
    uint32_t begin = (uint32_t)block * BLOCK;
    uint32_t left = s->crumbs->point_count - begin;
    (void)worker;
    (void)err;
    for (uint32_t i = begin; i < begin + (left < BLOCK ? left : BLOCK); i++) {
        uint32_t point = s->crumbs->points[i];
        bool known = s->cloud->points[point].flags & STP_SAMPLE_ORIENTED;
        s->odds[i] = known ? odds_of(s, point) : 0.0f;
    }
    return STP_OK;
}

static void turn_crumbs(const stp_crumbs *crumbs, stp_cloud *cloud, const float *odds, float *sums)
{
    memset(sums, 0, crumbs->piece_count * sizeof *sums);
    for (uint32_t i = 0; i < crumbs->point_count; i++)
        sums[crumbs->pieces[i]] += odds[i];
    for (uint32_t i = 0; i < crumbs->point_count; i++) {
        stp_cloud_point *p = &cloud->points[crumbs->points[i]];
        if (sums[crumbs->pieces[i]] < 0.0f && p->flags & STP_SAMPLE_ORIENTED)
            p->normal = glms_vec3_negate(p->normal);
    }
}

stp_status stp_crumbs_settle(const stp_crumbs *crumbs, stp_cloud *cloud,
                             const stp_neighbours *neighbours, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    settling s = {.crumbs = crumbs, .cloud = cloud, .neighbours = neighbours};
    float *sums = NULL;
    if (crumbs->point_count == 0)
        return STP_OK;
    STP_TRY(
        stp_spill_alloc(cloud->spill, &s.odds, crumbs->point_count, sizeof *s.odds, "pieces", err));
    STP_TRY(stp_spill_alloc(cloud->spill, &s.spot, cloud->count, sizeof *s.spot, "pieces", err));
    STP_TRY(stp_spill_alloc(cloud->spill, &sums, crumbs->piece_count, sizeof *sums, "pieces", err));
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i))
        s.spot[i] = STP_SHEET_NONE;
    for (uint32_t i = 0; i < crumbs->point_count; i++)
        s.spot[crumbs->points[i]] = crumbs->pieces[i];
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        STP_TRY(stp_cloud_run(cloud, pool, ((size_t)crumbs->point_count + BLOCK - 1) / BLOCK,
                              weigh_block, &s, err));
        turn_crumbs(crumbs, cloud, s.odds, sums);
    }
done:
    stp_spill_free(cloud->spill, sums);
    stp_spill_free(cloud->spill, s.spot);
    stp_spill_free(cloud->spill, s.odds);
    return status;
}

void stp_crumbs_clear(stp_crumbs *crumbs)
{
    stp_spill_free(crumbs->spill, crumbs->points);
    stp_spill_free(crumbs->spill, crumbs->pieces);
    *crumbs = (stp_crumbs){0};
}

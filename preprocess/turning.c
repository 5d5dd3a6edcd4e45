/* Turns pieces by volume, by scanners' positions and by what is seen of them. */
#include "preprocess/turning.h"

#include "base/memory.h"
#include "formats/chunk/sample.h"
#include "preprocess/facing.h"
#include "preprocess/visibility.h"

#include <stdlib.h>

/* A piece whose summed area vectors are below this part of its area is closed. */
#define CLOSED_RATIO 0.25
#define CLOSED_POINTS 64u

typedef struct piece {
    stp_dvec3 area; /* sum of area vectors */
    stp_dvec3 first;
    double total, volume;
    double facing; /* by how much more it faces its points' stations than it turns away */
    uint32_t count;
} piece;

/* Of points that are a piece of their own: there may be as many as points. */
#define LONE UINT32_MAX

/* Points' pieces of several, numbered from 0 in the order of their roots; returns how many. */
static uint32_t number_pieces(stp_forest *f, uint32_t count, uint32_t *numbers)
{
    uint32_t piece_count = 0;
    for (uint32_t i = 0; i < count;
         i++, stp_cloud_step(f->spill, i)) { /* a root is its piece's first point */
        uint8_t parity = 0;
        uint32_t root = stp_forest_find(f, i, &parity);
        if (root == i)
            numbers[i] = f->size[i] > 1 ? piece_count++ : LONE;
        else
            numbers[i] = numbers[root];
    }
    return piece_count;
}

static void add_to_piece(piece *c, const stp_cloud_point *p, const stp_dvec3 *stations)
{
    if (c->count++ == 0)
        c->first = p->position;
    double area = (double)p->spacing * (double)p->spacing;
    stp_dvec3 vector = stp_dvec3_scale(stp_dvec3_from_float(p->normal), area);
    c->area = stp_dvec3_add(c->area, vector);
    c->total += area;
    c->volume += stp_dvec3_dot(stp_dvec3_sub(p->position, c->first), vector);
    c->facing += stp_facing(p, stations);
}

/* Makes signs agree with the piece's first point and sums the pieces up. */
static void sum_pieces(stp_cloud *cloud, const stp_forest *f, const uint32_t *numbers,
                       const stp_dvec3 *stations, piece *pieces)
{
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i)) {
        stp_cloud_point *p = &cloud->points[i];
        if (f->parity[i])
            p->normal = glms_vec3_negate(p->normal);
        if (numbers[i] != LONE)
            add_to_piece(&pieces[numbers[i]], p, stations);
    }
}

/* Whether the piece's outside is known, and in *sign, above 0 where its normals point there: by its
 * points' stations or, where none is known, by its volume, if it is closed. */
static bool outside_of(const piece *c, double *sign)
{
    *sign = c->facing != 0.0 ? c->facing : c->volume;
    if (c->facing != 0.0)
        return true;
    return c->count >= CLOSED_POINTS && stp_dvec3_length(c->area) <= CLOSED_RATIO * c->total;
}

/* Either sign will do of which nothing is known; octahedral codes are contiguous around +z, not
 * around -z. */
static void turn_point(stp_cloud_point *p, const piece *c, const stp_dvec3 *stations)
{
    double sign = stp_facing(p, stations);
    bool known = p->flags & STP_SAMPLE_HAS_NORMAL && (sign != 0.0 || outside_of(c, &sign));
    if (!known)
        sign = c->area.z;
    if (sign < 0.0)
        p->normal = glms_vec3_negate(p->normal);
    if (known)
        p->flags |= STP_SAMPLE_ORIENTED;
}

stp_status stp_turn_pieces(stp_cloud *cloud, stp_forest *f, const stp_dvec3 *stations,
                           uint32_t *oriented, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t *numbers = NULL;
    piece *pieces = NULL;
    STP_TRY(stp_spill_alloc(cloud->spill, &numbers, cloud->count, sizeof *numbers, "pieces", err));
    uint32_t piece_count = number_pieces(f, cloud->count, numbers);
    STP_TRY(stp_spill_alloc(cloud->spill, &pieces, piece_count, sizeof *pieces, "pieces", err));
    sum_pieces(cloud, f, numbers, stations, pieces);
    *oriented = 0;
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i)) {
        piece lone = {.count = 0};
        if (numbers[i] == LONE)
            add_to_piece(&lone, &cloud->points[i], stations);
        turn_point(&cloud->points[i], numbers[i] == LONE ? &lone : &pieces[numbers[i]], stations);
        *oriented += (cloud->points[i].flags & STP_SAMPLE_ORIENTED) != 0;
    }
done:
    stp_spill_free(cloud->spill, pieces);
    stp_spill_free(cloud->spill, numbers);
    return status;
}

/* Turns the sheets of closed pieces whose seen points say so: reflection across one crease may be
 * wrong, but what a closed surface shows to the outside is its outside. */
stp_status stp_turn_seen(stp_cloud *cloud, const uint32_t *parts, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    _Atomic int *votes = NULL;
    int64_t *sums = NULL;
    STP_TRY(stp_spill_alloc(cloud->spill, &votes, cloud->count, sizeof *votes, "votes", err));
    STP_TRY(stp_spill_alloc(cloud->spill, &sums, cloud->count, sizeof *sums, "votes", err));
    STP_TRY(stp_visibility_vote(votes, cloud, pool, err));
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i))
        if (cloud->points[i].flags & STP_SAMPLE_ORIENTED)
            sums[parts[i]] += votes[i];
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i)) {
        stp_cloud_point *p = &cloud->points[i];
        if (p->flags & STP_SAMPLE_ORIENTED && sums[parts[i]] < 0)
            p->normal = glms_vec3_negate(p->normal);
    }
done:
    stp_spill_free(cloud->spill, sums);
    stp_spill_free(cloud->spill, (void *)votes);
    return status;
}

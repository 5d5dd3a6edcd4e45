/* Turns pieces by volume, by stations and by what is seen of them. */
#include "preprocess/orient/turning.h"

#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/orient/facing.h"
#include "preprocess/orient/visibility.h"

/* A piece is closed if its summed area vectors are at most this part of its area. */
#define CLOSED_RATIO 0.25
#define CLOSED_POINTS 64u

typedef struct piece {
    stp_dvec3 area; /* sum of area vectors */
    stp_dvec3 first;
    double total, volume;
    double facing; /* sum of cosines: above 0 if it faces its points' stations */
    uint64_t count;
} piece;

/* A point that is a piece by itself. There may be as many as points. */
#define LONE UINT32_MAX

/* Sets, for each piece of a cell, the number of the joined piece that it belongs to, in the order
 * of the roots. A joined piece of one point gets LONE. Returns how many numbers there are. */
static uint32_t number_pieces(stp_sheets *s, uint32_t *numbers)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < s->piece_count; i++, stp_cloud_step(s->forest.spill, i)) {
        uint8_t parity = 0;
        uint32_t root = stp_forest_find(&s->forest, i, &parity);
        if (root == i) /* the root comes before its other pieces */
            numbers[i] = s->forest.size[i] > 1 ? count++ : LONE;
        else
            numbers[i] = numbers[root];
    }
    return count;
}

static void add_to_piece(piece *c, const stp_cloud_point *p, vec3s normal,
                         const stp_dvec3 *stations)
{
    if (c->count++ == 0)
        c->first = p->position;
    double area = (double)p->spacing * (double)p->spacing;
    stp_dvec3 vector = stp_dvec3_scale(stp_dvec3_from_float(normal), area);
    c->area = stp_dvec3_add(c->area, vector);
    c->total += area;
    c->volume += stp_dvec3_dot(stp_dvec3_sub(p->position, c->first), vector);
    c->facing += stp_facing(p, normal, stations);
}

typedef struct summing {
    const stp_sheets *sheets;
    const stp_dvec3 *stations;
    uint32_t *numbers; /* by piece of a cell: the joined piece that it belongs to, or LONE */
    piece *pieces;     /* by joined piece */
} summing;

/* Makes signs agree with the piece's first point, and sums up each piece. */
static void sum_pieces(void *context)
{
    const summing *sum = context;
    const stp_sheets *s = sum->sheets;
    stp_cloud *cloud = s->cloud;
    const stp_rank_part own = stp_cloud_own(cloud);
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i)) {
        const uint32_t sheet = cloud->sheets[i], number = sum->numbers[sheet];
        if (s->forest.parity[sheet])
            cloud->marks[i] ^= STP_MARK_TURNED;
        if (number != LONE)
            add_to_piece(&sum->pieces[number], &cloud->points[i], stp_cloud_normal(cloud, i),
                         sum->stations);
    }
}

/* Whether the piece's outside is known: from its points' stations or, if none is known, from its
 * volume, if it is closed. *sign is above 0 if its normals point outward. */
static bool outside_of(const piece *c, double *sign)
{
    *sign = c->facing != 0.0 ? c->facing : c->volume;
    if (c->facing != 0.0)
        return true;
    return c->count >= CLOSED_POINTS && stp_dvec3_length(c->area) <= CLOSED_RATIO * c->total;
}

/* If the outside is unknown, either sign will do. The piece then faces +z, because octahedral codes
 * are contiguous around +z, not around -z. */
static void turn_point(stp_cloud *cloud, uint64_t i, const piece *c, const stp_dvec3 *stations)
{
    const stp_cloud_point *p = &cloud->points[i];
    double sign = stp_facing(p, stp_cloud_normal(cloud, i), stations);
    bool known = stp_has_normal(p) && (sign != 0.0 || outside_of(c, &sign));
    if (!known)
        sign = c->area.z;
    if (sign < 0.0)
        cloud->marks[i] ^= STP_MARK_TURNED;
    if (known)
        cloud->marks[i] |= STP_MARK_ORIENTED;
}

/* Turns this process's points, and counts them. */
static void turn_points(const summing *sum, uint64_t *with_normal, uint64_t *oriented)
{
    stp_cloud *cloud = sum->sheets->cloud;
    const stp_rank_part own = stp_cloud_own(cloud);
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i)) {
        uint32_t number = sum->numbers[cloud->sheets[i]];
        piece lone = {.count = 0};
        if (number == LONE)
            add_to_piece(&lone, &cloud->points[i], stp_cloud_normal(cloud, i), sum->stations);
        turn_point(cloud, i, number == LONE ? &lone : &sum->pieces[number], sum->stations);
        *with_normal += stp_has_normal(&cloud->points[i]);
        *oriented += (cloud->marks[i] & STP_MARK_ORIENTED) != 0;
    }
}

stp_status stp_turn_pieces(stp_sheets *s, const stp_dvec3 *stations, stp_turned *out,
                           stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud *cloud = s->cloud;
    summing sum = {.sheets = s, .stations = stations};
    uint64_t counts[2] = {0, 0};
    STP_TRY(stp_spill_alloc(cloud->spill, &sum.numbers, s->piece_count, sizeof *sum.numbers,
                            "pieces", err));
    uint32_t piece_count = number_pieces(s, sum.numbers);
    STP_TRY(
        stp_spill_alloc(cloud->spill, &sum.pieces, piece_count, sizeof *sum.pieces, "pieces", err));
    STP_TRY(stp_cloud_in_turn(cloud, sum_pieces, &sum, sum.pieces, piece_count * sizeof *sum.pieces,
                              err));
    turn_points(&sum, &counts[0], &counts[1]);
    STP_TRY(stp_cloud_sum(cloud, counts, 2, err));
    *out = (stp_turned){counts[0], counts[1]};
done:
    stp_spill_free(cloud->spill, sum.pieces);
    stp_spill_free(cloud->spill, sum.numbers);
    return status;
}

/* What the drawn points of each sheet vote. */
typedef struct vote_sum {
    const stp_sheets *sheets;
    const _Atomic int *votes; /* by drawn point */
    uint64_t stride;
    int64_t *sums; /* by sheet with its crumbs */
} vote_sum;

static void sum_votes(void *context)
{
    const vote_sum *v = context;
    const stp_sheets *s = v->sheets;
    const stp_cloud *cloud = s->cloud;
    const stp_rank_part own = stp_cloud_own(cloud);
    const uint64_t first = cloud->first, begin = own.begin - first;
    for (uint64_t n = (begin + v->stride - 1) / v->stride; first + n * v->stride < own.end; n++) {
        const uint64_t i = first + n * v->stride;
        stp_cloud_stride(cloud->spill, i, v->stride);
        if (cloud->marks[i] & STP_MARK_ORIENTED)
            v->sums[s->parts[cloud->sheets[i]]] += v->votes[n];
    }
}

/* Reflection across one crease may be wrong, but what a closed surface shows to the outside is its
 * outside. So the sheets of closed pieces turn by what is seen of them. */
stp_status stp_turn_seen(const stp_sheets *s, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud *cloud = s->cloud;
    const stp_rank_part own = stp_cloud_own(cloud);
    _Atomic int *votes = NULL;
    vote_sum v = {.sheets = s, .stride = stp_visibility_stride(cloud)};
    STP_TRY(stp_spill_alloc(cloud->spill, &votes, (cloud->count - 1) / v.stride + 1, sizeof *votes,
                            "votes", err));
    STP_TRY(stp_spill_alloc(cloud->spill, &v.sums, s->piece_count, sizeof *v.sums, "votes", err));
    STP_TRY(stp_visibility_vote(votes, cloud, pool, err));
    v.votes = votes;
    STP_TRY(stp_cloud_in_turn(cloud, sum_votes, &v, v.sums, s->piece_count * sizeof *v.sums, err));
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i))
        if (cloud->marks[i] & STP_MARK_ORIENTED && v.sums[s->parts[cloud->sheets[i]]] < 0)
            cloud->marks[i] ^= STP_MARK_TURNED;
done:
    stp_spill_free(cloud->spill, v.sums);
    stp_spill_free(cloud->spill, (void *)votes);
    return status;
}

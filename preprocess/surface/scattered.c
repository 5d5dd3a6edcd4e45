/* Finds points that fill a volume, and limits their spacings. */
#include "preprocess/surface/scattered.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/cloud/nearest_list.h"
#include "preprocess/surface/moments.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Least det(C) (3 / trace(C))^3 of the covariance C of scattered points. It is 1 if the extents
 * along all axes are equal, 0 on a plane, 0.43 on the edge of a cube. */
#define ROUND_LEAST 0.5
/* A neighbour is asked if its spacing is more than this part of the point's. Others are of a denser
 * surface. */
#define ASKED_LEAST 0.3f
/* A point floats before a denser surface if a third of its neighbours or more are of it, and
 * neither all of them nor the others, if there are ASKED_FEW, lie on a plane with it. */
#define ASKED_FEW 5u
#define FLAT_MOST 0.01f
/* Spacings are counted by their exponent and the 4 highest bits of their fraction. */
#define BIN_SHIFT 19
#define BINS (1u << (31 - BIN_SHIFT))

/* Adds where a neighbour lies, in spacings of the point, so that floats hold the sums. */
static void add_neighbour(stp_moments *m, const stp_cloud_point *own, const stp_cloud_point *other)
{
    const stp_dvec3 d =
        stp_dvec3_scale(stp_dvec3_sub(other->position, own->position), 1.0 / (double)own->spacing);
    stp_moments_add_point(m, stp_moments_place((float)d.x, (float)d.y, (float)d.z));
}

/* det(C) (3 / trace(C))^3 of points' covariance C; 0 if all lie at one place. */
static float roundness(const stp_moments *m)
{
    const stp_float4 mean = m->row[3] / m->row[3][3];
    const stp_float4 x = m->row[0] - m->row[3][0] * mean, y = m->row[1] - m->row[3][1] * mean;
    const stp_float4 z = m->row[2] - m->row[3][2] * mean;
    const float third = (x[0] + y[1] + z[2]) / 3.0f;
    const float determinant = x[0] * (y[1] * z[2] - y[2] * y[2]) -
                              x[1] * (x[1] * z[2] - y[2] * x[2]) +
                              x[2] * (x[1] * y[2] - y[1] * x[2]);
    return third > 0.0f ? determinant / (third * third * third) : 0.0f;
}

static bool is_round(const stp_unit *unit, uint32_t self)
{
    const stp_cloud_point *points = unit->cloud.points, *own = &points[self];
    const uint32_t *list = unit->neighbours.indices + (size_t)self * unit->neighbours.k;
    stp_moments m = {{{0}}};
    if (!(own->spacing > 0.0f))
        return false;
    m.row[3][3] = 1.0f; /* the point itself */
    for (unsigned i = 0; i < unit->neighbours.k && list[i] != STP_NEIGHBOUR_NONE; i++)
        add_neighbour(&m, own, &points[list[i]]);
    return roundness(&m) > ROUND_LEAST;
}

static bool is_asked(const stp_cloud_point *own, const stp_cloud_point *other)
{
    return ASKED_LEAST * own->spacing < other->spacing;
}

/* Whether a point floats before a denser surface. */
static bool floats(const stp_unit *unit, uint32_t self)
{
    const stp_cloud_point *points = unit->cloud.points, *own = &points[self];
    const uint32_t *list = unit->neighbours.indices + (size_t)self * unit->neighbours.k;
    unsigned denser = 0, asked = 0;
    stp_moments all = {{{0}}}, like = {{{0}}};
    all.row[3][3] = like.row[3][3] = 1.0f; /* the point itself */
    for (unsigned i = 0; i < unit->neighbours.k && list[i] != STP_NEIGHBOUR_NONE; i++) {
        const stp_cloud_point *other = &points[list[i]];
        const bool is_like = is_asked(own, other);
        add_neighbour(&all, own, other);
        if (is_like)
            add_neighbour(&like, own, other);
        asked += is_like;
        denser += !is_like;
    }
    return own->spacing > 0.0f && 2 * denser > asked && roundness(&all) > FLAT_MOST &&
           (asked < ASKED_FEW || roundness(&like) > FLAT_MOST);
}

stp_status stp_scattered_mark(stp_cloud *cloud, const stp_unit *unit, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_neighbours *near = &unit->neighbours;
    const stp_cloud_point *points = unit->cloud.points;
    const uint32_t count = stp_unit_inner(unit, 1);
    bool *round = NULL;
    STP_TRY(stp_alloc(&round, count, sizeof *round, "points", err));
    for (uint32_t i = 0; i < count; i++)
        round[i] = is_round(unit, i);
    for (uint32_t i = 0; i < unit->ring_end[0]; i++) {
        const uint32_t *list = near->indices + (size_t)i * near->k;
        unsigned votes = round[i], most = 1;
        for (unsigned n = 0; n < near->k && list[n] != STP_NEIGHBOUR_NONE; n++) {
            const bool asked = is_asked(&points[i], &points[list[n]]);
            votes += asked && round[list[n]];
            most += asked;
        }
        uint8_t *marks = &cloud->marks[unit->places[i]];
        *marks = (uint8_t)((*marks & ~STP_MARK_SCATTERED) |
                           (3 * votes > most || floats(unit, i) ? STP_MARK_SCATTERED : 0u));
    }
done:
    free(round);
    return status;
}

static uint32_t bin_of(float spacing)
{
    uint32_t bits;
    memcpy(&bits, &spacing, sizeof bits);
    return bits >> BIN_SHIFT;
}

/* The upper end of the bin that holds the median of the spacings above 0. */
static float median_of(const uint64_t counts[BINS])
{
    uint64_t all = 0, below = 0;
    uint32_t bin = 0;
    float end;
    for (uint32_t i = 1; i < BINS; i++)
        all += counts[i];
    while (bin + 1 < BINS && 2 * below < all)
        below += counts[++bin];
    const uint32_t bits = (bin + 1) << BIN_SHIFT;
    memcpy(&end, &bits, sizeof end);
    return end;
}

stp_status stp_scattered_limit(stp_cloud *cloud, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t counts[BINS + 1] = {0}; /* by bin; then scattered points */
    const stp_rank_part own = stp_cloud_own(cloud);
    for (uint32_t i = own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i)) {
        counts[bin_of(cloud->points[i].spacing)]++;
        counts[BINS] += (cloud->marks[i] & STP_MARK_SCATTERED) != 0;
    }
    STP_TRY(stp_cloud_sum(cloud, counts, BINS + 1, err));
    if (counts[BINS] == 0)
        return STP_OK;
    const float most = STP_SCATTERED_MEDIANS * median_of(counts);
    for (uint32_t i = own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i)) {
        float *spacing = &cloud->points[i].spacing;
        if (cloud->marks[i] & STP_MARK_SCATTERED && *spacing > most)
            *spacing = fmaxf(most, STP_SCATTERED_PART * *spacing);
    }
done:
    return status;
}

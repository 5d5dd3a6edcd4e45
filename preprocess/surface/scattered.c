/* Finds points that fill a volume, and limits their spacings. */
#include "preprocess/surface/scattered.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/cloud/nearest_list.h"
#include "preprocess/surface/neighbour_columns.h"

#include <math.h>
#include <string.h>

/* Least roundness (moments.h) of scattered points; it is 0.43 on the edge of a cube. */
#define ROUND_LEAST 0.5f
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

static bool is_round(const stp_unit *unit, uint32_t self)
{
    return unit->roundness[self] > ROUND_LEAST;
}

static bool is_asked(const stp_cloud_point *own, const stp_cloud_point *other)
{
    return ASKED_LEAST * own->spacing < other->spacing;
}

/* Whether a point with `count` neighbours floats before a denser surface. */
static bool floats(const stp_unit *unit, uint32_t self, unsigned count)
{
    const stp_cloud_point *points = unit->cloud.points, *own = &points[self];
    const uint32_t *list = unit->neighbours.indices + (size_t)self * unit->neighbours.k;
    const double scale = 1.0 / (double)own->spacing; /* so that floats hold the sums */
    unsigned asked = 0;
    stp_moments like = {{{0}}};
    if (!(own->spacing > 0.0f && unit->roundness[self] > FLAT_MOST))
        return false;
    for (unsigned i = 0; i < count; i++)
        asked += is_asked(own, &points[list[i]]);
    if (2 * (count - asked) <= asked) /* nearly all points */
        return false;
    like.row[3][3] = 1.0f; /* the point itself */
    for (unsigned i = 0; i < count; i++) {
        const stp_cloud_point *other = &points[list[i]];
        if (!is_asked(own, other))
            continue;
        const stp_dvec3 d = stp_dvec3_scale(stp_dvec3_sub(other->position, own->position), scale);
        stp_moments_add_point(&like, stp_moments_place((float)d.x, (float)d.y, (float)d.z));
    }
    return asked < ASKED_FEW || stp_moments_roundness(&like) > FLAT_MOST;
}

/* Whether more than a third of the point and those of its `count` neighbours that are asked are
 * round. */
static bool is_scattered(const stp_unit *unit, uint32_t self, unsigned count)
{
    const stp_cloud_point *points = unit->cloud.points;
    const uint32_t *list = unit->neighbours.indices + (size_t)self * unit->neighbours.k;
    unsigned most = 1;
    float roundest = unit->roundness[self];
    for (unsigned n = 0; n < count; n++) {
        const float other = unit->roundness[list[n]];
        roundest = other > roundest ? other : roundest;
    }
    if (!(roundest > ROUND_LEAST)) /* nearly all points of a surface */
        return false;
    unsigned votes = is_round(unit, self);
    for (unsigned n = 0; n < count; n++) {
        const bool asked = is_asked(&points[self], &points[list[n]]);
        votes += asked && is_round(unit, list[n]);
        most += asked;
    }
    return 3 * votes > most;
}

void stp_scattered_mark(stp_cloud *cloud, const stp_unit *unit)
{
    for (uint32_t i = 0; i < unit->ring_end[0]; i++) {
        uint8_t *marks = &cloud->marks[unit->places[i]];
        const unsigned k = unit->neighbours.k;
        const unsigned count = stp_neighbours_known(unit->neighbours.indices + (size_t)i * k, k);
        const bool scattered = is_scattered(unit, i, count) || floats(unit, i, count);
        *marks = (uint8_t)((*marks & ~STP_MARK_SCATTERED) | (scattered ? STP_MARK_SCATTERED : 0u));
    }
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
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i)) {
        counts[bin_of(cloud->points[i].spacing)]++;
        counts[BINS] += (cloud->marks[i] & STP_MARK_SCATTERED) != 0;
    }
    STP_TRY(stp_cloud_sum(cloud, counts, BINS + 1, err));
    uint64_t all = 0;
    for (uint32_t i = 0; i < BINS; i++)
        all += counts[i];
    const bool few = all <= STP_SCATTERED_FEW;
    if (counts[BINS] == 0 && !few)
        return STP_OK;
    const float most = few ? 0.0f : STP_SCATTERED_MEDIANS * median_of(counts);
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i)) {
        float *spacing = &cloud->points[i].spacing;
        if ((few || cloud->marks[i] & STP_MARK_SCATTERED) && *spacing > most)
            *spacing = fmaxf(most, (few ? STP_SCATTERED_FEW_PART : STP_SCATTERED_PART) * *spacing);
    }
done:
    return status;
}

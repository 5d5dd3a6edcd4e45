/* Local spacings without outliers and noise. */
#include "preprocess/surface/spacing.h"

#include "base/memory.h"
#include "preprocess/cloud/nearest_list.h"

#include <stdlib.h>

/* Least mutual neighbours of a point on a surface. */
#define SURFACE_POINTS 3u

typedef struct smoother {
    const stp_cloud *cloud;
    const stp_neighbours *neighbours;
    float *held;      /* spacings without outliers */
    uint64_t *mutual; /* by point: one bit for each neighbour that has the point as its neighbour */
} smoother;

/* Lower median; reorders the values. */
static float median(float *values, unsigned count)
{
    unsigned middle = (count - 1) / 2;
    for (unsigned low = 0, high = count - 1; low < high;) {
        float pivot = values[middle];
        unsigned i = low, j = high;
        while (i <= j) {
            /* both end at the pivot at the latest: NOLINTNEXTLINE(clang-analyzer-core.*) */
            while (values[i] < pivot)
                i++;
            /* NOLINTNEXTLINE(clang-analyzer-core.*) */
            while (pivot < values[j])
                j--;
            if (i > j)
                break;
            float swapped = values[i];
            values[i++] = values[j];
            values[j] = swapped;
            if (j == 0)
                break;
            j--;
        }
        if (j < middle)
            low = i;
        if (middle < i)
            high = j;
    }
    return values[middle];
}

/* The greatest spacing that a point may have: by the nearest third of its mutual neighbours; if it
 * has hardly any, by its neighbours' median spacing. */
static float limit(smoother *s, uint32_t self)
{
    const stp_cloud_point *points = s->cloud->points;
    const uint32_t *list = s->neighbours->indices + (size_t)self * s->neighbours->k;
    /* d_k^2 in squared spacings, and a little for rounding. */
    const double reach = (1.0 + 1e-6) * (double)s->neighbours->k / M_PI;
    float values[STP_NEIGHBOURS_LIMIT];
    double mutual[STP_NEIGHBOURS_LIMIT]; /* squared distances, nearest first */
    unsigned mutual_count = 0, count = 0;
    uint64_t knowing = 0;
    for (; count < s->neighbours->k && list[count] != STP_NEIGHBOUR_NONE; count++) {
        const stp_cloud_point *other = &points[list[count]];
        stp_dvec3 d = stp_dvec3_sub(other->position, points[self].position);
        double squared = stp_dvec3_dot(d, d);
        values[count] = other->spacing;
        bool knows = squared <= reach * (double)other->spacing * (double)other->spacing;
        knowing |= (uint64_t)knows << count;
        mutual[mutual_count] = squared;
        mutual_count += knows; /* no branch: it goes either way */
    }
    s->mutual[self] = knowing;
    if (mutual_count < SURFACE_POINTS)
        return count > 0 ? STP_SPACING_MEDIANS * median(values, count) : 0.0f;
    unsigned third = (mutual_count + 2) / 3;
    return STP_SPACING_EXCESS * (float)sqrt(mutual[third - 1] * M_PI / (double)third);
}

/* The harmonic mean: the finer side of a step in density then does not swell. */
static float average(const smoother *s, uint32_t self)
{
    const uint32_t *list = s->neighbours->indices + (size_t)self * s->neighbours->k;
    if (!(s->held[self] > 0.0f))
        return 0.0f;
    float sum = 1.0f / s->held[self];
    unsigned count = 1;
    for (uint64_t left = s->mutual[self]; left; left &= left - 1) {
        float other = s->held[list[__builtin_ctzll(left)]];
        if (other > 0.0f) {
            sum += 1.0f / other;
            count++;
        }
    }
    return (float)count / sum;
}

stp_status stp_spacing_smooth(stp_unit *unit, stp_error *err)
{
    stp_status status = STP_OK;
    smoother s = {.cloud = &unit->cloud, .neighbours = &unit->neighbours};
    stp_cloud_point *points = unit->cloud.points;
    uint32_t held = stp_unit_inner(unit, 1), smoothed = stp_unit_inner(unit, 2);
    STP_TRY(stp_alloc_unset(&s.held, held, sizeof *s.held, "spacings", err));
    STP_TRY(stp_alloc_unset(&s.mutual, held, sizeof *s.mutual, "spacings", err));
    for (uint32_t i = 0; i < held; i++)
        s.held[i] = fminf(points[i].spacing, limit(&s, i));
    for (uint32_t i = 0; i < smoothed; i++)
        points[i].spacing = average(&s, i);
done:
    free(s.mutual);
    free(s.held);
    return status;
}

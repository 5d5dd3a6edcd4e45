/* Local spacings without outliers and noise. */
#include "preprocess/surface/spacing.h"

#include "base/memory.h"
#include "base/wide.h"
#include "preprocess/cloud/nearest_list.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

/* Least mutual neighbours of a point on a surface. */
#define SURFACE_POINTS 3u

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

#define LANES STP_MOMENTS_LANES
#define WORD 32u
typedef float lanes __attribute__((vector_size(4 * LANES)));
typedef int32_t bits __attribute__((vector_size(4 * LANES)));

/* Sets a bit for each neighbour whose own neighbours reach the column's point, in words of 32 rows.
 */
STP_WIDE
static void find_mutual(const stp_neighbour_columns *c, uint32_t words[][LANES])
{
    /* d_k^2 in squared spacings, and a little for rounding. */
    const float reach = (1.0f + 1e-6f) * (float)c->k / (float)M_PI;
    for (unsigned first = 0; first < c->k; first += WORD) {
        bits word = {0};
        for (unsigned i = first; i < c->k && i < first + WORD; i++) {
            lanes x, y, z, spacing;
            memcpy(&x, c->places[i][0], sizeof x);
            memcpy(&y, c->places[i][1], sizeof y);
            memcpy(&z, c->places[i][2], sizeof z);
            memcpy(&spacing, c->spacings[i], sizeof spacing);
            const bits near = x * x + y * y + z * z <= reach * spacing * spacing + FLT_MIN;
            word |= near & (int32_t)(1u << (i - first));
        }
        memcpy(words[first / WORD], &word, sizeof word);
    }
}

/* The squared distance of two points. */
static double squared_between(const stp_cloud_point *p, const stp_cloud_point *q)
{
    const stp_dvec3 d = stp_dvec3_sub(q->position, p->position);
    return stp_dvec3_dot(d, d);
}

/* The greatest spacing that a point may have: by the nearest third of its mutual neighbours; if it
 * has hardly any, by its neighbours' median spacing. */
static float limit(const stp_unit *unit, uint32_t self, unsigned count, uint64_t mutual)
{
    const stp_cloud_point *points = unit->cloud.points;
    const uint32_t *list = unit->neighbours.indices + (size_t)self * unit->neighbours.k;
    const unsigned mutual_count = (unsigned)__builtin_popcountll(mutual);
    float values[STP_NEIGHBOURS_LIMIT];
    if (mutual_count < SURFACE_POINTS) {
        for (unsigned i = 0; i < count; i++)
            values[i] = points[list[i]].spacing;
        return count > 0 ? STP_SPACING_MEDIANS * median(values, count) : 0.0f;
    }
    const unsigned third = (mutual_count + 2) / 3;
    for (unsigned i = 1; i < third; i++)
        mutual &= mutual - 1;
    const stp_cloud_point *last = &points[list[__builtin_ctzll(mutual)]];
    return STP_SPACING_EXCESS *
           (float)sqrt(squared_between(&points[self], last) * M_PI / (double)third);
}

void stp_spacings_limit(stp_spacings *spacings, const stp_unit *unit,
                        const stp_neighbour_columns *columns, uint32_t count)
{
    uint32_t words[STP_NEIGHBOURS_LIMIT / WORD][LANES] = {{0}};
    find_mutual(columns, words);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t self = columns->first + i;
        const unsigned known = columns->counts[i];
        const uint64_t all = words[0][i] | (uint64_t)words[1][i] << WORD;
        const uint64_t mutual = known < 64 ? all & ((UINT64_C(1) << known) - 1) : all;
        const float limited =
            fminf(unit->cloud.points[self].spacing, limit(unit, self, known, mutual));
        spacings->mutual[self] = mutual;
        spacings->inverse[self] = limited > 0.0f ? 1.0f / limited : 0.0f;
    }
}

/* The harmonic mean: the finer side of a step in density then does not swell. */
static float average(const stp_spacings *s, const stp_unit *unit, uint32_t self)
{
    const uint32_t *list = unit->neighbours.indices + (size_t)self * unit->neighbours.k;
    float sum = s->inverse[self];
    unsigned count = 1;
    if (!(sum > 0.0f))
        return 0.0f;
    for (uint64_t left = s->mutual[self]; left; left &= left - 1) {
        const float other = s->inverse[list[__builtin_ctzll(left)]];
        sum += other;
        count += other > 0.0f;
    }
    return (float)count / sum;
}

void stp_spacings_smooth(const stp_spacings *spacings, stp_unit *unit)
{
    const uint32_t count = stp_unit_inner(unit, 2);
    for (uint32_t i = 0; i < count; i++)
        unit->cloud.points[i].spacing = average(spacings, unit, i);
}

stp_status stp_spacings_create(stp_spacings *out, uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_spacings s = {0};
    STP_TRY(stp_alloc_unset(&s.inverse, count, sizeof *s.inverse, "spacings", err));
    STP_TRY(stp_alloc_unset(&s.mutual, count, sizeof *s.mutual, "spacings", err));
    *out = s;
    s = (stp_spacings){0};
done:
    stp_spacings_clear(&s);
    return status;
}

void stp_spacings_clear(stp_spacings *spacings)
{
    free(spacings->inverse);
    free(spacings->mutual);
    *spacings = (stp_spacings){0};
}

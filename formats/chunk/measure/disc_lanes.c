/* Costs and distances of one point over many discs, and of pairs of point and disc. */
#include "formats/chunk/measure/disc_lanes.h"

#include "base/memory.h"
#include "base/wide.h"
#include "formats/chunk/measure/rim.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define FAR STP_LANE_FAR
#define STEP STP_LANE_STEP

stp_status stp_disc_columns_fill(stp_disc_columns *out, const stp_lane_disc *discs, uint32_t count,
                                 bool carried, stp_error *err)
{
    stp_status status = STP_OK;
    const int columns = carried ? STP_LANE_NUMBERS : STP_LANE_CARRIED;
    for (int c = 0; c < columns; c++)
        STP_TRY(stp_alloc_unset(&out->of[c], (size_t)count + STEP, sizeof **out->of, "discs", err));
    for (uint32_t i = 0; i < count; i++) {
        const float *d = discs[out->disc[i]].numbers;
        for (int c = 0; c < columns; c++)
            out->of[c][i] = d[c];
    }
    for (int c = 0; c < columns; c++)
        memset(out->of[c] + count, 0, STEP * sizeof **out->of);
done:
    return status;
}

void stp_disc_columns_clear(stp_disc_columns *columns)
{
    for (int i = 0; i < STP_LANE_NUMBERS; i++)
        free(columns->of[i]);
    free(columns->disc);
    *columns = (stp_disc_columns){{0}, NULL};
}

/* Whether a disc is one of those under p's merged disc. */
static inline bool is_own(uint32_t disc, const stp_over *over)
{
    return disc - over->begin < over->end - over->begin;
}

/* What the point finds over STEP discs. */
typedef struct told {
    float value[STEP], squared[STEP], cost[STEP];
} told;

/* Tells of the first `count` of STEP discs; the others are far away. Returns whether one is better
 * than the best. */
static inline bool step(const stp_disc_columns *columns, uint32_t first, uint32_t count,
                        bool carried, stp_over_what what, const stp_over *over,
                        const float point[3], const stp_disc_best *best, told *out)
{
    const int numbers = carried ? STP_LANE_NUMBERS : STP_LANE_CARRIED;
    const uint32_t *index = columns->disc + first;
    const float *column[STP_LANE_NUMBERS];
    int better = 0;
    for (int c = 0; c < numbers; c++)
        column[c] = columns->of[c] + first;
    for (uint32_t i = 0; i < STEP; i++) {
        float disc[STP_LANE_NUMBERS] = {0.0f}, squared;
        for (int c = 0; c < numbers; c++)
            disc[c] = column[c][i];
        float cost = stp_lane_cost_squared(point, disc, is_own(index[i], over), over, &squared);
        squared = i < count ? squared : FAR;
        cost = i < count ? cost : FAR;
        out->value[i] = what == STP_OVER_NEED ? stp_lane_need(cost, squared, over) : cost;
        out->squared[i] = squared;
        out->cost[i] = cost;
        better |= out->value[i] < best->value;
        if (what == STP_OVER_NEED)
            better |= squared < best->squared;
    }
    return better;
}

typedef int32_t step_bits __attribute__((vector_size(4 * STP_LANE_STEP)));

/* Whether some of STEP discs may be nearer to the point than `reach`: by the balls around them. */
static inline bool may_reach(const stp_disc_columns *columns, uint32_t first, const float point[3],
                             float reach)
{
    stp_step_lanes x, y, z, radius;
    uint64_t near[STEP / 2], any = 0;
    memcpy(&x, columns->of[0] + first, sizeof x);
    memcpy(&y, columns->of[1] + first, sizeof y);
    memcpy(&z, columns->of[2] + first, sizeof z);
    memcpy(&radius, columns->of[STP_LANE_RADIUS] + first, sizeof radius);
    x -= point[0];
    y -= point[1];
    z -= point[2];
    radius += reach;
    const step_bits nearer = x * x + y * y + z * z < radius * radius;
    memcpy(near, &nearer, sizeof near);
    for (unsigned i = 0; i < STEP / 2; i++)
        any |= near[i];
    return any;
}

static inline bool least_of(const stp_disc_columns *columns, uint32_t begin, uint32_t count,
                            bool carried, stp_over_what what, const stp_over *over,
                            const float point[3], float reach, stp_disc_best *best)
{
    const stp_over o = *over;
    const float p[3] = {point[0], point[1], point[2]};
    bool better = false;
    for (uint32_t at = 0; at < count; at += STEP) {
        told t;
        if (!may_reach(columns, begin + at, p, reach) ||
            !step(columns, begin + at, count - at, carried, what, &o, p, best, &t))
            continue;
        better = true;
        for (uint32_t i = 0; i < STEP; i++) {
            best->value = t.value[i] < best->value ? t.value[i] : best->value;
            if (what == STP_OVER_NEED && t.squared[i] < best->squared) {
                best->squared = t.squared[i];
                best->cost = t.cost[i];
            }
        }
    }
    return better;
}

STP_WIDE
bool stp_disc_columns_least(const stp_disc_columns *columns, uint32_t begin, uint32_t count,
                            const stp_over *over, const float point[3], float reach,
                            stp_disc_best *best)
{
    if (over->what == STP_OVER_COST)
        return least_of(columns, begin, count, false, STP_OVER_COST, over, point, reach, best);
    if (columns->of[STP_LANE_CARRIED])
        return least_of(columns, begin, count, true, STP_OVER_NEED, over, point, reach, best);
    return least_of(columns, begin, count, false, STP_OVER_NEED, over, point, reach, best);
}

float stp_lane_cost(const stp_lane_disc *disc, const stp_over *over, const float point[3])
{
    return stp_lane_value(point, disc->numbers, false, STP_OVER_COST, over);
}

STP_WIDE
void stp_lane_discs_tell(const stp_lane_disc *discs, const uint32_t index[STP_LANE_STEP],
                         const stp_over *over, const float point[3], float need[STP_LANE_STEP])
{
    float column[STP_LANE_NUMBERS][STEP];
    const stp_over o = *over;
    const float p[3] = {point[0], point[1], point[2]};
    stp_lane_discs_take(discs, index, column[0], STEP);
    for (uint32_t i = 0; i < STEP; i++)
        for (int c = STP_LANE_CARRIED; c < STP_LANE_NUMBERS; c++)
            column[c][i] = discs[index[i]].numbers[c];
    for (uint32_t i = 0; i < STEP; i++) {
        float disc[STP_LANE_NUMBERS];
        for (int c = 0; c < STP_LANE_NUMBERS; c++)
            disc[c] = column[c][i];
        need[i] = stp_lane_value(p, disc, is_own(index[i], &o), STP_OVER_NEED, &o);
    }
}

STP_WIDE
void stp_paired_lanes_points(stp_paired_lanes *out, const float centre[3], const float axes[2][3],
                             float radius)
{
    for (int c = 0; c < 3; c++) {
        const float middle = centre[c], u = axes[0][c] * radius, v = axes[1][c] * radius;
        for (unsigned i = 0; i < STP_DISC_LANES; i++)
            out->point[c][i] = middle;
        for (unsigned i = 0; i < STP_RIM_POINTS; i++)
            out->point[c][i + 1] = middle + (u * (float)stp_rim[0][i] + v * (float)stp_rim[1][i]);
    }
}

static inline void tell_paired(const stp_paired_lanes *lanes, stp_over_what what,
                               const stp_over *over, float value[STP_DISC_LANES])
{
    const stp_over o = *over;
    for (unsigned i = 0; i < STP_DISC_LANES; i++) {
        float point[3], disc[STP_LANE_NUMBERS];
        for (int c = 0; c < 3; c++)
            point[c] = lanes->point[c][i];
        for (int c = 0; c < STP_LANE_NUMBERS; c++)
            disc[c] = lanes->disc[c][i];
        value[i] = stp_lane_value(point, disc, is_own(lanes->index[i], &o), what, &o);
    }
}

STP_WIDE
uint32_t stp_paired_lanes_above(const stp_paired_lanes *lanes, const stp_over *over, float limit,
                                float value[STP_DISC_LANES])
{
    uint32_t bits = 0;
    if (over->what == STP_OVER_NEED)
        tell_paired(lanes, STP_OVER_NEED, over, value);
    else
        tell_paired(lanes, STP_OVER_COST, over, value);
    for (unsigned i = 0; i < STP_DISC_LANES; i++)
        bits |= (value[i] <= limit ? 0u : 1u) << i;
    return bits;
}

/* Costs and distances of points over discs, several at a time: one point over many discs, or pairs
 * of point and disc.
 *
 * Points, or discs, lie in lanes of floats, so the compiler takes four or more in one step: ten
 * times faster than one by one. Results are as exact as floats. If you need an exact number,
 * compute it for the chosen disc. Threads: any. */
#ifndef STP_FORMATS_CHUNK_MEASURE_DISC_LANES_H
#define STP_FORMATS_CHUNK_MEASURE_DISC_LANES_H

#include "base/error.h"
#include "base/vec.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/* Room for 17 points, in whole steps of eight. */
#define STP_DISC_LANES 24
/* Discs that are tried at a time. */
#define STP_LANE_STEP 8u

/* What is asked of a point over a disc: its cost (overhang.h), or what it needs if the disc may not
 * be the nearest, max(cost, distance - forgiven). */
typedef enum stp_over_what { STP_OVER_COST, STP_OVER_NEED } stp_over_what;

/* More than any value of a disc. */
#define STP_LANE_FAR 1e30f
/* Farther than any disc is from any point, and a float holds its square. */
#define STP_LANE_ANYWHERE 1e9f

/* What cost(p, d) needs to know besides p and d. */
typedef struct stp_over {
    stp_over_what what;
    float normal[3];     /* of p's merged disc */
    float error;         /* perpendicular error e */
    float forgiven;      /* of a need: the part of any distance that is allowed, e sin(gamma) */
    uint32_t begin, end; /* the discs under p's merged disc: [begin, end) */
} stp_over;

/* A disc and the errors that it carries. A zero normal makes it a ball. */
#define STP_LANE_NUMBERS 9
enum {
    STP_LANE_CENTRE = 0, /* x y z */
    STP_LANE_NORMAL = 3, /* x y z */
    STP_LANE_RADIUS = 6,
    STP_LANE_CARRIED = 7, /* t_d, tangential */
    STP_LANE_CARRIED_ERROR = 8
};

typedef struct stp_lane_disc {
    float numbers[STP_LANE_NUMBERS];
} stp_lane_disc;

/* Height h of a point over a disc (signed, *height) and overhang o in the disc's plane (returned).
 * Takes no difference of squares: floats would lose all digits. */
static inline float stp_lane_overhang(const float point[3], const float disc[STP_LANE_NUMBERS],
                                      float *height)
{
    const float *n = disc + STP_LANE_NORMAL;
    float x = point[0] - disc[0], y = point[1] - disc[1], z = point[2] - disc[2];
    *height = x * n[0] + y * n[1] + z * n[2];
    x -= *height * n[0];
    y -= *height * n[1];
    z -= *height * n[2];
    return fmaxf(sqrtf(x * x + y * y + z * z) - disc[STP_LANE_RADIUS], 0.0f);
}

/* cost(p, d) = o + t_d + min(a + b, h) as in overhang.h, and the squared distance. own: the disc is
 * one under p's merged disc. */
static inline float stp_lane_cost_squared(const float point[3], const float disc[STP_LANE_NUMBERS],
                                          bool own, const stp_over *over, float *squared)
{
    float height, overhang = stp_lane_overhang(point, disc, &height);
    *squared = height * height + overhang * overhang;
    const float *n = disc + STP_LANE_NORMAL, *m = over->normal;
    float cosine = n[0] * m[0] + n[1] * m[1] + n[2] * m[2];
    float x = n[0] - cosine * m[0], y = n[1] - cosine * m[1], z = n[2] - cosine * m[2];
    height = fabsf(height);
    float aside = own ? 0.0f : height * sqrtf(x * x + y * y + z * z);
    float high = height + disc[STP_LANE_CARRIED_ERROR];
    float beyond = sqrtf(fmaxf((high - over->error) * (high + over->error), 0.0f));
    float open = fminf(aside + beyond, height);
    return overhang + disc[STP_LANE_CARRIED] + open;
}

static inline float stp_lane_need(float cost, float squared, const stp_over *over)
{
    return fmaxf(cost, sqrtf(squared) - over->forgiven);
}

/* What is asked of the point (over->what, a constant to the compiler). */
static inline float stp_lane_value(const float point[3], const float disc[STP_LANE_NUMBERS],
                                   bool own, stp_over_what what, const stp_over *over)
{
    float squared, cost = stp_lane_cost_squared(point, disc, own, over, &squared);
    return what == STP_OVER_NEED ? stp_lane_need(cost, squared, over) : cost;
}

typedef float stp_step_lanes __attribute__((vector_size(4 * STP_LANE_STEP)));
/* The same, and half of it, anywhere in memory. */
typedef float stp_lanes_at __attribute__((vector_size(4 * STP_LANE_STEP), aligned(4), may_alias));
typedef float stp_half_at __attribute__((vector_size(2 * STP_LANE_STEP), aligned(4), may_alias));

/* Four numbers of two discs. */
static inline void stp_lane_discs_pair(const stp_lane_disc *one, const stp_lane_disc *other,
                                       unsigned first, stp_step_lanes *out)
{
    const stp_half_at *a = (const stp_half_at *)&one->numbers[first];
    const stp_half_at *b = (const stp_half_at *)&other->numbers[first];
    *out = __builtin_shufflevector(*a, *b, 0, 1, 2, 3, 4, 5, 6, 7);
}

/* Takes four numbers from each of the discs that `index` names: of[stride i] and those after it get
 * the ith of them. */
static inline void stp_lane_discs_take_four(const stp_lane_disc *discs,
                                            const uint32_t index[STP_LANE_STEP], unsigned first,
                                            float *of, size_t stride)
{
    stp_step_lanes a, b, c, d;
    stp_lane_discs_pair(&discs[index[0]], &discs[index[4]], first, &a);
    stp_lane_discs_pair(&discs[index[1]], &discs[index[5]], first, &b);
    stp_lane_discs_pair(&discs[index[2]], &discs[index[6]], first, &c);
    stp_lane_discs_pair(&discs[index[3]], &discs[index[7]], first, &d);
    const stp_step_lanes low = __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
    const stp_step_lanes high = __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
    const stp_step_lanes lower = __builtin_shufflevector(c, d, 0, 8, 1, 9, 4, 12, 5, 13);
    const stp_step_lanes higher = __builtin_shufflevector(c, d, 2, 10, 3, 11, 6, 14, 7, 15);
    *(stp_lanes_at *)of = __builtin_shufflevector(low, lower, 0, 1, 8, 9, 4, 5, 12, 13);
    *(stp_lanes_at *)(of + stride) =
        __builtin_shufflevector(low, lower, 2, 3, 10, 11, 6, 7, 14, 15);
    of += 2 * stride;
    *(stp_lanes_at *)of = __builtin_shufflevector(high, higher, 0, 1, 8, 9, 4, 5, 12, 13);
    *(stp_lanes_at *)(of + stride) =
        __builtin_shufflevector(high, higher, 2, 3, 10, 11, 6, 7, 14, 15);
}

/* Takes centres, normals and radii of the discs that `index` names: of[stride number + disc]. */
static inline void stp_lane_discs_take(const stp_lane_disc *discs,
                                       const uint32_t index[STP_LANE_STEP], float *of,
                                       size_t stride)
{
    stp_lane_discs_take_four(discs, index, STP_LANE_CENTRE, of, stride);
    stp_lane_discs_take_four(discs, index, STP_LANE_NORMAL, of + STP_LANE_NORMAL * stride, stride);
}

/* Discs as columns; disc[i] says which disc entry i is. */
typedef struct stp_disc_columns {
    float *of[STP_LANE_NUMBERS];
    uint32_t *disc;
} stp_disc_columns;

/* Fills the columns from the discs that out->disc[count] names; that array must have room for
 * STP_LANE_STEP more. If nothing is `carried`, the columns of carried errors are NULL. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_disc_columns_fill(stp_disc_columns *out, const stp_lane_disc *discs, uint32_t count,
                                 bool carried, stp_error *err);
void stp_disc_columns_clear(stp_disc_columns *columns);

/* The least value so far (over->what) and, of needs, the nearest disc's squared distance and cost.
 */
typedef struct stp_disc_best {
    float value, squared, cost;
} stp_disc_best;

/* Tries the entries [begin, begin + count), but may leave out discs that are `reach` away or
 * farther. Returns whether one is better. A cost leaves out what discs carry. */
bool stp_disc_columns_least(const stp_disc_columns *columns, uint32_t begin, uint32_t count,
                            const stp_over *over, const float point[3], float reach,
                            stp_disc_best *best);

/* The cost of a point over a disc that is not under its merged disc. */
float stp_lane_cost(const stp_lane_disc *disc, const stp_over *over, const float point[3]);

/* The need of a point over each of the discs that `index` names. */
void stp_lane_discs_tell(const stp_lane_disc *discs, const uint32_t index[STP_LANE_STEP],
                         const stp_over *over, const float point[3], float need[STP_LANE_STEP]);

/* Pairs of a point and a disc. */
typedef struct stp_paired_lanes {
    float point[3][STP_DISC_LANES];
    float disc[STP_LANE_NUMBERS][STP_DISC_LANES];
    uint32_t index[STP_DISC_LANES]; /* which disc */
} stp_paired_lanes;

/* Takes centre, normal and radius of each point's disc. */
static inline void stp_paired_lanes_take(stp_paired_lanes *lanes, const stp_lane_disc *discs)
{
    for (unsigned i = 0; i < STP_DISC_LANES; i += STP_LANE_STEP)
        stp_lane_discs_take(discs, lanes->index + i, &lanes->disc[0][i], STP_DISC_LANES);
}

/* The points of a disc, as stp_disc_points gives them. axes: the two that span its plane. */
void stp_paired_lanes_points(stp_paired_lanes *out, const float centre[3], const float axes[2][3],
                             float radius);
/* The cost or the need of each point over its disc, in value[]. Returns a bit for each point for
 * which this exceeds `limit`. */
uint32_t stp_paired_lanes_above(const stp_paired_lanes *lanes, const stp_over *over, float limit,
                                float value[STP_DISC_LANES]);

#endif

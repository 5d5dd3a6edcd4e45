/* Several points against one disc, several discs against one point, and points each against a disc
 * of its own: the centre and rim of merged discs over those they stand for.
 *
 * Points, or discs, lie in lanes of floats, so that the compiler takes four or more a step: ten
 * times faster than one by one. What is chosen is as exact as floats are; whoever wants exact
 * numbers computes them of the disc chosen. Threads: any. */
#ifndef STP_FORMATS_CHUNK_MEASURE_DISC_LANES_H
#define STP_FORMATS_CHUNK_MEASURE_DISC_LANES_H

#include "base/error.h"
#include "base/vec.h"

#include <stdbool.h>
#include <stdint.h>

/* Room for 17 points, in whole steps of four. */
#define STP_DISC_LANES 20
/* So many discs are tried at a time. */
#define STP_LANE_STEP 8u

typedef struct stp_disc_lanes {
    float x[STP_DISC_LANES], y[STP_DISC_LANES], z[STP_DISC_LANES];
    float squared[STP_DISC_LANES]; /* distance from the nearest disc so far */
    uint32_t nearest[STP_DISC_LANES];
    stp_dvec3 origin;
    double scale; /* lanes a unit of length */
} stp_disc_lanes;

/* count points (1 to STP_DISC_LANES) near origin, some units (> 0, else 1) about it; `first` is the
 * index of every point until a disc is tried. */
void stp_disc_lanes_begin(stp_disc_lanes *out, const stp_dvec3 *points, unsigned count,
                          stp_dvec3 origin, double unit, uint32_t first);

/* Takes the disc where it is nearer. A zero normal makes it a ball. */
void stp_disc_lanes_try(stp_disc_lanes *lanes, stp_dvec3 centre, stp_dvec3 normal, double radius,
                        uint32_t index);

/* What is asked of points over discs: what they count, or the square of their distance. */
typedef enum stp_over_what { STP_OVER_COUNT, STP_OVER_SQUARED } stp_over_what;

/* What decides how much a height over another disc counts: overhang.h. */
typedef struct stp_over {
    stp_over_what what;
    float normal[3];     /* of the merged disc whose points are asked */
    float error;         /* heights up to it are covered */
    float near_squared;  /* a disc farther than that is out of the question: it counts for 1e30 */
    uint32_t begin, end; /* discs over which covered heights count nothing: the patch's own */
} stp_over;

/* A disc and what it brings from below. A zero normal makes it a ball. */
#define STP_LANE_NUMBERS 9
enum {
    STP_LANE_CENTRE = 0, /* x y z */
    STP_LANE_NORMAL = 3, /* x y z */
    STP_LANE_RADIUS = 6,
    STP_LANE_CARRIED = 7, /* tangential */
    STP_LANE_CARRIED_ERROR = 8
};

typedef struct stp_lane_disc {
    float numbers[STP_LANE_NUMBERS];
} stp_lane_disc;

/* How high a point is over a disc, and how far it lies outside in its plane. No difference of
 * squares is taken, in which floats would lose all. */
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

/* Discs as columns, and which they are. */
typedef struct stp_disc_columns {
    float *of[STP_LANE_NUMBERS];
    uint32_t *disc;
} stp_disc_columns;

/* Columns of the discs that out->disc[count] names, which must have room for a step more; those of
 * what they bring are NULL if nothing is `carried`. Errors: OUT_OF_MEMORY. */
stp_status stp_disc_columns_fill(stp_disc_columns *out, const stp_lane_disc *discs, uint32_t count,
                                 bool carried, stp_error *err);
void stp_disc_columns_clear(stp_disc_columns *columns);

/* The one of the entries [begin, begin + count) over which a point counts least, or to which it is
 * nearest, if that is less than *least, which it then becomes; else UINT32_MAX. */
uint32_t stp_disc_columns_least(const stp_disc_columns *columns, uint32_t begin, uint32_t count,
                                const stp_over *over, const float point[3], float *least);

/* Whether a point counts at most `limit` over one of the discs that `index` names, or is no farther
 * from it. */
bool stp_lane_discs_reach(const stp_lane_disc *discs, const uint32_t index[STP_LANE_STEP],
                          const stp_over *over, const float point[3], float limit);

/* Points, each with a disc of its own. */
typedef struct stp_paired_lanes {
    float point[3][STP_DISC_LANES];
    float disc[STP_LANE_NUMBERS][STP_DISC_LANES];
    uint32_t index[STP_DISC_LANES]; /* of the disc */
} stp_paired_lanes;

/* The points of a disc, like stp_disc_points. axes: the two in its plane. */
void stp_paired_lanes_points(stp_paired_lanes *out, const float centre[3], const float axes[2][3],
                             float radius);
/* What each point counts over its disc, or its squared distance; returns a bit for each of more
 * than `limit`. */
uint32_t stp_paired_lanes_above(const stp_paired_lanes *lanes, const stp_over *over, float limit,
                                float counted[STP_DISC_LANES]);

#endif

/* Sums over points near a point, and the plane through them. Threads: any (pure functions). */
#ifndef STP_PREPROCESS_SURFACE_MOMENTS_H
#define STP_PREPROCESS_SURFACE_MOMENTS_H

#include "base/vec.h"

typedef float stp_float4 __attribute__((vector_size(16)));

/* Sum of w q q^T over weighted points, q = (x, y, z, 1). Places are relative to the point where
 * they are collected. The last row holds the sum of the places, and the total weight. */
typedef struct stp_moments {
    stp_float4 row[4];
} stp_moments;

static inline stp_float4 stp_moments_place(float x, float y, float z)
{
    return (stp_float4){x, y, z, 1.0f};
}

static inline void stp_moments_add_point(stp_moments *m, stp_float4 place)
{
    for (int r = 0; r < 4; r++)
        m->row[r] += place[r] * place;
}

/* Adds, with a weight, moments that were collected at another place. */
static inline void stp_moments_add(stp_moments *m, const stp_moments *other, stp_float4 place,
                                   float weight)
{
    stp_float4 d = place - (stp_float4){0.0f, 0.0f, 0.0f, 1.0f};
    stp_float4 t = other->row[3] + 0.5f * other->row[3][3] * d;
    for (int r = 0; r < 4; r++)
        m->row[r] += weight * (other->row[r] + d[r] * t + t[r] * d);
}

/* What a matrix of moments has besides what its symmetry repeats: xx, xy, xz, yy, yz, zz, x, y, z,
 * weight. */
#define STP_MOMENT_SUMS 10

static inline void stp_moments_get(const stp_moments *m, float sums[STP_MOMENT_SUMS])
{
    unsigned n = 0;
    for (unsigned r = 0; r < 3; r++)
        for (unsigned c = r; c < 3; c++)
            sums[n++] = m->row[r][c];
    for (unsigned c = 0; c < 4; c++)
        sums[n++] = m->row[3][c];
}

/* Neighbourhoods that are fitted at a time. */
#define STP_MOMENTS_LANES 8

/* Moments of several neighbourhoods. */
typedef struct stp_moment_columns {
    float of[STP_MOMENT_SUMS][STP_MOMENTS_LANES];
} stp_moment_columns;

/* Sets all but the weights: adds up `count` places of each neighbourhood, in their order. */
void stp_moments_sum(stp_moment_columns *out, const float places[][3][STP_MOMENTS_LANES],
                     unsigned count);

/* normal: direction of the points' least extent; zero if they lie on a line (Hoppe 1992). variance:
 * of the heights along it. roundness: det(C) (3 / trace(C))^3 of the covariance C; 1 if the extents
 * along all axes are equal, 0 on a plane. */
typedef struct stp_moments_plane {
    vec3s normal;
    float variance, roundness;
} stp_moments_plane;

void stp_moments_fit(const stp_moment_columns *m, stp_moments_plane out[STP_MOMENTS_LANES]);
/* The normal alone, of one neighbourhood: the same bits. */
vec3s stp_moments_normal(const stp_moments *m);
/* The roundness alone, the same but for rounding. */
float stp_moments_roundness(const stp_moments *m);
/* Like stp_moments_normal, but refines a direction that is near: cheaper, and the direction keeps
 * its side. *variance: of the heights along it. */
vec3s stp_moments_turn(const stp_moments *m, vec3s normal, float *variance);
/* Direction of the points' greatest extent, a unit vector. */
vec3s stp_moments_longest(const stp_moments *m);

#endif

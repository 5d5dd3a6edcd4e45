/* The plane through points. */
#include "preprocess/surface/moments.h"

#include "base/wide.h"

#include <math.h>
#include <string.h>

/* A second eigenvalue below this part of the first means a line: no normal. */
#define LINE_RATIO 1e-6

#define LANES STP_MOMENTS_LANES
/* Few are needed; of two roots near each other, each step leaves a quarter of the error. */
#define ROOT_STEPS 6

/* Covariance over its trace. */
typedef struct covariance {
    double xx, xy, xz, yy, yz, zz;
} covariance;

/* *trace: of the covariance times weight; if it is not positive, all is 0. */
static inline covariance covariance_from(const float sums[STP_MOMENT_SUMS], double *trace)
{
    const double x = (double)sums[6], y = (double)sums[7], z = (double)sums[8];
    const double weight = (double)sums[9], part = weight > 0.0 ? 1.0 / weight : 0.0;
    const double xx = (double)sums[0] - x * x * part, yy = (double)sums[3] - y * y * part;
    const double zz = (double)sums[5] - z * z * part, sum = xx + yy + zz;
    const double scale = sum > 0.0 ? 1.0 / sum : 0.0;
    *trace = sum;
    return (covariance){scale * xx,
                        scale * ((double)sums[1] - x * y * part),
                        scale * ((double)sums[2] - x * z * part),
                        scale * yy,
                        scale * ((double)sums[4] - y * z * part),
                        scale * zz};
}

static covariance covariance_of(const stp_moments *m, double *trace)
{
    float sums[STP_MOMENT_SUMS];
    stp_moments_get(m, sums);
    return covariance_from(sums, trace);
}

/* What a matrix C of trace 1 says of its least extent. */
typedef struct extents {
    double least, greatest; /* eigenvalues */
    double determinant;
    stp_dvec3 axis; /* unit vector of the least; zero if there is none */
} extents;

/* The least root of x^3 - x^2 + minors x - determinant, all of whose roots are real and not
 * negative. Laguerre's steps from 0 grow and never pass it (Wilkinson 1965). */
static inline double least_root(double minors, double determinant)
{
    double x = 0.0;
    for (int i = 0; i < ROOT_STEPS; i++) {
        const double value = ((x - 1.0) * x + minors) * x - determinant;
        const double slope = (3.0 * x - 2.0) * x + minors, bend = 6.0 * x - 2.0;
        const double square = 4.0 * slope * slope - 6.0 * value * bend;
        const double below = slope + sqrt(stp_max(square, 0.0));
        const double step = 3.0 * value / (below > 0.0 ? below : 1.0);
        x -= below > 0.0 ? step : 0.0;
    }
    return x;
}

/* Unit vector of the kernel of (C - value I): the longest cross product of two of its rows. No
 * branches, for vector instructions. */
static inline stp_dvec3 eigenvector(const covariance *c, double value)
{
    const double x = c->xx - value, y = c->yy - value, z = c->zz - value;
    const stp_dvec3 a = {c->xy * c->yz - c->xz * y, c->xz * c->xy - x * c->yz,
                         x * y - c->xy * c->xy};
    const stp_dvec3 b = {c->xy * z - c->xz * c->yz, c->xz * c->xz - x * z,
                         x * c->yz - c->xy * c->xz};
    const stp_dvec3 d = {y * z - c->yz * c->yz, c->yz * c->xz - c->xy * z,
                         c->xy * c->yz - y * c->xz};
    const double la = stp_dvec3_dot(a, a), lb = stp_dvec3_dot(b, b), ld = stp_dvec3_dot(d, d);
    const bool first = la >= lb, last = ld > stp_max(la, lb);
    const double length = last ? ld : first ? la : lb;
    const double scale = 1.0 / sqrt(length > 0.0 ? length : 1.0);
    return (stp_dvec3){scale * (last    ? d.x
                                : first ? a.x
                                        : b.x),
                       scale * (last    ? d.y
                                : first ? a.y
                                        : b.y),
                       scale * (last    ? d.z
                                : first ? a.z
                                        : b.z)};
}

static inline extents extents_of(const covariance *c)
{
    const double minors = c->xx * c->yy - c->xy * c->xy + c->xx * c->zz - c->xz * c->xz +
                          c->yy * c->zz - c->yz * c->yz;
    const double determinant = c->xx * (c->yy * c->zz - c->yz * c->yz) -
                               c->xy * (c->xy * c->zz - c->yz * c->xz) +
                               c->xz * (c->xy * c->yz - c->yy * c->xz);
    const double least = least_root(minors, determinant);
    const double others = 1.0 - least, product = minors - least * others;
    const double apart = sqrt(stp_max(others * others - 4.0 * product, 0.0));
    const double greatest = 0.5 * (others + apart);
    const bool is_plane = others - greatest > LINE_RATIO * greatest;
    const stp_dvec3 axis = eigenvector(c, least);
    return (extents){least, greatest, determinant, stp_dvec3_scale(axis, is_plane ? 1.0 : 0.0)};
}

/* What moments in columns say. */
typedef struct columns {
    double trace[LANES], least[LANES], determinant[LANES], x[LANES], y[LANES], z[LANES];
} columns;

STP_WIDE
static void solve(const stp_moment_columns *restrict m, columns *restrict s)
{
    for (int i = 0; i < LANES; i++) {
        float sums[STP_MOMENT_SUMS];
        for (int j = 0; j < STP_MOMENT_SUMS; j++)
            sums[j] = m->of[j][i];
        const covariance c = covariance_from(sums, &s->trace[i]);
        const extents e = extents_of(&c);
        s->least[i] = e.least;
        s->determinant[i] = e.determinant;
        s->x[i] = e.axis.x;
        s->y[i] = e.axis.y;
        s->z[i] = e.axis.z;
    }
}

typedef float lanes __attribute__((vector_size(4 * LANES)));

STP_WIDE
void stp_moments_sum(stp_moment_columns *out, const float places[][3][STP_MOMENTS_LANES],
                     unsigned count)
{
    lanes sums[STP_MOMENT_SUMS - 1] = {{0}};
    for (unsigned i = 0; i < count; i++) {
        lanes x, y, z;
        memcpy(&x, places[i][0], sizeof x);
        memcpy(&y, places[i][1], sizeof y);
        memcpy(&z, places[i][2], sizeof z);
        sums[0] += x * x;
        sums[1] += x * y;
        sums[2] += x * z;
        sums[3] += y * y;
        sums[4] += y * z;
        sums[5] += z * z;
        sums[6] += x;
        sums[7] += y;
        sums[8] += z;
    }
    memcpy(out->of, sums, sizeof sums);
}

void stp_moments_fit(const stp_moment_columns *m, stp_moments_plane out[STP_MOMENTS_LANES])
{
    columns s;
    solve(m, &s);
    for (int i = 0; i < LANES; i++)
        out[i] = (stp_moments_plane){
            stp_dvec3_to_float((stp_dvec3){s.x[i], s.y[i], s.z[i]}),
            (float)(stp_max(s.least[i], 0.0) * s.trace[i] / (double)m->of[9][i]),
            (float)(27.0 * s.determinant[i])};
}

vec3s stp_moments_normal(const stp_moments *m)
{
    double trace;
    const covariance c = covariance_of(m, &trace);
    return stp_dvec3_to_float(extents_of(&c).axis);
}

float stp_moments_roundness(const stp_moments *m)
{
    double trace;
    const covariance c = covariance_of(m, &trace);
    return (float)(27.0 * extents_of(&c).determinant);
}

/* Multiplies twice by the inverse covariance, without its determinant. */
vec3s stp_moments_turn(const stp_moments *m, vec3s normal, float *variance)
{
    double trace;
    const covariance c = covariance_of(m, &trace);
    stp_dvec3 r0 = {c.xx, c.xy, c.xz}, r1 = {c.xy, c.yy, c.yz}, r2 = {c.xz, c.yz, c.zz};
    stp_dvec3 a = stp_dvec3_cross(r1, r2), b = stp_dvec3_cross(r2, r0), d = stp_dvec3_cross(r0, r1);
    stp_dvec3 n = stp_dvec3_from_float(normal);
    for (int i = 0; i < 2; i++)
        n = stp_dvec3_normalize(
            (stp_dvec3){stp_dvec3_dot(a, n), stp_dvec3_dot(b, n), stp_dvec3_dot(d, n)});
    stp_dvec3 cn = {stp_dvec3_dot(r0, n), stp_dvec3_dot(r1, n), stp_dvec3_dot(r2, n)};
    *variance = (float)(stp_max(stp_dvec3_dot(cn, n), 0.0) * trace / (double)m->row[3][3]);
    return stp_dvec3_to_float(n);
}

vec3s stp_moments_longest(const stp_moments *m)
{
    double trace;
    const covariance c = covariance_of(m, &trace);
    const stp_dvec3 axis = eigenvector(&c, extents_of(&c).greatest);
    if (stp_dvec3_length(axis) > 0.5)
        return stp_dvec3_to_float(axis);
    /* The greatest two are equal, or all points lie on an axis. */
    if (c.xx >= c.yy && c.xx >= c.zz)
        return (vec3s){{1.0f, 0.0f, 0.0f}};
    return c.yy >= c.zz ? (vec3s){{0.0f, 1.0f, 0.0f}} : (vec3s){{0.0f, 0.0f, 1.0f}};
}

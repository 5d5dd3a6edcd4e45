/* The plane through points. */
#include "preprocess/surface/moments.h"

#include <math.h>

/* A second eigenvalue below this part of the first means a line: no normal. */
#define LINE_RATIO 1e-6

/* Covariance times weight. */
typedef struct covariance {
    double xx, xy, xz, yy, yz, zz;
} covariance;

static covariance covariance_of(const stp_moments *m)
{
    const stp_float4 *r = m->row;
    double x = (double)r[3][0], y = (double)r[3][1], z = (double)r[3][2];
    double scale = 1.0 / (double)r[3][3];
    return (covariance){(double)r[0][0] - x * x * scale, (double)r[0][1] - x * y * scale,
                        (double)r[0][2] - x * z * scale, (double)r[1][1] - y * y * scale,
                        (double)r[1][2] - y * z * scale, (double)r[2][2] - z * z * scale};
}
/* Eigenvalues of a symmetric 3x3 matrix, greatest first (Smith 1961). */
static void eigenvalues(const covariance *c, double out[3])
{
    double mean = (c->xx + c->yy + c->zz) / 3.0;
    double off = c->xy * c->xy + c->xz * c->xz + c->yz * c->yz;
    double a = c->xx - mean, b = c->yy - mean, d = c->zz - mean;
    double p = sqrt((a * a + b * b + d * d + 2.0 * off) / 6.0);
    if (!(p > 0.0)) {
        out[0] = out[1] = out[2] = mean;
        return;
    }
    double determinant = a * (b * d - c->yz * c->yz) - c->xy * (c->xy * d - c->yz * c->xz) +
                         c->xz * (c->xy * c->yz - b * c->xz);
    double r = determinant / (2.0 * p * p * p);
    double angle = acos(fmax(-1.0, fmin(1.0, r))) / 3.0;
    out[0] = mean + 2.0 * p * cos(angle);
    out[2] = mean + 2.0 * p * cos(angle + 2.0 * M_PI / 3.0);
    out[1] = 3.0 * mean - out[0] - out[2];
}

/* Unit vector of the kernel of (C - value I): the longest cross product of two of its rows. */
static stp_dvec3 eigenvector(const covariance *c, double value)
{
    stp_dvec3 r0 = {c->xx - value, c->xy, c->xz};
    stp_dvec3 r1 = {c->xy, c->yy - value, c->yz};
    stp_dvec3 r2 = {c->xz, c->yz, c->zz - value};
    stp_dvec3 a = stp_dvec3_cross(r0, r1);
    stp_dvec3 b = stp_dvec3_cross(r0, r2);
    stp_dvec3 d = stp_dvec3_cross(r1, r2);
    double la = stp_dvec3_dot(a, a), lb = stp_dvec3_dot(b, b), ld = stp_dvec3_dot(d, d);
    stp_dvec3 best = la >= lb && la >= ld ? a : lb >= ld ? b : d;
    return stp_dvec3_normalize(best);
}

vec3s stp_moments_normal(const stp_moments *m, float *variance)
{
    double values[3];
    covariance c = covariance_of(m);
    eigenvalues(&c, values);
    *variance = (float)fmax(values[2], 0.0) / m->row[3][3];
    if (!(values[1] > LINE_RATIO * values[0]))
        return (vec3s){{0.0f, 0.0f, 0.0f}};
    return stp_dvec3_to_float(eigenvector(&c, values[2]));
}

/* Multiplies twice by the inverse covariance, without its determinant. */
vec3s stp_moments_turn(const stp_moments *m, vec3s normal, float *variance)
{
    covariance c = covariance_of(m);
    stp_dvec3 r0 = {c.xx, c.xy, c.xz}, r1 = {c.xy, c.yy, c.yz}, r2 = {c.xz, c.yz, c.zz};
    stp_dvec3 a = stp_dvec3_cross(r1, r2), b = stp_dvec3_cross(r2, r0), d = stp_dvec3_cross(r0, r1);
    stp_dvec3 n = stp_dvec3_from_float(normal);
    for (int i = 0; i < 2; i++)
        n = stp_dvec3_normalize(
            (stp_dvec3){stp_dvec3_dot(a, n), stp_dvec3_dot(b, n), stp_dvec3_dot(d, n)});
    stp_dvec3 cn = {stp_dvec3_dot(r0, n), stp_dvec3_dot(r1, n), stp_dvec3_dot(r2, n)};
    *variance = (float)fmax(stp_dvec3_dot(cn, n), 0.0) / m->row[3][3];
    return stp_dvec3_to_float(n);
}

vec3s stp_moments_longest(const stp_moments *m)
{
    double values[3];
    covariance c = covariance_of(m);
    eigenvalues(&c, values);
    const stp_dvec3 axis = eigenvector(&c, values[0]);
    if (stp_dvec3_length(axis) > 0.5)
        return stp_dvec3_to_float(axis);
    /* The greatest two are equal, or all points lie on an axis. */
    if (c.xx >= c.yy && c.xx >= c.zz)
        return (vec3s){{1.0f, 0.0f, 0.0f}};
    return c.yy >= c.zz ? (vec3s){{0.0f, 1.0f, 0.0f}} : (vec3s){{0.0f, 0.0f, 1.0f}};
}

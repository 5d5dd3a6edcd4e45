/* Normals from neighbourhoods. */
#include "preprocess/normals.h"

#include "base/memory.h"
#include "preprocess/layer.h"

#include <stdlib.h>

/* A second eigenvalue below this part of the first means a line: no normal. */
#define LINE_RATIO 1e-6
/* Fewer neighbours are no second sheet. */
#define LAYER_POINTS 4u

typedef struct estimation {
    const stp_cloud *cloud;
    const stp_neighbours *neighbours;
    vec3s *normals; /* as fitted */
} estimation;

typedef struct covariance {
    double xx, xy, xz, yy, yz, zz;
} covariance;

/* About the mean of the listed points, and of the point itself if with_self. */
static covariance covariance_of(const stp_cloud *cloud, uint32_t self, const uint32_t *list,
                                unsigned count, bool with_self)
{
    stp_dvec3 p = cloud->points[self].position;
    stp_dvec3 mean = {0.0, 0.0, 0.0};
    covariance c = {0};
    for (unsigned i = 0; i < count; i++) {
        stp_dvec3 d = stp_dvec3_sub(cloud->points[list[i]].position, p);
        mean = stp_dvec3_add(mean, d);
        c.xx += d.x * d.x;
        c.xy += d.x * d.y;
        c.xz += d.x * d.z;
        c.yy += d.y * d.y;
        c.yz += d.y * d.z;
        c.zz += d.z * d.z;
    }
    double n = (double)count + (with_self ? 1.0 : 0.0); /* the point itself is the origin */
    c.xx -= mean.x * mean.x / n;
    c.xy -= mean.x * mean.y / n;
    c.xz -= mean.x * mean.z / n;
    c.yy -= mean.y * mean.y / n;
    c.yz -= mean.y * mean.z / n;
    c.zz -= mean.z * mean.z / n;
    return c;
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

static unsigned known_count(const uint32_t *list, unsigned k)
{
    unsigned count = 0;
    while (count < k && list[count] != STP_NEIGHBOUR_NONE)
        count++;
    return count;
}

/* Direction of least extent, zero on a line; *thickness: sum of the squares along it. */
static vec3s normal_of(const covariance *c, double *thickness)
{
    double values[3];
    eigenvalues(c, values);
    *thickness = values[2];
    if (!(values[1] > LINE_RATIO * values[0]))
        return (vec3s){{0.0f, 0.0f, 0.0f}};
    return stp_dvec3_to_float(eigenvector(c, values[2]));
}

/* Least sum of squared heights about their mean of `count` points and the point itself, of which
 * enough for a second sheet lie beyond a gap: all of them on one side, few or all but a few. */
static double two_sheet_thickness(unsigned count, float spacing)
{
    double gap = (double)(STP_LAYER_GAP * spacing);
    double n = count + 1.0;
    double beyond = LAYER_POINTS;
    return 0.999 * gap * gap * beyond * (n - beyond) / n;
}

/* A plane through all neighbours; where they lie on two sheets, one direction for both, each about
 * its own mean, so that their distance does not tilt it. */
static vec3s fit(const stp_cloud *cloud, const stp_neighbours *neighbours, uint32_t self)
{
    const uint32_t *list = neighbours->indices + (size_t)self * neighbours->k;
    unsigned count = known_count(list, neighbours->k);
    if (count < 3)
        return (vec3s){{0.0f, 0.0f, 0.0f}};
    covariance c = covariance_of(cloud, self, list, count, true);
    double thickness = 0.0;
    vec3s normal = normal_of(&c, &thickness);
    if (thickness < two_sheet_thickness(count, cloud->points[self].spacing))
        return normal; /* too thin: what follows would find one sheet */
    stp_layer layer = stp_layer_find(cloud, self, normal, list, count);
    uint32_t same[STP_NEIGHBOURS_LIMIT], others[STP_NEIGHBOURS_LIMIT];
    unsigned same_count = 0, other_count = 0;
    for (unsigned i = 0; i < count; i++) {
        if (stp_layer_holds(layer, stp_layer_height(cloud, self, normal, list[i])))
            same[same_count++] = list[i];
        else
            others[other_count++] = list[i];
    }
    if (same_count < LAYER_POINTS || other_count < LAYER_POINTS)
        return normal;
    covariance a = covariance_of(cloud, self, same, same_count, true);
    covariance b = covariance_of(cloud, self, others, other_count, false);
    c = (covariance){a.xx + b.xx, a.xy + b.xy, a.xz + b.xz, a.yy + b.yy, a.yz + b.yz, a.zz + b.zz};
    return normal_of(&c, &thickness);
}

/* Weight of a neighbour's normal: falls with the distance (squared, in spacings), with the offset
 * from the tangent plane and with the angle; negative where the signs disagree. */
static float weight_of(float cosine, float offset, float distance)
{
    float closeness = fabsf(cosine) - 0.9f;
    float beside = fabsf(offset) <= 1.0f ? 10.0f : 0.0f;
    float x = 0.25f * distance; /* e^-x to a thousandth where neighbours lie */
    float decay = 1.0f + x * (1.0f + x * (0.5f + x * (1.0f / 6.0f + x / 24.0f)));
    closeness = closeness > 0.0f ? closeness : 0.0f;
    return copysignf(closeness, cosine) * beside / decay;
}

/* Averages a fitted normal with those of neighbours that lie on the same piece of surface. Takes
 * the noise out of a fit over k points without rounding edges. */
static vec3s smooth(const estimation *e, uint32_t self)
{
    const stp_cloud *cloud = e->cloud;
    const uint32_t *list = e->neighbours->indices + (size_t)self * e->neighbours->k;
    const stp_cloud_point *point = &cloud->points[self];
    float scale = 1.0f / point->spacing;
    float dx[STP_NEIGHBOURS_LIMIT], dy[STP_NEIGHBOURS_LIMIT], dz[STP_NEIGHBOURS_LIMIT];
    float mx[STP_NEIGHBOURS_LIMIT], my[STP_NEIGHBOURS_LIMIT], mz[STP_NEIGHBOURS_LIMIT];
    unsigned count = known_count(list, e->neighbours->k);
    for (unsigned i = 0; i < count; i++) {
        stp_dvec3 d = stp_dvec3_sub(cloud->points[list[i]].position, point->position);
        vec3s m = e->normals[list[i]];
        dx[i] = (float)d.x * scale, dy[i] = (float)d.y * scale, dz[i] = (float)d.z * scale;
        mx[i] = m.x, my[i] = m.y, mz[i] = m.z;
    }
    vec3s n = e->normals[self];
    for (unsigned i = 0; i < count; i++) { /* by columns, for vector instructions */
        float weight = weight_of(n.x * mx[i] + n.y * my[i] + n.z * mz[i],
                                 n.x * dx[i] + n.y * dy[i] + n.z * dz[i],
                                 dx[i] * dx[i] + dy[i] * dy[i] + dz[i] * dz[i]);
        mx[i] *= weight;
        my[i] *= weight;
        mz[i] *= weight;
    }
    for (unsigned i = 0; i < count; i++)
        n = (vec3s){{n.x + mx[i], n.y + my[i], n.z + mz[i]}};
    return glms_vec3_normalize(n);
}

stp_status stp_normals_estimate(stp_unit *unit, stp_error *err)
{
    stp_status status = STP_OK;
    estimation e = {.cloud = &unit->cloud, .neighbours = &unit->neighbours};
    stp_cloud_point *points = unit->cloud.points;
    uint32_t fitted = stp_unit_inner(unit, 2), smoothed = stp_unit_inner(unit, 3);
    STP_TRY(stp_alloc(&e.normals, fitted, sizeof *e.normals, "normals", err));
    for (uint32_t i = 0; i < fitted; i++)
        e.normals[i] = points[i].given ? points[i].normal : fit(&unit->cloud, &unit->neighbours, i);
    for (uint32_t i = 0; i < smoothed; i++) {
        if (points[i].given || glms_vec3_norm2(e.normals[i]) == 0.0f)
            continue;
        points[i].normal = points[i].spacing > 0.0f ? smooth(&e, i) : e.normals[i];
    }
done:
    free(e.normals);
    return status;
}

/* Fits a plane to a whole cloud. */
#include "preprocess/viewpoint/broad_side.h"

#include "base/earth.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/surface/moments.h"

#include <math.h>
#include <stdlib.h>

#define POINTS 16384u
/* Flat: its thickness, a standard deviation, is at most this part of its breadth. Narrower than
 * STRIP_LEAST of its length it is a strip, of a road or a wire. */
#define FLAT_MOST 0.08
#define STRIP_LEAST 0.02
/* It lies level if its normal has more than this cosine to what is up. */
#define LEVEL_COSINE 0.85
/* y is up in place of z only if it lies so much more along the side. */
#define Y_LEAST 0.1
/* What leans by more than this cosine, as a roof does, is seen from above. */
#define LEANS_COSINE 0.3
/* Mean of the given normals along the normal that tells a side. */
#define FACING_LEAST 0.2

/* Variance of places along an axis. */
static double variance_along(const stp_cloud_point *points, uint32_t count, stp_dvec3 middle,
                             stp_dvec3 axis)
{
    double sum = 0.0, squares = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        const double d = stp_dvec3_dot(stp_dvec3_sub(points[i].position, middle), axis);
        sum += d;
        squares += d * d;
    }
    return fmax(squares / count - sum / count * (sum / count), 0.0);
}

/* The direction in which points are thin, if they are so; else zero. */
static stp_dvec3 thin_axis(const stp_cloud_point *points, uint32_t count, const stp_dbox *box)
{
    const stp_dvec3 middle = stp_dbox_middle(box);
    const double scale = 1.0 / fmax(stp_dbox_side(box), 1e-300);
    stp_moments m = {0};
    for (uint32_t i = 0; i < count; i++) {
        const stp_dvec3 p = stp_dvec3_scale(stp_dvec3_sub(points[i].position, middle), scale);
        stp_moments_add_point(&m, stp_moments_place((float)p.x, (float)p.y, (float)p.z));
    }
    const stp_dvec3 normal = stp_dvec3_from_float(stp_moments_normal(&m));
    const stp_dvec3 length = stp_dvec3_from_float(stp_moments_longest(&m));
    const double thick = variance_along(points, count, middle, normal);
    const double lengthwise = variance_along(points, count, middle, length);
    const double broad = variance_along(points, count, middle, stp_dvec3_cross(normal, length));
    const bool flat = thick <= FLAT_MOST * FLAT_MOST * broad &&
                      broad >= STRIP_LEAST * STRIP_LEAST * lengthwise && broad > 0.0;
    return flat ? normal : (stp_dvec3){0.0, 0.0, 0.0};
}

/* Turns the normal to the side that is to be seen. */
static stp_dvec3 to_front(stp_dvec3 normal, const stp_cloud_point *points, uint32_t count,
                          stp_dvec3 up)
{
    double facing = 0.0;
    for (uint32_t i = 0; i < count; i++)
        if (points[i].given == STP_GIVEN_INPUT)
            facing += stp_dvec3_dot(stp_dvec3_from_float(points[i].normal), normal);
    if (fabs(facing) < FACING_LEAST * count) {
        const bool leans = fabs(stp_dvec3_dot(up, normal)) > LEANS_COSINE;
        facing = stp_dvec3_dot(leans ? up : stp_whole_direction_over(up), normal);
    }
    return facing < 0.0 ? stp_dvec3_scale(normal, -1.0) : normal;
}

stp_status stp_broad_side_find(stp_broad_side *out, const stp_cloud *cloud, const stp_dbox *box,
                               stp_dvec3 up, stp_error *err)
{
    stp_cloud_point *points = NULL;
    uint32_t listed = 0, count = 0;
    const stp_status status =
        stp_cloud_every(cloud, cloud->count / POINTS + 1, &points, &listed, err);
    if (status != STP_OK)
        return status;
    for (uint32_t i = 0; i < listed; i++)
        if (stp_dbox_distance_squared(box, points[i].position) == 0.0)
            points[count++] = points[i];
    *out = (stp_broad_side){.up = up};
    const stp_dvec3 n = count > 0 ? thin_axis(points, count, box) : (stp_dvec3){0.0, 0.0, 0.0};
    if (stp_dvec3_length(up) == 0.0)
        out->up = fabs(n.y) < fabs(n.z) - Y_LEAST ? (stp_dvec3){0.0, 1.0, 0.0}
                                                  : (stp_dvec3){0.0, 0.0, 1.0};
    const bool ground = stp_dvec3_length(up) == 0.0 && fabs(n.z) > LEVEL_COSINE;
    out->found =
        stp_dvec3_length(n) > 0.0 && !ground && fabs(stp_dvec3_dot(n, out->up)) <= LEVEL_COSINE;
    out->normal = to_front(n, points, count, out->up);
    free(points);
    return STP_OK;
}

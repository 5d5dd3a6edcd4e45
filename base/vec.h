/* Double-precision 3-vectors and axis-aligned boxes; single-precision ones are cglm's vec3s.
 *
 * World coordinates are doubles (georeferenced scans keep their millimetres); everything relative
 * to a cell, chunk or patch is float. */
#ifndef STP_BASE_VEC_H
#define STP_BASE_VEC_H

#include "base/vec_types.h"

#include <cglm/struct/vec3.h>
#include <math.h>
#include <stdbool.h>

/* The greater and the lesser of two numbers that are not NaN. Each is one instruction; fmax is a
 * call. */
static inline double stp_max(double a, double b)
{
    return a > b ? a : b;
}

static inline double stp_min(double a, double b)
{
    return a < b ? a : b;
}

static inline stp_dvec3 stp_dvec3_add(stp_dvec3 a, stp_dvec3 b)
{
    return (stp_dvec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline stp_dvec3 stp_dvec3_sub(stp_dvec3 a, stp_dvec3 b)
{
    return (stp_dvec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline bool stp_dvec3_equal(stp_dvec3 a, stp_dvec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static inline stp_dvec3 stp_dvec3_scale(stp_dvec3 a, double s)
{
    return (stp_dvec3){a.x * s, a.y * s, a.z * s};
}

static inline double stp_dvec3_dot(stp_dvec3 a, stp_dvec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline stp_dvec3 stp_dvec3_cross(stp_dvec3 a, stp_dvec3 b)
{
    return (stp_dvec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline double stp_dvec3_length(stp_dvec3 a)
{
    return sqrt(stp_dvec3_dot(a, a));
}

/* The zero vector stays zero. */
static inline stp_dvec3 stp_dvec3_normalize(stp_dvec3 a)
{
    double length = stp_dvec3_length(a);
    return length > 0.0 ? stp_dvec3_scale(a, 1.0 / length) : a;
}

/* The greatest absolute coordinate. */
static inline double stp_dvec3_reach(stp_dvec3 a)
{
    return fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z)));
}

/* Completes a unit vector, the third axis, to right-handed axes. */
static inline void stp_dvec3_axes(stp_dvec3 axes[3], stp_dvec3 third)
{
    const stp_dvec3 other =
        fabs(third.y) < 0.7 ? (stp_dvec3){0.0, 1.0, 0.0} : (stp_dvec3){1.0, 0.0, 0.0};
    axes[2] = third;
    axes[0] = stp_dvec3_normalize(stp_dvec3_cross(other, third));
    axes[1] = stp_dvec3_cross(third, axes[0]);
}

/* v rotated about a unit axis (Rodrigues). */
static inline stp_dvec3 stp_dvec3_rotate(stp_dvec3 v, stp_dvec3 axis, double angle_rad)
{
    double c = cos(angle_rad), s = sin(angle_rad);
    stp_dvec3 along = stp_dvec3_scale(axis, stp_dvec3_dot(axis, v) * (1.0 - c));
    stp_dvec3 turned =
        stp_dvec3_add(stp_dvec3_scale(v, c), stp_dvec3_scale(stp_dvec3_cross(axis, v), s));
    return stp_dvec3_add(turned, along);
}

static inline stp_dvec3 stp_dvec3_from_float(vec3s a)
{
    return (stp_dvec3){(double)a.x, (double)a.y, (double)a.z};
}

static inline vec3s stp_dvec3_to_float(stp_dvec3 a)
{
    return (vec3s){{(float)a.x, (float)a.y, (float)a.z}};
}

static inline bool stp_dvec3_finite(stp_dvec3 a)
{
    return isfinite(a.x) && isfinite(a.y) && isfinite(a.z);
}

/* The empty box: adding a point gives that point's box. */
static inline stp_dbox stp_dbox_empty(void)
{
    return (stp_dbox){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

static inline void stp_dbox_add(stp_dbox *box, stp_dvec3 p)
{
    box->min =
        (stp_dvec3){stp_min(p.x, box->min.x), stp_min(p.y, box->min.y), stp_min(p.z, box->min.z)};
    box->max =
        (stp_dvec3){stp_max(p.x, box->max.x), stp_max(p.y, box->max.y), stp_max(p.z, box->max.z)};
}

/* Joining an empty box changes nothing. */
static inline void stp_dbox_join(stp_dbox *box, const stp_dbox *other)
{
    const stp_dvec3 low = other->min, high = other->max;
    box->min = (stp_dvec3){stp_min(low.x, box->min.x), stp_min(low.y, box->min.y),
                           stp_min(low.z, box->min.z)};
    box->max = (stp_dvec3){stp_max(high.x, box->max.x), stp_max(high.y, box->max.y),
                           stp_max(high.z, box->max.z)};
}

/* The box with a margin on all sides. */
static inline stp_dbox stp_dbox_grown(const stp_dbox *box, double margin)
{
    const stp_dvec3 by = {margin, margin, margin};
    return (stp_dbox){stp_dvec3_sub(box->min, by), stp_dvec3_add(box->max, by)};
}

/* Length of the longest side. */
static inline double stp_dbox_side(const stp_dbox *box)
{
    const stp_dvec3 size = stp_dvec3_sub(box->max, box->min);
    return fmax(size.x, fmax(size.y, size.z));
}

/* Guesses the up axis from the box's shape: z if the box is less than half as high in z as it is
 * long in both x and y (a surveyed terrain), else y. */
static inline stp_dvec3 stp_dbox_up(const stp_dbox *box)
{
    const stp_dvec3 size = stp_dvec3_sub(box->max, box->min);
    const bool z = size.z < 0.5 * size.x && size.z < 0.5 * size.y;
    return (stp_dvec3){0.0, z ? 0.0 : 1.0, z ? 1.0 : 0.0};
}

static inline stp_dvec3 stp_dbox_middle(const stp_dbox *box)
{
    return stp_dvec3_scale(stp_dvec3_add(box->min, box->max), 0.5);
}

/* Whether x and y are map coordinates: both lie 8 longest sides of the box away from the origin. No
 * model of its own lies so far out. */
static inline bool stp_dbox_is_map(const stp_dbox *box)
{
    const stp_dvec3 middle = stp_dbox_middle(box);
    const double far = 8.0 * stp_dbox_side(box);
    return fabs(middle.x) > far && fabs(middle.y) > far;
}

/* From where a whole model is seen, if y or z is up, or y down as for cameras that look along z:
 * the front, a little from the right and above. Not a unit vector. */
static inline stp_dvec3 stp_whole_direction(stp_dvec3 up)
{
    if (up.y < -0.5)
        return (stp_dvec3){0.35, -0.25, -1.0};
    return up.z > 0.5 ? (stp_dvec3){0.3, -1.0, 0.7} : (stp_dvec3){0.35, 0.25, 1.0};
}

/* Whether the boxes share a point. */
static inline bool stp_dbox_meet(const stp_dbox *a, const stp_dbox *b)
{
    return a->min.x <= b->max.x && b->min.x <= a->max.x && a->min.y <= b->max.y &&
           b->min.y <= a->max.y && a->min.z <= b->max.z && b->min.z <= a->max.z;
}

/* Squared distance from p to the box; 0 inside. */
static inline double stp_dbox_distance_squared(const stp_dbox *box, stp_dvec3 p)
{
    double dx = stp_max(0.0, stp_max(box->min.x - p.x, p.x - box->max.x));
    double dy = stp_max(0.0, stp_max(box->min.y - p.y, p.y - box->max.y));
    double dz = stp_max(0.0, stp_max(box->min.z - p.z, p.z - box->max.z));
    return dx * dx + dy * dy + dz * dz;
}

static inline bool stp_dbox_is_empty(const stp_dbox *box)
{
    return !(box->min.x <= box->max.x && box->min.y <= box->max.y && box->min.z <= box->max.z);
}

#endif

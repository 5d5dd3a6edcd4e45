/* Computes the ellipses of pixels: "The ellipse" of shaders/README.md. */
#include "tests/support/reference_parts.h"

#include <math.h>

/* The least semi-axes. */
static double floor_px(const reference_pyramid *pyramid, const reference_pixel *p)
{
    if (reference_is_line(p))
        return 0.5;
    return reference_sees_all(pyramid) ? 0.75 : 1.25;
}

double reference_radius_px(const reference_pyramid *pyramid, const reference_pixel *p)
{
    return fmax(p->radius * reference_pixels_per_unit(&pyramid->view, p->z_min),
                floor_px(pyramid, p));
}

/* Returns s, the point where the ray meets the disc's plane, in radii from the disc's centre. If
 * that point is behind the eye, s is infinite; in orthographic views this holds only for filters
 * that ask for depths. */
static stp_dvec3 ellipse_place(const reference_pyramid *pyramid, const reference_pixel *p,
                               double cx, double cy, double x, double y, double least_px)
{
    double radius = reference_radius_px(pyramid, p);
    stp_dvec3 w = reference_ray(&pyramid->view, cx + x, cy + y); /* through the point asked */
    stp_dvec3 delta = {x / radius, y / radius, 0.0};
    stp_dvec3 n = reference_is_tube(p) ? stp_dvec3_scale(w, -1.0) : p->normal;
    double k = stp_dvec3_dot(n, w);
    double least = fmin(1.0, least_px / radius);
    double k_floored = (k > 0.0 ? 1.0 : -1.0) * fmax(fabs(k), least);
    stp_dvec3 s = stp_dvec3_sub(delta, stp_dvec3_scale(w, stp_dvec3_dot(delta, n) / k_floored));
    double depth = p->z_min - s.z * radius / reference_pixels_per_unit(&pyramid->view, p->z_min);
    return depth > 0.0 || (pyramid->view.orthographic && pyramid->filter < REFERENCE_SPLAT)
               ? s
               : (stp_dvec3){INFINITY, INFINITY, 0.0};
}

/* The q of an ellipse whose minor semi-axis is at least least_px. */
double reference_ellipse_least(const reference_pyramid *pyramid, const reference_pixel *p,
                               double cx, double cy, double x, double y, double least_px)
{
    if (!(p->radius > 0.0))
        return x == 0.0 && y == 0.0 ? 0.0 : INFINITY;
    stp_dvec3 s = ellipse_place(pyramid, p, cx, cy, x, y, least_px);
    return stp_dvec3_dot(s, s);
}

double reference_ellipse(const reference_pyramid *pyramid, const reference_pixel *p, double cx,
                         double cy, double x, double y)
{
    return reference_ellipse_least(pyramid, p, cx, cy, x, y, floor_px(pyramid, p));
}

double reference_gap(const reference_pyramid *pyramid, const reference_pixel *p, double q)
{
    double reach = 1.0 + floor_px(pyramid, p) / reference_radius_px(pyramid, p);
    return pyramid->grid ? fmin(q, reach * reach) : q;
}

double reference_meet(const reference_pyramid *pyramid, const reference_pixel *p, double cx,
                      double cy, double u, double v, double *depth)
{
    *depth = p->z_min;
    if (!(p->radius > 0.0))
        return u == cx && v == cy ? 0.0 : INFINITY;
    stp_dvec3 s = ellipse_place(pyramid, p, cx, cy, u - cx, v - cy, floor_px(pyramid, p));
    *depth -=
        s.z * reference_radius_px(pyramid, p) / reference_pixels_per_unit(&pyramid->view, p->z_min);
    return stp_dvec3_dot(s, s);
}

/* Helpers that the files of the reference share. */
#ifndef STP_TESTS_SUPPORT_REFERENCE_PARTS_H
#define STP_TESTS_SUPPORT_REFERENCE_PARTS_H

#include "formats/chunk/sample/sample.h"
#include "tests/support/reference.h"

/* The ray through window coordinates, a unit vector. */
static inline stp_dvec3 reference_ray(const stp_view *view, double u, double v)
{
    if (view->orthographic)
        return (stp_dvec3){0.0, 0.0, -1.0};
    return stp_dvec3_normalize((stp_dvec3){(u - stp_view_axis_x(view)) / view->f,
                                           (v - stp_view_axis_y(view)) / view->f, -1.0});
}

/* How many pixels a world unit covers. */
static inline double reference_pixels_per_unit(const stp_view *view, double depth)
{
    return view->orthographic ? view->f : view->f / depth;
}

/* True for splats and templates. */
static inline bool reference_sees_all(const reference_pyramid *pyramid)
{
    return pyramid->filter == REFERENCE_SPLAT || pyramid->filter >= REFERENCE_TEMPLATE3;
}

/* By the tag. */
static inline bool reference_two_sided(const reference_pixel *p)
{
    return p->tag != 0 && ((p->tag - 1) & 8) != 0;
}

/* A tube's normal is its tangent. */
static inline bool reference_is_tube(const reference_pixel *p)
{
    return p->tag != 0 && ((p->tag - 1) & 3) == STP_KIND_TUBE;
}

/* A ribbon or a tube. */
static inline bool reference_is_line(const reference_pixel *p)
{
    unsigned kind = (unsigned)(p->tag - 1) & 3;
    return p->tag != 0 && (kind == STP_KIND_RIBBON || kind == STP_KIND_TUBE);
}

static inline bool reference_is_polygon(const reference_pixel *p)
{
    return p->tag != 0 && ((p->tag - 1) & 3) == STP_KIND_POLYGON;
}

/* reference_ellipse, for an ellipse whose minor semi-axis is at least least_px. */
double reference_ellipse_least(const reference_pyramid *pyramid, const reference_pixel *p,
                               double cx, double cy, double x, double y, double least_px);

/* Up to which q, at most the given one, an ellipse closes a gap. */
double reference_gap(const reference_pyramid *pyramid, const reference_pixel *p, double q);

#endif

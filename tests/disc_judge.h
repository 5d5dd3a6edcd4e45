/* What one disc covers of a picture, found by meeting the rays of pixels with its plane, in double
 * and without the shaders' formulas. The eye is at the origin and looks along -z. */
#ifndef STP_TESTS_DISC_JUDGE_H
#define STP_TESTS_DISC_JUDGE_H

#include "tests/disc_fixture.h"

/* Whether a pixel may be covered. */
typedef enum disc_cover {
    DISC_OUTSIDE = 0,
    DISC_WITHIN_FLOOR = 1, /* not more than the ellipses' floor beyond the disc */
    DISC_INSIDE = 2
} disc_cover;

typedef struct disc_judge {
    const stp_view *view;
    stp_dvec3 centre, normal; /* zero: the disc faces the ray it is met with */
    double radius;
    double floor_px; /* least semi-axes */
} disc_judge;

/* The point of a ray at a depth; the ray through window (u, v). */
static inline stp_dvec3 disc_judge_at(const stp_view *view, double u, double v, double depth)
{
    double scale = (view->orthographic ? 1.0 : depth) / view->f;
    return (stp_dvec3){(u - 0.5 * view->width) * scale, (v - 0.5 * view->height) * scale, -depth};
}

/* Whether the ray through window (u, v) meets the disc in front of the eye. */
static inline bool disc_judge_meets(const disc_judge *j, double u, double v)
{
    stp_dvec3 from = disc_judge_at(j->view, u, v, 0.0), at = disc_judge_at(j->view, u, v, 1.0);
    stp_dvec3 ray = stp_dvec3_sub(at, from), to_centre = stp_dvec3_sub(j->centre, from);
    stp_dvec3 normal = stp_dvec3_length(j->normal) > 0.0 ? j->normal : ray;
    double depth = stp_dvec3_dot(normal, to_centre) / stp_dvec3_dot(normal, ray);
    stp_dvec3 met = stp_dvec3_add(from, stp_dvec3_scale(ray, depth));
    return (depth > 0.0 || j->view->orthographic) &&
           stp_dvec3_length(stp_dvec3_sub(met, j->centre)) <= j->radius * (1.0 + 1e-4);
}

/* How much wider a ball is in the picture's corner than on the axis. */
static inline double disc_judge_widening(const stp_view *view)
{
    return view->orthographic ? 1.0
                              : hypot(hypot(0.5 * view->width, 0.5 * view->height) / view->f, 1.0);
}

/* Lets the pixels around a place be covered. */
static inline void disc_judge_allow(const disc_judge *j, stp_dvec3 place, uint8_t *cover)
{
    const stp_view *view = j->view;
    double scale = view->orthographic ? view->f : view->f / -place.z;
    double u = 0.5 * view->width + scale * place.x, v = 0.5 * view->height + scale * place.y;
    double reach = j->floor_px * disc_judge_widening(view);
    if (!(place.z < 0.0 || view->orthographic) || !(u > -reach && u < view->width + reach) ||
        !(v > -reach && v < view->height + reach))
        return;
    for (int y = (int)floor(v - reach); y <= (int)floor(v + reach); y++)
        for (int x = (int)floor(u - reach); x <= (int)floor(u + reach); x++)
            if (x >= 0 && y >= 0 && x < view->width && y < view->height &&
                hypot(x + 0.5 - u, y + 0.5 - v) <= reach && cover[y * view->width + x] == 0)
                cover[y * view->width + x] = DISC_WITHIN_FLOOR;
}

/* Along the rim, and from rim to rim: a disc seen from its edge has nothing inside. */
static inline void disc_judge_allow_rim(const disc_judge *j, uint8_t *cover)
{
    enum { STEPS = 1 << 14 };
    stp_dvec3 n = stp_dvec3_length(j->normal) > 0.0 ? j->normal : (stp_dvec3){0.0, 0.0, 1.0};
    stp_dvec3 a = fabs(n.x) < 0.6 ? (stp_dvec3){1.0, 0.0, 0.0} : (stp_dvec3){0.0, 1.0, 0.0};
    stp_dvec3 b = stp_dvec3_normalize(stp_dvec3_cross(n, a));
    a = stp_dvec3_cross(b, n);
    disc_judge_allow(j, j->centre, cover);
    for (int i = 0; i < STEPS; i++) {
        double angle = 2.0 * M_PI * i / STEPS;
        stp_dvec3 spoke = stp_dvec3_scale(
            stp_dvec3_add(stp_dvec3_scale(a, cos(angle)), stp_dvec3_scale(b, sin(angle))),
            j->radius);
        disc_judge_allow(j, stp_dvec3_add(j->centre, spoke), cover);
    }
}

/* Adds what the disc covers to width * height of disc_cover, bottom row first. */
static inline void disc_judge_cover(const disc_judge *j, uint8_t *cover)
{
    const stp_view *view = j->view;
    for (int i = 0; i < view->width * view->height; i++)
        if (disc_judge_meets(j, i % view->width + 0.5, i / view->width + 0.5))
            cover[i] = DISC_INSIDE;
    disc_judge_allow_rim(j, cover);
}

#endif

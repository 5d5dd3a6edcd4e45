/* Smooths edges on the CPU ("Smooth edges" in shaders/README.md). */
#include "tests/support/reference_parts.h"

#include <math.h>

/* STEP: another surface lies this many pixels deeper. RADIUS: the least radius in pixels. COSINE:
 * the least cosine to the ray. LOST: how much farther lost samples reach, in pixels. */
#define STEP 64.0
#define RADIUS 0.75
#define COSINE 1e-3
#define LOST 0.4

/* A pixel whose edge is wanted. */
typedef struct place {
    int x, y;
    double outward[2];
    double near, far; /* its surface lies between these depths */
    stp_dvec3 ray;
    double reach;
} place;

static double units(const stp_view *view, double depth)
{
    return view->orthographic ? 1.0 / view->f : depth / view->f;
}

static int clamp_to(int i, int count)
{
    return i < 0 ? 0 : i >= count ? count - 1 : i;
}

static bool lies_behind(const reference_rough *rough, const place *p, int x, int y)
{
    x = clamp_to(x, rough->view.width);
    y = clamp_to(y, rough->view.height);
    double depth = (double)rough->depth[y * rough->view.width + x];
    return depth <= 0.0 || depth > p->far;
}

/* The point where the ray through window (u, v) meets the disc's plane, relative to the disc's
 * centre (cu, cv), in radii of the disc. */
static stp_dvec3 on_disc(const stp_view *view, const reference_pixel *disc, stp_dvec3 ray, double u,
                         double v, double cu, double cv)
{
    stp_dvec3 n = reference_is_tube(disc) ? stp_dvec3_scale(ray, -1.0) : disc->normal;
    double radius = fmax(disc->radius / units(view, disc->z_min), RADIUS);
    double k = stp_dvec3_dot(n, ray);
    k = copysign(fmax(fabs(k), COSINE), k > 0.0 ? 1.0 : -1.0);
    stp_dvec3 delta = {(u - cu) / radius, (v - cv) / radius, 0.0};
    return stp_dvec3_sub(delta, stp_dvec3_scale(ray, stp_dvec3_dot(delta, n) / k));
}

/* If the line outward meets the disc with its centre at window (cu, cv), extends to the disc's
 * end. */
static void reach_disc(const stp_view *view, place *p, const reference_pixel *disc, double cu,
                       double cv)
{
    if (disc->tag == 0 || disc->z_min <= p->near || disc->z_min >= p->far)
        return;
    double u = p->x + 0.5, v = p->y + 0.5;
    stp_dvec3 from = on_disc(view, disc, p->ray, u, v, cu, cv);
    stp_dvec3 to = on_disc(view, disc, p->ray, u + p->outward[0], v + p->outward[1], cu, cv);
    stp_dvec3 step = stp_dvec3_sub(to, from);
    double a = stp_dvec3_dot(step, step), b = stp_dvec3_dot(from, step);
    double root = b * b - a * (stp_dvec3_dot(from, from) - 1.0);
    double radius = fmax(disc->radius / units(view, disc->z_min), RADIUS);
    if (root >= 0.0)
        p->reach = fmax(p->reach, (sqrt(root) - b) / a + LOST * fmax(0.0, 1.0 - 0.5 * radius));
}

static void reach_all(const reference_rough *rough, place *p)
{
    const stp_view *view = &rough->view;
    int width = (view->width + 1) / 2, height = (view->height + 1) / 2;
    for (int i = 0; i < 9; i++) {
        int x = clamp_to(p->x + i % 3 - 1, view->width),
            y = clamp_to(p->y + i / 3 - 1, view->height);
        const reference_pixel *disc = &rough->level_0[y * view->width + x];
        reach_disc(view, p, disc, x + 0.5 + disc->dx, y + 0.5 + disc->dy);
    }
    for (int i = 0; i < 4 && rough->level_1 != NULL; i++) {
        int x = clamp_to(p->x / 2 + (i & 1) * (p->x % 2 ? 1 : -1), width);
        int y = clamp_to(p->y / 2 + (i >> 1) * (p->y % 2 ? 1 : -1), height);
        const reference_pixel *disc = &rough->level_1[y * width + x];
        reach_disc(view, p, disc, 2.0 * x + 1.0 + disc->dx, 2.0 * y + 1.0 + disc->dy);
    }
}

/* Finds the direction outward; returns false if the surface goes on all around. */
static bool find_edge(const reference_rough *rough, place *p)
{
    static const int around[8][2] = {{2, 0},  {1, 1},   {0, 2},  {-1, 1},
                                     {-2, 0}, {-1, -1}, {0, -2}, {1, -1}};
    const stp_view *view = &rough->view;
    double depth = (double)rough->depth[p->y * view->width + p->x];
    double sum[2] = {0.0, 0.0};
    p->far = depth + STEP * units(view, depth);
    p->near = depth - STEP * units(view, depth);
    for (int i = 0; i < 8 && depth > 0.0; i++)
        if (lies_behind(rough, p, p->x + around[i][0], p->y + around[i][1])) {
            sum[0] += around[i][0];
            sum[1] += around[i][1];
        }
    double length = hypot(sum[0], sum[1]);
    if (length == 0.0)
        return false;
    p->outward[0] = sum[0] / length;
    p->outward[1] = sum[1] / length;
    return true;
}

static void smooth(const reference_rough *rough, place *p, double out[4])
{
    const stp_view *view = &rough->view;
    double u = (p->x + 0.5 - stp_view_axis_x(view)) / view->f;
    double v = (p->y + 0.5 - stp_view_axis_y(view)) / view->f;
    stp_dvec3 ahead = {0.0, 0.0, -1.0};
    p->ray = view->orthographic ? ahead : stp_dvec3_normalize((stp_dvec3){u, v, -1.0});
    p->reach = -INFINITY;
    reach_all(rough, p);
    double share = isinf(p->reach) ? 1.0 : fmin(fmax(0.5 + p->reach, 0.0), 1.0);
    int x = clamp_to(p->x + (int)rint(2.0 * p->outward[0]), view->width);
    int y = clamp_to(p->y + (int)rint(2.0 * p->outward[1]), view->height);
    const uint8_t *ground = rough->rgba + 4 * (y * view->width + x);
    bool behind = lies_behind(rough, p, x, y);
    for (int c = 0; c < 4; c++)
        out[c] = share * out[c] + (behind ? (1.0 - share) * ground[c] : 0.0);
}

void reference_edges(const reference_rough *rough, double *rgba)
{
    for (int i = 0; i < rough->view.width * rough->view.height; i++) {
        place p = {.x = i % rough->view.width, .y = i / rough->view.width};
        for (int c = 0; c < 4; c++)
            rgba[4 * i + c] = rough->rgba[4 * i + c];
        if (find_edge(rough, &p))
            smooth(rough, &p, rgba + 4 * i);
    }
}

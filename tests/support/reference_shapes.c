/* Draws segments and triangles on the CPU: "Segments and triangles" of shaders/README.md. */
#include "tests/support/reference.h"

#include "base/memory.h"
#include "formats/chunk/sample/sample.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* How far a rasteriser may move a vertex: its positions are fixed-point numbers. */
#define ROUNDING_PX 0.01

void reference_disc_list_clear(reference_disc_list *list)
{
    free(list->items);
    *list = (reference_disc_list){0};
}

stp_status reference_append(reference_disc_list *list, const reference_disc *disc, stp_error *err)
{
    stp_status status =
        stp_grow(&list->items, &list->capacity, list->count + 1, sizeof *list->items, "discs", err);
    if (status == STP_OK)
        list->items[list->count++] = *disc;
    return status;
}

static double mean(double a, double b, double t)
{
    return a + t * (b - a);
}

static stp_dvec3 mean_place(stp_dvec3 a, stp_dvec3 b, double t)
{
    return stp_dvec3_add(stp_dvec3_scale(a, 1.0 - t), stp_dvec3_scale(b, t));
}

/* Mixes two discs, with the share t of b; visible from both sides. */
static reference_disc mean_disc(const reference_disc *a, const reference_disc *b, double t)
{
    reference_disc out = *a;
    bool turned = stp_dvec3_dot(a->normal, b->normal) < 0.0;
    out.oriented = false;
    out.has_normal = a->has_normal && b->has_normal;
    out.normal = stp_dvec3_normalize(
        mean_place(a->normal, stp_dvec3_scale(b->normal, turned ? -1.0 : 1.0), t));
    out.position = mean_place(a->position, b->position, t);
    out.radius = mean(a->radius, b->radius, t);
    for (int k = 0; k < 3; k++)
        out.rgb[k] = mean(a->rgb[k], b->rgb[k], t);
    return out;
}

/* ---- segments ---- */

/* The image of the part of a segment before the near plane. */
typedef struct image {
    const stp_view *view;
    double begin, end; /* along the segment, 0 to 1 */
    double from[2], way[2];
    double depth[2]; /* at its ends */
} image;

static void place(const stp_view *view, stp_dvec3 p, double out[2])
{
    double scale = view->orthographic ? view->f : view->f / -p.z;
    out[0] = stp_view_axis_x(view) + scale * p.x;
    out[1] = stp_view_axis_y(view) + scale * p.y;
}

static bool look(image *out, const stp_view *view, const reference_disc *a, const reference_disc *b)
{
    double to[2], da = -a->position.z, db = -b->position.z, near_depth = view->near_depth;
    if (da <= near_depth && db <= near_depth)
        return false;
    out->view = view;
    out->begin = da < near_depth ? (near_depth - da) / (db - da) : 0.0;
    out->end = db < near_depth ? (near_depth - da) / (db - da) : 1.0;
    stp_dvec3 p = mean_place(a->position, b->position, out->begin);
    stp_dvec3 q = mean_place(a->position, b->position, out->end);
    place(view, p, out->from);
    place(view, q, to);
    for (int k = 0; k < 2; k++)
        out->way[k] = to[k] - out->from[k];
    out->depth[0] = -p.z;
    out->depth[1] = -q.z;
    return true;
}

/* The segment's point nearest to the centre of a pixel. */
static reference_disc nearest(const image *m, const reference_disc *a, const reference_disc *b,
                              int x, int y)
{
    double along = (x + 0.5 - m->from[0]) * m->way[0] + (y + 0.5 - m->from[1]) * m->way[1];
    double length = m->way[0] * m->way[0] + m->way[1] * m->way[1];
    double s = length > 0.0 ? fmin(fmax(along / length, 0.0), 1.0) : 0.0;
    double t = m->view->orthographic ? s : s * m->depth[0] / mean(m->depth[1], m->depth[0], s);
    return mean_disc(a, b, mean(m->begin, m->end, t));
}

/* Distance of the image's point at s from the centre of a pixel, along the axes. */
static double aside(const image *m, double s, int x, int y)
{
    return fabs(m->from[0] + s * m->way[0] - x - 0.5) + fabs(m->from[1] + s * m->way[1] - y - 0.5);
}

/* OpenGL 4.5, 14.5.1: whether the segment leaves the diamond of this size in the middle of a
 * pixel. */
static bool leaves_diamond(const image *m, int x, int y, double size)
{
    double least = fmin(aside(m, 0.0, x, y), aside(m, 1.0, x, y));
    const double centre[2] = {x + 0.5, y + 0.5};
    for (int k = 0; k < 2; k++)
        if (m->way[k] != 0.0)
            least = fmin(
                least, aside(m, fmin(fmax((centre[k] - m->from[k]) / m->way[k], 0.0), 1.0), x, y));
    return least < size && aside(m, 1.0, x, y) >= size;
}

/* Whether an end lies in the pixel. */
static bool ends_in(const image *m, int x, int y)
{
    for (int s = 0; s <= 1; s++) {
        double u = fabs(m->from[0] + s * m->way[0] - x - 0.5);
        double v = fabs(m->from[1] + s * m->way[1] - y - 0.5);
        if (u < 0.5 + ROUNDING_PX && v < 0.5 + ROUNDING_PX)
            return true;
    }
    return false;
}

/* Appends the pixel if the segment draws it or may draw it. */
static stp_status visit(const image *m, const reference_disc *a, const reference_disc *b, int x,
                        int y, reference_disc_list *out, stp_error *err)
{
    bool less = leaves_diamond(m, x, y, 0.5 - ROUNDING_PX);
    bool more = leaves_diamond(m, x, y, 0.5 + ROUNDING_PX);
    bool there = leaves_diamond(m, x, y, 0.5), end = ends_in(m, x, y);
    if (!less && !more && !there && !end)
        return STP_OK;
    reference_disc disc = nearest(m, a, b, x, y);
    disc.presence = !there                 ? REFERENCE_MISSING
                    : less && more && !end ? REFERENCE_SURE
                                           : REFERENCE_THERE;
    return reference_append(out, &disc, err);
}

stp_status reference_segment(const stp_view *view, const reference_disc *a, const reference_disc *b,
                             reference_disc_list *out, stp_error *err)
{
    image m;
    stp_status status = STP_OK;
    if (!look(&m, view, a, b))
        return STP_OK;
    int major = fabs(m.way[1]) > fabs(m.way[0]), size[2] = {view->width, view->height};
    double low = fmin(m.from[major], m.from[major] + m.way[major]);
    double high = fmax(m.from[major], m.from[major] + m.way[major]);
    for (double i = fmax(0.0, floor(low)); i < fmin(high, size[major]); i++) {
        double part = m.way[major] != 0.0 ? (i + 0.5 - m.from[major]) / m.way[major] : 0.0;
        double middle = floor(m.from[!major] + part * m.way[!major]);
        for (double j = fmax(0.0, middle - 1.0); j <= middle + 1.0 && j < size[!major]; j++) {
            STP_TRY(visit(&m, a, b, (int)(major ? j : i), (int)(major ? i : j), out, err));
        }
    }
done:
    return status;
}

/* The greatest distance in pixels that the image of a ball reaches from the image of its centre. */
static double ball_reach(const stp_view *view, stp_dvec3 centre, double radius)
{
    double depth = -centre.z;
    if (view->orthographic)
        return radius * view->f;
    return view->f * radius * stp_dvec3_length(centre) /
           (depth * fmax(depth - radius, view->near_depth));
}

stp_status reference_segment_wide(const stp_view *view, const reference_disc *a,
                                  const reference_disc *b, reference_disc_list *out, stp_error *err)
{
    image m;
    stp_status status = STP_OK;
    if (!look(&m, view, a, b))
        return STP_OK;
    double reach = 1.0, size[2] = {view->width, view->height}, low[2], high[2];
    for (int k = 0; k < 2; k++) {
        reference_disc disc = mean_disc(a, b, k == 0 ? m.begin : m.end);
        reach = fmax(reach, 1.0 + ball_reach(view, disc.position, disc.radius));
    }
    for (int k = 0; k < 2; k++) {
        low[k] = floor(fmin(m.from[k], m.from[k] + m.way[k]) - reach);
        low[k] = fmin(size[k], fmax(0.0, low[k]));
        high[k] = fmin(size[k], fmax(m.from[k], m.from[k] + m.way[k]) + reach);
    }
    for (int y = (int)low[1]; y < high[1]; y++)
        for (int x = (int)low[0]; x < high[0]; x++) {
            reference_disc disc = nearest(&m, a, b, x, y);
            double centre[2];
            place(view, disc.position, centre);
            if (hypot(centre[0] - x - 0.5, centre[1] - y - 0.5) > reach)
                continue;
            disc.wide = true;
            disc.pixel[0] = x;
            disc.pixel[1] = y;
            STP_TRY(reference_append(out, &disc, err));
        }
done:
    return status;
}

/* ---- triangles ---- */

/* Finds where the ray through window coordinates meets a triangle's plane: `parts` are the shares
 * of the second and third corner. Returns whether the point is in the triangle. */
static bool meets(const stp_view *view, const reference_disc corners[3], const double window[2],
                  double parts[2])
{
    double u = (window[0] - stp_view_axis_x(view)) / view->f;
    double v = (window[1] - stp_view_axis_y(view)) / view->f;
    bool flat = view->orthographic;
    stp_dvec3 eye = {flat ? u : 0.0, flat ? v : 0.0, 0.0};
    stp_dvec3 ray = {flat ? 0.0 : u, flat ? 0.0 : v, -1.0};
    stp_dvec3 ab = stp_dvec3_sub(corners[1].position, corners[0].position);
    stp_dvec3 ac = stp_dvec3_sub(corners[2].position, corners[0].position);
    stp_dvec3 from = stp_dvec3_sub(eye, corners[0].position), side = stp_dvec3_cross(ray, ac);
    double volume = stp_dvec3_dot(ab, side);
    if (volume == 0.0)
        return false;
    parts[0] = stp_dvec3_dot(from, side) / volume;
    parts[1] = stp_dvec3_dot(ray, stp_dvec3_cross(from, ab)) / volume;
    return parts[0] >= 0.0 && parts[1] >= 0.0 && parts[0] + parts[1] <= 1.0;
}

/* Finds the parts at which a triangle draws a pixel, and how surely it does; returns false if it
 * does not. */
static bool touches(const stp_view *view, const reference_disc corners[3], int x, int y,
                    double parts[2], reference_presence *presence)
{
    static const double around[4][2] = {{-1.0, 0.0}, {1.0, 0.0}, {0.0, -1.0}, {0.0, 1.0}};
    double aside[2];
    parts[0] = parts[1] = 0.0;
    bool there = meets(view, corners, (const double[2]){x + 0.5, y + 0.5}, parts);
    int met = there;
    for (int k = 0; k < 4; k++)
        met += meets(view, corners,
                     (const double[2]){x + 0.5 + ROUNDING_PX * around[k][0],
                                       y + 0.5 + ROUNDING_PX * around[k][1]},
                     aside);
    double most = 0.0;
    for (int k = 0; k < 2; k++)
        most += parts[k] = fmax(parts[k], 0.0);
    for (int k = 0; k < 2; k++)
        parts[k] /= fmax(1.0, most);
    *presence = !there ? REFERENCE_MISSING : met == 5 ? REFERENCE_SURE : REFERENCE_THERE;
    return met > 0;
}

/* Appends the pixel if the triangle draws it. */
static stp_status visit_triangle(const stp_view *view, const reference_disc corners[3], int x,
                                 int y, reference_disc_list *out, stp_error *err)
{
    double parts[2];
    reference_presence presence;
    if (!touches(view, corners, x, y, parts, &presence))
        return STP_OK;
    double sum = parts[0] + parts[1];
    reference_disc edge = mean_disc(&corners[1], &corners[2], sum > 0.0 ? parts[1] / sum : 0.0);
    reference_disc disc = mean_disc(&corners[0], &edge, sum);
    disc.presence = presence;
    return reference_append(out, &disc, err);
}

/* Columns and rows that may show a triangle; all of them if it reaches behind the near plane. */
static void bound(const stp_view *view, const reference_disc corners[3], int low[2], int high[2])
{
    const int size[2] = {view->width, view->height};
    double least[2] = {INFINITY, INFINITY}, most[2] = {-INFINITY, -INFINITY};
    for (int i = 0; i < 3; i++) {
        double at[2] = {0.0, 0.0};
        bool behind = -corners[i].position.z <= view->near_depth;
        if (!behind)
            place(view, corners[i].position, at);
        for (int k = 0; k < 2; k++) {
            least[k] = behind ? -INFINITY : fmin(least[k], at[k]);
            most[k] = behind ? INFINITY : fmax(most[k], at[k]);
        }
    }
    for (int k = 0; k < 2; k++) {
        low[k] = (int)fmax(0.0, fmin(least[k], size[k]) - 1.0);
        high[k] = (int)fmin(size[k], fmax(most[k], -2.0) + 2.0);
    }
}

stp_status reference_triangle(const stp_view *view, const reference_disc corners[3],
                              reference_disc_list *out, stp_error *err)
{
    stp_status status = STP_OK;
    int low[2], high[2];
    bound(view, corners, low, high);
    for (int y = low[1]; y < high[1]; y++)
        for (int x = low[0]; x < high[0]; x++)
            STP_TRY(visit_triangle(view, corners, x, y, out, err));
done:
    return status;
}

/* ---- flat pieces of ribbons ---- */

bool reference_ribbon_is_flat(const stp_view *view, const reference_disc *a,
                              const reference_disc *b)
{
    const reference_disc *ends[2] = {a, b};
    double width = 0.0;
    for (int k = 0; k < 2; k++) {
        double depth = fmax(-ends[k]->position.z, view->near_depth);
        width = fmax(width, ends[k]->radius * (view->orthographic ? view->f : view->f / depth));
    }
    return a->kind == STP_KIND_RIBBON && a->has_normal && b->has_normal && width > 0.5;
}

/* The vector from the line to the ribbon's edge at vertex i. */
static stp_dvec3 ribbon_half(const reference_disc *vertices, unsigned count, unsigned i)
{
    const reference_disc *v = &vertices[i];
    stp_dvec3 way = stp_dvec3_sub(vertices[i + 1 < count ? i + 1 : i].position,
                                  vertices[i > 0 ? i - 1 : 0].position);
    stp_dvec3 side = stp_dvec3_cross(v->normal, way);
    double length = stp_dvec3_length(side);
    return length > 0.0 ? stp_dvec3_scale(side, v->radius / length) : (stp_dvec3){0.0, 0.0, 0.0};
}

/* Appends the pixel if one of the piece's two triangles draws it. The first corner of the turned
 * triangle is at the segment's second end. */
static stp_status visit_piece(const stp_view *view, const reference_disc ends[2],
                              const reference_disc corners[3], bool turned, const int pixel[2],
                              reference_disc_list *out, stp_error *err)
{
    double parts[2];
    reference_presence presence;
    if (!touches(view, corners, pixel[0], pixel[1], parts, &presence))
        return STP_OK;
    reference_disc disc = mean_disc(&ends[0], &ends[1], turned ? 1.0 - parts[1] : parts[1]);
    disc.position = corners[0].position;
    for (int k = 0; k < 2; k++)
        disc.position = stp_dvec3_add(
            disc.position,
            stp_dvec3_scale(stp_dvec3_sub(corners[k + 1].position, corners[0].position), parts[k]));
    disc.radius = 0.0;
    disc.presence = presence;
    disc.wide = true; /* splats: not a vertex by itself */
    memcpy(disc.pixel, pixel, sizeof disc.pixel);
    return reference_append(out, &disc, err);
}

stp_status reference_ribbon(const stp_view *view, const reference_disc *vertices, unsigned count,
                            unsigned i, reference_disc_list *out, stp_error *err)
{
    stp_status status = STP_OK;
    const reference_disc ends[2] = {vertices[i], vertices[i + 1]};
    stp_dvec3 half[2] = {ribbon_half(vertices, count, i), ribbon_half(vertices, count, i + 1)};
    if (stp_dvec3_dot(half[0], half[1]) < 0.0)
        half[1] = stp_dvec3_scale(half[1], -1.0);
    for (int turned = 0; turned < 2; turned++) { /* near low, near high, far low; far high, ... */
        reference_disc corners[3] = {ends[turned], ends[turned], ends[!turned]};
        double side = turned ? 1.0 : -1.0;
        int low[2], high[2];
        for (int k = 0; k < 3; k++) {
            bool far = turned ? k < 2 : k == 2;
            corners[k].position = stp_dvec3_add(corners[k].position,
                                                stp_dvec3_scale(half[far], k == 1 ? -side : side));
        }
        bound(view, corners, low, high);
        for (int y = low[1]; y < high[1]; y++)
            for (int x = low[0]; x < high[0]; x++)
                STP_TRY(visit_piece(view, ends, corners, turned, (const int[2]){x, y}, out, err));
    }
done:
    return status;
}

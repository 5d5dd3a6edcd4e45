/* Rasterises triangles in double. */
#include "tests/support/triangles.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

/* A vertex in eye space, and its place on the window. */
typedef struct corner {
    stp_dvec3 position, normal;
    double u, v;
    double depth;
    double w; /* 1 / depth, or 1 if orthographic: linear on the window */
} corner;

static stp_dvec3 turn(const stp_view *view, stp_dvec3 d)
{
    return (stp_dvec3){stp_dvec3_dot(view->right, d), stp_dvec3_dot(view->up, d),
                       stp_dvec3_dot(view->back, d)};
}

static void place(const stp_view *view, corner *c)
{
    c->depth = -c->position.z;
    double scale = view->orthographic ? view->f : view->f / c->depth;
    c->u = stp_view_axis_x(view) + scale * c->position.x;
    c->v = stp_view_axis_y(view) + scale * c->position.y;
    c->w = view->orthographic ? 1.0 : 1.0 / c->depth;
}

/* The point where the edge from a to b meets the near plane. */
static corner cut_edge(const corner *a, const corner *b, double near_depth)
{
    double da = -a->position.z - near_depth, db = -b->position.z - near_depth;
    double t = da / (da - db);
    corner c = {
        .normal = stp_dvec3_add(stp_dvec3_scale(a->normal, 1.0 - t), stp_dvec3_scale(b->normal, t)),
        .position =
            stp_dvec3_add(stp_dvec3_scale(a->position, 1.0 - t), stp_dvec3_scale(b->position, t))};
    c.position.z = -near_depth;
    return c;
}

/* The part of a triangle beyond the near plane: 0, 3 or 4 corners (Sutherland and Hodgman 1974). */
static int clip(const corner in[3], double near_depth, corner out[4])
{
    int count = 0;
    for (int i = 0; i < 3; i++) {
        const corner *a = &in[i], *b = &in[(i + 1) % 3];
        bool inside_a = -a->position.z > near_depth, inside_b = -b->position.z > near_depth;
        if (inside_a)
            out[count++] = *a;
        if (inside_a != inside_b)
            out[count++] = cut_edge(a, b, near_depth);
    }
    return count;
}

static double side_from(const corner *a, const corner *b, double u, double v)
{
    return (b->u - a->u) * (v - a->v) - (b->v - a->v) * (u - a->u);
}

/* Twice the area of (a, b, p), positive if p lies left of a to b. Swapping a and b gives exactly
 * the negative, so two triangles never both miss a pixel of their common edge. */
static double side_of(const corner *a, const corner *b, double u, double v)
{
    bool swap = b->u < a->u || (b->u == a->u && b->v < a->v);
    return swap ? -side_from(b, a, u, v) : side_from(a, b, u, v);
}

/* For a counter-clockwise triangle, y up: left edges go down, top edges go left. */
static bool owns_edge(const corner *a, const corner *b)
{
    return b->v < a->v || (b->v == a->v && b->u < a->u);
}

static void cover(triangles_pixel *pixel, const corner c[3], const double share[3],
                  stp_dvec3 face_normal, uint32_t triangle)
{
    double w = 0.0;
    double each[3];
    for (int i = 0; i < 3; i++)
        w += each[i] = share[i] * c[i].w;
    double depth = 0.0;
    stp_dvec3 normal = {0.0, 0.0, 0.0}, position = {0.0, 0.0, 0.0};
    for (int i = 0; i < 3; i++) {
        depth += each[i] / w * c[i].depth;
        normal = stp_dvec3_add(normal, stp_dvec3_scale(c[i].normal, each[i] / w));
        position = stp_dvec3_add(position, stp_dvec3_scale(c[i].position, each[i] / w));
    }
    if (pixel->layers++ > 0 && pixel->depth <= depth)
        return;
    normal = stp_dvec3_normalize(stp_dvec3_length(normal) > 0.0 ? normal : face_normal);
    pixel->depth = depth;
    pixel->normal = normal;
    pixel->triangle = triangle;
}

/* The first and the last pixel whose centre may lie in [low, high]. */
static void pixel_range(double low, double high, int size, int *first, int *last)
{
    low = fmin(fmax(low, 0.0), size);
    high = fmin(fmax(high, -1.0), size);
    *first = (int)floor(low);
    *last = (int)fmin(floor(high), size - 1.0);
}

static void fill(triangles_picture *picture, corner c[3], stp_dvec3 face_normal, uint32_t triangle)
{
    double area = side_of(&c[0], &c[1], c[2].u, c[2].v);
    if (!(fabs(area) > 0.0))
        return;
    if (area < 0.0) {
        corner swapped = c[1];
        c[1] = c[2];
        c[2] = swapped;
        area = -area;
    }
    int x0, x1, y0, y1;
    pixel_range(fmin(c[0].u, fmin(c[1].u, c[2].u)), fmax(c[0].u, fmax(c[1].u, c[2].u)),
                picture->width, &x0, &x1);
    pixel_range(fmin(c[0].v, fmin(c[1].v, c[2].v)), fmax(c[0].v, fmax(c[1].v, c[2].v)),
                picture->height, &y0, &y1);
    for (int y = y0; y <= y1; y++)
        for (int x = x0; x <= x1; x++) {
            double share[3];
            bool inside = true;
            for (int i = 0; inside && i < 3; i++) {
                const corner *a = &c[(i + 1) % 3], *b = &c[(i + 2) % 3];
                double side = side_of(a, b, x + 0.5, y + 0.5);
                inside = side > 0.0 || (side == 0.0 && owns_edge(a, b));
                share[i] = side / area;
            }
            if (inside)
                cover(&picture->pixels[(size_t)y * (size_t)picture->width + (size_t)x], c, share,
                      face_normal, triangle);
        }
}

static void draw_triangle(triangles_picture *picture, const triangles_mesh *mesh,
                          const stp_view *view, uint32_t triangle)
{
    corner in[3], out[4];
    for (int i = 0; i < 3; i++) {
        uint32_t vertex = mesh->triangles[triangle][i];
        stp_dvec3 p = stp_dvec3_sub(mesh->positions[vertex], view->eye);
        in[i] = (corner){.position = turn(view, p)};
        if (mesh->normals != NULL)
            in[i].normal = turn(view, mesh->normals[vertex]);
    }
    stp_dvec3 face =
        stp_dvec3_normalize(stp_dvec3_cross(stp_dvec3_sub(in[1].position, in[0].position),
                                            stp_dvec3_sub(in[2].position, in[0].position)));
    int count = clip(in, view->near_depth, out);
    for (int i = 0; i < count; i++)
        place(view, &out[i]);
    for (int i = 2; i < count; i++) {
        corner part[3] = {out[0], out[i - 1], out[i]};
        fill(picture, part, face, triangle);
    }
}

/* Turns over normals that point away from the eye. */
static void face_the_eye(triangles_picture *picture, const stp_view *view)
{
    for (int y = 0; y < picture->height; y++)
        for (int x = 0; x < picture->width; x++) {
            stp_dvec3 ray = {(x + 0.5 - 0.5 * picture->width) / view->f,
                             (y + 0.5 - 0.5 * picture->height) / view->f, -1.0};
            if (view->orthographic)
                ray.x = ray.y = 0.0;
            triangles_pixel *p = &picture->pixels[(size_t)y * (size_t)picture->width + (size_t)x];
            if (stp_dvec3_dot(ray, p->normal) > 0.0)
                p->normal = stp_dvec3_scale(p->normal, -1.0);
        }
}

stp_status triangles_draw(triangles_picture *out, const triangles_mesh *mesh, const stp_view *view,
                          stp_error *err)
{
    triangles_picture picture = {.width = view->width, .height = view->height};
    stp_status status = stp_alloc(&picture.pixels, (size_t)view->width * (size_t)view->height,
                                  sizeof *picture.pixels, "a picture", err);
    if (status != STP_OK)
        return status;
    for (size_t i = 0; i < mesh->triangle_count; i++)
        draw_triangle(&picture, mesh, view, (uint32_t)i);
    face_the_eye(&picture, view);
    *out = picture;
    return STP_OK;
}

void triangles_destroy(triangles_picture *picture)
{
    free(picture->pixels);
    *picture = (triangles_picture){0};
}

void triangles_mask(const triangles_picture *picture, uint8_t *mask)
{
    for (size_t i = 0; i < (size_t)picture->width * (size_t)picture->height; i++)
        mask[i] = picture->pixels[i].layers > 0;
}

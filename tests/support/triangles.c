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
static corner cut_edge(const corner *a, const corner *b, const stp_view *view)
{
    double da = -a->position.z - view->near_depth, db = -b->position.z - view->near_depth;
    double t = da / (da - db);
    corner c = {
        .normal = stp_dvec3_add(stp_dvec3_scale(a->normal, 1.0 - t), stp_dvec3_scale(b->normal, t)),
        .position =
            stp_dvec3_add(stp_dvec3_scale(a->position, 1.0 - t), stp_dvec3_scale(b->position, t))};
    c.position.z = -view->near_depth;
    place(view, &c);
    return c;
}

/* The part of a triangle beyond the near plane: 0, 3 or 4 corners (Sutherland and Hodgman 1974). */
static int clip(const corner in[3], const stp_view *view, corner out[4])
{
    int count = 0;
    for (int i = 0; i < 3; i++) {
        const corner *a = &in[i], *b = &in[(i + 1) % 3];
        bool inside_a = -a->position.z > view->near_depth;
        bool inside_b = -b->position.z > view->near_depth;
        if (inside_a)
            out[count++] = *a;
        if (inside_a != inside_b)
            out[count++] = cut_edge(a, b, view);
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

/* The normal of the triangle's plane. */
static stp_dvec3 face_normal(const corner c[3])
{
    return stp_dvec3_normalize(stp_dvec3_cross(stp_dvec3_sub(c[1].position, c[0].position),
                                               stp_dvec3_sub(c[2].position, c[0].position)));
}

/* c: the corners of the part of a triangle that is drawn; whole: the triangle's own. */
static void cover(triangles_pixel *pixel, const corner c[3], const double share[3],
                  const corner whole[3], uint32_t triangle)
{
    double w = 0.0;
    double each[3];
    for (int i = 0; i < 3; i++)
        w += each[i] = share[i] * c[i].w;
    double depth = 0.0;
    for (int i = 0; i < 3; i++)
        depth += each[i] / w * c[i].depth;
    if (pixel->layers++ > 0 && pixel->depth <= depth)
        return;
    stp_dvec3 normal = {0.0, 0.0, 0.0};
    for (int i = 0; i < 3; i++)
        normal = stp_dvec3_add(normal, stp_dvec3_scale(c[i].normal, each[i] / w));
    normal = stp_dvec3_length(normal) > 0.0 ? stp_dvec3_normalize(normal) : face_normal(whole);
    pixel->depth = depth;
    pixel->normal = normal;
    pixel->triangle = triangle;
}

/* The first and the last pixel whose centre may lie between the least and the greatest of three
 * coordinates. Most triangles of a fine mesh lie between the centres. */
static void pixel_range(double a, double b, double c, int size, int *first, int *last)
{
    const double rounding = 1e-6;
    double low = a < b ? a : b, high = a < b ? b : a;
    low = (c < low ? c : low) - 0.5 - rounding;
    high = (c > high ? c : high) - 0.5 + rounding;
    *first = low > 0.0 ? (int)ceil(low < size ? low : size) : 0;
    *last = high < 0.0 ? -1 : high < size ? (int)high : size - 1;
}

static void fill(triangles_picture *picture, corner c[3], const corner whole[3], uint32_t triangle)
{
    int x0, x1, y0, y1;
    pixel_range(c[0].u, c[1].u, c[2].u, picture->width, &x0, &x1);
    pixel_range(c[0].v, c[1].v, c[2].v, picture->height, &y0, &y1);
    if (x0 > x1 || y0 > y1)
        return;
    double area = side_of(&c[0], &c[1], c[2].u, c[2].v);
    if (!(fabs(area) > 0.0))
        return;
    if (area < 0.0) {
        corner swapped = c[1];
        c[1] = c[2];
        c[2] = swapped;
        area = -area;
    }
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
                      whole, triangle);
        }
}

/* The mesh's vertices in eye space; those beyond the near plane have their place. */
static void place_vertices(corner *out, const triangles_mesh *mesh, const stp_view *view)
{
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        out[i] = (corner){.position = turn(view, stp_dvec3_sub(mesh->positions[i], view->eye))};
        if (mesh->normals != NULL)
            out[i].normal = turn(view, mesh->normals[i]);
        if (-out[i].position.z > view->near_depth)
            place(view, &out[i]);
    }
}

static void draw_triangle(triangles_picture *picture, const corner *vertices, const uint32_t at[3],
                          const stp_view *view, uint32_t triangle)
{
    const corner in[3] = {vertices[at[0]], vertices[at[1]], vertices[at[2]]};
    corner out[4];
    int count = clip(in, view, out);
    for (int i = 2; i < count; i++) {
        corner part[3] = {out[0], out[i - 1], out[i]};
        fill(picture, part, in, triangle);
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
    stp_status status = STP_OK;
    triangles_picture picture = {.width = view->width, .height = view->height};
    corner *vertices = NULL;
    STP_TRY(stp_alloc(&vertices, mesh->vertex_count, sizeof *vertices, "vertices", err));
    STP_TRY(stp_alloc(&picture.pixels, (size_t)view->width * (size_t)view->height,
                      sizeof *picture.pixels, "a picture", err));
    place_vertices(vertices, mesh, view);
    for (size_t i = 0; i < mesh->triangle_count; i++)
        draw_triangle(&picture, vertices, mesh->triangles[i], view, (uint32_t)i);
    face_the_eye(&picture, view);
    *out = picture;
done:
    free(vertices);
    return status;
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

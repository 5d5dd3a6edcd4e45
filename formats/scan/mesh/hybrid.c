/* Splits a mesh into a hybrid surface. */
#include "formats/scan/mesh/hybrid.h"

#include "base/memory.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The triangles that use a vertex. */
enum { OF_LARGE = 1, OF_SMALL = 2 };

static double sum_areas(const stp_point_mesh *mesh)
{
    double sum = 0.0;
    for (size_t t = 0; t < mesh->triangle_count; t++)
        sum += stp_point_mesh_area(mesh, t);
    return sum;
}

/* The size from which a triangle is large: an area or a length. */
typedef struct size_limit {
    double area, edge;
} size_limit;

/* Triangles with an image are never large: their corners alone would not keep its colours. */
static bool is_large(const stp_point_mesh *mesh, size_t t, const size_limit *least)
{
    const double area = stp_point_mesh_area(mesh, t);
    return !stp_materials_textured(&mesh->materials, t) &&
           (area >= least->area ||
            (area > 0.0 && stp_point_mesh_longest_side(mesh, t) >= least->edge));
}

/* Separates the triangles. Large ones still name the mesh's vertices. */
static stp_status part(stp_point_mesh *mesh, const size_limit *least, uint8_t *uses,
                       stp_triangle_set *out, stp_error *err)
{
    stp_status status = STP_OK;
    size_t capacity = 0, kept = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *triangle = mesh->triangles[t];
        const bool large = is_large(mesh, t, least);
        for (int k = 0; k < 3; k++)
            uses[triangle[k]] |= large ? OF_LARGE : OF_SMALL;
        if (large) {
            STP_TRY(stp_grow(&out->triangles, &capacity, out->triangle_count + 1,
                             sizeof *out->triangles, "triangles", err));
            memcpy(out->triangles[out->triangle_count++], triangle, sizeof *out->triangles);
        } else {
            stp_materials_move(&mesh->materials, kept, t);
            memmove(mesh->triangles[kept++], triangle, sizeof *mesh->triangles);
        }
    }
    mesh->triangle_count = kept;
done:
    return status;
}

static stp_line_vertex vertex_of(const stp_point_mesh *mesh, size_t i, double radius)
{
    const stp_point *p = &mesh->points[i];
    stp_line_vertex out = {.position = p->position,
                           .direction = p->normal,
                           .radius = (float)fmin(radius, (double)FLT_MAX),
                           .intensity = p->intensity,
                           .class_id = p->class_id};
    for (int c = 0; c < 3; c++)
        out.rgb[c] = mesh->attributes & STP_POINT_HAS_COLOUR ? p->rgb[c] : STP_POINT_GREY;
    return out;
}

/* Gives the set its own vertices, in the mesh's order. */
static stp_status take_vertices(const stp_point_mesh *mesh, const uint8_t *uses, double radius,
                                stp_triangle_set *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t *numbers = NULL;
    size_t count = 0;
    for (size_t i = 0; i < mesh->point_count; i++)
        count += (uses[i] & OF_LARGE) != 0;
    STP_TRY(stp_alloc(&numbers, mesh->point_count, sizeof *numbers, "triangles", err));
    STP_TRY(stp_alloc(&out->vertices, count, sizeof *out->vertices, "triangles", err));
    for (size_t i = 0; i < mesh->point_count; i++) {
        if (!(uses[i] & OF_LARGE))
            continue;
        numbers[i] = (uint32_t)out->vertex_count;
        out->vertices[out->vertex_count++] = vertex_of(mesh, i, uses[i] & OF_SMALL ? radius : 0.0);
    }
    for (uint64_t t = 0; t < out->triangle_count; t++)
        for (int k = 0; k < 3; k++)
            out->triangles[t][k] = numbers[out->triangles[t][k]];
done:
    free(numbers);
    return status;
}

stp_status stp_hybrid_split(stp_point_mesh *mesh, uint64_t *sample_count, uint8_t *taken,
                            stp_triangle_set *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *uses = NULL;
    stp_triangle_set set = {0};
    const double wanted = (double)(*sample_count ? *sample_count : mesh->point_count);
    const double share = sum_areas(mesh) / wanted; /* area per point */
    if (!(share > 0.0) || !isfinite(share))
        return STP_OK;
    STP_TRY(stp_alloc(&uses, mesh->point_count, 1, "triangles", err));
    /* A few points on small triangles far apart would take each other for neighbours, and their
     * discs would be as wide as the way between them. */
    const bool all =
        *sample_count > 0 && STP_HYBRID_POINTS * (double)mesh->triangle_count <= wanted;
    /* If only vertices become points, they do not cover a long triangle, however thin. Points
     * spread over the faces do. */
    const double area = all ? DBL_MIN : STP_HYBRID_POINTS * share;
    const size_limit least = {area,
                              *sample_count > 0 ? (double)INFINITY : sqrt(4.0 / sqrt(3.0) * area)};
    STP_TRY(part(mesh, &least, uses, &set, err));
    STP_TRY(take_vertices(mesh, uses, STP_HYBRID_LAMBDA * sqrt(share), &set, err));
    for (size_t i = 0; i < mesh->point_count; i++)
        taken[i] |= uses[i] == OF_LARGE;
    if (*sample_count > 0) {
        const double left = sum_areas(mesh) / share;
        *sample_count = left > 0.0 && left < 1.0 ? 1 : (uint64_t)(left + 0.5);
    }
    *out = set;
    set = (stp_triangle_set){0};
done:
    stp_triangle_set_clear(&set);
    free(uses);
    return status;
}

/* A mesh as the scan reader holds it. */
#include "formats/scan/mesh/point_mesh.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

stp_status stp_point_mesh_reserve(stp_point_mesh *mesh, const char *path, size_t count,
                                  stp_error *err)
{
    if (count > UINT32_MAX - mesh->point_count)
        return stp_error_set(
            err, STP_LIMIT,
            "%s: a mesh of more than %u vertices is not supported: give the points "
            "without faces, or with normals",
            path, UINT32_MAX);
    return stp_grow(&mesh->points, &mesh->point_capacity, mesh->point_count + count,
                    sizeof *mesh->points, "mesh vertices", err);
}

stp_status stp_point_mesh_add_triangle(stp_point_mesh *mesh, uint32_t a, uint32_t b, uint32_t c,
                                       stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_grow(&mesh->triangles, &mesh->triangle_capacity, mesh->triangle_count + 1,
                     sizeof *mesh->triangles, "triangles", err));
    uint32_t *triangle = mesh->triangles[mesh->triangle_count++];
    triangle[0] = a;
    triangle[1] = b;
    triangle[2] = c;
done:
    return status;
}

stp_status stp_point_mesh_add_edge(stp_point_mesh *mesh, const stp_mesh_edge *edge, stp_error *err)
{
    stp_status status = stp_grow(&mesh->edges, &mesh->edge_capacity, mesh->edge_count + 1,
                                 sizeof *mesh->edges, "edges", err);
    if (status == STP_OK)
        mesh->edges[mesh->edge_count++] = *edge;
    return status;
}

void stp_point_mesh_free(stp_point_mesh *mesh)
{
    free(mesh->points);
    free(mesh->edges);
    free(mesh->radii);
    free(mesh->triangles);
    free(mesh->loose);
    stp_materials_clear(&mesh->materials);
    *mesh = (stp_point_mesh){0};
}

vec3s stp_unit_normal(stp_dvec3 n)
{
    /* Divide by the greatest component first: the square of a tiny or huge component would leave
     * the range. */
    const double scale = fmax(fabs(n.x), fmax(fabs(n.y), fabs(n.z)));
    if (!(scale > 0.0) || !stp_dvec3_finite(n))
        return (vec3s){{0.0f, 0.0f, 0.0f}};
    const stp_dvec3 scaled = {n.x / scale, n.y / scale, n.z / scale};
    return stp_dvec3_to_float(stp_dvec3_normalize(scaled));
}

static stp_dvec3 corner(const stp_point_mesh *mesh, size_t triangle, int k)
{
    return mesh->points[mesh->triangles[triangle][k % 3]].position;
}

static stp_dvec3 cross_of(stp_dvec3 a, stp_dvec3 b, stp_dvec3 c)
{
    const stp_dvec3 n = stp_dvec3_cross(stp_dvec3_sub(b, a), stp_dvec3_sub(c, a));
    return stp_dvec3_finite(n) ? n : (stp_dvec3){0.0, 0.0, 0.0};
}

stp_dvec3 stp_point_mesh_area_vector(const stp_point_mesh *mesh, size_t triangle)
{
    return cross_of(corner(mesh, triangle, 0), corner(mesh, triangle, 1),
                    corner(mesh, triangle, 2));
}

double stp_point_mesh_area(const stp_point_mesh *mesh, size_t triangle)
{
    const double twice = stp_dvec3_length(stp_point_mesh_area_vector(mesh, triangle));
    return isfinite(twice) ? 0.5 * twice : 0.0;
}

double stp_point_mesh_longest_side(const stp_point_mesh *mesh, size_t triangle)
{
    double longest = 0.0;
    for (int k = 0; k < 3; k++)
        longest = fmax(longest, stp_dvec3_length(stp_dvec3_sub(corner(mesh, triangle, k),
                                                               corner(mesh, triangle, k + 1))));
    return longest;
}

typedef struct normal_job {
    const unsigned char *positions;
    size_t position_stride;
    const uint32_t (*triangles)[3];
} normal_job;

/* Twice the area times the normal; zero if a corner is not finite. */
static stp_dvec3 area_vector(const normal_job *job, size_t triangle)
{
    const stp_dvec3 *p[3];
    for (int k = 0; k < 3; k++)
        p[k] = (const stp_dvec3 *)(const void *)(job->positions + job->triangles[triangle][k] *
                                                                      job->position_stride);
    return cross_of(*p[0], *p[1], *p[2]);
}

void stp_accumulate_normals(const stp_dvec3 *positions, size_t position_stride,
                            const uint32_t (*triangles)[3], size_t triangle_count, vec3s *normals,
                            size_t normal_stride, size_t vertex_count)
{
    const normal_job job = {(const unsigned char *)positions, position_stride, triangles};
    unsigned char *out = (unsigned char *)normals;
    double greatest = 0.0;
    for (size_t i = 0; i < triangle_count; i++) {
        const stp_dvec3 n = area_vector(&job, i);
        greatest = fmax(greatest, fmax(fabs(n.x), fmax(fabs(n.y), fabs(n.z))));
    }
    /* The sums are floats, which needs no extra memory. Relative to the greatest area they stay in
     * range. */
    const double scale = greatest > 0.0 ? 1.0 / greatest : 0.0;
    for (size_t i = 0; i < triangle_count && isfinite(scale); i++) {
        const stp_dvec3 n = stp_dvec3_scale(area_vector(&job, i), scale);
        for (int k = 0; k < 3; k++) {
            vec3s *sum = (vec3s *)(void *)(out + triangles[i][k] * normal_stride);
            *sum = stp_dvec3_to_float(stp_dvec3_add(stp_dvec3_from_float(*sum), n));
        }
    }
    for (size_t i = 0; i < vertex_count; i++) {
        vec3s *sum = (vec3s *)(void *)(out + i * normal_stride);
        *sum = stp_unit_normal(stp_dvec3_from_float(*sum));
    }
}

void stp_point_mesh_set_normals(stp_point_mesh *mesh)
{
    for (size_t i = 0; i < mesh->point_count; i++)
        mesh->points[i].normal = (vec3s){{0.0f, 0.0f, 0.0f}};
    if (mesh->point_count > 0)
        stp_accumulate_normals(&mesh->points->position, sizeof *mesh->points,
                               (const uint32_t(*)[3])mesh->triangles, mesh->triangle_count,
                               &mesh->points->normal, sizeof *mesh->points, mesh->point_count);
}

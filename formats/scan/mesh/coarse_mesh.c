/* Meshes whose vertices do not tell the surface. */
#include "formats/scan/mesh/coarse_mesh.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

/* A vertex of more faces is left alone: pairs of its faces are compared. */
#define FACE_LIMIT 256

static stp_dvec3 corner(const stp_point_mesh *mesh, size_t triangle, int k)
{
    return mesh->points[mesh->triangles[triangle][k % 3]].position;
}

/* Twice the area times the unit normal. */
static stp_dvec3 area_vector(const stp_point_mesh *mesh, size_t triangle)
{
    const stp_dvec3 a = corner(mesh, triangle, 0);
    return stp_dvec3_cross(stp_dvec3_sub(corner(mesh, triangle, 1), a),
                           stp_dvec3_sub(corner(mesh, triangle, 2), a));
}

/* The diagonal of the box around the faces. */
static double diagonal_of(const stp_point_mesh *mesh)
{
    stp_dbox box = stp_dbox_empty();
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int k = 0; k < 3; k++)
            if (stp_dvec3_finite(corner(mesh, t, k)))
                stp_dbox_add(&box, corner(mesh, t, k));
    return stp_dvec3_length(stp_dvec3_sub(box.max, box.min));
}

/* Counts vertices without a face. */
static stp_status count_loose(const stp_point_mesh *mesh, size_t *loose, stp_error *err)
{
    stp_status status = STP_OK;
    bool *used = NULL;
    STP_TRY(stp_alloc(&used, mesh->point_count, sizeof *used, "a mesh's vertices", err));
    *loose = mesh->point_count;
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int k = 0; k < 3; k++) {
            *loose -= !used[mesh->triangles[t][k]];
            used[mesh->triangles[t][k]] = true;
        }
done:
    free(used);
    return status;
}

/* The area of the faces that have a side longer than `most`. */
static double sum_areas(const stp_point_mesh *mesh, double most)
{
    double sum = 0.0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const double area = 0.5 * stp_dvec3_length(area_vector(mesh, t));
        double side = 0.0;
        for (int k = 0; k < 3; k++)
            side = fmax(
                side, stp_dvec3_length(stp_dvec3_sub(corner(mesh, t, k), corner(mesh, t, k + 1))));
        sum += side > most && isfinite(area) ? area : 0.0;
    }
    return sum;
}

stp_status stp_mesh_measure_coarse(const stp_point_mesh *mesh, uint64_t *sample_count,
                                   stp_error *err)
{
    stp_status status = STP_OK;
    size_t loose = 0;
    const double diagonal = diagonal_of(mesh), across = STP_COARSE_POINTS / diagonal;
    const double area = sum_areas(mesh, 0.0);
    *sample_count = 0;
    if (!(area > 0.0) || !isfinite(area) ||
        sum_areas(mesh, diagonal / STP_COARSE_SIDES) < STP_COARSE_SHARE * area)
        return STP_OK;
    STP_TRY(count_loose(mesh, &loose, err));
    if (loose <= mesh->point_count / STP_COARSE_LOOSE)
        *sample_count = (uint64_t)fmax((double)mesh->point_count,
                                       fmin(area * across * across, STP_COARSE_POINT_LIMIT));
done:
    return status;
}

/* Corners by vertex: those of vertex v are list[begin[v]] to list[begin[v + 1] - 1], each as 3
 * triangle + number. */
typedef struct corner_lists {
    size_t *begin, *list;
    stp_dvec3 *areas; /* by triangle: area vectors, */
    stp_dvec3 *units; /* and these at unit length, or zero */
} corner_lists;

static void free_lists(corner_lists *lists)
{
    free(lists->begin);
    free(lists->list);
    free(lists->areas);
    free(lists->units);
}

static stp_status list_corners(const stp_point_mesh *mesh, corner_lists *out, stp_error *err)
{
    stp_status status = STP_OK;
    const char *const what = "a mesh's corners";
    STP_TRY(stp_alloc(&out->begin, mesh->point_count + 2, sizeof *out->begin, what, err));
    STP_TRY(stp_alloc(&out->list, 3 * mesh->triangle_count, sizeof *out->list, what, err));
    STP_TRY(stp_alloc(&out->areas, mesh->triangle_count, sizeof *out->areas, what, err));
    STP_TRY(stp_alloc(&out->units, mesh->triangle_count, sizeof *out->units, what, err));
    /* Counts stand two places on, so that adding the corners leaves each list's begin. */
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int k = 0; k < 3; k++)
            out->begin[mesh->triangles[t][k] + 2]++;
    for (size_t v = 2; v < mesh->point_count + 2; v++)
        out->begin[v] += out->begin[v - 1];
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        for (int k = 0; k < 3; k++)
            out->list[out->begin[mesh->triangles[t][k] + 1]++] = 3 * t + (size_t)k;
        out->areas[t] = area_vector(mesh, t);
        out->units[t] = stp_dvec3_from_float(stp_unit_normal(out->areas[t]));
    }
done:
    return status;
}

/* The normal of a corner if it has faces beyond a crease; false: it has none. */
static bool beyond_crease(const corner_lists *lists, size_t vertex, size_t triangle, vec3s *normal)
{
    const stp_dvec3 own = lists->units[triangle];
    stp_dvec3 sum = {0.0, 0.0, 0.0};
    bool found = false;
    for (size_t i = lists->begin[vertex]; i < lists->begin[vertex + 1]; i++) {
        const size_t other = lists->list[i] / 3;
        const stp_dvec3 unit = lists->units[other];
        if (stp_dvec3_dot(unit, unit) == 0.0)
            continue;
        if (stp_dvec3_dot(unit, own) >= STP_CREASE_COSINE)
            sum = stp_dvec3_add(sum, lists->areas[other]);
        else
            found = true;
    }
    *normal = stp_unit_normal(sum);
    return found && stp_dvec3_dot(own, own) > 0.0;
}

/* The number of a copy of the vertex with this normal; those from `first` on are its copies. */
static stp_status take_copy(stp_point_mesh *mesh, uint32_t vertex, size_t first, vec3s normal,
                            uint32_t *number, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    for (size_t i = first; i < mesh->point_count; i++) {
        const float *n = mesh->points[i].normal.raw;
        if (n[0] * normal.raw[0] + n[1] * normal.raw[1] + n[2] * normal.raw[2] > 0.99999f) {
            *number = (uint32_t)i;
            return STP_OK;
        }
    }
    STP_TRY(stp_point_mesh_reserve(mesh, path, 1, err));
    *number = (uint32_t)mesh->point_count;
    mesh->points[mesh->point_count] = mesh->points[vertex];
    mesh->points[mesh->point_count++].normal = normal;
done:
    return status;
}

stp_status stp_mesh_split_creases(stp_point_mesh *mesh, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    corner_lists lists = {0};
    const size_t vertices = mesh->point_count;
    STP_TRY(list_corners(mesh, &lists, err));
    for (size_t v = 0; v < vertices; v++) {
        const size_t first_copy = mesh->point_count;
        if (lists.begin[v + 1] - lists.begin[v] > FACE_LIMIT)
            continue;
        for (size_t i = lists.begin[v]; i < lists.begin[v + 1]; i++) {
            vec3s normal;
            const size_t triangle = lists.list[i] / 3;
            if (beyond_crease(&lists, v, triangle, &normal))
                STP_TRY(take_copy(mesh, (uint32_t)v, first_copy, normal,
                                  &mesh->triangles[triangle][lists.list[i] % 3], path, err));
        }
    }
done:
    free_lists(&lists);
    return status;
}

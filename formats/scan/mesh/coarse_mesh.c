/* Meshes whose vertices do not tell the surface. */
#include "formats/scan/mesh/coarse_mesh.h"

#include "base/memory.h"
#include "formats/scan/mesh/hybrid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A vertex of more faces is left alone: pairs of its faces are compared. */
#define FACE_LIMIT 256
/* Normals of copies that differ less are one. */
#define SAME_COSINE 0.99999

/* The diagonal of the box around the faces. */
static double diagonal_of(const stp_point_mesh *mesh)
{
    stp_dbox box = stp_dbox_empty();
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int k = 0; k < 3; k++)
            if (stp_dvec3_finite(mesh->points[mesh->triangles[t][k]].position))
                stp_dbox_add(&box, mesh->points[mesh->triangles[t][k]].position);
    return stp_dvec3_length(stp_dvec3_sub(box.max, box.min));
}

/* Finds the vertices of faces. used: zero. Returns how many they are. */
static size_t find_used(const stp_point_mesh *mesh, bool *used)
{
    size_t count = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int k = 0; k < 3; k++) {
            count += !used[mesh->triangles[t][k]];
            used[mesh->triangles[t][k]] = true;
        }
    return count;
}

static stp_status keep_loose(stp_point_mesh *mesh, const uint8_t *taken, stp_error *err)
{
    stp_status status = STP_OK;
    bool *used = NULL;
    STP_TRY(stp_alloc(&used, mesh->point_count, sizeof *used, "a mesh's vertices", err));
    STP_TRY(stp_alloc(&mesh->loose, mesh->point_count - find_used(mesh, used), sizeof *mesh->loose,
                      "points", err));
    for (size_t i = 0; i < mesh->point_count; i++)
        if (!used[i] && !(taken && taken[i]))
            mesh->loose[mesh->loose_count++] = (uint32_t)i;
    if (mesh->loose_count < STP_COARSE_LOOSE) {
        mesh->loose_left_out = mesh->loose_count;
        mesh->loose_count = 0;
    }
done:
    free(used);
    return status;
}

/* What the faces are in all. */
typedef struct face_sums {
    double area, long_area; /* of all; of those that are long */
    double sliver_area;
    double texels;
} face_sums;

static face_sums sum_faces(const stp_point_mesh *mesh, double most, double vertices)
{
    face_sums sums = {0};
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        sums.area += stp_point_mesh_area(mesh, t);
        sums.texels += stp_materials_texels(&mesh->materials, t);
    }
    const double sliver = STP_SLIVER_SPACINGS * sqrt(sums.area / vertices);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const double area = stp_point_mesh_area(mesh, t);
        const double side = stp_point_mesh_longest_side(mesh, t);
        sums.long_area += side > most ? area : 0.0;
        sums.sliver_area += side > sliver ? area : 0.0;
    }
    return sums;
}

stp_status stp_mesh_measure_coarse(const stp_point_mesh *mesh, uint64_t *sample_count,
                                   stp_error *err)
{
    stp_status status = STP_OK;
    bool *used = NULL;
    const double diagonal = diagonal_of(mesh), across = STP_COARSE_POINTS / diagonal;
    *sample_count = 0;
    STP_TRY(stp_alloc(&used, mesh->point_count, sizeof *used, "a mesh's vertices", err));
    const double vertices = (double)find_used(mesh, used);
    const face_sums sums = sum_faces(mesh, diagonal / STP_COARSE_SIDES, vertices);
    const bool slivers = sums.sliver_area >= STP_SLIVER_SHARE * sums.area;
    if (!(sums.area > 0.0) || !isfinite(sums.area) ||
        (!slivers && sums.long_area < STP_COARSE_SHARE * sums.area &&
         sums.texels <= STP_COARSE_TEXELS * vertices))
        goto done;
    if (mesh->attributes & STP_POINT_HAS_STATION && 2.0 * vertices < (double)mesh->point_count)
        goto done; /* a scan beside a few faces: samples have no stations */
    const double stay = slivers ? STP_HYBRID_POINTS * (double)mesh->triangle_count : 0.0;
    const double spread = fmax(sums.area * across * across, stay);
    *sample_count = (uint64_t)fmax(vertices, fmax(fmin(spread, STP_COARSE_POINT_LIMIT),
                                                  fmin(sums.texels, STP_COARSE_TEXEL_LIMIT)));
done:
    free(used);
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
        out->areas[t] = stp_point_mesh_area_vector(mesh, t);
        out->units[t] = stp_dvec3_from_float(stp_unit_normal(out->areas[t]));
    }
done:
    return status;
}

/* Whether faces around the corner's vertex lie beyond a crease; then *normal becomes that of those
 * that do not. */
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
    found = found && stp_dvec3_dot(own, own) > 0.0;
    if (found)
        *normal = stp_unit_normal(sum);
    return found;
}

/* The number of a copy of the vertex with this normal and colour; those from `first` on are its
 * copies. */
static stp_status take_copy(stp_point_mesh *mesh, uint32_t vertex, size_t first,
                            const stp_point *look, uint32_t *number, const char *path,
                            stp_error *err)
{
    stp_status status = STP_OK;
    for (size_t i = first; i < mesh->point_count; i++) {
        const stp_dvec3 n = stp_dvec3_from_float(mesh->points[i].normal);
        if (stp_dvec3_dot(n, stp_dvec3_from_float(look->normal)) > SAME_COSINE &&
            memcmp(mesh->points[i].rgb, look->rgb, sizeof look->rgb) == 0) {
            *number = (uint32_t)i;
            return STP_OK;
        }
    }
    STP_TRY(stp_point_mesh_reserve(mesh, path, 1, err));
    *number = (uint32_t)mesh->point_count;
    mesh->points[mesh->point_count] = mesh->points[vertex];
    mesh->points[mesh->point_count].normal = look->normal;
    memcpy(mesh->points[mesh->point_count++].rgb, look->rgb, sizeof look->rgb);
done:
    return status;
}

/* Gives the corners of a vertex copies of it, where they look different. */
static stp_status split_vertex(stp_point_mesh *mesh, const corner_lists *lists, uint32_t v,
                               const char *path, stp_error *err)
{
    static const double middle[3] = {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0};
    stp_status status = STP_OK;
    const size_t first_copy = mesh->point_count;
    for (size_t i = lists->begin[v]; i < lists->begin[v + 1]; i++) {
        const size_t triangle = lists->list[i] / 3;
        stp_point look = mesh->points[v];
        bool differs = beyond_crease(lists, v, triangle, &look.normal);
        if (!stp_materials_textured(&mesh->materials, triangle) &&
            stp_materials_colour(&mesh->materials, triangle, middle, 0.0, look.rgb))
            differs |= memcmp(look.rgb, mesh->points[v].rgb, sizeof look.rgb) != 0;
        if (differs)
            STP_TRY(take_copy(mesh, v, first_copy, &look,
                              &mesh->triangles[triangle][lists->list[i] % 3], path, err));
    }
done:
    return status;
}

stp_status stp_mesh_split_creases(stp_point_mesh *mesh, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    corner_lists lists = {0};
    const size_t vertices = mesh->point_count;
    STP_TRY(list_corners(mesh, &lists, err));
    for (size_t v = 0; v < vertices; v++)
        if (lists.begin[v + 1] - lists.begin[v] <= FACE_LIMIT)
            STP_TRY(split_vertex(mesh, &lists, (uint32_t)v, path, err));
done:
    free_lists(&lists);
    return status;
}

stp_status stp_mesh_begin_samples(stp_point_mesh *mesh, uint8_t **taken, const char *path,
                                  stp_error *err)
{
    const stp_status status = keep_loose(mesh, *taken, err);
    free(*taken);
    *taken = NULL;
    mesh->edge_count = 0;
    return status == STP_OK ? stp_mesh_split_creases(mesh, path, err) : status;
}

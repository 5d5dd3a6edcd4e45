/* Reads meshes of plants for prep. */
#include "tools/prep/prep_plants.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

static void add_report(stp_plant_report *sum, const stp_plant_report *one)
{
    sum->vertices_before += one->vertices_before;
    sum->positions_before += one->positions_before;
    sum->vertices_after += one->vertices_after;
    sum->triangles += one->triangles;
    sum->ribbon_triangles += one->ribbon_triangles;
    sum->tube_triangles += one->tube_triangles;
    sum->kept_triangles += one->kept_triangles;
    sum->ribbons += one->ribbons;
    sum->tubes += one->tubes;
    sum->rings += one->rings;
}

/* Converts a mesh to triangles that are drawn as triangles, with radius 0. */
static stp_status take_rest(const stp_mesh *mesh, stp_triangle_set *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_triangle_set set = {0};
    vec3s *normals = NULL;
    STP_TRY(stp_alloc(&set.vertices, mesh->vertex_count, sizeof *set.vertices, "triangles", err));
    STP_TRY(
        stp_alloc(&set.triangles, mesh->triangle_count, sizeof *set.triangles, "triangles", err));
    if (!mesh->normals) {
        STP_TRY(stp_alloc(&normals, mesh->vertex_count, sizeof *normals, "normals", err));
        stp_mesh_vertex_normals(mesh, normals);
    }
    set.vertex_count = mesh->vertex_count;
    set.triangle_count = mesh->triangle_count;
    for (uint64_t i = 0; i < mesh->vertex_count; i++) {
        set.vertices[i] = (stp_line_vertex){
            .position = mesh->positions[i],
            .direction = mesh->normals ? mesh->normals[i] : normals[i],
        };
        for (int c = 0; c < 3; c++)
            set.vertices[i].rgb[c] = mesh->rgb ? mesh->rgb[i][c] : STP_POINT_GREY;
    }
    if (mesh->triangle_count > 0)
        memcpy(set.triangles, mesh->triangles, mesh->triangle_count * sizeof *set.triangles);
    *out = set;
    set = (stp_triangle_set){0};
done:
    stp_triangle_set_clear(&set);
    free(normals);
    return status;
}

stp_status prep_plants_read(const char *path, stp_line_set *lines, stp_triangle_set *triangles,
                            stp_plant_report *report, stp_error *err)
{
    stp_status status = STP_OK;
    stp_mesh *mesh = NULL;
    stp_plant plant = {0};
    STP_TRY(stp_mesh_load(&mesh, path, err));
    STP_TRY(stp_plant_convert(&plant, mesh, NULL, err));
    STP_TRY(take_rest(plant.rest, triangles, err));
    *lines = plant.lines;
    plant.lines = (stp_line_set){0};
    add_report(report, &plant.report);
done:
    stp_plant_clear(&plant);
    stp_mesh_destroy(&mesh);
    return status;
}

/* Closed surfaces have half as many vertices as faces, loose leaves of two triangles have twice as
 * many. */
#define SUSPECT_VERTICES_PER_FACE 0.6
#define SUSPECT_FACES_MOST 1000000u
#define SUSPECT_LEAVES_LEAST 32u

bool prep_plants_suspect(const char *path, const stp_scan_info *info)
{
    bool suspect = false;
    stp_mesh *mesh = NULL;
    stp_plant plant = {0};
    const double least = SUSPECT_VERTICES_PER_FACE * (double)info->face_count;
    const bool sampled = info->coarse_samples > 0; /* then the points are not the vertices */
    if (info->face_count > SUSPECT_FACES_MOST || (!sampled && (double)info->point_count < least))
        return false;
    if (stp_mesh_load(&mesh, path, NULL) == STP_OK && (double)mesh->vertex_count >= least &&
        stp_plant_convert(&plant, mesh, NULL, NULL) == STP_OK)
        suspect = plant.report.ribbons >= SUSPECT_LEAVES_LEAST &&
                  2 * plant.report.kept_triangles < plant.report.triangles;
    stp_plant_clear(&plant);
    stp_mesh_destroy(&mesh);
    return suspect;
}

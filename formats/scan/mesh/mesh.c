/* A triangle mesh in memory: loading and vertex normals. */
#include "formats/scan/mesh/mesh.h"

#include "base/memory.h"
#include "formats/scan/detect.h"
#include "formats/scan/mesh/mesh_read.h"
#include "formats/scan/mesh/point_mesh.h"
#include "formats/scan/ply/ply.h"

#include <stdlib.h>
#include <string.h>

static stp_status read_any(stp_point_mesh *points, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_scan_format format;
    stp_ply *ply = NULL;
    STP_TRY(stp_scan_detect(&format, path, err));
    if (format != STP_SCAN_PLY) {
        STP_TRY(stp_mesh_read(points, path, format, err));
    } else {
        STP_TRY(stp_ply_open(&ply, path, false, err));
        STP_TRY(stp_ply_read_mesh(ply, points, err));
    }
done:
    stp_ply_close(&ply);
    return status;
}

/* Splits the points' attributes into separate arrays; takes over the triangles. */
static stp_status split(stp_mesh *mesh, stp_point_mesh *from, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t count = from->point_count;
    STP_TRY(stp_alloc(&mesh->positions, count, sizeof *mesh->positions, "positions", err));
    if (from->attributes & STP_POINT_HAS_NORMAL)
        STP_TRY(stp_alloc(&mesh->normals, count, sizeof *mesh->normals, "normals", err));
    if (from->attributes & STP_POINT_HAS_COLOUR)
        STP_TRY(stp_alloc(&mesh->rgb, count, sizeof *mesh->rgb, "colours", err));
    for (size_t i = 0; i < count; i++) {
        mesh->positions[i] = from->points[i].position;
        if (mesh->normals)
            mesh->normals[i] = from->points[i].normal;
        if (mesh->rgb)
            memcpy(mesh->rgb[i], from->points[i].rgb, sizeof mesh->rgb[i]);
    }
    mesh->vertex_count = count;
    mesh->triangle_count = from->triangle_count;
    mesh->triangles = from->triangles;
    from->triangles = NULL;
done:
    return status;
}

stp_status stp_mesh_load(stp_mesh **out, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_point_mesh points = {0};
    stp_mesh *mesh = NULL;
    STP_TRY(read_any(&points, path, err));
    STP_TRY(stp_alloc(&mesh, 1, sizeof *mesh, "mesh", err));
    STP_TRY(split(mesh, &points, err));
    *out = mesh;
    mesh = NULL;
done:
    stp_mesh_destroy(&mesh);
    stp_point_mesh_free(&points);
    return status;
}

void stp_mesh_destroy(stp_mesh **mesh)
{
    stp_mesh *m = *mesh;
    if (!m)
        return;
    free(m->positions);
    free(m->normals);
    free(m->rgb);
    free(m->triangles);
    free(m);
    *mesh = NULL;
}

void stp_mesh_vertex_normals(const stp_mesh *mesh, vec3s *normals)
{
    if (mesh->vertex_count == 0)
        return;
    memset(normals, 0, (size_t)mesh->vertex_count * sizeof *normals);
    stp_accumulate_normals(mesh->positions, sizeof *mesh->positions,
                           (const uint32_t(*)[3])mesh->triangles, (size_t)mesh->triangle_count,
                           normals, sizeof *normals, (size_t)mesh->vertex_count);
}

/* Reads OBJ, OFF and STL into a point mesh through OpenMesh, and glTF. */
#include "formats/scan/mesh/mesh_read.h"

#include "formats/scan/gltf/gltf.h"
#include "formats/scan/mesh/mesh_colours.h"
#include "formats/scan/mesh/mesh_text.h"
#include "formats/scan/mesh/openmesh_shim.h"
#include "formats/scan/mesh/stl_colours.h"

typedef struct mesh_sink {
    stp_point_mesh *mesh;
    const char *path;
    bool has_points;   /* the text already gave the points, in double */
    size_t next_point; /* number of vertices from OpenMesh so far */
} mesh_sink;

static stp_status add_vertex(void *context, const float position[3], stp_error *err)
{
    stp_status status = STP_OK;
    mesh_sink *sink = context;
    stp_point_mesh *mesh = sink->mesh;
    if (!sink->has_points) {
        STP_TRY(stp_point_mesh_reserve(mesh, sink->path, 1, err));
        mesh->points[mesh->point_count++] = (stp_point){
            .position = {(double)position[0], (double)position[1], (double)position[2]}};
    }
    sink->next_point++;
done:
    return status;
}

static stp_status bad_vertex(const mesh_sink *sink, int64_t vertex, stp_error *err)
{
    return stp_error_set(
        err, STP_CORRUPT,
        "%s: face %llu names vertex %lld, but there are %zu (counted from 0): mend "
        "the mesh or export it again",
        sink->path, (unsigned long long)sink->mesh->face_count, (long long)vertex,
        sink->mesh->point_count);
}

static bool vertex_exists(const mesh_sink *sink, int64_t vertex)
{
    return vertex >= 0 && (uint64_t)vertex < sink->mesh->point_count;
}

/* Corners of one vertex may have different normals: adds up their directions. */
static stp_status add_normal(void *context, int64_t vertex, const float normal[3], stp_error *err)
{
    mesh_sink *sink = context;
    if (!vertex_exists(sink, vertex))
        return bad_vertex(sink, vertex, err);
    const vec3s unit =
        stp_unit_normal((stp_dvec3){(double)normal[0], (double)normal[1], (double)normal[2]});
    vec3s *sum = &sink->mesh->points[vertex].normal;
    for (int k = 0; k < 3; k++)
        sum->raw[k] += unit.raw[k];
    sink->mesh->attributes |= STP_POINT_HAS_NORMAL;
    return STP_OK;
}

static stp_status add_face(void *context, const int64_t *vertices, size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    mesh_sink *sink = context;
    for (size_t i = 0; i < count; i++)
        if (!vertex_exists(sink, vertices[i]))
            return bad_vertex(sink, vertices[i], err);
    for (size_t i = 2; i < count; i++)
        STP_TRY(stp_point_mesh_add_triangle(sink->mesh, (uint32_t)vertices[0],
                                            (uint32_t)vertices[i - 1], (uint32_t)vertices[i], err));
    sink->mesh->face_count++;
done:
    return status;
}

static stp_status prepare(stp_mesh_text *text, stp_scan_format format, stp_point_mesh *mesh,
                          stp_error *err)
{
    switch (format) {
    case STP_SCAN_OBJ:
        return stp_mesh_text_prepare_obj(text, mesh, err);
    case STP_SCAN_OFF:
        return stp_mesh_text_prepare_off(text, mesh, err);
    case STP_SCAN_STL_ASCII:
        return stp_mesh_text_prepare_stl_ascii(text, err);
    case STP_SCAN_STL_BINARY:
        return stp_mesh_text_check_stl_binary(text, err);
    default:
        break;
    }
    return stp_error_set(err, STP_INTERNAL, "%s: not a mesh format of OpenMesh's", text->path);
}

stp_status stp_mesh_read(stp_point_mesh *mesh, const char *path, stp_scan_format format,
                         stp_error *err)
{
    stp_status status = STP_OK;
    stp_mesh_text text = {0};
    if (format == STP_SCAN_GLTF) {
        status = stp_gltf_read(mesh, path, err);
        return status == STP_OK ? stp_mesh_take_colours(mesh, path, err) : status;
    }
    const bool is_stl = format == STP_SCAN_STL_ASCII || format == STP_SCAN_STL_BINARY;
    mesh_sink sink = {.mesh = mesh, .path = path, .has_points = !is_stl};
    const stp_openmesh_sink callbacks = {&sink, add_vertex, add_normal, add_face};
    STP_TRY(stp_mesh_text_load(&text, path, err));
    STP_TRY(prepare(&text, format, mesh, err));
    if (format == STP_SCAN_STL_BINARY)
        STP_TRY(stp_stl_colours_add(&text, &mesh->materials, err));
    const stp_openmesh_input input = {.path = path,
                                      .data = text.data,
                                      .size = text.size,
                                      .extension = format == STP_SCAN_OBJ   ? ".obj"
                                                   : format == STP_SCAN_OFF ? ".off"
                                                                            : ".stl",
                                      .binary = format == STP_SCAN_STL_BINARY};
    STP_TRY(stp_openmesh_read(&input, &callbacks, err));
    if (sink.next_point != mesh->point_count) {
        status = stp_error_set(err, STP_CORRUPT,
                               "%s: %zu vertices, of which OpenMesh could read %zu: export it "
                               "again, or as PLY",
                               path, mesh->point_count, sink.next_point);
        goto done;
    }
    for (size_t i = 0; i < mesh->point_count; i++)
        mesh->points[i].normal = stp_unit_normal(stp_dvec3_from_float(mesh->points[i].normal));
    STP_TRY(stp_mesh_take_colours(mesh, path, err));
done:
    stp_mesh_text_free(&text);
    return status;
}

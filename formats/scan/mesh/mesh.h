/* A triangle mesh in memory, as OpenMesh or the PLY reader gives it for callers that need faces.
 * Polygons become fans of triangles. Threads: any once loaded. */
#ifndef STP_FORMATS_SCAN_MESH_MESH_H
#define STP_FORMATS_SCAN_MESH_MESH_H

#include "base/error.h"
#include "base/vec.h"

#include <stdint.h>

typedef struct stp_mesh {
    uint64_t vertex_count;
    stp_dvec3 *positions;
    vec3s *normals;     /* NULL if the file has none */
    uint16_t (*rgb)[3]; /* NULL if the file has none; full range 0..65535 */
    uint64_t triangle_count;
    uint32_t (*triangles)[3];
} stp_mesh;

/* Loads PLY, OBJ, OFF, STL or glTF. Errors as stp_scan_open. */
stp_status stp_mesh_load(stp_mesh **out, const char *path, stp_error *err);
void stp_mesh_destroy(stp_mesh **mesh);
/* Writes area-weighted vertex normals of the faces into normals[vertex_count]. A normal is zero if
 * no face of the vertex has a positive area. */
void stp_mesh_vertex_normals(const stp_mesh *mesh, vec3s *normals);

#endif

/* A triangle mesh in memory: what OpenMesh or the PLY reader gives when faces matter.
 * Polygons are fans of triangles. Threads: any once loaded. */
#ifndef STP_FORMATS_SCAN_MESH_MESH_H
#define STP_FORMATS_SCAN_MESH_MESH_H

#include "base/error.h"
#include "base/vec.h"

#include <stdint.h>

typedef struct stp_mesh {
    uint64_t vertex_count;
    stp_dvec3 *positions;
    vec3s *normals;     /* NULL where the file has none */
    uint16_t (*rgb)[3]; /* NULL likewise; full range 0..65535 */
    uint64_t triangle_count;
    uint32_t (*triangles)[3];
} stp_mesh;

/* PLY, OBJ, OFF or STL. Errors as stp_scan_open. */
stp_status stp_mesh_load(stp_mesh **out, const char *path, stp_error *err);
void stp_mesh_destroy(stp_mesh **mesh);
/* Area-weighted vertex normals of the faces into normals[vertex_count]; zero where a vertex has no
 * face of positive area. */
void stp_mesh_vertex_normals(const stp_mesh *mesh, vec3s *normals);

#endif

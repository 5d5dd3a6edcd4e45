/* A mesh as the scan reader holds it: points with all their attributes, and triangles over them.
 *
 * Grows as a file is read, never by what its header promises. Polygons are fans of triangles.
 * Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_POINT_MESH_H
#define STP_FORMATS_SCAN_POINT_MESH_H

#include "base/error.h"
#include "formats/scan/mesh.h"
#include "formats/scan/scan.h"

#include <stddef.h>
#include <stdint.h>

typedef struct stp_point_mesh {
    stp_point *points;
    size_t point_count, point_capacity;
    uint32_t (*triangles)[3];
    size_t triangle_count, triangle_capacity;
    uint64_t face_count; /* polygons, as the file counts them */
    uint32_t attributes; /* STP_POINT_HAS_* of the file */
} stp_point_mesh;

/* Room for count more points. Errors: OUT_OF_MEMORY, LIMIT (indices have 32 bits). */
stp_status stp_point_mesh_reserve(stp_point_mesh *mesh, const char *path, size_t count,
                                  stp_error *err);
/* The indices name points: who reads them from a file has checked. Errors: OUT_OF_MEMORY. */
stp_status stp_point_mesh_add_triangle(stp_point_mesh *mesh, uint32_t a, uint32_t b, uint32_t c,
                                       stp_error *err);
/* Replaces the points' normals by the area-weighted ones of their faces; zero where there is none.
 */
void stp_point_mesh_set_normals(stp_point_mesh *mesh);
void stp_point_mesh_free(stp_point_mesh *mesh);

/* The normals' common part: positions stride bytes apart, and so the normals; normals start at
 * zero. */
void stp_accumulate_normals(const stp_dvec3 *positions, size_t position_stride,
                            const uint32_t (*triangles)[3], size_t triangle_count, vec3s *normals,
                            size_t normal_stride, size_t vertex_count);

/* The unit vector along n, zero where n is zero or not finite. */
vec3s stp_unit_normal(stp_dvec3 n);

#endif

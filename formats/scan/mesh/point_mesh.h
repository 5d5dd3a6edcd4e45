/* A mesh as the scan reader holds it: points with all their attributes, triangles over them, and
 * edges between them that are lines.
 *
 * The mesh grows as the file is read, never by what the header promises. Polygons become fans of
 * triangles. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_MESH_POINT_MESH_H
#define STP_FORMATS_SCAN_MESH_POINT_MESH_H

#include "base/error.h"
#include "formats/scan/mesh/material.h"
#include "formats/scan/mesh/mesh.h"
#include "formats/scan/scan.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* An edge as the file has it. The vertices may not exist. */
typedef struct stp_mesh_edge {
    uint32_t vertices[2]; /* STP_MESH_NO_VERTEX: a number that no vertex can have */
    uint16_t rgb[3];      /* 0..65535; set if the mesh has edge_colours */
} stp_mesh_edge;

#define STP_MESH_NO_VERTEX UINT32_MAX

typedef struct stp_point_mesh {
    stp_point *points;
    size_t point_count, point_capacity;
    uint32_t (*triangles)[3];
    size_t triangle_count, triangle_capacity;
    stp_mesh_edge *edges;
    size_t edge_count, edge_capacity;
    bool edge_colours;
    float *radii; /* per point, half-widths of lines; NULL if the file has none */
    size_t radius_capacity;
    stp_materials materials; /* by triangle, of OBJ and PLY files; empty: none */
    uint32_t *loose;         /* points that no face uses, kept beside samples of the faces */
    size_t loose_count;
    uint64_t loose_left_out; /* such points, but too few to be kept */
    uint64_t face_count;     /* polygons, counted as in the file */
    uint32_t attributes;     /* STP_POINT_HAS_* of the file */
} stp_point_mesh;

/* Makes room for count more points. Errors: OUT_OF_MEMORY, LIMIT (indices have 32 bits). */
stp_status stp_point_mesh_reserve(stp_point_mesh *mesh, const char *path, size_t count,
                                  stp_error *err);
/* The indices must name points: the reader of the file has checked them. Errors: OUT_OF_MEMORY. */
stp_status stp_point_mesh_add_triangle(stp_point_mesh *mesh, uint32_t a, uint32_t b, uint32_t c,
                                       stp_error *err);
/* Errors: OUT_OF_MEMORY. */
stp_status stp_point_mesh_add_edge(stp_point_mesh *mesh, const stp_mesh_edge *edge, stp_error *err);
/* Replaces the points' normals by the area-weighted normals of their faces; zero if there is none.
 */
void stp_point_mesh_set_normals(stp_point_mesh *mesh);
void stp_point_mesh_free(stp_point_mesh *mesh);

/* Twice a triangle's area times its normal; zero if a corner is not finite. */
stp_dvec3 stp_point_mesh_area_vector(const stp_point_mesh *mesh, size_t triangle);
/* 0 if a corner is not finite. */
double stp_point_mesh_area(const stp_point_mesh *mesh, size_t triangle);
double stp_point_mesh_longest_side(const stp_point_mesh *mesh, size_t triangle);

/* Adds the faces' area-weighted normals to normals, which start at zero. Positions lie
 * position_stride bytes apart, normals likewise. */
void stp_accumulate_normals(const stp_dvec3 *positions, size_t position_stride,
                            const uint32_t (*triangles)[3], size_t triangle_count, vec3s *normals,
                            size_t normal_stride, size_t vertex_count);

/* The unit vector along n; zero if n is zero or not finite. */
vec3s stp_unit_normal(stp_dvec3 n);

#endif

/* Splits a mesh into a hybrid surface (MKC08, section 4): large triangles stay triangles, the
 * others become points.
 *
 * The sampling s is the side of a square that holds one point: s^2 = area / points, with the points
 * wanted over all faces, or the vertices. A triangle is large if it would get STP_HYBRID_POINTS
 * points, or if all triangles would get so many on average. If the points are vertices, a triangle
 * is also large if it is as long as an equilateral triangle that would get so many. Triangles with
 * colours from an image are never large: their corners alone would not keep these. If a large
 * triangle meets other triangles, its vertices there get the radius of the points there, so that
 * both blend. Threads: any, one mesh each. */
#ifndef STP_FORMATS_SCAN_MESH_HYBRID_H
#define STP_FORMATS_SCAN_MESH_HYBRID_H

#include "formats/scan/mesh/point_mesh.h"
#include "formats/scan/mesh/triangle_set.h"

/* A triangle is stored as three samples. If it replaces 8 points or more, it is the smaller one. */
#define STP_HYBRID_POINTS 8.0
/* Radius of a vertex at a border, divided by the sampling; prep's lambda. */
#define STP_HYBRID_LAMBDA 1.7

/* Moves large triangles to *out, which must be empty; the mesh keeps the others. *sample_count: in,
 * the points wanted over all faces, 0 for the vertices; out, the points wanted over the remaining
 * faces, at least 1 if a face has an area. taken: per point of the mesh, set if only large
 * triangles use the point. The mesh must have its normals. Errors: OUT_OF_MEMORY. */
stp_status stp_hybrid_split(stp_point_mesh *mesh, uint64_t *sample_count, uint8_t *taken,
                            stp_triangle_set *out, stp_error *err);

#endif

/* A mesh as a hybrid surface (MKC08, section 4): large triangles stay triangles, of the others the
 * points are taken.
 *
 * The sampling is the side of a square of which each point has one: of the points wanted over all
 * faces, or of the vertices. A triangle is large if it would get STP_HYBRID_POINTS of them, or
 * where these are vertices if it is as long as an equilateral triangle that would. Where a large
 * triangle meets others, the vertices' radius is that of the points there, so that both blend.
 * Threads: any, one mesh each. */
#ifndef STP_FORMATS_SCAN_MESH_HYBRID_H
#define STP_FORMATS_SCAN_MESH_HYBRID_H

#include "formats/scan/mesh/point_mesh.h"
#include "formats/scan/mesh/triangle_set.h"

/* A triangle is stored as three samples: with so many points in its place it is the smaller one. */
#define STP_HYBRID_POINTS 8.0
/* Radius of a border's vertices over the sampling; prep's lambda. */
#define STP_HYBRID_LAMBDA 1.7

/* Moves large triangles to *out, which must be empty; the mesh keeps the others. *sample_count: how
 * many points are wanted over all faces, 0 for the vertices; then, over those that are left, at
 * least 1 where any has an area. taken: by point of the mesh, set where only large triangles have
 * it. The mesh has its normals. Errors: OUT_OF_MEMORY. */
stp_status stp_hybrid_split(stp_point_mesh *mesh, uint64_t *sample_count, uint8_t *taken,
                            stp_triangle_set *out, stp_error *err);

#endif

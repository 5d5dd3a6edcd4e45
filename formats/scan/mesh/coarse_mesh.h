/* Meshes whose vertices do not tell the surface: their faces are large, as those of a drawn house.
 *
 * A face is long if its longest side exceeds 1 / STP_COARSE_SIDES of the diagonal of the mesh's
 * box: 8 pixels of a picture of 512. A mesh is coarse if a share STP_COARSE_SHARE of its area lies
 * in long faces. Meshes of scans have less than 1/100 of their area there, drawn ones nearly all. A
 * mesh is coarse, too, if half of its area lies in slivers: faces longer than STP_SLIVER_SPACINGS
 * times the vertices' mean spacing, as in parts that were constructed. Discs of the vertices would
 * leave gaps along them. It gets the points that let all its triangles stay (hybrid.h). A mesh is
 * coarse as well if its images have more than STP_COARSE_TEXELS texels on the faces for each
 * vertex: the vertices would lose the picture. Vertices without a face stay points beside the
 * samples, unless they are fewer than STP_COARSE_LOOSE: waste of an export, whose discs would be as
 * wide as the model. If they are more than half, and stations saw them, the mesh is not coarse.
 * Threads: any, one mesh each. */
#ifndef STP_FORMATS_SCAN_MESH_COARSE_MESH_H
#define STP_FORMATS_SCAN_MESH_COARSE_MESH_H

#include "formats/scan/mesh/point_mesh.h"

#define STP_COARSE_SIDES 64.0
#define STP_COARSE_SHARE 0.125
/* Meshes of scans have less than a tenth of their area in such faces. */
#define STP_SLIVER_SPACINGS 3.0
#define STP_SLIVER_SHARE 0.5
/* Points on the diagonal, if a coarse mesh is sampled: about one a pixel. */
#define STP_COARSE_POINTS 512.0
/* The most points that a coarse mesh gets, unless it has more vertices. */
#define STP_COARSE_POINT_LIMIT 4000000.0
/* Likewise for the sake of its texels. */
#define STP_COARSE_TEXEL_LIMIT 2000000.0
/* A mesh is coarse if it has more texels than so many for each vertex. */
#define STP_COARSE_TEXELS 2.0
/* A mesh of more vertices, in a file that has their normals, is not read to find out. */
#define STP_COARSE_VERTEX_LIMIT 1000000u
/* As many points as have each other for neighbours. */
#define STP_COARSE_LOOSE 17u
/* Faces that meet at a greater angle, 45 degrees, do so in a crease. */
#define STP_CREASE_COSINE 0.70710678

/* *sample_count: the points that the faces of a coarse mesh should get, no fewer than they have
 * vertices; 0 if it is not coarse. Errors: OUT_OF_MEMORY. */
stp_status stp_mesh_measure_coarse(const stp_point_mesh *mesh, uint64_t *sample_count,
                                   stp_error *err);
/* Notes the vertices without a face, or how many are left out, but for those that lines have taken,
 * by point; *taken may be NULL, and becomes NULL. Forgets the edges, which are lines now, and
 * splits creases. Errors: as stp_mesh_split_creases. */
stp_status stp_mesh_begin_samples(stp_point_mesh *mesh, uint8_t **taken, const char *path,
                                  stp_error *err);
/* Gives each side of a crease vertices and normals of its own. A face whose material has another
 * colour than a vertex gets a copy of the vertex in its own colour. A corner's new normal is the
 * area-weighted one of those faces around its vertex that lie within the crease's angle of its
 * face. Where all do, the vertex keeps its normal. The mesh must have its normals, and no edges.
 * Errors: OUT_OF_MEMORY, LIMIT (indices have 32 bits). */
stp_status stp_mesh_split_creases(stp_point_mesh *mesh, const char *path, stp_error *err);

#endif

/* A plant's mesh to lines: leaves to ribbons, branches to tubes, the rest stays triangles.
 *
 * Source: Marroquim, Kraus, Cavalcanti, "Efficient image reconstruction for point-based and
 * line-based rendering", Computers & Graphics 2008, section 4.3; how leaves and rings are found and
 * what becomes of them say plant_leaf.h and plant_tube.h. The mesh is taken apart where it is not
 * joined (mesh_parts.h); each part is a leaf, or a branch as far as its rings go, or stays. Each
 * triangle is replaced by one line or kept, never both; twins, a leaf's front and back, together.
 * Vertices of no triangle are left out. Same mesh, same bytes. Takes time and
 * memory in proportion to the mesh. Threads: any. */
#ifndef STP_PREPROCESS_PLANT_PLANT_H
#define STP_PREPROCESS_PLANT_PLANT_H

#include "base/error.h"
#include "formats/scan/mesh/line_set.h"
#include "formats/scan/mesh/mesh.h"

#include <stdint.h>

/* Lengths as parts of the diagonal of the box around the mesh's triangles; 0 means the default. */
typedef struct stp_plant_params {
    double leaf_size; /* the greatest of a leaf, its box's diagonal; 0.1 */
    /* The greatest radius of a tube; what is thicker is trunk and stays triangles. 1/128: in a
     * picture that the plant fills, 1,024 pixels across, such a tube is 16 pixels wide. A line has
     * one normal across its width and a disc turned to the eye, which pixels wider than that show.
     */
    double trunk_radius;
} stp_plant_params;

typedef struct stp_plant_report {
    uint64_t vertices_before;  /* the mesh's, as its file has them */
    uint64_t positions_before; /* distinct ones of these: without what seams repeat */
    uint64_t vertices_after;   /* the lines' and those of kept triangles */
    uint64_t triangles;        /* all: the sum of the next three */
    uint64_t ribbon_triangles, tube_triangles, kept_triangles;
    uint64_t ribbons;      /* one a leaf */
    uint64_t tubes, rings; /* rings: all of the tubes' vertices */
} stp_plant_report;

typedef struct stp_plant {
    stp_line_set lines; /* class and intensity are 0 */
    stp_mesh *rest;     /* kept triangles in their order, with the vertices that they use */
    stp_plant_report report;
} stp_plant;

/* The mesh's indices name vertices; whoever read it has checked. params may be NULL. Errors:
 * INVALID_ARGUMENT (a parameter negative or not finite), LIMIT (mesh_parts.h), OUT_OF_MEMORY. */
stp_status stp_plant_convert(stp_plant *out, const stp_mesh *mesh, const stp_plant_params *params,
                             stp_error *err);
void stp_plant_clear(stp_plant *plant);

#endif

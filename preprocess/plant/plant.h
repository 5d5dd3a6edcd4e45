/* Turns a plant's mesh into lines: leaves into ribbons, branches into tubes. The rest stays
 * triangles.
 *
 * Source: Marroquim, Kraus, Cavalcanti, "Efficient image reconstruction for point-based and
 * line-based rendering", Computers & Graphics 2008, section 4.3. plant_leaf.h and plant_tube.h say
 * how leaves and rings are found and what becomes of them.
 *
 * The mesh is split into its connected parts (mesh_parts.h). A part is a leaf, or a branch as far
 * as its rings go, or stays. Each triangle is either replaced by one line or kept, never both;
 * twins, a leaf's front and back, go together. Vertices of no triangle are left out. The same mesh
 * gives the same bytes. Takes time and memory proportional to the mesh. Threads: any. */
#ifndef STP_PREPROCESS_PLANT_PLANT_H
#define STP_PREPROCESS_PLANT_PLANT_H

#include "base/error.h"
#include "formats/scan/mesh/line_set.h"
#include "formats/scan/mesh/mesh.h"

#include <stdint.h>

/* Lengths, relative to the diagonal of the box around the mesh's triangles. 0: the default. */
typedef struct stp_plant_params {
    double leaf_size; /* largest leaf: diagonal of its box; default 0.1 */
    /* Greatest radius of a tube; default 1/128. Anything thicker is trunk and stays triangles. In a
     * picture 1,024 pixels across that the plant fills, such a tube is 16 pixels wide. A line has
     * one normal across its width and a disc turned to the eye; wider lines would show it. */
    double trunk_radius;
} stp_plant_params;

typedef struct stp_plant_report {
    uint64_t vertices_before;  /* the mesh's, as its file has them */
    uint64_t positions_before; /* distinct positions of these: without repeats at seams */
    uint64_t vertices_after;   /* of lines and of kept triangles */
    uint64_t triangles;        /* all: the sum of the next three */
    uint64_t ribbon_triangles, tube_triangles, kept_triangles;
    uint64_t ribbons;      /* one per leaf */
    uint64_t tubes, rings; /* rings: all of the tubes' vertices */
} stp_plant_report;

typedef struct stp_plant {
    stp_line_set lines; /* class and intensity are 0 */
    stp_mesh *rest;     /* kept triangles in their order, with their vertices */
    stp_plant_report report;
} stp_plant;

/* Converts a mesh. All of its indices must be valid; its reader has checked that. params may be
 * NULL. Errors: INVALID_ARGUMENT (a parameter is negative or not finite), LIMIT (mesh_parts.h),
 * OUT_OF_MEMORY. */
stp_status stp_plant_convert(stp_plant *out, const stp_mesh *mesh, const stp_plant_params *params,
                             stp_error *err);
void stp_plant_clear(stp_plant *plant);

#endif

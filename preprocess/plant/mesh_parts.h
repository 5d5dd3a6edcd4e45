/* The parts of a triangle mesh: triangles joined across edges that exactly two of them share.
 *
 * Vertices at the same position count as one here, however often seams of texture or shading repeat
 * them; positions are compared exactly (0 and -0 are the same). An edge of one triangle is a part's
 * border; one of three or more joins nothing, and a vertex alone joins nothing. A triangle that is
 * none (a corner twice, a coordinate that is not finite) is in no part, nor is the twin of an
 * earlier one, with the same three positions: many leaves have a front and a back. Takes time in
 * proportion to the mesh. Threads: any, one result each. */
#ifndef STP_PREPROCESS_PLANT_MESH_PARTS_H
#define STP_PREPROCESS_PLANT_MESH_PARTS_H

#include "base/error.h"
#include "formats/scan/mesh/mesh.h"

#include <stdint.h>

typedef struct stp_mesh_parts {
    uint64_t position_count; /* distinct ones */
    uint32_t *first_at;      /* of each vertex: the first one at its position */
    uint8_t *open_edges;     /* of each triangle: bit k where edge k to k + 1 is not of two */
    uint32_t *first_same;    /* of each triangle: the first at its three positions */
    uint32_t part_count;     /* in the order of their first triangles */
    uint32_t *begins;        /* part_count + 1 places in order */
    uint32_t *order;         /* the parts' triangles, ascending in each */
    uint32_t most_triangles; /* of a part */
} stp_mesh_parts;

/* The mesh's indices name vertices. Errors: OUT_OF_MEMORY, LIMIT (2^30 triangles or vertices). */
stp_status stp_mesh_parts_find(stp_mesh_parts *out, const stp_mesh *mesh, stp_error *err);
void stp_mesh_parts_clear(stp_mesh_parts *parts);

#endif

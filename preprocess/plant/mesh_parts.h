/* The parts of a triangle mesh: triangles joined across edges that exactly two of them share.
 *
 * Vertices at the same position count as one vertex here, even if seams of texture or shading
 * repeat them. Positions are compared exactly (0 equals -0). An edge of one triangle is a part's
 * border. An edge of three or more triangles joins nothing, and neither does a shared vertex alone.
 * In no part are: a degenerate triangle (a corner twice, or a coordinate that is not finite), and
 * the twin of an earlier triangle, with the same three positions. Many leaves have a front and a
 * back. Takes time proportional to the mesh. Threads: any, one result each. */
#ifndef STP_PREPROCESS_PLANT_MESH_PARTS_H
#define STP_PREPROCESS_PLANT_MESH_PARTS_H

#include "base/error.h"
#include "formats/scan/mesh/mesh.h"

#include <stdint.h>

typedef struct stp_mesh_parts {
    uint64_t position_count; /* distinct positions */
    uint32_t *first_at;      /* by vertex: the first vertex at its position */
    uint8_t *open_edges;     /* by triangle: bit k: the edge from corner k to k + 1 is not of two
                                triangles */
    uint32_t *first_same;    /* by triangle: the first one with its three positions */
    uint32_t part_count;     /* in the order of their first triangles */
    uint32_t *begins;        /* part_count + 1 places in order */
    uint32_t *order;         /* the parts' triangles, ascending in each */
    uint32_t most_triangles; /* of a part */
} stp_mesh_parts;

/* Finds the parts. All of the mesh's indices must be valid. Errors: OUT_OF_MEMORY, LIMIT (2^30
 * triangles or vertices). */
stp_status stp_mesh_parts_find(stp_mesh_parts *out, const stp_mesh *mesh, stp_error *err);
void stp_mesh_parts_clear(stp_mesh_parts *parts);

#endif

/* Chains the edges of a mesh to polylines: two edges that meet at a vertex are joined; every other
 * vertex ends a polyline.
 *
 * An edge is left out and counted if it names a vertex that does not exist or is not finite, joins
 * a vertex with itself, repeats an edge, or is a side of a face. The first vertex of a closed chain
 * is also its last one. The order of the lines follows the vertex numbers, whatever the order of
 * the edges. Threads: any, one mesh each. */
#ifndef STP_FORMATS_SCAN_MESH_LINE_CHAIN_H
#define STP_FORMATS_SCAN_MESH_LINE_CHAIN_H

#include "formats/scan/mesh/line_set.h"
#include "formats/scan/mesh/point_mesh.h"

/* Half the width of lines without a width, as a part of the diagonal of their box. The width is a
 * pixel if the box fills 1,000 pixels. */
#define STP_LINE_RADIUS_PART (1.0 / 2000.0)

/* Makes lines of the mesh's edges: ribbons if all vertices of a chain have normals from the file,
 * else tubes. Half-width: the vertex's if it is positive, else `radius`, else by
 * STP_LINE_RADIUS_PART. If only edges have colours, a vertex gets the mean of its edges' colours,
 * and the mesh has colours. *taken: per point, true if a line goes through it and no face uses it;
 * free with free(). Errors: OUT_OF_MEMORY. */
stp_status stp_line_chain(stp_line_set *out, uint8_t **taken, stp_point_mesh *mesh, double radius,
                          stp_edge_counts *counts, stp_error *err);

#endif

/* Edges of a mesh as polylines: chained at vertices where two edges meet, ended at all others.
 *
 * Edges that name a vertex that does not exist or is not finite, that join a vertex with itself,
 * that are there already or that are sides of faces are left out and counted. A closed chain begins
 * at its first vertex, which is its last one, too. Order: by vertices' numbers, whatever that of
 * the edges. Threads: any, one mesh each. */
#ifndef STP_FORMATS_SCAN_MESH_LINE_CHAIN_H
#define STP_FORMATS_SCAN_MESH_LINE_CHAIN_H

#include "formats/scan/mesh/line_set.h"
#include "formats/scan/mesh/point_mesh.h"

/* Half the width of lines that have none, as a part of the diagonal of their box: a pixel where the
 * box fills 1,000. */
#define STP_LINE_RADIUS_PART (1.0 / 2000.0)

/* Makes lines of the mesh's edges: ribbons where all vertices of a chain have normals of the
 * file's, else tubes. Half-widths: the vertex's, where it is positive, else `radius`, else by
 * STP_LINE_RADIUS_PART. Where edges alone have colours, vertices get the means of their edges', and
 * the mesh has colours. *taken: by point, whether a line goes through it and it is no face's; free
 * with free().
 * Errors: OUT_OF_MEMORY. */
stp_status stp_line_chain(stp_line_set *out, uint8_t **taken, stp_point_mesh *mesh, double radius,
                          stp_edge_counts *counts, stp_error *err);

#endif

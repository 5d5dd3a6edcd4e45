/* The neighbour graph of one cell: its pieces of smooth surface, and what only all cells together
 * decide.
 *
 * Edges lead from each point to its nearest neighbours. The sure ones, along smooth surface and
 * within the layers of both ends, join the cell's points into pieces, surest first. Others are kept
 * open, and so are the neighbours of points that will be asked again. Threads: cells side by side.
 */
#ifndef STP_PREPROCESS_ORIENT_GRAPH_H
#define STP_PREPROCESS_ORIENT_GRAPH_H

#include "preprocess/cloud/unit.h"
#include "preprocess/orient/relation.h"

/* Most points of a crumb, a piece too small to be a sheet. */
#define STP_CRUMB_POINTS 64u

/* From a point of the cell to another, then from piece to piece; the relation is that of signs as
 * marked. Small: noise has several of them a point. */
typedef struct stp_edge {
    uint32_t other; /* place in the cloud, then number of a piece among those of all cells */
    uint16_t own;   /* place, then number of a piece, in the cell */
    uint16_t rank : 9, turned : 1, narrow : 1;
} stp_edge;

_Static_assert(STP_CELL_POINTS <= 1u << 16 && STP_RANK_NONE < 1u << 9, "an edge holds them");

/* Of a cell. Arrays lie in the cloud's spill. */
typedef struct stp_graph {
    uint32_t piece_count, *sizes; /* of its pieces, points */
    stp_edge *edges;              /* open: to other cells, and unsure ones */
    size_t edge_count, edge_capacity;
    /* Points whose neighbours are kept: those on crumbs of the cell's, and those seen at a grazing
     * angle by their stations. Places in the cloud, ascending, and their lists, one after the other
     * (place_list.h). */
    uint32_t *kept, kept_count;
    uint8_t *lists;
} stp_graph;

/* Joins a cell's points: sets, in the whole cloud, their sheets to the numbers of their pieces in
 * the cell and their marks to the signs against the first point of the piece. The unit has the cell
 * and four rings. stations: NULL for none. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_graph_create(stp_graph *out, const stp_unit *unit, const stp_cell *cell,
                            const stp_dvec3 *stations, stp_error *err);
/* Makes the edges, whose ends are points, ones between pieces: of all that join the same two, the
 * surest alone, and the surest that is not narrow; surest first, of equals in the order in which
 * the cell's points have them. The cloud's sheets number the pieces of all cells, from piece_begin
 * those of this one. Errors: OUT_OF_MEMORY. */
stp_status stp_graph_resolve(stp_graph *graph, const stp_cloud *cloud, const stp_cell *cell,
                             uint32_t piece_begin, stp_error *err);
void stp_graph_clear(stp_graph *graph, stp_spill *spill);

#endif

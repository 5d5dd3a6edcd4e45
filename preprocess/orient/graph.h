/* The neighbour graph of one cell: its pieces of smooth surface, and what only all cells together
 * can decide.
 *
 * Edges lead from each point to its nearest neighbours. Sure edges run along smooth surface within
 * the layers of both ends. They join the cell's points into pieces, surest first. Other edges stay
 * open. The neighbours of points that will be asked again are kept, too. Threads: cells side by
 * side. */
#ifndef STP_PREPROCESS_ORIENT_GRAPH_H
#define STP_PREPROCESS_ORIENT_GRAPH_H

#include "preprocess/cloud/unit.h"
#include "preprocess/orient/relation.h"

/* Most points of a crumb, a piece too small to be a sheet. */
#define STP_CRUMB_POINTS 64u

/* An edge from a point of the cell to another point; after stp_graph_resolve, from piece to piece
 * with the signs that the marks say. Kept small: noise gives several edges per point. */
typedef struct stp_edge {
    /* place in the cloud; then number of a piece among those of all cells */
    uint64_t other : STP_PLACE_BITS;
    uint64_t own : 16; /* place in the cell; then number of a piece in the cell */
    uint64_t rank : 8, turned : 1, narrow : 1;
} stp_edge;

_Static_assert(STP_CELL_POINTS <= 1u << 16 && STP_RANK_NONE <= 1u << 8 && sizeof(stp_edge) == 8,
               "an edge holds them");

/* The graph of a cell. Its arrays lie in the cloud's spill. */
typedef struct stp_graph {
    uint32_t piece_count, *sizes; /* sizes: points of each piece */
    stp_edge *edges;              /* the open ones: to other cells, and unsure ones */
    size_t edge_count, edge_capacity;
    /* Points whose neighbours are kept: points on crumbs of the cell, and points that their
     * stations see at a grazing angle. kept: places in the cell, ascending. lists: their lists, one
     * after the other (place_list.h). */
    uint16_t *kept;
    uint32_t kept_count;
    uint8_t *lists;
    size_t list_bytes;
} stp_graph;

/* Joins a cell's points. Sets in the whole cloud the points' sheets to the number of their piece in
 * the cell, and their marks to the sign relative to the piece's first point. The unit has the cell
 * and four rings. stations: NULL for none. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_graph_create(stp_graph *out, const stp_unit *unit, const stp_cell *cell,
                            const stp_dvec3 *stations, stp_error *err);
/* Turns edges between points into edges between pieces. If several edges join the same two pieces,
 * keeps the surest one and the surest that is not narrow. Sorts them surest first, and equals in
 * the order of the cell's points. The cloud's sheets number the pieces of all cells; this cell's
 * begin at piece_begin. Errors: OUT_OF_MEMORY. */
stp_status stp_graph_resolve(stp_graph *graph, const stp_cloud *cloud, const stp_cell *cell,
                             uint32_t piece_begin, stp_error *err);
/* Moves the arrays, which are plain memory, into the spill. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_graph_stow(stp_graph *graph, stp_spill *spill, stp_error *err);
void stp_graph_clear(stp_graph *graph, stp_spill *spill);

#endif

/* Sheets: pieces of smooth surface, and the signs by which their points' normals agree.
 *
 * Edges lead from each point to its nearest neighbours. The sure ones, along smooth surface and
 * within the layers of both ends, join sheets; the others lead across creases. Surest first, inside
 * each cell, cells on the pool, and then between cells: the same for any number of threads. */
#ifndef STP_PREPROCESS_SHEETS_H
#define STP_PREPROCESS_SHEETS_H

#include "preprocess/crumbs.h"
#include "preprocess/layer.h"
#include "preprocess/relation.h"

typedef struct stp_open_edges stp_open_edges;

typedef struct stp_sheets {
    stp_cloud *cloud;
    const stp_neighbours *neighbours;
    stp_forest forest;    /* pieces joined so far; signs against the normals as they are */
    stp_open_edges *open; /* by cell */
    stp_crumbs crumbs;
    uint32_t *parts;     /* by point: one sheet and its crumbs; NULL before stp_sheets_cross */
    unsigned edge_count; /* of each point */
} stp_sheets;

/* Joins the points by sure edges and sets every point's sheet: the root of its piece, or of the one
 * it lies nearest to where its own is a crumb. Cloud and neighbours are kept. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_sheets_create(stp_sheets *out, stp_cloud *cloud, const stp_neighbours *neighbours,
                             stp_pool *pool, stp_error *err);
/* Joins the pieces across creases, too; the points' sheets stay. Errors: OUT_OF_MEMORY. */
stp_status stp_sheets_cross(stp_sheets *sheets, stp_error *err);
void stp_sheets_clear(stp_sheets *sheets);

#endif

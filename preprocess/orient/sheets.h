/* Sheets: pieces of smooth surface, and the signs by which their points' normals agree.
 *
 * Each cell's own pieces are known (graph.h); here those of all cells are joined, surest edges
 * first: within sheets, and then across creases. The same for any number of threads. */
#ifndef STP_PREPROCESS_ORIENT_SHEETS_H
#define STP_PREPROCESS_ORIENT_SHEETS_H

#include "preprocess/orient/forest.h"
#include "preprocess/orient/graph.h"

typedef struct stp_sheets {
    stp_cloud *cloud; /* its sheets number the pieces of all cells */
    unsigned k;
    stp_graph *graphs;     /* by cell */
    uint32_t *piece_begin; /* by cell: the number of its first piece */
    uint32_t *kept_begin;  /* by cell: how many points are kept in those before; all at the end */
    uint32_t piece_count;
    stp_forest forest; /* over pieces, as joined so far; signs against the marks */
    uint32_t *roots;   /* by piece: its sheet, a piece */
    uint8_t *crumbs;   /* by piece: 1 where that is too small to be a sheet */
    uint32_t *parts;   /* by piece: one sheet and its crumbs; NULL before stp_sheets_cross */
} stp_sheets;

/* Takes the graphs of the cloud's cells, as stp_surface_find leaves them with it; *graphs becomes
 * NULL. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_sheets_create(stp_sheets *out, stp_cloud *cloud, unsigned k, stp_graph **graphs,
                             stp_pool *pool, stp_error *err);
/* Joins the pieces across creases, too; sheets stay. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_sheets_cross(stp_sheets *sheets, stp_error *err);
/* Sets the cloud's sheets for good: of a point its piece's; on a crumb that of the sheet nearby
 * whose planes it lies nearest to; without a normal none. Comes last: pieces are forgotten. Errors:
 * OUT_OF_MEMORY, IO. */
stp_status stp_sheets_settle(stp_sheets *sheets, stp_pool *pool, stp_error *err);
void stp_sheets_clear(stp_sheets *sheets);

/* The sheet of a point's piece, and whether that is a crumb. */
static inline uint32_t stp_sheets_root(const stp_sheets *sheets, uint32_t point)
{
    return sheets->roots[sheets->cloud->sheets[point]];
}

static inline bool stp_sheets_on_crumb(const stp_sheets *sheets, uint32_t point)
{
    return sheets->crumbs[sheets->cloud->sheets[point]];
}

#endif

/* Sheets: pieces of smooth surface, and the signs that make their points' normals agree.
 *
 * graph.h finds each cell's pieces. Here the pieces of all cells are joined, surest edges first:
 * within sheets, then across creases. The result is the same for any number of threads. */
#ifndef STP_PREPROCESS_ORIENT_SHEETS_H
#define STP_PREPROCESS_ORIENT_SHEETS_H

#include "preprocess/orient/forest.h"
#include "preprocess/orient/graph.h"

typedef struct stp_sheets {
    stp_cloud *cloud; /* its sheets number the pieces of all cells */
    unsigned k;
    stp_graph *graphs;     /* by cell */
    uint32_t *piece_begin; /* by cell: the number of its first piece */
    uint64_t *kept_begin;  /* by cell: number of kept points in the cells before; then the total */
    uint32_t piece_count;  /* below STP_SHEET_NONE */
    stp_forest forest;     /* over pieces, as joined so far; signs relative to the marks */
    uint32_t *roots;       /* by piece: its sheet, named by its root piece */
    uint8_t *crumbs;       /* by piece: 1 if its sheet is too small, that is, a crumb */
    uint32_t *parts; /* by piece: its sheet with the sheet's crumbs; NULL before stp_sheets_cross */
} stp_sheets;

/* Takes the graphs of the cloud's cells, as stp_surface_find leaves them; *graphs becomes NULL.
 * Errors: OUT_OF_MEMORY, IO, LIMIT (pieces). */
stp_status stp_sheets_create(stp_sheets *out, stp_cloud *cloud, unsigned k, stp_graph **graphs,
                             stp_pool *pool, stp_error *err);
/* Joins the pieces across creases, too. Sheets stay as they are. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_sheets_cross(stp_sheets *sheets, stp_error *err);
/* Sets the cloud's final sheets. A point gets the sheet of its piece. A point on a crumb gets the
 * sheet nearby whose planes are nearest to it. A point without a normal gets none. Call this last:
 * it forgets the pieces. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_sheets_adopt(stp_sheets *sheets, stp_pool *pool, stp_error *err);
void stp_sheets_clear(stp_sheets *sheets);

/* The sheet of a point's piece, and whether that sheet is a crumb. */
static inline uint32_t stp_sheets_root(const stp_sheets *sheets, uint64_t point)
{
    return sheets->roots[sheets->cloud->sheets[point]];
}

static inline bool stp_sheets_on_crumb(const stp_sheets *sheets, uint64_t point)
{
    return sheets->crumbs[sheets->cloud->sheets[point]];
}

#endif

/* Discs of a level raster by column and row: those beside a point are found without hashed cells.
 *
 * Rows of discs lie in memory as columns of floats (disc_lanes.h), so eight discs of a row are
 * tried at a time. Threads: any may search at once in rows that are made. */
#ifndef STP_FORMATS_CHUNK_MEASURE_DISC_ROWS_H
#define STP_FORMATS_CHUNK_MEASURE_DISC_ROWS_H

#include "formats/chunk/measure/disc_grid.h"
#include "formats/chunk/measure/patch_bounds.h"

/* Lengths are in grid units. */
typedef struct stp_disc_rows {
    const stp_lane_disc *discs; /* borrowed */
    int columns, rows;          /* places, with a margin; no columns: the discs are not in rows */
    float first[2], inverse[2]; /* of x and y: a place is (x - first) inverse */
    float *numbers;             /* by row STP_LANE_CARRIED times the columns; no disc: far away */
    uint32_t *disc;             /* by place */
    uint8_t *away;   /* by place: columns or rows from the nearest disc; NULL: there are no holes */
    uint8_t *hollow; /* by square of places: the greatest of these */
} stp_disc_rows;

/* Puts the discs of the grid into rows if its chunk has one level raster, each disc near it has a
 * place of its own and none carries errors. Else the rows have no columns. Errors: OUT_OF_MEMORY.
 */
stp_status stp_disc_rows_create(stp_disc_rows *out, const stp_disc_grid *grid, stp_error *err);
void stp_disc_rows_clear(stp_disc_rows *rows);

/* Costs less than this are over a disc. */
#define STP_DISC_ROWS_NONE 1e15f

/* Returns the least cost of a point over the discs in rows and columns about it, or the first one
 * that is at most `stop`, and sets *disc. If all these places are a hole, returns
 * STP_DISC_ROWS_NONE or more. */
float stp_disc_rows_least(const stp_disc_rows *rows, const float x[3], const stp_over *over,
                          float stop, uint32_t *disc);

/* Pairs each point of the lanes with the disc of the place that it is nearest to. */
void stp_disc_rows_pair(const stp_disc_rows *rows, stp_paired_lanes *lanes);

/* Finds the place under a disc, at most 32 columns and rows from its centre, that is farthest from
 * all discs of the rows, if a hole of three columns and rows or more is there. Sets *out, the
 * disc's point over or under it. */
bool stp_disc_rows_hole(const stp_disc_rows *rows, const stp_disc *disc, stp_dvec3 *out);

#endif

/* Discs of a level raster by column and row: the nearest disc is found among those beside a point,
 * without hashed cells.
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
    float side;                 /* lesser side of a cell, less what discs are off their places */
    float *numbers;             /* by row STP_LANE_CARRIED times the columns; no disc: far away */
    uint32_t *disc;             /* by place */
    float *widest;              /* by square of places: greatest radius in it and beside it */
    uint8_t *away; /* by place: columns or rows from the nearest disc; NULL: there are no holes */
} stp_disc_rows;

/* Puts the discs of the grid into rows if its chunk has one level raster, each disc near it has a
 * place of its own and none carries errors. Else the rows have no columns. Errors: OUT_OF_MEMORY.
 */
stp_status stp_disc_rows_create(stp_disc_rows *out, const stp_disc_grid *grid, stp_error *err);
void stp_disc_rows_clear(stp_disc_rows *rows);

/* What disc answers a point, though another may be nearer: one within this squared distance, or one
 * that `over` does not take for too far away and over which the point costs at most `cost`. */
typedef struct stp_near_enough {
    float squared, cost;
    stp_over over;
} stp_near_enough;

/* Looks for the disc nearest to a point, or one near enough. Sets *squared, its distance, and
 * *disc. Returns false if a disc farther off than the rows that it tries may be nearer. */
bool stp_disc_rows_nearest(const stp_disc_rows *rows, stp_dvec3 x, const stp_near_enough *enough,
                           double *squared, uint32_t *disc);

/* Finds the place under a disc that is farthest from all discs of the rows, if a hole of three
 * columns and rows or more is there. Sets *out, the disc's point over or under it. */
bool stp_disc_rows_hole(const stp_disc_rows *rows, const stp_disc *disc, stp_dvec3 *out);

#endif

/* Discs of a level raster by column and row: those beside a point are found without hashed cells.
 * Eight discs of a row are tried at a time.
 *
 * On a slope the places nearest to a point need not be those of the nearest column and row. Seen
 * along the slope's normal, places are nodes of a lattice, which two short steps span. On level
 * ground these are a column and a row. On a slope of 3 along columns and rows, a step of one column
 * there and one row back is 1.4 cells long, a column 3.2, a column and a row 6.2. A point's place
 * is rounded along the short steps: the disc there lies beside it on any slope, those one step away
 * lie around it.
 *
 * Threads: any may search at once in rows that are made. */
#ifndef STP_FORMATS_CHUNK_MEASURE_DISC_ROWS_H
#define STP_FORMATS_CHUNK_MEASURE_DISC_ROWS_H

#include "formats/chunk/measure/disc_grid.h"
#include "formats/chunk/measure/patch_bounds.h"

/* Lengths are in grid units. */
typedef struct stp_disc_rows {
    const stp_lane_disc *discs; /* borrowed */
    int columns, rows;          /* places, with a margin; no columns: the discs are not in rows */
    float first[2], inverse[2]; /* of x and y: a place is (x - first) inverse */
    float side[2];              /* of a cell, with the sign of `inverse` */
    uint32_t none;              /* the disc of places without one: far away */
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

/* Two short steps between places that span all of them. */
typedef struct stp_disc_steps {
    float by[2][2];                /* columns and rows of each */
    float inverse[2][2];           /* how many of each a column and a row are */
    int32_t around[STP_LANE_STEP]; /* ways to the places one step of any kind away */
} stp_disc_steps;

/* Finds short steps on a slope that has this normal. */
void stp_disc_rows_steps(const stp_disc_rows *rows, const float normal[3], stp_disc_steps *out);

/* Sets value[] to the cost of each point of a merged disc over a disc near it, or over the best one
 * of some discs about it. steps: of the slope that the points lie on. Returns a bit for each of the
 * points, STP_DISC_POINTS, whose cost exceeds `limit`. */
uint32_t stp_disc_rows_above(const stp_disc_rows *rows, const stp_disc_steps *steps,
                             const stp_over *over, float limit, stp_paired_lanes *lanes,
                             float value[STP_DISC_LANES]);

/* Finds the place under a disc, at most 32 columns and rows from its centre, that is farthest from
 * all discs of the rows, if a hole of three columns and rows or more is there. Sets *out, the
 * disc's point over or under it. */
bool stp_disc_rows_hole(const stp_disc_rows *rows, const stp_disc *disc, stp_dvec3 *out);

#endif

/* The nearest of all level-0 discs of a chunk and its surroundings to a point.
 *
 * Each disc is entered in every cell of a hashed grid that its box touches, as columns of floats,
 * so that a cell is tried four discs at a time. Threads: any may search at once in a grid that is
 * made. */
#ifndef STP_FORMATS_CHUNK_DISC_GRID_H
#define STP_FORMATS_CHUNK_DISC_GRID_H

#include "formats/chunk/disc_lanes.h"
#include "formats/chunk/surroundings.h"

/* Discs too large for the cells are tried by every search; with more than these few there is none.
 */
#define STP_DISC_LARGE_MAX 32

/* The entries of bucket b are begin[b] to begin[b + 1]. */
typedef struct stp_disc_grid {
    stp_flat_disc *discs; /* by level-0 sample of the chunk; then those around it */
    uint32_t own_count, count;
    double width; /* of a cell */
    uint32_t *begin, mask;
    stp_disc_columns columns; /* by entry */
    uint32_t *disc_of_entry;
    uint32_t large[STP_DISC_LARGE_MAX], large_count;
} stp_disc_grid;

/* Where a point lies over a disc. */
typedef struct stp_disc_position {
    uint32_t disc;
    double squared;  /* distance */
    double height;   /* over its plane, unsigned */
    double overhang; /* in its plane, outside */
} stp_disc_position;

/* around: NULL for nothing. Errors: OUT_OF_MEMORY. */
stp_status stp_disc_grid_create(stp_disc_grid *out, const stp_chunk *chunk,
                                const stp_surroundings *around, stp_error *err);
void stp_disc_grid_clear(stp_disc_grid *grid);

stp_disc_position stp_disc_grid_position(const stp_disc_grid *grid, uint32_t disc, stp_dvec3 x);

/* Finds what is nearer to x than *best, which some disc is; stops where its square is no more than
 * `enough`. False if a thousand discs do not tell, and then best is any. hint: a disc that may be
 * near, which spares time and changes nothing: of equally near discs always the same is found. The
 * choice is as exact as floats of the chunk's coordinates, best's numbers as doubles. */
bool stp_disc_grid_nearest(const stp_disc_grid *grid, stp_dvec3 x, double enough, uint32_t hint,
                           stp_disc_position *best);

#endif

/* All level-0 discs of a chunk and its surroundings, and what points of merged discs count over
 * them (overhang.h).
 *
 * Each disc is entered in the cell of a hashed grid where its centre lies, as columns of floats, so
 * that a cell is tried several discs at a time. Threads: any may search at once in a grid that is
 * made. */
#ifndef STP_FORMATS_CHUNK_MEASURE_DISC_GRID_H
#define STP_FORMATS_CHUNK_MEASURE_DISC_GRID_H

#include "formats/chunk/measure/disc_lanes.h"
#include "formats/chunk/measure/surroundings.h"

/* Discs too large for the cells are tried by every search; with more than these few there is none.
 */
#define STP_DISC_LARGE_MAX 32

/* Lengths are in units of the grid, in which no coordinate exceeds 1. The entries of bucket b are
 * begin[b] to begin[b + 1]. */
typedef struct stp_disc_grid {
    const stp_chunk *chunk;      /* borrowed: its level-0 samples are the first discs, */
    const stp_flat_disc *around; /* these the others */
    uint32_t own_count, count;
    const stp_carry *carry, *carry_around; /* likewise borrowed; NULL for none */
    double scale;                          /* units a world unit, a power of two */
    double radius;                         /* geometric mean of the chunk's own, at least 2^-18 */
    float width, margin; /* of a cell; discs may reach so far out of their cells */
    uint32_t *begin, mask;
    stp_lane_disc *numbers;   /* of all discs */
    stp_disc_columns columns; /* by entry */
    uint32_t entries;
    uint32_t large[STP_DISC_LARGE_MAX], large_count;
} stp_disc_grid;

/* Points farther out than this are not searched, units. */
#define STP_DISC_GRID_REACH 16.0

/* A merged disc whose points are measured. */
typedef struct stp_merged_disc {
    stp_over_what what;  /* is asked of them */
    stp_dvec3 normal;    /* zero where unknown */
    double error;        /* perpendicular, units: it covers heights up to it */
    double near_squared; /* discs farther away are not asked for what a point counts over them */
    uint32_t begin, end; /* level-0 discs of its own patch */
} stp_merged_disc;

/* around: NULL for nothing. carry: by level-0 sample, or NULL. All are borrowed. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_disc_grid_create(stp_disc_grid *out, const stp_chunk *chunk, const stp_carry *carry,
                                const stp_surroundings *around, stp_error *err);
void stp_disc_grid_clear(stp_disc_grid *grid);

/* The nearest of the discs [first, last), at least one, and the square of its distance, as floats
 * tell. */
uint32_t stp_disc_grid_nearest(const stp_disc_grid *grid, uint32_t first, uint32_t last,
                               stp_dvec3 x, double *squared);

/* What a point of the merged disc counts over a disc, units. */
double stp_disc_grid_value(const stp_disc_grid *grid, uint32_t disc, stp_dvec3 x,
                           const stp_merged_disc *merged);

/* Looks for the disc over which x counts least, or to which it is nearest, if less than *least,
 * which that or its squared distance then becomes, as floats tell, and *disc that disc. Stops at
 * one of at most `stop`. whole: all discs are tried rather than that it
 * gives up. False if it gave up: there may be one of less. */
bool stp_disc_grid_least(const stp_disc_grid *grid, stp_dvec3 x, const stp_merged_disc *merged,
                         double stop, bool whole, double *least, uint32_t *disc);

#endif

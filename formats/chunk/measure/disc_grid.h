/* All level-0 discs of a chunk and its surroundings, searched for the disc of least cost under a
 * point, or for the nearest disc. overhang.h defines cost(p, d).
 *
 * Each disc is entered in the cell of a hashed grid that holds its centre. Entries are columns of
 * floats, so a search tries several discs of a cell at a time. Threads: any may search at once in a
 * grid that is made. */
#ifndef STP_FORMATS_CHUNK_MEASURE_DISC_GRID_H
#define STP_FORMATS_CHUNK_MEASURE_DISC_GRID_H

#include "formats/chunk/measure/disc_lanes.h"
#include "formats/chunk/measure/surroundings.h"

/* Every search tries the discs that are too large for the cells. If there are more than this, no
 * search runs at all. */
#define STP_DISC_LARGE_MAX 32

/* Lengths are in grid units, in which no coordinate exceeds 1. The entries of bucket b are
 * [begin[b], begin[b + 1]). */
typedef struct stp_disc_grid {
    const stp_chunk *chunk;      /* borrowed: its level-0 samples are discs [0, own_count) */
    const stp_flat_disc *around; /* borrowed: discs [own_count, count) */
    uint32_t own_count, count;
    const stp_carry *carry, *carry_around; /* borrowed; NULL if the discs carry no errors */
    double scale;                          /* grid units a world unit, a power of two */
    double radius;       /* geometric mean of the chunk's own radii, at least 2^-18 */
    float width, margin; /* of a cell; how far discs may reach out of their cells */
    uint32_t *begin, mask;
    stp_lane_disc *numbers;   /* by disc; then one that is far from everything */
    float low[3], high[3];    /* least and greatest coordinates of the chunk's own discs' centres */
    uint16_t *patch_of;       /* by own disc: the patch that holds it */
    stp_disc_columns columns; /* by entry */
    uint32_t entries;
    uint32_t large[STP_DISC_LARGE_MAX], large_count;
} stp_disc_grid;

/* Points farther out than this are not searched, grid units. */
#define STP_DISC_GRID_REACH 16.0

/* A merged disc whose points are measured. */
typedef struct stp_merged_disc {
    stp_over_what what;  /* what is searched for */
    stp_dvec3 normal;    /* zero where unknown */
    double error;        /* perpendicular error e, grid units */
    double forgiven;     /* of a need */
    uint32_t begin, end; /* the level-0 discs under it: [begin, end) */
} stp_merged_disc;

/* Takes the discs. around: NULL for nothing. carry: by level-0 sample, or NULL. All are borrowed.
 * Clear *out also after a failure. Errors: OUT_OF_MEMORY. */
stp_status stp_disc_grid_create(stp_disc_grid *out, const stp_chunk *chunk, const stp_carry *carry,
                                const stp_surroundings *around, stp_error *err);
/* Enters them in cells, for stp_disc_grid_least. Errors: OUT_OF_MEMORY. */
stp_status stp_disc_grid_fill(stp_disc_grid *grid, stp_error *err);
void stp_disc_grid_clear(stp_disc_grid *grid);

/* The nearest of the discs [first, last), at least one. *squared: the square of its distance, as
 * exact as floats. */
uint32_t stp_disc_grid_nearest(const stp_disc_grid *grid, uint32_t first, uint32_t last,
                               stp_dvec3 x, double *squared);

/* cost(x, disc) for a point x of the merged disc, grid units. */
double stp_disc_grid_value(const stp_disc_grid *grid, uint32_t disc, stp_dvec3 x,
                           const stp_merged_disc *merged);

/* Looks for the disc of least value to x (merged->what), and of needs for the nearest one. *best
 * holds what is known before, or STP_LANE_FAR. Stops at the first value of at most `stop`. whole:
 * tries all discs instead of giving up. Returns false if it gave up: then a better disc may exist.
 */
bool stp_disc_grid_least(const stp_disc_grid *grid, stp_dvec3 x, const stp_merged_disc *merged,
                         double stop, bool whole, stp_disc_best *best);

#endif

/* Sorts points in place along the Morton curve of their bounding cube.
 *
 * Codes have 21 bits per axis, x lowest. Points with the same code are ordered by coordinates, then
 * by source. If more points than a cell holds share a code (a pile: for example, a whole model
 * beside one outlier), they follow the Morton curve of their own bounding cube, and so on. Points
 * at one position are ordered by source. Memory: a few tens of megabytes per thread, for any number
 * of points. Threads: those of the pool. The order does not depend on their number, nor on the
 * order of the input. */
#ifndef STP_PREPROCESS_CLOUD_MORTON_H
#define STP_PREPROCESS_CLOUD_MORTON_H

#include "preprocess/cloud/cloud.h"

#define STP_MORTON_BITS 21

/* A cube of 2^21 grid cells per axis. A box that has no extent, or is too wide for doubles, is one
 * grid cell. */
typedef struct stp_morton_grid {
    stp_dvec3 low;
    double scale; /* grid cells per unit; 0: one grid cell */
} stp_morton_grid;

stp_morton_grid stp_morton_grid_of(const stp_dbox *box);
uint64_t stp_morton_code(const stp_morton_grid *grid, stp_dvec3 position);

/* A thing's index and its code on the curve. */
typedef struct stp_morton_place {
    uint64_t code;
    uint32_t index;
} stp_morton_place;

/* Sorts things by code, in memory; equal codes by index. */
void stp_morton_order(stp_morton_place *places, uint32_t count);

/* Sets *box to the points' box. spill: where they lie; NULL: in plain memory. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_morton_box(stp_dbox *box, const stp_cloud_point *points, uint64_t count,
                          stp_spill *spill, stp_pool *pool, stp_error *err);
/* Sorts the points along the curve of the cube of a box around them. Errors: likewise. */
stp_status stp_morton_sort(stp_cloud_point *points, uint64_t count, stp_spill *spill,
                           const stp_dbox *box, stp_pool *pool, stp_error *err);

#endif

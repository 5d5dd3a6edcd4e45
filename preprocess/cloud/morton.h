/* Points along the Morton curve of their bounding cube, sorted where they lie.
 *
 * 21 bits an axis, x lowest. Points of one code lie in the order of their coordinates, then of
 * their sources; but more of one code than a cell holds (a pile, such as all of a model but one
 * outlier) follow the Morton curve of their own bounding cube, and so on. Points at one place
 * follow their sources. Memory: a few tens of megabytes a thread, whatever the number of points.
 * Threads: those of the pool; the order does not depend on their number, nor on that of the input.
 */
#ifndef STP_PREPROCESS_CLOUD_MORTON_H
#define STP_PREPROCESS_CLOUD_MORTON_H

#include "preprocess/cloud/cloud.h"

#define STP_MORTON_BITS 21

/* A cube of 2^21 cells an axis. A box without extent, or too wide for doubles, is one cell. */
typedef struct stp_morton_grid {
    stp_dvec3 low;
    double scale; /* cells a unit; 0: one cell */
} stp_morton_grid;

stp_morton_grid stp_morton_grid_of(const stp_dbox *box);
uint64_t stp_morton_code(const stp_morton_grid *grid, stp_dvec3 position);

/* One of several things, and where it lies on the curve. */
typedef struct stp_morton_place {
    uint64_t code;
    uint32_t index;
} stp_morton_place;

/* Puts things in the curve's order, in memory; equal codes by index. */
void stp_morton_order(stp_morton_place *places, uint32_t count);

/* Sorts; *box: of all points. spill: where they lie, NULL in memory. Errors: OUT_OF_MEMORY. */
stp_status stp_morton_sort(stp_cloud_point *points, uint32_t count, stp_spill *spill, stp_dbox *box,
                           stp_pool *pool, stp_error *err);

#endif

/* The k nearest distinct positions of every point, cell by cell with a halo.
 *
 * FLANN's kd-tree gives candidates by float distances, once for a few points that follow each
 * other; the lists are made of them in double, ties by source index, and a point for which nearer
 * ones may lie beyond its candidates is searched alone: where more points might tie with the last
 * one, all as near are compared, and where the k-th distance passes the cell's halo, every cell its
 * ball meets. Duplicates share one list. Threads: cells run on the pool; the result does not depend
 * on their number. */
#ifndef STP_PREPROCESS_NEIGHBOURS_H
#define STP_PREPROCESS_NEIGHBOURS_H

#include "base/progress.h"
#include "preprocess/cloud.h"

/* Most neighbours of a point. */
#define STP_NEIGHBOURS_LIMIT 64
#define STP_NEIGHBOUR_NONE UINT32_MAX

typedef struct stp_neighbours {
    unsigned k;
    uint32_t
        *indices; /* count * k places in the cloud, nearest first, STP_NEIGHBOUR_NONE at the end */
    stp_spill *spill; /* where they lie: the cloud's */
} stp_neighbours;

/* Fills out and every point's spacing, s = d_k sqrt(pi / k) (ALGORITHMS "Radius"; 0 where a point
 * has no distinct neighbour). Errors: OUT_OF_MEMORY, INVALID_ARGUMENT (k), CANCELLED. */
stp_status stp_neighbours_find(stp_neighbours *out, stp_cloud *cloud, unsigned k, stp_pool *pool,
                               const stp_progress *progress, stp_error *err);
void stp_neighbours_clear(stp_neighbours *neighbours);

#endif

/* Exact nearest neighbours among points that lie in Morton order: boxes over runs of eight.
 *
 * Runs of neighbours in the order are the leaves of an implicit binary tree, so building it costs a
 * pass; the queries of one run share their walk through it. Distances are compared in double with
 * ties by source index: floats only tell which points need not be looked at. Threads: any number of
 * readers. */
#ifndef STP_PREPROCESS_NEAREST_H
#define STP_PREPROCESS_NEAREST_H

#include "preprocess/cloud.h"

/* Most neighbours of a point. */
#define STP_NEIGHBOURS_LIMIT 64
/* Points of a leaf. */
#define STP_NEAREST_RUN 8u

typedef struct stp_nearest stp_nearest;

/* Neighbours found, nearest first. */
typedef struct stp_nearest_list {
    unsigned capacity, count;
    double squared[STP_NEIGHBOURS_LIMIT];
    uint32_t index[STP_NEIGHBOURS_LIMIT]; /* places in the cloud */
} stp_nearest_list;

/* Puts a point at a squared distance above 0 into the list if it belongs there; equal distances
 * stand in the order of source. */
void stp_nearest_insert(stp_nearest_list *list, const stp_cloud *cloud, double squared,
                        uint32_t index);

/* indices: count places in the cloud, kept by the caller as long as the tree; best in Morton order.
 * Errors: OUT_OF_MEMORY. */
stp_status stp_nearest_create(stp_nearest **out, const stp_cloud *cloud, const uint32_t *indices,
                              size_t count, stp_error *err);
void stp_nearest_destroy(stp_nearest **tree);

/* The nearest points of each point of run `run`, that is, of indices 8 run to 8 run + 7, at other
 * positions than its own. Fills as many lists as the run has points; their capacity is given. */
void stp_nearest_run(const stp_nearest *tree, size_t run, stp_nearest_list lists[STP_NEAREST_RUN]);

#endif

/* Sorts points that lie in parts on several ranks. */
#ifndef STP_PREPROCESS_CLOUD_CLOUD_PARTS_H
#define STP_PREPROCESS_CLOUD_CLOUD_PARTS_H

#include "preprocess/cloud/cloud.h"
#include "preprocess/ranks/ranks.h"

/* stp_cloud_sort, of a part of the points on each rank: the order is that of one process. Each rank
 * sorts a run of the curve, and ranks then share the cloud (cloud_blocks.h). Errors:
 * OUT_OF_MEMORY, IO, CANCELLED. */
stp_status stp_cloud_sort_parts(stp_cloud *cloud, stp_ranks *ranks, stp_pool *pool, stp_error *err);
/* Sorts the points of a cloud that ranks share once more: each rank's own are a part again, less
 * those with a mark in `without`, STP_MARK_*. Errors: likewise. */
stp_status stp_cloud_sort_again(stp_cloud *cloud, unsigned without, stp_pool *pool, stp_error *err);

#endif

/* Sorts points that lie in parts on several ranks. */
#ifndef STP_PREPROCESS_CLOUD_CLOUD_PARTS_H
#define STP_PREPROCESS_CLOUD_CLOUD_PARTS_H

#include "preprocess/cloud/cloud.h"
#include "preprocess/ranks/ranks.h"

/* stp_cloud_sort, of a part of the points on each rank. The cloud has room for all: it holds them
 * afterwards, on every rank in the same order as those of one process. Each rank sorts a run of the
 * curve, and gives it to all others. Errors: OUT_OF_MEMORY, IO, CANCELLED, LIMIT (too many points).
 */
stp_status stp_cloud_sort_parts(stp_cloud *cloud, stp_ranks *ranks, stp_pool *pool, stp_error *err);

#endif

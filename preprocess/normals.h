/* Normals from neighbourhoods: principal component analysis, then averaging over the neighbours.
 *
 * Sign is arbitrary here; preprocess/orientation.h makes it agree. Threads: points run on the pool.
 */
#ifndef STP_PREPROCESS_NORMALS_H
#define STP_PREPROCESS_NORMALS_H

#include "preprocess/neighbours.h"

/* Sets every point's normal and STP_SAMPLE_HAS_NORMAL; points that have a normal already keep it.
 * Fewer than three distinct neighbours, or all on a line: unknown, normal zero. Source: smallest
 * eigenvector of the covariance of the neighbours and the point itself (Hoppe 1992). Errors:
 * OUT_OF_MEMORY, CANCELLED. */
stp_status stp_normals_estimate(stp_cloud *cloud, const stp_neighbours *neighbours, stp_pool *pool,
                                const stp_progress *progress, stp_error *err);

#endif

/* Decides which side of the surface is seen from outside.
 *
 * The cloud is viewed from 26 directions, both ends of 13 axes, from far away. In each pixel the
 * nearest point counts as seen, and a seen point faces the viewer. A closed surface of any shape is
 * seen from one side only. An open surface is seen from both, which decides nothing. Pixels are
 * wider than the sampling, so almost no pixel sees through the surface. Threads: one call at a
 * time. */
#ifndef STP_PREPROCESS_ORIENT_VISIBILITY_H
#define STP_PREPROCESS_ORIENT_VISIBILITY_H

#include "preprocess/cloud/cloud.h"

#include <stdatomic.h>

/* The step between points that are drawn, from the first point on; more than 1 in large clouds. The
 * cloud has points. */
uint64_t stp_visibility_stride(const stp_cloud *cloud);
/* Counts votes for the i-th drawn point: for each direction that sees it, +1 if its normal faces
 * the viewer, -1 if it turns away. Grazing views do not count. votes: zero before. The result is
 * the same for any number of threads. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_visibility_vote(_Atomic int *votes, const stp_cloud *cloud, stp_pool *pool,
                               stp_error *err);

#endif

/* Which side of the surface is seen from outside.
 *
 * The cloud is looked at from 26 directions, both ends of 13 axes, far away; in each pixel the
 * nearest point is taken to be seen, and a seen point faces the viewer. A closed surface is seen
 * from one side only, whatever its shape; an open one from both, which says that nothing is known.
 * Pixels are wider than the sampling, so that nearly none looks through the surface. Threads: one
 * call at a time. */
#ifndef STP_PREPROCESS_ORIENT_VISIBILITY_H
#define STP_PREPROCESS_ORIENT_VISIBILITY_H

#include "preprocess/cloud/cloud.h"

#include <stdatomic.h>

/* Of large clouds every so-manieth point is looked at, the first included. The cloud has points. */
uint32_t stp_visibility_stride(const stp_cloud *cloud);
/* Adds to votes[i], for each direction from which the i-th point that is looked at is seen, 1 if
 * its normal faces the viewer and -1 if it turns away; grazing views do not count. votes: zero at
 * first. The same for any number of threads. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_visibility_vote(_Atomic int *votes, const stp_cloud *cloud, stp_pool *pool,
                               stp_error *err);

#endif

/* Normals from neighbourhoods: principal component analysis, then averaging over the neighbours.
 *
 * Sign is arbitrary here; preprocess/orientation.h makes it agree. Threads: a unit each. */
#ifndef STP_PREPROCESS_NORMALS_H
#define STP_PREPROCESS_NORMALS_H

#include "preprocess/unit.h"

/* Sets the normals of all points that have three rings around them; given ones stay. Fewer than
 * three distinct neighbours, or all on a line: unknown, normal zero. Source: smallest eigenvector
 * of the covariance of the neighbours and the point itself (Hoppe 1992). Errors: OUT_OF_MEMORY. */
stp_status stp_normals_estimate(stp_unit *unit, stp_error *err);

#endif

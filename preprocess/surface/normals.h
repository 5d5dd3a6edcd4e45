/* Normals from neighbourhoods: principal component analysis, as wide as noise asks for,
 * then averaging over the neighbours.
 *
 * Sign is arbitrary here; preprocess/orient/orientation.h makes it agree. Threads: a unit each. */
#ifndef STP_PREPROCESS_SURFACE_NORMALS_H
#define STP_PREPROCESS_SURFACE_NORMALS_H

#include "preprocess/cloud/unit.h"

/* Sets the normals of all points that have four rings around them. The plane through the nearest
 * (smallest eigenvector of the covariance of the neighbours and the point itself, Hoppe 1992) grows
 * by those of its neighbours where noise asks for it and no crease forbids it. Given normals
 * stay. Says in the unit which own points' planes grew. Fewer than three distinct neighbours,
 * or all on a line: unknown, normal zero. shifts, NULL or ring_end[0] of them: along the normal,
 * the way of each own point to its plane where that has grown and is near beside the noise, else
 * zero. Errors: OUT_OF_MEMORY. */
stp_status stp_normals_estimate(stp_unit *unit, vec3s *shifts, stp_error *err);

#endif

/* Normals from neighbourhoods: principal component analysis, over as many points as the noise asks
 * for, then averaging over the neighbours.
 *
 * Signs are arbitrary here; preprocess/orient/orientation.h makes them agree. Threads: a unit each.
 */
#ifndef STP_PREPROCESS_SURFACE_NORMALS_H
#define STP_PREPROCESS_SURFACE_NORMALS_H

#include "preprocess/cloud/unit.h"
#include "preprocess/surface/normal_error.h"

/* Smooths the spacings of all points with two rings around them (spacing.h), and sets the normals
 * of all points with four.
 * 1. Fits a plane to the point and its neighbours (smallest eigenvector of the covariance, Hoppe
 *    1992).
 * 2. If noise asks for it and no crease forbids it, the plane grows by the planes of its
 *    neighbours. The unit then says so in `wide`.
 * 3. Averages the normal with those of the neighbours.
 *
 * Given normals stay. With fewer than three distinct neighbours, or all on a line, the normal is
 * unknown: zero. shifts: NULL, or ring_end[0] entries: an own point's way to its plane, along the
 * normal, if the plane has grown and is near beside the noise; else zero. errors: gets those of the
 * normals of own points that were not given. Sets the unit's `wide` and `roundness`. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_normals_estimate(stp_unit *unit, vec3s *shifts, stp_normal_errors *errors,
                                stp_error *err);

#endif

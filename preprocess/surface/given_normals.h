/* Normals that the input brings, where they are noisy.
 *
 * A scanner's normals come from its own depth grid, with that grid's noise; where scans overlap,
 * each brings its own error, and the picture shows specks. True normals differ the less the nearer
 * the points are; noisy ones differ as much between the nearest points as between farther ones (the
 * nugget of a variogram). That is measured for the cloud as a whole, so that true normals of a
 * surface that is folded here and there stay as they are. Threads: any. */
#ifndef STP_PREPROCESS_SURFACE_GIVEN_NORMALS_H
#define STP_PREPROCESS_SURFACE_GIVEN_NORMALS_H

#include "preprocess/cloud/unit.h"

/* True if the given normals of a sorted cloud are noisy. The same for any cells and threads. */
bool stp_given_noisy(const stp_cloud *cloud);
/* Averages the given normals of a unit's own points with those of their neighbours; out,
 * ring_end[0] of them, takes all own normals. Needs one ring, and spacings. */
void stp_given_average(vec3s *out, const stp_unit *unit);

#endif

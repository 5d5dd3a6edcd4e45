/* Normals that came with the input, and their noise.
 *
 * A scanner's normals come from its own depth grid and have that grid's noise. Where scans overlap,
 * each brings its own error, and the picture shows specks. True normals differ less between nearer
 * points. Noisy normals differ as much between the nearest points as between farther ones (the
 * nugget of a variogram). This is measured for the cloud as a whole, so true normals of a surface
 * that is folded here and there stay as they are. Threads: any. */
#ifndef STP_PREPROCESS_SURFACE_GIVEN_NORMALS_H
#define STP_PREPROCESS_SURFACE_GIVEN_NORMALS_H

#include "preprocess/cloud/unit.h"

/* Whether the given normals of a sorted cloud are noisy. The same for any cells, threads and ranks.
 * Errors: those of stp_cloud_fetch. */
stp_status stp_given_noisy(stp_cloud *cloud, bool *out, stp_error *err);
/* Averages the given normals of a unit's own points with those of their neighbours. out:
 * ring_end[0] entries; gets all own normals. Needs one ring, and spacings. */
void stp_given_average(vec3s *out, const stp_unit *unit);

#endif

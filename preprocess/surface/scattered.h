/* Points that fill a volume, as wrong matches of photographs, leaves and birds do.
 *
 * A spacing is that of points on a surface. Points scattered in a volume have none: at their
 * spacing their discs would be plates in front of everything else. So if the spacing of a scattered
 * point is more than STP_SCATTERED_MEDIANS medians of the cloud's, it is that limit, or
 * STP_SCATTERED_PART of itself if that is more. Such points are then dots. In a cloud that is
 * scattered as a whole, none is far above the median. At most STP_SCATTERED_FEW points show no
 * surface: all are dots, of STP_SCATTERED_FEW_PART. */
#ifndef STP_PREPROCESS_SURFACE_SCATTERED_H
#define STP_PREPROCESS_SURFACE_SCATTERED_H

#include "preprocess/cloud/unit.h"

#define STP_SCATTERED_MEDIANS 2.0f
#define STP_SCATTERED_PART 0.125f
#define STP_SCATTERED_FEW 16u
#define STP_SCATTERED_FEW_PART 0.03125f

/* Sets STP_MARK_SCATTERED on those own points of a unit of `cloud` that are scattered. A
 * neighbourhood is round if it is spread about alike along all axes. A point is scattered if more
 * than a third of its neighbours and itself, counted together, have a round one; neighbours of much
 * smaller spacing are not asked: they are of a denser surface. If a third are, the point floats
 * before it, and is scattered, too, unless it is in a plane with them or with those that are asked.
 * Few points on edges are scattered: their neighbours lie on faces. Noise as large as the spacing
 * scatters a surface. Call stp_normals_estimate before. Threads: a unit each. */
void stp_scattered_mark(stp_cloud *cloud, const stp_unit *unit);

/* Limits the spacings of points with STP_MARK_SCATTERED. The same result for any number of ranks
 * and threads. Threads: one. Errors: IO, CANCELLED, if ranks share the cloud. */
stp_status stp_scattered_limit(stp_cloud *cloud, stp_error *err);

#endif

/* The smallest ball around points (Welzl 1991; pivoting as by Gaertner 1999).
 *
 * Threads: any (pure functions). */
#ifndef STP_PREPROCESS_MAPS_PARTS_BALL_H
#define STP_PREPROCESS_MAPS_PARTS_BALL_H

#include "base/vec.h"

/* Every point is within `radius` of the centre, for certain. No ball is smaller, but for rounding:
 * a relative error of some 1e-12. */
typedef struct stp_smallest_ball {
    stp_dvec3 centre;
    double radius;
} stp_smallest_ball;

/* points: finite, at least 1; equal points, and points on a line or a circle, are allowed. The
 * order of the points does not matter but for rounding. Time: some 5 to 10 passes over the
 * points. */
stp_smallest_ball stp_ball_around(const vec3s *points, size_t count);

#endif

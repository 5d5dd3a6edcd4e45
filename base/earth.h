/* What is up in coordinates about the earth's centre, and from where things are seen then. */
#ifndef STP_BASE_EARTH_H
#define STP_BASE_EARTH_H

#include "base/vec.h"

/* What is up, if the box lies near the surface of the earth in coordinates about its centre (WGS
 * 84, m); else zero. Within 20 km of the equator's plane, z may be the height of a map: zero. */
static inline stp_dvec3 stp_dbox_earth_up(const stp_dbox *box)
{
    const double a = 6378137.0, b = 6356752.3;
    const stp_dvec3 p = stp_dbox_middle(box);
    const stp_dvec3 scaled = {p.x / a, p.y / a, p.z / b}; /* of length 1 on the ellipsoid */
    const double height = (stp_dvec3_length(scaled) - 1.0) * b;
    const bool near = fabs(height) < 2e4 && fabs(p.z) > 2e4 && stp_dbox_side(box) < 1e5;
    return near ? stp_dvec3_normalize((stp_dvec3){scaled.x / a, scaled.y / a, scaled.z / b})
                : (stp_dvec3){0.0, 0.0, 0.0};
}

/* Whether what is up is an axis, as nearly all models have it. */
static inline bool stp_up_is_axis(stp_dvec3 up)
{
    return stp_dvec3_reach(up) >= 0.9999 * stp_dvec3_length(up);
}

/* The side of a thing that is its front: z, or if z is up -y, or if y is down -z; if what is up is
 * no axis, the south. up: a unit vector. */
static inline stp_dvec3 stp_front(stp_dvec3 up)
{
    if (!stp_up_is_axis(up))
        return stp_dvec3_cross(stp_dvec3_normalize((stp_dvec3){-up.y, up.x, 0.0}), up);
    return up.z > 0.5 ? (stp_dvec3){0.0, -1.0, 0.0}
                      : (stp_dvec3){0.0, 0.0, up.y < -0.5 ? -1.0 : 1.0};
}

/* stp_whole_direction; if what is up is no axis, from the south, a little from the east and above.
 */
static inline stp_dvec3 stp_whole_direction_over(stp_dvec3 up)
{
    if (stp_up_is_axis(up))
        return stp_whole_direction(up);
    const stp_dvec3 east = stp_dvec3_normalize((stp_dvec3){-up.y, up.x, 0.0});
    return stp_dvec3_add(stp_dvec3_add(stp_dvec3_scale(east, 0.3), stp_dvec3_scale(up, 0.7)),
                         stp_front(up));
}

#endif

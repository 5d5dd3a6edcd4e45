/* The nearest of many discs to a point, tried one by one.
 *
 * A disc with a zero normal is a ball. Lengths in any one unit. Threads: any (pure functions). */
#ifndef STP_FORMATS_CHUNK_NEAREST_DISC_H
#define STP_FORMATS_CHUNK_NEAREST_DISC_H

#include "base/vec.h"

#include <math.h>
#include <stdint.h>

/* The nearest so far. */
typedef struct stp_nearest_disc {
    uint32_t index;
    double squared, distance; /* distance: the root of squared */
    double height;            /* of the point over the disc's plane, unsigned */
    double overhang;          /* in the plane, outside the disc */
} stp_nearest_disc;

static inline stp_nearest_disc stp_nearest_disc_none(void)
{
    return (stp_nearest_disc){.squared = INFINITY, .distance = INFINITY};
}

/* Takes the disc if it is nearer to x. One that its plane or its rim alone keeps farther is passed
 * over, so that roots are drawn only for those that come nearer. */
static inline void stp_nearest_disc_try(stp_nearest_disc *best, stp_dvec3 x, stp_dvec3 centre,
                                        stp_dvec3 normal, double radius, uint32_t index)
{
    stp_dvec3 v = stp_dvec3_sub(x, centre);
    double height = stp_dvec3_dot(v, normal);
    double squared = height * height;
    double across = stp_dvec3_dot(v, v) - squared;
    double reach = radius + best->distance;
    if ((squared >= best->squared) | (across >= reach * reach))
        return;
    double overhang = 0.0;
    if (across > radius * radius) {
        overhang = sqrt(across) - radius;
        squared += overhang * overhang;
    }
    if (squared < best->squared)
        *best = (stp_nearest_disc){index, squared, sqrt(squared), fabs(height), overhang};
}

#endif

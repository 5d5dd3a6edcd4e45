/* The narrowest cone around normals, and the few normals that it depends on.
 *
 * The cone's axis leads to the centre of the smallest ball around the unit normals. If the normals
 * lie within less than 90 degrees of an axis, the cone depends only on the corners of their hull.
 * Seen along the axis, in the plane that touches the sphere there, the hull is a convex polygon:
 *
 *       c---c
 *      / . . \        c: corners; .: normals that no cone can leave out if it has the corners
 *     c  . .  c
 *      \_c___/
 *
 * So the cone of two sets together is that of their corners. Threads: any (pure functions). */
#ifndef STP_PREPROCESS_MAPS_PARTS_NORMAL_CONE_H
#define STP_PREPROCESS_MAPS_PARTS_NORMAL_CONE_H

#include "base/error.h"
#include "base/vec.h"

#include <stdint.h>

typedef struct stp_normal_cone {
    stp_dvec3 axis; /* unit; zero: no half-space has all normals */
    double cosine;  /* of the greatest angle between the axis and a normal; -1 without an axis */
} stp_normal_cone;

/* The cone of at least 1 unit normal. */
stp_normal_cone stp_normal_cone_of(const vec3s *normals, size_t count);
/* Copies the corners of the normals' hull. cone: of the normals, with a cosine above 0. *out: at
 * least 1, free with free(). Errors: OUT_OF_MEMORY. */
stp_status stp_normal_cone_corners(const vec3s *normals, uint32_t count,
                                   const stp_normal_cone *cone, vec3s **out, uint32_t *out_count,
                                   stp_error *err);

#endif

/* Which neighbours of a point are on its own sheet where another lies close over or under it: those
 * that no gap in height parts from it. Threads: any (pure functions). */
#ifndef STP_PREPROCESS_SURFACE_LAYER_H
#define STP_PREPROCESS_SURFACE_LAYER_H

#include "preprocess/cloud/cloud.h"

/* Spacings without a point between two sheets. */
#define STP_LAYER_GAP 0.35f

/* Heights over the point's plane, world units, that its own sheet has nearby. */
typedef struct stp_layer {
    float low, high;
} stp_layer;

/* Height of b over the plane through a with this normal. */
static inline float stp_layer_height(const stp_cloud *cloud, uint32_t a, vec3s normal, uint32_t b)
{
    stp_dvec3 d = stp_dvec3_sub(cloud->points[b].position, cloud->points[a].position);
    return glms_vec3_dot(normal, stp_dvec3_to_float(d));
}

/* list: k neighbours of self, or fewer and STP_NEIGHBOUR_NONE; gap: STP_LAYER_GAP in world units.
 */
stp_layer stp_layer_find(const stp_cloud *cloud, uint32_t self, vec3s normal, const uint32_t *list,
                         unsigned k, float gap);

static inline bool stp_layer_holds(stp_layer layer, float height)
{
    return height >= layer.low && height <= layer.high;
}

#endif

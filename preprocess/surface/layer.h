/* Finds the neighbours on a point's own sheet if another sheet is close above or below: those that
 * no gap in height separates from the point.
 *
 *         o   o    o         other sheet
 *                            gap
 *       o   P   o    o       own sheet: the layer around P
 *
 * Threads: any (pure functions). */
#ifndef STP_PREPROCESS_SURFACE_LAYER_H
#define STP_PREPROCESS_SURFACE_LAYER_H

#include "preprocess/cloud/cloud.h"

/* The gap between two sheets, in spacings: no point lies in it. */
#define STP_LAYER_GAP 0.35f

/* The range of heights over the point's plane, in world units, that its own sheet has nearby. */
typedef struct stp_layer {
    float low, high;
} stp_layer;

/* Height of b over the plane through a with this normal. */
static inline float stp_layer_height(const stp_cloud *cloud, uint32_t a, vec3s normal, uint32_t b)
{
    stp_dvec3 d = stp_dvec3_sub(cloud->points[b].position, cloud->points[a].position);
    return glms_vec3_dot(normal, stp_dvec3_to_float(d));
}

/* The layer of a point whose neighbours have these heights over its plane; any unit. gap:
 * STP_LAYER_GAP in that unit. */
stp_layer stp_layer_of(const float *heights, unsigned count, float gap);

/* list: k neighbours of self, or fewer and then STP_NEIGHBOUR_NONE. gap: STP_LAYER_GAP in world
 * units. */
stp_layer stp_layer_find(const stp_cloud *cloud, uint32_t self, vec3s normal, const uint32_t *list,
                         unsigned k, float gap);

static inline bool stp_layer_holds(stp_layer layer, float height)
{
    return height >= layer.low && height <= layer.high;
}

#endif

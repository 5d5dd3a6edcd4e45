/* Points of a scan as items of a leaf chunk. Threads: any (pure functions). */
#ifndef STP_PREPROCESS_PATCH_POINT_ITEM_H
#define STP_PREPROCESS_PATCH_POINT_ITEM_H

#include "preprocess/cloud/cloud.h"
#include "preprocess/patch/displacement.h"

typedef struct stp_point_item_params {
    double lambda; /* radius of a sample over its spacing */
    stp_resolution resolution;
    uint16_t intensity_max; /* of all points: what 255 stands for */
    int vertex_least;       /* of patches that will be built: no vertex has a finer lattice */
} stp_point_item_params;

/* Exponent of the lattice of a point so far from its neighbours. Exact: by the inputs' step,
 * whatever the disc; floats as finely as patches of some 64 points allow. */
int stp_point_exponent(stp_dvec3 position, double spacing, const stp_point_item_params *params);
/* Whether such a point is closer to others, against its coordinates, than points that differ by
 * more than rounding. */
bool stp_point_is_rounded(stp_dvec3 position, int exponent);

/* Points [begin, begin + count) of a sorted cloud, as one chunk will have them. Exact: a disc that
 * is too large to have a code on its point's lattice is the largest that has one. */
void stp_point_items_make(stp_item *items, const stp_cloud *cloud, uint32_t begin, uint32_t count,
                          const stp_point_item_params *params);

#endif

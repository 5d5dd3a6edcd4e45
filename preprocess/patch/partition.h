/* Orders points so that patches, and the groups inside them, are runs of neighbours.
 *
 * Recursive halving along the longest axis of the bounding box of position and, for small sets,
 * normal: what a plain octree gets wrong (two sheets with opposed normals in one node) splits
 * first. Threads: any, on separate arrays. */
#ifndef STP_PREPROCESS_PATCH_PARTITION_H
#define STP_PREPROCESS_PATCH_PARTITION_H

#include "base/error.h"

#include <stdint.h>

typedef struct stp_place {
    float key[6];  /* position relative to anything near, then normal */
    float spacing; /* distance to its neighbours on the surface, as the positions */
    uint32_t sheet;
} stp_place;

/* Writes the indices of places[0, count) to order[count], as runs of at most 64 adjacent ones,
 * ordered inside so that stp_level_children_begin's ranges are adjacent at every level; run i ends
 * at ends[i]. Indices break ties. ends and scratch have room for count entries. Returns the number
 * of runs. */
uint32_t stp_partition(const stp_place *places, uint32_t count, uint32_t *order, uint64_t *scratch,
                       uint32_t *ends);

#endif

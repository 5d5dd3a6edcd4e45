/* Orders points so that patches, and the groups inside them, are runs of neighbours.
 *
 * Sets are halved recursively along the longest axis of their bounding box. The box is of positions
 * and, for small sets, also of normals. So two sheets with opposed normals, which a plain octree
 * leaves in one node, are separated first. Threads: any, on separate arrays. */
#ifndef STP_PREPROCESS_PATCH_PARTITION_H
#define STP_PREPROCESS_PATCH_PARTITION_H

#include "base/error.h"

#include <stdint.h>

/* Sheets of this number and more share no patch, even where each has only crumbs of the surface. */
#define STP_SHEET_APART (UINT32_C(1) << 31)

typedef struct stp_place {
    float key[6];  /* position relative to any point nearby, then normal */
    float spacing; /* distance to its neighbours on the surface, in units of the positions */
    uint32_t sheet;
} stp_place;

/* Writes the indices of places[0, count) to order[count], as runs of at most `most` adjacent
 * places. most: 1 to STP_PATCH_SAMPLES. Inside a run, the ranges of stp_level_children_begin are
 * adjacent at every level. Run i ends at ends[i]. Indices break ties. ends and scratch have room
 * for count entries. Returns the number of runs. */
uint32_t stp_partition(const stp_place *places, uint32_t count, uint32_t most, uint32_t *order,
                       uint64_t *scratch, uint32_t *ends);

#endif

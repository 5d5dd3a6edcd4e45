/* Points along the Morton curve of their bounding cube.
 *
 * 21 bits an axis, x lowest. A most-significant-digit pass parts the keys into buckets that are
 * sorted side by side. Threads: those of the pool; the order does not depend on their number. */
#ifndef STP_PREPROCESS_MORTON_H
#define STP_PREPROCESS_MORTON_H

#include "preprocess/cloud.h"

#define STP_MORTON_BITS 21

typedef struct stp_morton_key {
    uint64_t code;
    uint32_t index; /* of the point before sorting */
} stp_morton_key;

/* Sorts points into `sorted` and their keys into `keys` (count each), ties by coordinates, then by
 * source; *box: of all points. Errors: OUT_OF_MEMORY. */
stp_status stp_morton_sort(const stp_cloud_point *points, uint32_t count, stp_cloud_point *sorted,
                           stp_morton_key *keys, stp_dbox *box, stp_pool *pool, stp_error *err);

#endif

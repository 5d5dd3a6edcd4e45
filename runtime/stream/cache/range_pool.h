/* Contiguous ranges of a buffer's elements, handed out first fit, in O(log n). Threads: one at a
 * time. */
#ifndef STP_RUNTIME_STREAM_CACHE_RANGE_POOL_H
#define STP_RUNTIME_STREAM_CACHE_RANGE_POOL_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct stp_range {
    uint32_t begin, count;
} stp_range;

/* Zero is a pool without elements; set capacity. */
typedef struct stp_range_pool {
    uint32_t capacity;
    struct stp_range_node *nodes; /* a tree of the ranges in use; [0] stands for no node */
    size_t node_count, node_capacity;
    uint32_t root, unused; /* unused: a list of nodes */
} stp_range_pool;

/* False if no gap is large enough. Errors go to *status: OUT_OF_MEMORY. count 0 gives {0, 0}. */
bool stp_range_pool_take(stp_range_pool *pool, uint32_t count, stp_range *out, stp_status *status,
                         stp_error *err);
/* Returns a range from stp_range_pool_take to the pool. */
void stp_range_pool_give(stp_range_pool *pool, stp_range range);
/* Returns all but the first `count` elements of a range from stp_range_pool_take, at least one. */
void stp_range_pool_trim(stp_range_pool *pool, stp_range *range, uint32_t count);
/* Frees the tree; leaves the pool as zero. */
void stp_range_pool_destroy(stp_range_pool *pool);

#endif

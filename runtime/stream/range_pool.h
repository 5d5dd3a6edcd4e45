/* Contiguous ranges of a buffer's elements, handed out first fit. Threads: one at a time. */
#ifndef STP_RUNTIME_STREAM_RANGE_POOL_H
#define STP_RUNTIME_STREAM_RANGE_POOL_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct stp_range {
    uint32_t begin, count;
} stp_range;

/* Zero is a pool without elements; set capacity. `used` is sorted by begin. */
typedef struct stp_range_pool {
    uint32_t capacity;
    stp_range *used;
    size_t used_count, used_capacity;
} stp_range_pool;

/* False if no gap is large enough. Errors go to *status: OUT_OF_MEMORY. count 0 gives {0, 0}. */
bool stp_range_pool_take(stp_range_pool *pool, uint32_t count, stp_range *out, stp_status *status,
                         stp_error *err);
/* Returns a range from stp_range_pool_take to the pool. */
void stp_range_pool_give(stp_range_pool *pool, stp_range range);
/* Frees the list; leaves the pool as zero. */
void stp_range_pool_destroy(stp_range_pool *pool);

#endif

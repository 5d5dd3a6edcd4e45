/* Hands out ranges first fit, over a sorted list of used ranges. */
#include "runtime/stream/range_pool.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

bool stp_range_pool_take(stp_range_pool *pool, uint32_t count, stp_range *out, stp_status *status,
                         stp_error *err)
{
    *status = STP_OK;
    if (count == 0) {
        *out = (stp_range){0, 0};
        return true;
    }
    uint32_t begin = 0;
    size_t at = 0;
    while (at < pool->used_count && pool->used[at].begin - begin < count) {
        begin = pool->used[at].begin + pool->used[at].count;
        at++;
    }
    if (pool->capacity - begin < count)
        return false;
    *status = stp_grow(&pool->used, &pool->used_capacity, pool->used_count + 1, sizeof *pool->used,
                       "a list of GPU ranges", err);
    if (*status != STP_OK)
        return false;
    memmove(pool->used + at + 1, pool->used + at, (pool->used_count - at) * sizeof *pool->used);
    pool->used[at] = *out = (stp_range){begin, count};
    pool->used_count++;
    return true;
}

void stp_range_pool_give(stp_range_pool *pool, stp_range range)
{
    for (size_t i = 0; range.count > 0 && i < pool->used_count; i++)
        if (pool->used[i].begin == range.begin) {
            pool->used_count--;
            memmove(pool->used + i, pool->used + i + 1,
                    (pool->used_count - i) * sizeof *pool->used);
            return;
        }
}

void stp_range_pool_destroy(stp_range_pool *pool)
{
    free(pool->used);
    *pool = (stp_range_pool){0};
}

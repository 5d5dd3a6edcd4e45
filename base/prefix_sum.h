/* Counts to places, as counting sorts need them. Threads: any (pure function). */
#ifndef STP_BASE_PREFIX_SUM_H
#define STP_BASE_PREFIX_SUM_H

#include <stddef.h>

/* Replaces each count by the sum of those before it; returns the sum of all. */
static inline size_t stp_prefix_sum(size_t *counts, size_t count)
{
    size_t sum = 0;
    for (size_t i = 0; i < count; i++) {
        size_t here = counts[i];
        counts[i] = sum;
        sum += here;
    }
    return sum;
}

#endif

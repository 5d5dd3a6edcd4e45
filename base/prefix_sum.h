/* Turns counts into places for counting sorts. Threads: any (pure function). */
#ifndef STP_BASE_PREFIX_SUM_H
#define STP_BASE_PREFIX_SUM_H

#include <stddef.h>

/* Replaces each count by the sum of the counts before it. Returns the total. */
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

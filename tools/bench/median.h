/* The median of measurements. Threads: any (pure). */
#ifndef STP_TOOLS_BENCH_MEDIAN_H
#define STP_TOOLS_BENCH_MEDIAN_H

#include "base/sort.h"

/* Sorts the values. For an even count, returns the mean of the two in the middle; for none, 0. */
static inline double bench_median(double *values, size_t count)
{
    if (count == 0)
        return 0.0;
    stp_sort_doubles(values, count);
    return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

#endif

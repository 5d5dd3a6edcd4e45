/* The middle of what was measured. Threads: any (pure). */
#ifndef STP_TOOLS_BENCH_MEDIAN_H
#define STP_TOOLS_BENCH_MEDIAN_H

#include <stddef.h>
#include <stdlib.h>

static inline int bench_compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sorts the values; of an even count the mean of the two in the middle, of none 0. */
static inline double bench_median(double *values, size_t count)
{
    if (count == 0)
        return 0.0;
    qsort(values, count, sizeof *values, bench_compare);
    return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

#endif

/* Sorting numbers. Threads: any (pure). */
#ifndef STP_BASE_SORT_H
#define STP_BASE_SORT_H

#include <stddef.h>
#include <stdlib.h>

static inline int stp_compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sorts in increasing order. No value may be NaN. */
static inline void stp_sort_doubles(double *values, size_t count)
{
    if (count > 0)
        qsort(values, count, sizeof *values, stp_compare_doubles);
}

#endif

/* Sorting numbers, and what lies in a file. Threads: any (pure). */
#ifndef STP_BASE_SORT_H
#define STP_BASE_SORT_H

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

/* Sorts in increasing order, some times as fast as qsort. No value may be NaN. */
void stp_sort_doubles(double *values, size_t count);

static inline int stp_compare_u32(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static inline void stp_sort_u32(uint32_t *values, size_t count)
{
    if (count > 0)
        qsort(values, count, sizeof *values, stp_compare_u32);
}

static inline int stp_compare_u64(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

static inline void stp_sort_u64(uint64_t *values, size_t count)
{
    if (count > 0)
        qsort(values, count, sizeof *values, stp_compare_u64);
}

static inline int stp_compare_i64(const void *a, const void *b)
{
    const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

static inline void stp_sort_i64(int64_t *values, size_t count)
{
    if (count > 0)
        qsort(values, count, sizeof *values, stp_compare_i64);
}

/* Something of a file: its number, and the byte where it lies. */
typedef struct stp_placed {
    uint64_t offset;
    uint32_t id;
} stp_placed;

static inline int stp_compare_placed(const void *a, const void *b)
{
    const stp_placed *x = a, *y = b;
    if (x->offset != y->offset)
        return x->offset < y->offset ? -1 : 1;
    return (x->id > y->id) - (x->id < y->id);
}

/* Sorts by place; what lies at one place, by number. */
static inline void stp_sort_placed(stp_placed *list, size_t count)
{
    if (count > 0)
        qsort(list, count, sizeof *list, stp_compare_placed);
}

#endif

/* Sorts pairs of parts. */
#include "preprocess/maps/parts/part.h"

#include <stdlib.h>

static int compare_pairs(const void *a, const void *b)
{
    const stp_part_pair *p = a, *q = b;
    if (p->a != q->a)
        return p->a < q->a ? -1 : 1;
    return (p->b > q->b) - (p->b < q->b);
}

size_t stp_part_pairs_sort(stp_part_pair *pairs, size_t count)
{
    size_t kept = 0;
    if (count > 0)
        qsort(pairs, count, sizeof *pairs, compare_pairs);
    for (size_t i = 0; i < count; i++)
        if (i == 0 || compare_pairs(&pairs[i - 1], &pairs[i]) != 0)
            pairs[kept++] = pairs[i];
    return kept;
}

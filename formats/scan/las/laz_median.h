/* The median of the last few differences, kept up to date as LASzip does. */
#ifndef STP_FORMATS_SCAN_LAS_LAZ_MEDIAN_H
#define STP_FORMATS_SCAN_LAS_LAZ_MEDIAN_H

#include <stdbool.h>
#include <stdint.h>

/* Five numbers in increasing order. Alternately, the greatest or the least one gives way to a new
 * one: which, follows from the side where the new ones fell. */
typedef struct stp_laz_median {
    int32_t sorted[5];
    bool drop_least; /* the next number on the upper side drops the least */
} stp_laz_median;

static inline int32_t stp_laz_median_get(const stp_laz_median *m)
{
    return m->sorted[2];
}

static inline void stp_laz_median_add(stp_laz_median *m, int32_t value)
{
    int32_t *v = m->sorted;
    if (!m->drop_least) {
        const bool below = value < v[2];
        int i = 4;
        for (; i > (below ? 0 : 3) && value < v[i - 1]; i--)
            v[i] = v[i - 1];
        v[i] = value;
        m->drop_least = !below;
    } else {
        const bool above = value > v[2];
        int i = 0;
        for (; i < (above ? 4 : 1) && value > v[i + 1]; i++)
            v[i] = v[i + 1];
        v[i] = value;
        m->drop_least = above;
    }
}

#endif

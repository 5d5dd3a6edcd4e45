/* The median of the last few changes of a coordinate, kept up to date as LASzip does. */
#ifndef STP_FORMATS_SCAN_LAS_LAZ_LAZ_MEDIAN_H
#define STP_FORMATS_SCAN_LAS_LAZ_LAZ_MEDIAN_H

#include "formats/scan/las/las_bytes.h"
#include "formats/scan/las/laz/laz_stream.h"

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

/* Adds a change near the median of those before it to the coordinate at `at`. next: the coordinate
 * that this gives. */
static inline void stp_laz_code_along(stp_laz_stream *d, stp_laz_integer *m, stp_laz_median *median,
                                      unsigned context, unsigned char *at,
                                      const unsigned char *next)
{
    const int32_t change = stp_laz_code_integer(d, m, stp_laz_median_get(median), context,
                                                (int32_t)(stp_las_u32(next) - stp_las_u32(at)));
    stp_laz_median_add(median, change);
    stp_las_put_u32(at, stp_las_u32(at) + (uint32_t)change);
}

#endif

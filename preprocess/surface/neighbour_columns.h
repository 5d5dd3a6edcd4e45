/* The neighbours of several points at a time, a column for each point: one pass over them serves
 * both planes (normals.h) and spacings (spacing.h). Threads: any, each with its own columns. */
#ifndef STP_PREPROCESS_SURFACE_NEIGHBOUR_COLUMNS_H
#define STP_PREPROCESS_SURFACE_NEIGHBOUR_COLUMNS_H

#include "preprocess/cloud/nearest_list.h"
#include "preprocess/cloud/unit.h"
#include "preprocess/surface/moments.h"

typedef struct stp_neighbour_columns {
    uint32_t first;                     /* number of the first column's point */
    unsigned k;                         /* rows */
    unsigned counts[STP_MOMENTS_LANES]; /* neighbours of each point */
    float places[STP_NEIGHBOURS_LIMIT][3][STP_MOMENTS_LANES]; /* from the point; lengths times the
                                                                 unit's scale */
    float spacings[STP_NEIGHBOURS_LIMIT][STP_MOMENTS_LANES];  /* likewise */
} stp_neighbour_columns;

/* How many neighbours a list of k has. */
static inline unsigned stp_neighbours_known(const uint32_t *list, unsigned k)
{
    while (k > 0 && list[k - 1] == STP_NEIGHBOUR_NONE) /* usually none: the last ones are missing */
        k--;
    return k;
}

/* Sets the columns to the neighbours of points from `first` on, before `end`. Columns that are left
 * repeat the last point; rows that are left are 0. scale: a factor of lengths. */
void stp_neighbour_columns_take(stp_neighbour_columns *out, const stp_unit *unit, uint32_t first,
                                uint32_t end, double scale);

#endif

/* Sums over the samples around those of a row of a square, which tell normals. */
#include "preprocess/grid/grid_windows.h"

#include "base/wide.h"
#include "formats/chunk/codec/inline.h"

#include <math.h>

/* See by_columns. */
#define CLIFF_STEPS 3.0
#define CLIFF_SLOPE 2.0
#define CLIFF_NOISE 8.0

/* What the windows of a row share: its columns, as far as they reach up and down. */
typedef double strip_row[STP_SQUARE_SIDE + 2 * STP_GRID_REACH];
typedef struct strip {
    strip_row z, yz;                                                   /* sums */
    strip_row highest[STP_GRID_REACH + 1], lowest[STP_GRID_REACH + 1]; /* of the rows so far off */
} strip;

/* Sets heights by steps. A lesser step that is not there is infinite. */
STP_INLINE void set_cliffs(const double *middle, int beside, double slope, int reach,
                           stp_grid_lanes *out)
{
    stp_grid_lanes each;
#pragma GCC unroll 1 /* unrolled, it would not become vectors */
    for (unsigned k = 0; k < STP_SQUARE_SIDE; k++) {
        const double before = fabs(middle[k] - middle[(int)k - beside]);
        const double after = fabs(middle[k] - middle[(int)k + beside]);
        const double a = isnan(before) ? INFINITY : before, b = isnan(after) ? INFINITY : after;
        each[k] = CLIFF_STEPS * (a < b ? a : b) + slope;
        out[0][k] = 0.0;
    }
    for (int i = 1; i <= reach; i++)
#pragma GCC unroll 1
        for (unsigned k = 0; k < STP_SQUARE_SIDE; k++)
            out[i][k] = i * each[k];
}

STP_INLINE void sum_columns(const double *middle, int stride, int reach, strip *restrict s)
{
    const unsigned count = sizeof(strip_row) / sizeof(double);
    const double *first = middle - STP_GRID_REACH;
    for (unsigned k = 0; k < count; k++) {
        s->z[k] = s->highest[0][k] = s->lowest[0][k] = first[k];
        s->yz[k] = 0.0;
    }
    for (int j = 1; j <= reach; j++) {
        const double *above = first - j * stride;
        const double *below = first + j * stride;
#pragma GCC unroll 1
        for (unsigned k = 0; k < count; k++) {
            s->z[k] += above[k] + below[k];
            s->yz[k] += j * (below[k] - above[k]);
            s->highest[j][k] = above[k] > below[k] ? above[k] : below[k];
            s->lowest[j][k] = above[k] < below[k] ? above[k] : below[k];
        }
    }
}

/* Finds how far the samples i columns and j rows from those of the row, on either side, are behind
 * a cliff. */
STP_INLINE void look_beyond(const strip *s, const double *restrict middle, int i, int j,
                            stp_grid_windows *restrict w)
{
    const double *highest = s->highest[j] + STP_GRID_REACH, *lowest = s->lowest[j] + STP_GRID_REACH;
    const double *across = w->by_columns[i], *down = w->by_rows[j];
#pragma GCC unroll 1
    for (unsigned k = 0; k < STP_SQUARE_SIDE; k++) {
        const double left = highest[(int)k - i], right = highest[(int)k + i];
        const double low_left = lowest[(int)k - i], low_right = lowest[(int)k + i];
        const double up = (left > right ? left : right) - middle[k];
        const double down_to = middle[k] - (low_left < low_right ? low_left : low_right);
        const double beyond = (up > down_to ? up : down_to) - (across[k] + down[k] + w->noise);
        w->beyond[k] = beyond > w->beyond[k] ? beyond : w->beyond[k];
    }
}

STP_WIDE
void stp_grid_windows_sum(const double *middle, int stride, const double sides[2],
                          const stp_height_grid *grid, stp_grid_windows *w)
{
    const int reach = (int)grid->reach;
    strip s;
    w->noise = CLIFF_NOISE * grid->noise;
    set_cliffs(middle, 1, CLIFF_SLOPE * sides[0], reach, w->by_columns);
    set_cliffs(middle, stride, CLIFF_SLOPE * sides[1], reach, w->by_rows);
    sum_columns(middle, stride, reach, &s);
    for (unsigned k = 0; k < STP_SQUARE_SIDE; k++) {
        w->xz[k] = w->beyond[k] = 0.0;
        w->yz[k] = s.yz[k + STP_GRID_REACH];
    }
    for (int i = 1; i <= reach; i++) {
        const double *z = s.z + STP_GRID_REACH, *yz = s.yz + STP_GRID_REACH;
#pragma GCC unroll 1
        for (int k = 0; k < (int)STP_SQUARE_SIDE; k++) {
            w->xz[k] += i * (z[k + i] - z[k - i]);
            w->yz[k] += yz[k + i] + yz[k - i];
        }
    }
    for (int j = 0; j <= reach; j++)
        for (int i = 0; i <= reach; i++)
            look_beyond(&s, middle, i, j, w);
}

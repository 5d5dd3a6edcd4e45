/* Sums over the samples around those of a row of a square, which tell normals.
 *
 * Threads: any. */
#ifndef STP_PREPROCESS_GRID_GRID_WINDOWS_H
#define STP_PREPROCESS_GRID_GRID_WINDOWS_H

#include "preprocess/grid/height_grid.h"

typedef double stp_grid_lanes[STP_SQUARE_SIDE];
/* Sums over the windows around the samples of a row of a square, a lane each. */
typedef struct stp_grid_windows {
    /* How far a sample may lie over or under the middle and still be on the same surface, by steps
     * from it: three times as far as the lesser step to a neighbour goes on, beside a slope of 2
     * and the noise. What lies farther off is behind a cliff. */
    stp_grid_lanes by_columns[STP_GRID_REACH + 1], by_rows[STP_GRID_REACH + 1];
    double noise;
    stp_grid_lanes xz, yz;
    stp_grid_lanes beyond; /* how far one is behind a cliff, at most */
    /* Of samples whose windows are whole: */
    stp_grid_lanes normal[3],
        code[2]; /* code: coordinates of the normal's, as places of their grid */
} stp_grid_windows;

/* Finds sums and cliffs of the samples from `middle` on, among rows `stride` apart that reach
 * STP_GRID_REACH samples farther on all sides. sides: of a cell, along columns and rows. Where a
 * sample of a window is missing, xz or yz is NaN, and `beyond` is anything. */
void stp_grid_windows_sum(const double *middle, int stride, const double sides[2],
                          const stp_height_grid *grid, stp_grid_windows *w);

#endif

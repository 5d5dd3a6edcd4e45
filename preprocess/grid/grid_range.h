/* What the heights of a grid tell of themselves: which range nearly all are in, and whether the
 * least or the greatest number looks like one that stands for no sample. Threads: any. */
#ifndef STP_PREPROCESS_GRID_GRID_RANGE_H
#define STP_PREPROCESS_GRID_GRID_RANGE_H

#include "preprocess/grid/height_grid.h"

typedef struct stp_grid_range {
    double low, high;    /* nearly all heights but odd ones lie between */
    double share;        /* of all heights that do */
    double odd[2];       /* the least and the greatest height, if many are just that and all others
                            lie far from it */
    double odd_share[2]; /* of the heights; 0: they are not odd */
} stp_grid_range;

/* Looks at up to 2^18 samples of a finished grid. Without samples all is 0. If tiles are shared,
 * all ranks call it. Errors: OUT_OF_MEMORY, IO, CANCELLED. */
stp_status stp_grid_range_measure(stp_grid_range *out, const stp_height_grid *grid,
                                  stp_ranks *ranks, stp_error *err);

#endif

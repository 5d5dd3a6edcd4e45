/* Balls around the openings of a sealed grid of voxels. */
#ifndef STP_PREPROCESS_CLOSED_OPENINGS_H
#define STP_PREPROCESS_CLOSED_OPENINGS_H

#include "formats/chunk/outside.h"
#include "preprocess/closed/voxel_grid.h"

/* Covers the openings with balls. Every path from outside to inside that touches no occupied voxel
 * passes through a ball. Units: voxels. *count is the number of balls; if more than
 * STP_OPENINGS_LIMIT are needed, *count exceeds the limit and out is of no use. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_openings_find(const stp_voxel_grid *grid, stp_opening out[STP_OPENINGS_LIMIT],
                             size_t *count, stp_error *err);

#endif

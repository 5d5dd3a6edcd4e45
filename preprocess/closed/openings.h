/* Balls around the openings of a grid of voxels that were sealed. */
#ifndef STP_PREPROCESS_CLOSED_OPENINGS_H
#define STP_PREPROCESS_CLOSED_OPENINGS_H

#include "formats/chunk/outside.h"
#include "preprocess/closed/voxel_grid.h"

/* Every way from outside to inside that touches no occupied voxel goes through one of the balls. In
 * voxels; *count: how many, at most STP_OPENINGS_LIMIT; more where there are more. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_openings_find(const stp_voxel_grid *grid, stp_opening out[STP_OPENINGS_LIMIT],
                             size_t *count, stp_error *err);

#endif

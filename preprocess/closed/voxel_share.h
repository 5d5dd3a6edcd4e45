/* Joins the grids of voxels that several ranks made of a part of the points each. Does nothing if
 * there is one process. Threads: one. */
#ifndef STP_PREPROCESS_CLOSED_VOXEL_SHARE_H
#define STP_PREPROCESS_CLOSED_VOXEL_SHARE_H

#include "preprocess/closed/voxel_grid.h"
#include "preprocess/ranks/ranks.h"

/* Claims the blocks that any rank claims. Errors: OUT_OF_MEMORY, IO, CANCELLED. */
stp_status stp_voxel_share_claims(stp_voxel_grid *grid, stp_ranks *ranks, stp_error *err);
/* Occupies the voxels that any rank occupies. Errors: likewise. */
stp_status stp_voxel_share_occupied(stp_voxel_grid *grid, stp_ranks *ranks, stp_error *err);

#endif

/* Merges the parts of a cell, before parts of different cells are merged (part_merge.h).
 *
 * A rough surface falls into parts of 4 to 6 points, whose merging takes long. So each cell merges
 * its parts first: nine of ten are gone then. Cells are the same for any number of ranks and
 * threads, so are the parts. Threads: any, a cell each. */
#ifndef STP_PREPROCESS_MAPS_PARTS_PART_WITHIN_H
#define STP_PREPROCESS_MAPS_PARTS_PART_WITHIN_H

#include "preprocess/maps/parts/part_cut.h"

/* Merges the parts of cell `index` until no more can be merged, and numbers those that are left:
 * in parts, pairs, borders, and by the cell's points in numbers. cone_rad: that merged parts keep.
 * Errors: OUT_OF_MEMORY; parts may only be cleared then. */
stp_status stp_cell_parts_merge(stp_cell_parts *parts, const stp_cloud *cloud, uint32_t index,
                                double cone_rad, uint32_t *numbers, stp_error *err);

#endif

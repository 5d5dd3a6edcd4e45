/* Cuts cells that are too wide for one chunk: a chunk's lattices must reach from its finest points
 * to its farthest. Example: a dense cluster with a few points far around it.
 *
 * Threads: those of the pool; the same cells for any number. */
#ifndef STP_PREPROCESS_TREE_CELL_CUT_H
#define STP_PREPROCESS_TREE_CELL_CUT_H

#include "preprocess/patch/point_item.h"

/* Cuts the cells that are too wide in a cloud whose spacings are known. All other cells stay as
 * they are. Errors: OUT_OF_MEMORY. */
stp_status stp_cells_cut(stp_cloud *cloud, const stp_point_item_params *params, stp_pool *pool,
                         stp_error *err);

#endif

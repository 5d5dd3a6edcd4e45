/* Builds the leaf of a cell of the cloud.
 *
 * A point becomes an item just before its patch is built: items are three times as large as points,
 * and those of a whole cell would go through memory several times. Threads: any. */
#ifndef STP_PREPROCESS_TREE_POINT_LEAF_H
#define STP_PREPROCESS_TREE_POINT_LEAF_H

#include "preprocess/tree/chunk_build.h"

/* only: by point of the cloud, bits, from place cloud->first on, of those that the leaf has; NULL:
 * all of the cell. Errors: those of stp_chunk_build_leaf. Free with stp_built_chunk_clear. */
stp_status stp_point_leaf_build(stp_built_chunk *out, const stp_cloud *cloud, const stp_cell *cell,
                                const uint64_t *only, const stp_point_item_params *params,
                                stp_error *err);

#endif

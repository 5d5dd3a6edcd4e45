/* In which order the leaves of a model stand: those near each other get one parent. */
#ifndef STP_PREPROCESS_LEAF_ORDER_H
#define STP_PREPROCESS_LEAF_ORDER_H

#include "preprocess/cloud.h"
#include "preprocess/line_leaves.h"

/* A cell of the cloud, or a leaf of lines. */
typedef struct stp_leaf_place {
    bool is_lines;
    uint32_t index;
} stp_leaf_place;

/* Cells alone stand as they are; with lines (NULL: none) all leaves follow the Morton curve of the
 * model's box by their boxes' middles. *out: *count leaves, free with free(). Errors:
 * OUT_OF_MEMORY. */
stp_status stp_leaf_order(const stp_cloud *cloud, const stp_line_leaves *lines,
                          stp_leaf_place **out, uint32_t *count, stp_error *err);

#endif

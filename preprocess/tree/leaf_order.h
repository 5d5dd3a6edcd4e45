/* The order of a model's leaves: leaves near each other get one parent. */
#ifndef STP_PREPROCESS_TREE_LEAF_ORDER_H
#define STP_PREPROCESS_TREE_LEAF_ORDER_H

#include "preprocess/cloud/cloud.h"
#include "preprocess/tree/line_leaves.h"
#include "preprocess/tree/triangle_leaves.h"

/* A cell of the cloud, or a leaf of lines or of triangles. */
typedef enum stp_leaf_kind { STP_LEAF_CELL, STP_LEAF_LINES, STP_LEAF_TRIANGLES } stp_leaf_kind;

typedef struct stp_leaf_place {
    stp_leaf_kind kind;
    uint32_t index;
} stp_leaf_place;

/* Orders the leaves. If there are only cells, they keep their order. With lines or triangles (NULL:
 * none), all leaves follow the Morton curve of the model's box by the middles of their boxes. *out:
 * *count leaves, free with free(). Errors: OUT_OF_MEMORY. */
stp_status stp_leaf_order(const stp_cloud *cloud, const stp_line_leaves *lines,
                          const stp_triangle_leaves *triangles, stp_leaf_place **out,
                          uint32_t *count, stp_error *err);

#endif

/* The order of a model's leaves: leaves near each other get one parent. */
#ifndef STP_PREPROCESS_TREE_LEAF_ORDER_H
#define STP_PREPROCESS_TREE_LEAF_ORDER_H

#include "preprocess/cloud/cloud.h"
#include "preprocess/grid/depth_image.h"
#include "preprocess/grid/height_grid.h"
#include "preprocess/maps/map_leaves.h"
#include "preprocess/tree/line_leaves.h"
#include "preprocess/tree/triangle_leaves.h"

/* A cell of the cloud, a leaf of lines, of triangles, of maps or of depth images, a tile of a grid.
 */
typedef enum stp_leaf_kind {
    STP_LEAF_CELL,
    STP_LEAF_LINES,
    STP_LEAF_TRIANGLES,
    STP_LEAF_TILE,
    STP_LEAF_MAPS,
    STP_LEAF_DEPTHS
} stp_leaf_kind;

/* Where leaves come from, beside the cloud: NULL for none. */
typedef struct stp_leaf_sources {
    const stp_line_leaves *lines;
    const stp_triangle_leaves *triangles;
    const stp_height_grid *grid;
    const stp_map_leaves *maps;
    const stp_depth_images *depths; /* they have all points of the cloud but loose ones, for which
                                       its cells are left */
} stp_leaf_sources;

/* What discs may not cover, by sheet (patch_build.h); NULL: nothing. */
static inline const stp_holes *stp_leaf_sources_holes(const stp_leaf_sources *from)
{
    return from->grid ? from->grid->holes : from->depths ? from->depths->holes : NULL;
}

typedef struct stp_leaf_place {
    stp_leaf_kind kind;
    uint32_t index;
} stp_leaf_place;

/* Orders the leaves. If there are only cells, they keep their order. Else all leaves follow the
 * Morton curve of the model's box by the middles of their boxes. *out: *count leaves, free with
 * free(). Errors: OUT_OF_MEMORY. */
stp_status stp_leaf_order(const stp_cloud *cloud, const stp_leaf_sources *from,
                          stp_leaf_place **out, uint32_t *count, stp_error *err);
/* Whether the leaves are those of one grid of heights that lacks no sample. */
bool stp_leaves_are_whole_grid(const stp_leaf_sources *from, const stp_leaf_place *leaves,
                               uint32_t count);
/* Asks other ranks for the points of a leaf (cloud_blocks.h). */
void stp_leaf_ask(const stp_cloud *cloud, const stp_leaf_sources *from, const stp_leaf_place *leaf);

/* The box of all that leaves come from. */
stp_dbox stp_leaf_sources_box(const stp_cloud *cloud, const stp_leaf_sources *from);

#endif

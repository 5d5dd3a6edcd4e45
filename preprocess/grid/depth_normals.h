/* Lets the normals of depth images' pixels follow from merged ones, where they are noisy: a chunk
 * then stores the normals of 4 x 4 pixels alone.
 *
 * Such a normal is the mean of those of its pixels, on its grid. Those of 2 x 2 pixels, and then of
 * pixels, are what a codec expects of them by the merged ones around (formats/SPEC.md, "Squares",
 * reach 6), on the grid of pixels, to the same bits, unless its own is far off. Threads: any. */
#ifndef STP_PREPROCESS_GRID_DEPTH_NORMALS_H
#define STP_PREPROCESS_GRID_DEPTH_NORMALS_H

#include "preprocess/grid/depth_image.h"

/* Merged normals of a square, of levels 1 and 2. */
#define STP_DEPTH_MERGED (STP_SQUARE_SAMPLES / 4 + STP_SQUARE_SAMPLES / 16)

/* A run of squares that become a block: [begin, end) of `order`. */
typedef struct stp_depth_block {
    const stp_cloud *cloud;
    const stp_depth_square *squares;
    const uint32_t *order;
    uint32_t begin, end;
    const uint32_t *ends;       /* by place in `order`: of the squares' items */
    const uint64_t *points;     /* by item */
    stp_item *items;            /* their normals are set */
    stp_patch_grid *grids;      /* by place in `order`: their merged normals are set */
    stp_dvec3 *merged;          /* by place in `order`: room for STP_DEPTH_MERGED */
    unsigned bits, merged_bits; /* of the grids of normals */
} stp_depth_block;

/* Sets the normals of a block whose points all have normals. Errors: OUT_OF_MEMORY. */
stp_status stp_depth_normals_derive(const stp_depth_block *block, stp_error *err);

#endif

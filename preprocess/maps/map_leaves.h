/* Leaf chunks of elevation maps: the samples of all maps in squares of 8 x 8, squares near each
 * other in one leaf. A square is one patch; its samples stand in Morton order.
 *
 * A sample's disc is as wide as the surface over its square of the grid. At the border of a map a
 * disc hardly reaches past its neighbours, since another map may go on there. Threads: one maker;
 * leaves may be built on any. */
#ifndef STP_PREPROCESS_MAPS_MAP_LEAVES_H
#define STP_PREPROCESS_MAPS_MAP_LEAVES_H

#include "preprocess/maps/maps.h"
#include "preprocess/tree/chunk_build.h"
#include "preprocess/tree/leaf_cut.h"

/* A square that has samples. */
typedef struct stp_map_square {
    uint32_t map, column, row; /* of its first sample */
} stp_map_square;

typedef struct stp_map_leaves {
    const stp_maps *maps;    /* borrowed */
    stp_map_square *squares; /* leaf by leaf */
    uint32_t square_count;
    stp_leaf_run *leaves; /* of squares */
    uint32_t leaf_count;
    bool *wanted; /* by map: leaves need it that were asked for */
    stp_dbox box; /* of all samples */
} stp_map_leaves;

/* Cuts the maps, borrowed as long as the leaves are used, into leaves. lambda, resolution: what the
 * samples will be stored with. Errors: OUT_OF_MEMORY, IO, CANCELLED. Free with
 * stp_map_leaves_clear. */
stp_status stp_map_leaves_create(stp_map_leaves *out, const stp_maps *maps, double lambda,
                                 const stp_resolution *resolution, stp_error *err);
/* Notes the maps that a leaf needs; then gets their samples from the ranks that have them. Errors
 * of this: OUT_OF_MEMORY, IO, CANCELLED. */
void stp_map_leaf_ask(const stp_map_leaves *leaves, uint32_t leaf);
stp_status stp_map_leaves_fetch(const stp_map_leaves *leaves, stp_error *err);
/* Builds one leaf, without tangential errors. Errors: OUT_OF_MEMORY, LIMIT. */
stp_status stp_map_leaf_build(const stp_map_leaves *leaves, uint32_t leaf,
                              const stp_point_item_params *params, stp_built_chunk *out,
                              stp_error *err);
/* Where a sample is put before it is rounded to the lattice of its square, which is the finest of
 * the exponents of the square's samples. raster: the map's, of any origin. */
stp_dvec3 stp_map_leaf_place(const stp_map *map, const stp_raster *raster, uint32_t column,
                             uint32_t row, const stp_point_item_params *params, int *exponent);
void stp_map_leaves_clear(stp_map_leaves *leaves);

#endif

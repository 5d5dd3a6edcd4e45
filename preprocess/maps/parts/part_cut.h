/* Cuts the points of one cell into parts whose normals keep a cone.
 *
 * 1. The cell's points are halved across their longest axis (halve.h) until the normals of each set
 *    keep the cone.
 * 2. A set falls into its connected pieces: points and their nearest neighbours hang together if no
 *    gap or step lies between them. Each piece is a part.
 *
 * Points without a normal or a spacing, and outliers, are in no part. Threads: any, a cell each. */
#ifndef STP_PREPROCESS_MAPS_PARTS_PART_CUT_H
#define STP_PREPROCESS_MAPS_PARTS_PART_CUT_H

#include "preprocess/cloud/cloud.h"
#include "preprocess/maps/parts/part.h"

/* A part of the cell touches the part of a point in another cell. */
typedef struct stp_part_border {
    uint32_t part, place;
} stp_part_border;

typedef struct stp_cell_parts {
    stp_part *parts;
    uint32_t part_count;
    stp_part_pair *pairs; /* of parts of this cell, each once */
    size_t pair_count;
    stp_part_border *borders; /* one for each pair of points that hang together */
    size_t border_count;
} stp_cell_parts;

/* Cuts cell `index` of a cloud whose spacings and normals are known. cosine: of the cone's angle.
 * numbers: by place in the cloud; gets for each point of the cell the number of its part in the
 * cell, or STP_PART_NONE. If *cloud->missed becomes true, nothing is cut: try again when the points
 * around the cell are here. Errors: OUT_OF_MEMORY. Free with stp_cell_parts_clear. */
stp_status stp_cell_parts_cut(stp_cell_parts *out, const stp_cloud *cloud, uint32_t index,
                              double cosine, uint32_t *numbers, stp_error *err);
void stp_cell_parts_clear(stp_cell_parts *parts);

#endif

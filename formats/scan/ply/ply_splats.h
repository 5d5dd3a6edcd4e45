/* Packed Gaussian splats, as PlayCanvas and SuperSplat write them (.compressed.ply).
 *
 * Every 256 vertices belong to one record of the element `chunk`, which has the least and the
 * greatest x, y and z of their positions, and perhaps of their colours (min_x ... max_b). In
 * `packed_position` 11, 10 and 11 bits, from the high ones on, are shares between these; in
 * `packed_color` 8 bits each of red, green, blue and opacity. The colour of a splat is between 0
 * and 1. Its rotation and size are no part of a point. */
#ifndef STP_FORMATS_SCAN_PLY_PLY_SPLATS_H
#define STP_FORMATS_SCAN_PLY_PLY_SPLATS_H

#include "formats/scan/ply/ply_columns.h"

/* Positions, then colours. */
typedef struct stp_ply_splats {
    double min[6], max[6];
} stp_ply_splats;

/* Whether the vertices are packed. Then gives the properties their targets. */
bool stp_ply_splats_find(stp_ply *ply);
/* Reads the element `chunk`, at which the cursor stands. Errors: IO, CORRUPT, OUT_OF_MEMORY. */
stp_status stp_ply_splats_read(stp_ply *ply, const stp_ply_element *element, stp_error *err);
/* Fails if the vertices have too few chunks. Errors: CORRUPT. */
stp_status stp_ply_splats_check(const stp_ply *ply, stp_error *err);
/* Puts coordinates and colours in place of the numbers of a block that begins with this vertex. */
void stp_ply_splats_part(stp_ply *ply, uint64_t first, size_t count);

#endif

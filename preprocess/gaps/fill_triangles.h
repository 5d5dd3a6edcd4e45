/* The triangles between maps, as a chunk stores triangles. Threads: any (pure). */
#ifndef STP_PREPROCESS_GAPS_FILL_TRIANGLES_H
#define STP_PREPROCESS_GAPS_FILL_TRIANGLES_H

#include "formats/scan/mesh/triangle_set.h"
#include "preprocess/maps/map_leaves.h"

/* The corners are exactly where the samples of the maps are stored. params: of the maps' leaves.
 * Errors: OUT_OF_MEMORY. Free with stp_triangle_set_clear. */
stp_status stp_fill_triangles(stp_triangle_set *out, const stp_maps *maps,
                              const stp_point_item_params *params, stp_error *err);

#endif

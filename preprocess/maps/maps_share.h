/* Gives what each rank made of the maps to all ranks: parts of its cells, and maps of its merged
 * parts. Threads: the main thread. */
#ifndef STP_PREPROCESS_MAPS_MAPS_SHARE_H
#define STP_PREPROCESS_MAPS_MAPS_SHARE_H

#include "preprocess/maps/map_try.h"
#include "preprocess/maps/part_cut.h"
#include "preprocess/ranks/ranks.h"

/* The merged parts that a rank samples, with about as many points as those of others. begins: by
 * merged part, where its points begin; then where the last one's end. */
stp_rank_part stp_maps_rank_part(const stp_ranks *ranks, unsigned rank, const uint32_t *begins,
                                 uint32_t count);
/* Gives the parts of each rank's cells (stp_cloud_cells), and the numbers of their points, to all.
 * Errors: OUT_OF_MEMORY, IO, INTERNAL, CANCELLED. */
stp_status stp_cell_parts_share(stp_ranks *ranks, const stp_cloud *cloud, stp_cell_parts *cells,
                                uint32_t *numbers, stp_error *err);
/* Gives the maps of each rank's merged parts to all, and which points they stand for. lists: by
 * merged part; places: that each part has, from begins[part] on. Errors: likewise. */
stp_status stp_map_lists_share(stp_ranks *ranks, const stp_cloud *cloud, stp_map_list *lists,
                               const uint32_t *begins, uint32_t count, const uint32_t *places,
                               bool *mapped, stp_error *err);

#endif

/* What ranks tell each other of maps. Nothing happens without ranks. Threads: the main thread. */
#ifndef STP_PREPROCESS_MAPS_MAPS_SHARE_H
#define STP_PREPROCESS_MAPS_MAPS_SHARE_H

#include "preprocess/maps/map_try.h"
#include "preprocess/maps/parts/part_cut.h"
#include "preprocess/ranks/ranks.h"

/* Gives the parts of each rank's cells, and which of a cell touch, to all. Errors: OUT_OF_MEMORY,
 * IO, INTERNAL, CANCELLED. */
stp_status stp_cell_parts_share(stp_ranks *ranks, const stp_cloud *cloud, stp_cell_parts *cells,
                                stp_error *err);
/* Gives the maps of each rank's lists and their counts to all. firsts: by rank, its first list;
 * then the number of lists. samples: those of the maps, too. Errors: likewise. */
stp_status stp_map_lists_share(stp_ranks *ranks, const stp_cloud *cloud, stp_map_list *lists,
                               const uint64_t *firsts, bool samples, stp_error *err);
/* Gets the samples of wanted maps, by number, from the ranks that have them. Errors: likewise. */
stp_status stp_maps_fetch(const stp_maps *maps, const bool *wanted, stp_error *err);

#endif

/* Counts points, samples and distances again when maps were trimmed and gaps were filled. Threads:
 * those of the pool; the same counts for any number. */
#ifndef STP_PREPROCESS_GAPS_MAP_ACCOUNT_H
#define STP_PREPROCESS_GAPS_MAP_ACCOUNT_H

#include "preprocess/maps/maps.h"

/* Which map stands for which point. */
typedef struct stp_map_owners {
    const uint32_t *numbers; /* by own point that is mapped: its merged part */
    const uint32_t *first;   /* by merged part: its first map; then the number of maps */
    bool *mapped;            /* by own point */
} stp_map_owners;

/* Sets the box and the counts of maps whose gaps are filled. A point is as far from the surface as
 * from the maps of its merged part, or from the triangles between maps and the cells at borders,
 * whichever are nearer. Points that are now farther off than they may be are no longer mapped.
 * Errors: OUT_OF_MEMORY, IO, CANCELLED, LIMIT. */
stp_status stp_maps_account(stp_maps *maps, const stp_cloud *cloud, const stp_maps_params *params,
                            const stp_map_owners *owners, stp_pool *pool, stp_error *err);

#endif

/* Turns whole pieces of surface whose points' signs agree already. Threads: one call at a time. */
#ifndef STP_PREPROCESS_TURNING_H
#define STP_PREPROCESS_TURNING_H

#include "preprocess/cloud.h"
#include "preprocess/forest.h"

/* Applies the forest's signs, turns points to where their outside is known to be and marks them
 * oriented; *oriented: how many. stations: of the points (NULL: none is known). A point faces its
 * station; one without goes with its piece, and the piece faces the stations of its points. Where
 * none is known it is turned outward by the sign of its volume if it is closed, that is, if its
 * area vectors cancel. Errors: OUT_OF_MEMORY. */
stp_status stp_turn_pieces(stp_cloud *cloud, stp_forest *forest, const stp_dvec3 *stations,
                           uint32_t *oriented, stp_error *err);
/* Turns those sheets of oriented points that are seen from their inside (visibility.h). Errors:
 * OUT_OF_MEMORY. */
stp_status stp_turn_seen(stp_cloud *cloud, const uint32_t *parts, stp_pool *pool, stp_error *err);

#endif

/* Turns whole pieces of surface whose points' signs agree already. Threads: one call at a time. */
#ifndef STP_PREPROCESS_TURNING_H
#define STP_PREPROCESS_TURNING_H

#include "preprocess/cloud.h"
#include "preprocess/forest.h"

/* Applies the forest's signs, turns closed pieces outward (by the sign of their volume) and marks
 * their points oriented; *oriented: how many. A piece is closed if its area vectors cancel. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_turn_outward(stp_cloud *cloud, stp_forest *forest, uint32_t *oriented,
                            stp_error *err);
/* Turns every point to a scanner's position, and those seen at a grazing angle with the piece they
 * are on. Errors: OUT_OF_MEMORY. */
stp_status stp_turn_to(stp_cloud *cloud, stp_forest *forest, stp_dvec3 position, stp_error *err);
/* Turns those sheets of oriented points that are seen from their inside (visibility.h). Errors:
 * OUT_OF_MEMORY. */
stp_status stp_turn_seen(stp_cloud *cloud, const uint32_t *parts, stp_pool *pool, stp_error *err);

#endif

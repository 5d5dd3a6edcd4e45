/* Parts a set of points by the plane through its middle, across its longest axis. Threads: any, on
 * separate arrays. */
#ifndef STP_PREPROCESS_MAPS_HALVE_H
#define STP_PREPROCESS_MAPS_HALVE_H

#include "preprocess/cloud/cloud.h"

/* Orders `count` places of the cloud, at least 2, so that the first half comes first; each half
 * keeps its order. Returns how many are in the first half: at least 1, at most count - 1. Equal
 * positions are parted by their order. scratch: room for `count`. */
uint32_t stp_places_halve(const stp_cloud *cloud, uint32_t *places, uint32_t count,
                          uint32_t *scratch);

#endif

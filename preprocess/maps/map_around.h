/* Finds the points around a part of a surface. Threads: any (reads the cloud). */
#ifndef STP_PREPROCESS_MAPS_MAP_AROUND_H
#define STP_PREPROCESS_MAPS_MAP_AROUND_H

#include "preprocess/cloud/cloud.h"

/* Finds all points of a sorted cloud with normals in the box, but for those at `count` places, at
 * least 1. places: ascending. *out: ascending, free with free(). Errors: OUT_OF_MEMORY. */
stp_status stp_places_around(const stp_cloud *cloud, const uint32_t *places, uint32_t count,
                             const stp_dbox *box, uint32_t **out, uint32_t *out_count,
                             stp_error *err);

#endif

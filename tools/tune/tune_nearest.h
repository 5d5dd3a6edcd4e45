/* Finds nearest points on the union of the level-0 discs of all leaves, exactly, with one leaf in
 * memory at a time. Drawn discs are judged by this surface, whatever errors the file stores.
 *
 * A disc without a normal is a ball here. Lines and triangles are left out. tests/support/promise.h
 * does the same with all discs in memory. World axes and units. Threads: one call at a time. */
#ifndef STP_TOOLS_TUNE_TUNE_NEAREST_H
#define STP_TOOLS_TUNE_TUNE_NEAREST_H

#include "base/pool.h"
#include "base/progress.h"
#include "formats/chunk/chunk_file.h"

typedef struct tune_probe {
    stp_dvec3 at;
    stp_dvec3 nearest;
    double distance; /* infinite if the model has no disc */
} tune_probe;

typedef struct tune_nearest_params {
    stp_chunk_file *file;
    const stp_chunk_entry *entries; /* by chunk id */
    uint32_t chunk_count;
    stp_pool *pool;
    const stp_progress *progress;
} tune_nearest_params;

/* Fills nearest and distance. Errors: those of reading leaves, CANCELLED, OUT_OF_MEMORY. */
stp_status tune_nearest_find(const tune_nearest_params *params, tune_probe *probes, size_t count,
                             stp_error *err);

#endif

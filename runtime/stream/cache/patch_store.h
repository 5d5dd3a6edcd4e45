/* Memory for what the CPU keeps of the patches on the GPU, by their numbers in the Object Texture:
 * whoever has a range of patch numbers has the memory of these patches, too. A frame reads some
 * hundred thousand of them, block by block. In blocks allocated one by one, most of a look's time
 * went into finding their pages; here pages are large where the system has such. Pages get memory
 * when they are written. Threads: any for stp_patch_store_at; ranges do not overlap. */
#ifndef STP_RUNTIME_STREAM_CACHE_PATCH_STORE_H
#define STP_RUNTIME_STREAM_CACHE_PATCH_STORE_H

#include "runtime/stream/stream.h"

/* Zero: no memory. */
typedef struct stp_patch_store {
    uint8_t *region;
    size_t region_bytes;
    uint32_t patch_capacity;
} stp_patch_store;

/* Errors: OUT_OF_MEMORY. */
stp_status stp_patch_store_create(stp_patch_store *out, uint32_t patch_capacity, stp_error *err);
void stp_patch_store_destroy(stp_patch_store *store);

/* Where the arrays of these patches are. The rest of the mirror is empty. */
stp_mirror stp_patch_store_at(const stp_patch_store *store, stp_range patches);

#endif

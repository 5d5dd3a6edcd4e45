/* A leaf's payload of codec 1 or 2 without its directory entry: where it ends, and what it holds.
 *
 * The number of patches, which the parent knows, is enough: each table or frame says how long it
 * is, and the patches how many rows or families follow. Threads: any. */
#ifndef STP_FORMATS_CHUNK_REPAIR_FOUND_PAYLOAD_H
#define STP_FORMATS_CHUNK_REPAIR_FOUND_PAYLOAD_H

#include "formats/chunk/repair/damaged.h"

/* Decodes the payload of patch_count patches and entry->codec at entry->offset, which ends at `end`
 * at the latest, and sets entry's segment_end, segment_hash, patch_count and sample_count. *out is
 * NULL if there is none. Errors: IO, OUT_OF_MEMORY. */
stp_status stp_found_payload(const stp_damaged *d, uint64_t end, uint32_t patch_count,
                             stp_chunk_entry *entry, stp_chunk **out, stp_error *err);

/* Order in the world: by x, then y, then z. */
static inline bool stp_found_before(stp_dvec3 a, stp_dvec3 b)
{
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
}

#endif

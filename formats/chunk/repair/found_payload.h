/* Finds where a leaf's payload of codec 1 to 6 ends, and what it holds, without its directory
 * entry.
 *
 * The parent knows the number of patches, and that is enough: each table or frame says how long it
 * is, and the patches say how many rows or families follow. In codecs 3 to 6, the segments' indices
 * say it all. Threads: any. */
#ifndef STP_FORMATS_CHUNK_REPAIR_FOUND_PAYLOAD_H
#define STP_FORMATS_CHUNK_REPAIR_FOUND_PAYLOAD_H

#include "formats/chunk/repair/damaged.h"

/* Decodes the payload at entry->offset, of patch_count patches and entry->codec, which ends at
 * `end` at the latest. Sets entry's segment_end, segment_hash, patch_count and sample_count. *out
 * is NULL if there is no payload. Errors: IO, OUT_OF_MEMORY. */
stp_status stp_found_payload(const stp_damaged *d, uint64_t end, uint32_t patch_count,
                             stp_chunk_entry *entry, stp_chunk **out, stp_error *err);

/* Order in the world: by x, then y, then z. */
static inline bool stp_found_before(stp_dvec3 a, stp_dvec3 b)
{
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
}

#endif

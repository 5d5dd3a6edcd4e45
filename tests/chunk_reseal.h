/* Makes all checksums of a chunk file's bytes right again after they were tampered with, so that
 * the code behind the checksums is reached. Follows offsets only where they stay inside the bytes.
 */
#ifndef STP_TESTS_CHUNK_RESEAL_H
#define STP_TESTS_CHUNK_RESEAL_H

#include "base/checked.h"
#include "formats/chunk/layout.h"

#include <stdbool.h>

static inline void reseal_segments(uint8_t *entry, const uint8_t *bytes, size_t size)
{
    uint64_t offset = stp_get_u64(entry);
    uint32_t begin = 0;
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        uint32_t end = stp_get_u32(entry + 8 + 4 * s);
        if (end < begin || !stp_range_inside(offset, end, size))
            return;
        stp_put_u64(entry + 24 + 8 * s, stp_hash(bytes + offset + begin, end - begin));
        begin = end;
    }
}

/* Bytes of a page: a whole one, or what is left before the end. */
static inline void reseal_directory(uint8_t *bytes, size_t size)
{
    uint64_t at = stp_get_u64(bytes + 32);
    uint32_t count = stp_get_u32(bytes + 16);
    uint32_t entry_bytes = stp_get_u32(bytes + 24);
    if (entry_bytes < STP_ENTRY_BYTES || entry_bytes > STP_ENTRY_BYTES_LIMIT)
        return;
    while (count > 0) {
        uint32_t here = count < STP_PAGE_ENTRIES ? count : STP_PAGE_ENTRIES;
        uint64_t hashed = (uint64_t)here * entry_bytes;
        if (!stp_range_inside(at, hashed + STP_HASH_BYTES, size))
            return;
        for (uint32_t i = 0; i < here; i++)
            reseal_segments(bytes + at + (uint64_t)i * entry_bytes, bytes, size);
        stp_put_u64(bytes + at + hashed, stp_hash(bytes + at, hashed));
        at += hashed + STP_HASH_BYTES;
        count -= here;
    }
}

/* file_bytes: also set the header's file size to size. */
static inline void reseal(uint8_t *bytes, size_t size, bool file_bytes)
{
    if (size < STP_HEADER_BYTES)
        return;
    uint32_t header_bytes = stp_get_u32(bytes + 12);
    uint64_t metadata = stp_get_u64(bytes + 40);
    uint64_t metadata_bytes = stp_get_u64(bytes + 48);
    reseal_directory(bytes, size);
    if (stp_range_inside(metadata, metadata_bytes, size))
        stp_put_u64(bytes + 56, stp_hash(bytes + metadata, metadata_bytes));
    if (file_bytes)
        stp_put_u64(bytes + 144, size);
    if (header_bytes >= STP_HEADER_BYTES && header_bytes <= size)
        stp_put_u64(bytes + header_bytes - STP_HASH_BYTES,
                    stp_hash(bytes, header_bytes - STP_HASH_BYTES));
}

#endif

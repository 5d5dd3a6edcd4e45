/* Unused bytes among the payloads of a file: the section FREE (formats/SPEC.md, "Unused bytes").
 *
 * Threads: any. */
#ifndef STP_FORMATS_CHUNK_FREE_RANGES_H
#define STP_FORMATS_CHUNK_FREE_RANGES_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/table/column.h"

typedef struct stp_free_range {
    uint64_t offset, bytes; /* in the file */
} stp_free_range;

/* Appends a record for each run of bytes of [begin, end) that belongs to no payload. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_free_ranges_find(const stp_chunk_entry *entries, uint32_t count, uint64_t begin,
                                uint64_t end, stp_bytes *out, stp_error *err);
/* Reads the ranges of a file, in order; *count is 0 if it has none. Free with free(). Errors: IO,
 * OUT_OF_MEMORY, CORRUPT (a checksum; ranges that are not in order, or not among the payloads). */
stp_status stp_free_ranges_read(const stp_chunk_file *file, stp_free_range **out, size_t *count,
                                stp_error *err);
/* The sum of the ranges. Errors: as reading. */
stp_status stp_free_ranges_sum(const stp_chunk_file *file, uint64_t *bytes, stp_error *err);

#endif

/* The table of blocks of a file of version 2: a record of STP_BLOCK_BYTES for each block. A view
 * reads only the records to choose a block, to find its bytes and to check them (formats/SPEC.md,
 * "The table of blocks").
 *
 * Pure conversions and checks. Threads: any. */
#ifndef STP_FORMATS_CHUNK_BLOCK_BLOCK_TABLE_H
#define STP_FORMATS_CHUNK_BLOCK_BLOCK_TABLE_H

#include "formats/chunk/block/block.h"
#include "formats/chunk/codec/table/column.h"

/* Appends the records of a chunk's blocks; none if its codec has no blocks. The payload is what the
 * chunk was encoded to, the entry has its codec, segment_end and box. Errors: LIMIT (a part is too
 * large), OUT_OF_MEMORY. */
stp_status stp_block_records_of(const stp_chunk *chunk, const uint8_t *payload,
                                const stp_chunk_entry *entry, stp_bytes *out, stp_error *err);

/* The same of a payload alone: decodes its segment 0. The entry has counts, too. *count: how many
 * blocks. Errors: those of decoding, LIMIT, OUT_OF_MEMORY. */
stp_status stp_block_records_make(const uint8_t *payload, const stp_chunk_entry *entry,
                                  stp_bytes *out, uint32_t *count, stp_error *err);

/* Appends the records of a chunk's entry->block_count blocks. Errors: LIMIT (a part is too large),
 * OUT_OF_MEMORY. */
stp_status stp_block_records_write(const stp_block *blocks, const stp_chunk_entry *entry,
                                   stp_bytes *out, stp_error *err);

/* Reads the records of a chunk's entry->block_count blocks, and places their parts. record_bytes:
 * of each, as stp_record_bytes has it. Errors: CORRUPT (a number is out of range, or the blocks do
 * not add up to the chunk). */
stp_status stp_block_records_read(const uint8_t *records, size_t record_bytes,
                                  const stp_chunk_entry *entry, uint32_t id, stp_block *out,
                                  stp_error *err);

#endif

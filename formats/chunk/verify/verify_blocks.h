/* Checks what a file of version 2 says of its header and blocks. Threads: any. */
#ifndef STP_FORMATS_CHUNK_VERIFY_VERIFY_BLOCKS_H
#define STP_FORMATS_CHUNK_VERIFY_VERIFY_BLOCKS_H

#include "formats/chunk/block/block.h"

/* Both copies of the header and all sections must be sound, and the records of blocks follow the
 * chunks' ids, so that each record belongs to one chunk. Errors: CORRUPT, IO, OUT_OF_MEMORY. */
stp_status stp_verify_sections(const stp_chunk_file *file, const stp_chunk_entry *entries,
                               stp_error *err);

/* Compares a decoded chunk with its records: counts, sizes and checksums of each block. *blocks
 * receives the entry's block_count blocks (free with free()); NULL if the chunk has none. Errors:
 * CORRUPT, IO, OUT_OF_MEMORY. */
stp_status stp_verify_blocks(stp_chunk_file *file, const stp_chunk *chunk,
                             const stp_chunk_entry *entry, stp_block **blocks, stp_error *err);

#endif

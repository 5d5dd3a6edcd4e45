/* Mends the sections of a damaged file of version 2, the table of blocks above all. */
#ifndef STP_FORMATS_CHUNK_REPAIR_LOST_SECTIONS_H
#define STP_FORMATS_CHUNK_REPAIR_LOST_SECTIONS_H

#include "formats/chunk/repair/damaged.h"

/* Sets an entry's block_count and blocks_hash from its payload, which is sound. Does nothing if its
 * codec has no blocks. Errors: IO, CORRUPT, OUT_OF_MEMORY. */
stp_status stp_lost_blocks_describe(const stp_damaged *d, stp_chunk_entry *entry, stp_error *err);

/* Puts flipped bits back in a chunk's payload, one in each part of a block, by the checksums in the
 * records of its blocks. lost[s]: a part of segment s cannot be mended. Does nothing if the chunk
 * has no blocks or their records are damaged. Errors: IO, OUT_OF_MEMORY, CANCELLED. */
stp_status stp_lost_blocks_mend(stp_damaged *d, uint32_t id, bool lost[STP_SEGMENT_COUNT],
                                stp_error *err);

/* Once the directory is read: puts flipped bits back, and makes damaged records of blocks anew from
 * their chunk's payload. Sets d->sections_lost if that does not do. Errors: IO, OUT_OF_MEMORY,
 * CANCELLED. */
stp_status stp_lost_sections_mend(stp_damaged *d, stp_error *err);

#endif

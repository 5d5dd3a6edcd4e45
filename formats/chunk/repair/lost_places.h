/* Finds the sections of a file whose headers are lost. Threads: one call at a time per file. */
#ifndef STP_FORMATS_CHUNK_REPAIR_LOST_PLACES_H
#define STP_FORMATS_CHUNK_REPAIR_LOST_PLACES_H

#include "formats/chunk/repair/damaged.h"

/* Places the sections of d->header, whose metadata_offset is the end of the payloads, and moves
 * metadata_offset behind them. The table of blocks is found by the checksum that the root's entry
 * has of its records, or by its own: else it is taken for all that lies between the payloads and
 * the metadata. What lies before it is the numbers of attributes, whose table follows the blocks'.
 * Hashes stay 0. Errors: IO, OUT_OF_MEMORY. */
stp_status stp_lost_places_find(stp_damaged *d, uint64_t block_count,
                                const uint8_t root[STP_ENTRY_BYTES], stp_error *err);

#endif

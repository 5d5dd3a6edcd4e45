/* Whether a chunk agrees with its directory entry and with what the file says it has.
 *
 * What all who read chunks rely on and no payload alone shows; asked once, where a chunk is decoded
 * (SPEC.md, "Who checks what"). Does not compare errors, boxes and radii: verify does. Threads:
 * any. */
#ifndef STP_FORMATS_CHUNK_CHUNK_FAULT_H
#define STP_FORMATS_CHUNK_CHUNK_FAULT_H

#include "formats/chunk/chunk_file.h"

/* What is wrong, NULL where nothing is; *patch is where, STP_CHUNK_NONE for the whole chunk.
 * attributes: STP_HAS_* of the file. Levels that the chunk was not read with are left out. */
const char *stp_chunk_fault(const stp_chunk *chunk, const stp_chunk_entry *entry,
                            uint32_t attributes, uint32_t *patch);

#endif

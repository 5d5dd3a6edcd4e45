/* Checks a decoded chunk against its directory entry and the file's attributes.
 *
 * Every reader of chunks relies on these facts, and no payload alone shows them; they are checked
 * once, where a chunk is decoded (SPEC.md, "Who checks what"). Errors, boxes and radii are not
 * compared here: verify does that. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CHUNK_FAULT_H
#define STP_FORMATS_CHUNK_CHUNK_FAULT_H

#include "formats/chunk/chunk_file.h"

/* Returns what is wrong, or NULL. *patch is the patch at fault, STP_CHUNK_NONE for the whole chunk.
 * attributes: STP_HAS_* of the file. A chunk of fewer patches than the entry has is a block of it:
 * whether each child is named is then not checked. Levels that the chunk was not read with are not
 * checked. */
const char *stp_chunk_fault(const stp_chunk *chunk, const stp_chunk_entry *entry,
                            uint32_t attributes, uint32_t *patch);

#endif

/* Checks the joint between a chunk and one of its children: both must hold the same samples. */
#ifndef STP_FORMATS_CHUNK_VERIFY_VERIFY_JOIN_H
#define STP_FORMATS_CHUNK_VERIFY_VERIFY_JOIN_H

#include "formats/chunk/chunk_file.h"

/* Compares, as multisets, the level-0 samples of the parent's patches that name child_index with
 * the child's level 3: world position (as doubles), radius, normal, colour, intensity, class and
 * flags. If the parent is linked, compares them one by one. Sets *fault to NULL or to what is
 * wrong, and *patch to the parent's patch or STP_CHUNK_NONE. Errors: OUT_OF_MEMORY. */
stp_status stp_verify_join(const stp_chunk *parent, const stp_chunk_entry *parent_entry,
                           uint32_t child_index, const stp_chunk *child,
                           const stp_chunk_entry *child_entry, const char **fault, uint32_t *patch,
                           stp_error *err);

#endif

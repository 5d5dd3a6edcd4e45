/* Numbers the chunks of a file: handles, in the order of writing, become ids, breadth first from
 * the root. Threads: any (pure functions). */
#ifndef STP_FORMATS_CHUNK_CHUNK_TREE_H
#define STP_FORMATS_CHUNK_CHUNK_TREE_H

#include "formats/chunk/chunk_file.h"

typedef struct stp_chunk_tree {
    uint32_t *handle;         /* by id */
    stp_chunk_entry *entries; /* by id, with parent, children and depth filled in */
    uint32_t count;
    uint32_t depth; /* 1: the root alone */
} stp_chunk_tree;

/* entries: count of them, by handle. children[h]: the handles of the children of h, child_counts[h]
 * of them. Free *out with stp_chunk_tree_clear, also on failure. Errors: INVALID_ARGUMENT (no
 * tree), LIMIT, OUT_OF_MEMORY. */
stp_status stp_chunk_tree_number(const stp_chunk_entry *entries, size_t count, uint32_t root,
                                 const uint32_t *const *children, const uint32_t *child_counts,
                                 stp_chunk_tree *out, stp_error *err);
void stp_chunk_tree_clear(stp_chunk_tree *tree);

#endif

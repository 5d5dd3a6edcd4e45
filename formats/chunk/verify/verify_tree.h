/* The part of verify that needs only the directory: the tree, sums, and payloads that tile the
 * file.
 *
 * Also gives the whole directory to the rest of verify. Threads: one per call. */
#ifndef STP_FORMATS_CHUNK_VERIFY_VERIFY_TREE_H
#define STP_FORMATS_CHUNK_VERIFY_VERIFY_TREE_H

#include "formats/chunk/chunk_file.h"

/* Reads all entries (as many as info says; free with free()) and checks them against each other.
 * Errors: CORRUPT, IO, OUT_OF_MEMORY. */
stp_status stp_verify_tree(stp_chunk_file *file, stp_chunk_entry **entries, stp_error *err);
/* Checks that entries form a tree, so that code can follow their links. Errors: CORRUPT. */
stp_status stp_verify_tree_entries(const stp_chunk_file *file, const stp_chunk_entry *entries,
                                   stp_error *err);

#endif

/* The part of verify that needs the directory alone: tree, sums, and that payloads tile the file.
 *
 * Also gives the whole directory to the rest of verify. Threads: one per call. */
#ifndef STP_FORMATS_CHUNK_VERIFY_VERIFY_TREE_H
#define STP_FORMATS_CHUNK_VERIFY_VERIFY_TREE_H

#include "formats/chunk/chunk_file.h"

/* Reads all entries (as many as info says; free with free()) and checks them against each other.
 * Errors: CORRUPT, IO, OUT_OF_MEMORY. */
stp_status stp_verify_tree(stp_chunk_file *file, stp_chunk_entry **entries, stp_error *err);
/* That entries which were read make a tree: what following them relies on. Errors: CORRUPT. */
stp_status stp_verify_tree_entries(const stp_chunk_file *file, const stp_chunk_entry *entries,
                                   stp_error *err);

#endif

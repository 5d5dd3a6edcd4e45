/* The file that several ranks write: each rank the payloads of its own chunks, at their places, and
 * rank 0 the rest.
 *
 * The other ranks open the file by a temporary name, until rank 0 gives the file its own. All ranks
 * call the same functions. Errors: IO, CANCELLED, OUT_OF_MEMORY. */
#ifndef STP_PREPROCESS_TREE_TIER_FILE_H
#define STP_PREPROCESS_TREE_TIER_FILE_H

#include "preprocess/tree/tier_chunk.h"

typedef struct stp_tier_file {
    stp_ranks *ranks;
    char *path;     /* owned; NULL: not open */
    int descriptor; /* of the ranks but 0 */
    uint64_t end;   /* where the next payload goes */
} stp_tier_file;

/* Opens the file of a writer, which is NULL on the ranks but 0. */
stp_status stp_tier_file_open(stp_tier_file *out, const stp_chunk_writer *writer, stp_ranks *ranks,
                              stp_error *err);
/* Writes the payloads of this rank's chunks of a tier, unless it is rank 0, whose writer appends
 * them; and frees them. */
stp_status stp_tier_file_write(stp_tier_file *file, stp_tier_chunk *tier, uint32_t count,
                               stp_spill *spill, stp_error *err);
/* Waits until all payloads are on the disk. */
stp_status stp_tier_file_sync(stp_tier_file *file, stp_error *err);
void stp_tier_file_close(stp_tier_file *file);

#endif

/* Checks the attributes of a file: each number can be decoded, and every byte of the section
 * belongs to one part. Threads: one call at a time per worker. */
#ifndef STP_FORMATS_CHUNK_VERIFY_VERIFY_NUMBERS_H
#define STP_FORMATS_CHUNK_VERIFY_VERIFY_NUMBERS_H

#include "formats/chunk/attribute/attribute_file.h"

#include <stdatomic.h>

typedef struct stp_verify_numbers {
    stp_chunk_file *file;
    stp_attribute_file **readers; /* by worker */
    unsigned worker_count;
    atomic_uint_least64_t bytes; /* of all parts so far */
} stp_verify_numbers;

/* Reads the list once for each worker. Clear *out also after a failure. Errors: IO, CORRUPT,
 * OUT_OF_MEMORY. */
stp_status stp_verify_numbers_begin(stp_verify_numbers *out, stp_chunk_file *file,
                                    unsigned worker_count, stp_error *err);
/* Checks a chunk that is decoded to level 0. Errors: IO, CORRUPT, OUT_OF_MEMORY. */
stp_status stp_verify_numbers_chunk(stp_verify_numbers *v, const stp_chunk *chunk, unsigned worker,
                                    stp_error *err);
/* When all chunks are checked. Errors: CORRUPT. */
stp_status stp_verify_numbers_end(const stp_verify_numbers *v, stp_error *err);
void stp_verify_numbers_clear(stp_verify_numbers *v);

#endif

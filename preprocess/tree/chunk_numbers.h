/* The attributes of a built chunk, encoded. Threads: any, one chunk each. */
#ifndef STP_PREPROCESS_TREE_CHUNK_NUMBERS_H
#define STP_PREPROCESS_TREE_CHUNK_NUMBERS_H

#include "formats/chunk/attribute/attribute_encode.h"
#include "preprocess/tree/chunk_build.h"
#include "preprocess/tree/tree.h"

/* As stp_chunk_writer_append_numbers takes them. Zero is none. */
typedef struct stp_chunk_numbers {
    void *bytes; /* in the spill */
    size_t size;
    stp_attribute_row *rows; /* by attribute */
} stp_chunk_numbers;

/* Encodes the chunk's attributes and gives its vertices the sources that they borrow. rows: the
 * numbers by level-0 sample; NULL: those of `numbers` by source. Clear *out also after a failure.
 * Errors: OUT_OF_MEMORY, IO, INTERNAL. */
stp_status stp_chunk_numbers_make(stp_chunk_numbers *out, stp_built_chunk *built,
                                  const stp_point_numbers *numbers, const uint8_t *rows,
                                  stp_spill *spill, stp_error *err);
void stp_chunk_numbers_clear(stp_chunk_numbers *numbers, stp_spill *spill);

#endif

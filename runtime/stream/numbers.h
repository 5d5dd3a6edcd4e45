/* Reads the numbers of one attribute for decoded blocks.
 *
 * The numbers of a chunk are read when the first of its blocks asks, and kept for the others: at
 * most STP_NUMBERS_CHUNKS chunks, each number in as many bytes as its type has. An attribute that
 * is in the samples coarsely (16-bit colours) needs the samples of the whole chunk: they are read
 * with it. Threads: one at a time; the caller locks. */
#ifndef STP_RUNTIME_STREAM_NUMBERS_H
#define STP_RUNTIME_STREAM_NUMBERS_H

#include "formats/chunk/attribute/attribute_file.h"
#include "formats/chunk/block.h"

#define STP_NUMBERS_CHUNKS 64u

typedef struct stp_numbers stp_numbers;

/* A decoded block, and all blocks of its chunk, of which it is `index`. */
typedef struct stp_numbers_block {
    const stp_block *blocks;
    uint32_t index, count;
    const stp_chunk *chunk; /* the block's patches and samples */
} stp_numbers_block;

/* Both are borrowed. Errors: OUT_OF_MEMORY. */
stp_status stp_numbers_create(stp_numbers **out, stp_chunk_file *file,
                              stp_attribute_file *attributes, uint32_t index, stp_error *err);
/* Reads the numbers of a level of a block. above: those of the next coarser level; not used for
 * level 3. words: by sample. Errors: IO, CORRUPT, CANCELLED, OUT_OF_MEMORY. */
stp_status stp_numbers_read(stp_numbers *numbers, const stp_numbers_block *block, int level,
                            const uint64_t *above, uint64_t *words, stp_error *err);
void stp_numbers_destroy(stp_numbers **numbers);

#endif

/* Reads the numbers of one attribute for decoded blocks.
 *
 * The numbers of a chunk are read when the first of its blocks asks, and kept for the others: at
 * most STP_NUMBERS_CHUNKS chunks, each number in as many bytes as its type has. An attribute that
 * is in the samples coarsely (16-bit colours) needs the samples of the whole chunk: they are read
 * with it. Threads: one at a time; the caller locks. */
#ifndef STP_RUNTIME_STREAM_NUMBERS_H
#define STP_RUNTIME_STREAM_NUMBERS_H

#include "formats/chunk/attribute/attribute_file.h"
#include "formats/chunk/block/block.h"

#define STP_NUMBERS_CHUNKS 64u

typedef struct stp_numbers stp_numbers;

/* A decoded block: number `index` of all blocks of its chunk. */
typedef struct stp_numbers_block {
    const stp_block *blocks;
    uint32_t index, count;
    const stp_chunk *chunk; /* the block's patches and samples */
} stp_numbers_block;

/* Both are borrowed. Errors: OUT_OF_MEMORY. */
stp_status stp_numbers_create(stp_numbers **out, stp_chunk_file *file,
                              stp_attribute_file *attributes, uint32_t index, stp_error *err);
/* The numbers of the level that was read last, by sample of the block, and those of the level above
 * it. Starts zeroed. */
typedef struct stp_numbers_words {
    uint64_t *own, *above;
} stp_numbers_words;

/* Makes room for all levels of the block. Free *out even after a failure. Errors: OUT_OF_MEMORY. */
stp_status stp_numbers_words_create(stp_numbers_words *out, const stp_numbers_block *block,
                                    stp_error *err);
void stp_numbers_words_free(stp_numbers_words *words);
/* Reads the numbers of a level of a block: level 3 first, then each next finer one. Errors: IO,
 * CORRUPT, CANCELLED, OUT_OF_MEMORY. */
stp_status stp_numbers_read(stp_numbers *numbers, const stp_numbers_block *block, int level,
                            stp_numbers_words *words, stp_error *err);
void stp_numbers_destroy(stp_numbers **numbers);

#endif

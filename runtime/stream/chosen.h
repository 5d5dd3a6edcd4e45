/* Chooses by a condition which samples of a model are drawn: marks the others when a block is
 * decoded. Shaders drop marked samples as they drop samples of hidden classes.
 *
 * Every sample of every level is asked by itself. A merged sample has its own colour, intensity and
 * class, and the attributes of one of its points (formats/chunk/attribute/attribute_order.h).
 *
 * The mark is a pair of flags that no sample of a file has: closed, but without a normal. Threads:
 * any; a lock guards the numbers. */
#ifndef STP_RUNTIME_STREAM_CHOSEN_H
#define STP_RUNTIME_STREAM_CHOSEN_H

#include "runtime/stream/numbers.h"

typedef struct stp_chosen stp_chosen;

/* The file is borrowed. Errors: INVALID_ARGUMENT (no condition, or a name that the file does not
 * have; the message says where, and which there are), those of reading. */
stp_status stp_chosen_create(stp_chosen **out, stp_chunk_file *file, const char *condition,
                             stp_error *err);
/* Marks the samples of a decoded block that do not fulfil the condition. chunk: the block's, as in
 * *block. Errors: IO, CORRUPT, CANCELLED, OUT_OF_MEMORY. */
stp_status stp_chosen_mark(stp_chosen *chosen, const stp_numbers_block *block, stp_chunk *chunk,
                           stp_error *err);
void stp_chosen_destroy(stp_chosen **chosen);

/* shaders/project/patch.glsl, stp_sample_marked, asks the same. */
static inline bool stp_sample_marked(const stp_sample *sample)
{
    return (sample->flags & (STP_SAMPLE_HAS_NORMAL | STP_SAMPLE_CLOSED)) == STP_SAMPLE_CLOSED;
}

/* Bit l: all samples of level l of a patch are marked, or the chunk is not decoded to it. */
unsigned stp_chosen_empty(const stp_chunk *chunk, uint32_t patch);

#endif

/* Where a chunk is cut into blocks: between the patches that one patch of the parent stands for and
 * the next, so that no patch of the parent stands for patches of two blocks. Threads: any. */
#ifndef STP_FORMATS_CHUNK_BLOCK_BLOCK_CUT_H
#define STP_FORMATS_CHUNK_BLOCK_BLOCK_CUT_H

#include "formats/chunk/chunk_file.h"

/* The least level-0 samples of a block that pays, for a codec. */
uint32_t stp_block_samples_least(stp_codec codec);

/* Cuts a chunk at some of the run_ends, ascending: the patches up to each are what patches of the
 * parent stand for. Sets chunk->block_ends. A block has at least `least` level-0 samples,
 * the last one half of it. Errors: OUT_OF_MEMORY. */
stp_status stp_chunk_cut(stp_chunk *chunk, const uint32_t *run_ends, uint32_t run_count,
                         uint32_t least, stp_error *err);

/* The same with the chunk's linked parent, decoded down to level 2. child: which of the parent's
 * children the chunk is. If the parent's patches do not cover the chunk once, leaves it whole. */
stp_status stp_chunk_cut_by_parent(stp_chunk *chunk, const stp_chunk *parent, uint32_t child,
                                   uint32_t least, stp_error *err);

#endif

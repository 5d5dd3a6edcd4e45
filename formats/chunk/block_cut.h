/* Where a chunk is cut into blocks: between the patches that one patch of the parent stands for and
 * the next, so that no patch of the parent stands for patches of two blocks. Threads: any. */
#ifndef STP_FORMATS_CHUNK_BLOCK_CUT_H
#define STP_FORMATS_CHUNK_BLOCK_CUT_H

#include "formats/chunk/chunk_file.h"

/* Cuts a chunk at some of the run_ends, ascending: the patches up to each are what patches of the
 * parent stand for. Sets chunk->block_ends. A block has at least as many samples as the codec
 * asks for: smaller blocks cost too many bytes. Errors: OUT_OF_MEMORY. */
stp_status stp_chunk_cut(stp_chunk *chunk, const uint32_t *run_ends, uint32_t run_count,
                         stp_codec codec, stp_error *err);

/* The same by the chunk's linked parent, of which level 2 is enough. child: which of its children
 * the chunk is. If the parent's patches do not cover the chunk once, leaves it whole. */
stp_status stp_chunk_cut_by_parent(stp_chunk *chunk, const stp_chunk *parent, uint32_t child,
                                   stp_codec codec, stp_error *err);

#endif

/* The squares of a block that is to be written, and their map. Threads: any, one block each. */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_BLOCK_SQUARES_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_BLOCK_SQUARES_H

#include "formats/chunk/codec/square/square_map.h"

typedef struct stp_block_squares {
    stp_square *of, *own; /* by patch; own: to be freed */
    stp_square_map map;
    bool kept;  /* the map belongs to the block */
    bool found; /* false: the block is coded as points */
} stp_block_squares;

/* Finds the squares and makes their map, or takes those that segment 0 left in the block, if it has
 * room for them. Clear *out also after a failure. Errors: OUT_OF_MEMORY. */
stp_status stp_block_squares_find(const stp_chunk *block, int segment, stp_block_squares *out,
                                  stp_error *err);
void stp_block_squares_clear(stp_block_squares *s);

#endif

/* Codes the colours of level 0 of squares by rows, each sample by those around it that come
 * before, by its parent and by its other channels. What these tell is learned on the way.
 *
 * formats/SPEC.md, "Colours by rows", has the arithmetic. Encoding and decoding run the same code.
 * Threads: any, one map each. */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_SQUARE_COLOURS_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_SQUARE_COLOURS_H

#include "formats/chunk/codec/odds/tight.h"
#include "formats/chunk/codec/square/square_map.h"

/* Whether the colours of level 0 are smaller by rows than in families: not if they are noise, or
 * all equal; and if so, by parents, too: not if neighbours tell little. Level 1 of the block must
 * be there. Errors: OUT_OF_MEMORY. */
stp_status stp_square_colours_pay(const stp_chunk *block, const stp_square_map *map, bool *pay,
                                  bool *by_parents, stp_error *err);

/* Level 0, behind its tables; level 1 of the block must be there. Errors: OUT_OF_MEMORY. */
stp_status stp_square_colours_encode(const stp_chunk *block, const stp_square_map *map,
                                     bool by_parents, stp_symbol_writer *w, stp_error *err);
/* by_parents: as the choice says. What does not fit into the bytes, the reader tells at their end.
 * Errors: CORRUPT, OUT_OF_MEMORY. */
stp_status stp_square_colours_decode(const stp_chunk *block, const stp_square_map *map,
                                     bool by_parents, stp_tight_reader *tight, stp_error *err);

#endif

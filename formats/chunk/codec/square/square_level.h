/* Codes the levels of a block of squares as columns of small numbers: predicts samples from their
 * parents, from slopes between the parents, and normals from heights.
 *
 * Columns and tables are those of predict.h; level 3 is coded as it says. formats/SPEC.md,
 * "Squares", has the arithmetic. Encoding and decoding run the same code. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_SQUARE_LEVEL_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_SQUARE_LEVEL_H

#include "formats/chunk/codec/predict/predict.h"
#include "formats/chunk/codec/square/ladder.h"
#include "formats/chunk/codec/square/square_choice.h"

/* Levels 0 to 2. The next coarser level of the block must be there. ladder: of level 0; NULL:
 * heights are coded as numbers. Encoding sets choice->follow, and the reach to what is best: 0,
 * parents, or what it was. */
void stp_square_level_encode(const stp_chunk *block, int level, stp_square_map *map,
                             const stp_ladder *ladder, stp_square_choice *choice,
                             const stp_level_tables *tables);
void stp_square_level_decode(stp_chunk *block, int level, stp_square_map *map,
                             const stp_ladder *ladder, const stp_square_choice *choice,
                             const stp_level_tables *tables);

#endif

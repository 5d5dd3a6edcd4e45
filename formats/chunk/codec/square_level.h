/* Codes the levels of a block of squares as columns of small numbers: predicts samples from their
 * parents, from slopes between the parents, and normals from heights.
 *
 * Columns and tables are those of predict.h; level 3 is coded as it says. formats/SPEC.md,
 * "Squares", has the arithmetic. Encoding and decoding run the same code. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_LEVEL_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_LEVEL_H

#include "formats/chunk/codec/predict.h"
#include "formats/chunk/codec/square_map.h"

/* What the writer chooses for a level: a byte. */
typedef struct stp_square_choice {
    unsigned reach; /* of the windows of normals, 1 to 4; 0: none, normals follow from slopes */
    bool follow;    /* red and blue change as green does */
    bool tight;     /* the tables that follow are one run (tight.h) */
} stp_square_choice;

#define STP_SQUARE_CHOICE_BYTES 1u

uint8_t stp_square_choice_write(const stp_square_choice *choice);
bool stp_square_choice_is_tight(uint8_t byte);
/* Errors: CORRUPT. */
stp_status stp_square_choice_read(uint8_t byte, stp_square_choice *out, stp_error *err);

/* Levels 0 to 2. The next coarser level of the block must be there. Encoding sets choice->follow,
 * and the reach to what is best: 0, parents, or what it was. */
void stp_square_level_encode(const stp_chunk *block, int level, stp_square_map *map,
                             stp_square_choice *choice, const stp_level_tables *tables);
void stp_square_level_decode(stp_chunk *block, int level, stp_square_map *map,
                             const stp_square_choice *choice, const stp_level_tables *tables);

#endif

/* Pieces of a patch that no surface joins: folds that only lie near each other, and the sides of a
 * sharp crease. Samples merged across would stand for the air between them. Threads: any. */
#ifndef STP_PREPROCESS_PIECES_H
#define STP_PREPROCESS_PIECES_H

#include "formats/chunk/sample.h"
#include "preprocess/partition.h"

/* Numbers the pieces of at most STP_PATCH_SAMPLES places, piece[i] of places[i]; returns how many.
 * The first place's piece is 0. The time grows with the square of the count. */
unsigned stp_pieces_number(const stp_place *places, uint32_t count, uint8_t *piece);

#endif

/* Pieces of a patch that no surface joins: folds that only lie near each other, or the sides of a
 * sharp crease. A merged sample across two pieces would stand for the air between them. Threads:
 * any. */
#ifndef STP_PREPROCESS_PATCH_PIECES_H
#define STP_PREPROCESS_PATCH_PIECES_H

#include "formats/chunk/sample/sample.h"
#include "preprocess/patch/partition.h"

/* Returns the number of pieces of the places order[0, count), count at most STP_PATCH_SAMPLES. Sets
 * in *first the bits of the places in the first place's piece. Time grows with the square of count.
 */
unsigned stp_pieces_count(const stp_place *places, const uint32_t *order, uint32_t count,
                          uint64_t *first);

#endif

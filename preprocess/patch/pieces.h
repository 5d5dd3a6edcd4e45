/* Pieces of a patch that no surface joins: folds that only lie near each other, and the sides of a
 * sharp crease. Samples merged across would stand for the air between them. Threads: any. */
#ifndef STP_PREPROCESS_PATCH_PIECES_H
#define STP_PREPROCESS_PATCH_PIECES_H

#include "formats/chunk/sample.h"
#include "preprocess/patch/partition.h"

/* Returns in how many pieces the places order[0, count) lie, at most STP_PATCH_SAMPLES, and sets a
 * bit in *first for each that is in the piece of the first. The time grows with the square of the
 * count. */
unsigned stp_pieces_count(const stp_place *places, const uint32_t *order, uint32_t count,
                          uint64_t *first);

#endif

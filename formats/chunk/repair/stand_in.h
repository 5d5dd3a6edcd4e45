/* Builds leaf chunks that stand in for lost ones.
 *
 * If a leaf still has coarser levels, they become its finer ones. If it has nothing, it gets the
 * finest samples that its parent has in its place. Stored errors stay as they were, over the lost
 * points. Threads: any (pure functions). */
#ifndef STP_FORMATS_CHUNK_REPAIR_STAND_IN_H
#define STP_FORMATS_CHUNK_REPAIR_STAND_IN_H

#include "formats/chunk/chunk_file.h"

/* A leaf whose levels are those of `in` from in->finest_level (1 or 2) on. Perpendicular and colour
 * errors also hold over its own level 0. Errors: OUT_OF_MEMORY. */
stp_status stp_stand_in_coarse(const stp_chunk *in, stp_chunk **out, stp_error *err);

/* A leaf of one-sample patches. Its samples are those of parent->finest_level in the parent's
 * patches that name child_index, in the parent's coordinates. If the parent is linked and has level
 * 0, they are in the order of its links. Errors: OUT_OF_MEMORY; EMPTY: no patch names child_index.
 */
stp_status stp_stand_in_samples(const stp_chunk *parent, uint32_t child_index, stp_chunk **out,
                                stp_error *err);

/* Raises the errors of a patch's levels and quarters, from level 0 on, to at least these codes.
 * True if one was less. */
bool stp_patch_raise(stp_patch *patch, uint8_t error, uint8_t tangential_error);

#endif

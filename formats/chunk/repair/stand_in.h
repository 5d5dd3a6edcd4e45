/* Leaf chunks in place of ones that are lost.
 *
 * What a leaf still has of coarser levels becomes its finer ones; of a leaf that has nothing, the
 * finest samples that its parent has in its place. Stored errors stay what they were: over the
 * points that are lost. Threads: any (pure functions). */
#ifndef STP_FORMATS_CHUNK_REPAIR_STAND_IN_H
#define STP_FORMATS_CHUNK_REPAIR_STAND_IN_H

#include "formats/chunk/chunk_file.h"

/* A leaf whose levels are those of `in` from in->finest_level (1 or 2) on. Perpendicular and colour
 * errors hold over its own level 0, too. Errors: OUT_OF_MEMORY. */
stp_status stp_stand_in_coarse(const stp_chunk *in, stp_chunk **out, stp_error *err);

/* A leaf of one-sample patches: the samples of parent->finest_level of those of its patches that
 * name child_index, in the parent's coordinates; of a linked parent's level 0 in the order that its
 * links say. Errors: OUT_OF_MEMORY; EMPTY: no patch names it. */
stp_status stp_stand_in_samples(const stp_chunk *parent, uint32_t child_index, stp_chunk **out,
                                stp_error *err);

/* Raises the errors of a patch's levels and quarters from level 0 on to at least these codes. True
 * if one was less. */
bool stp_patch_raise(stp_patch *patch, uint8_t error, uint8_t tangential_error);

#endif

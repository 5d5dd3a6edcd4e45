/* Cuts an ordered list of patches, not made yet, into leaf chunks.
 *
 * Threads: one at a time. */
#ifndef STP_PREPROCESS_TREE_LEAF_CUT_H
#define STP_PREPROCESS_TREE_LEAF_CUT_H

#include "base/error.h"
#include "base/vec.h"

#include <stdint.h>

/* Most patches of a leaf. */
#define STP_LEAF_PATCHES 1000u

/* The extent of patches: the world box of their vertices, and the exponents of their lattices. */
typedef struct stp_leaf_extent {
    stp_dbox box;
    int finest, coarsest;
} stp_leaf_extent;

/* Patches [begin, end) are a leaf. */
typedef struct stp_leaf_run {
    uint32_t begin, end;
    stp_dvec3 middle, origin; /* of its box; of its chunk, for stp_chunk_build_made */
} stp_leaf_run;

typedef stp_leaf_extent stp_extent_of(const void *context, uint32_t patch);

/* Ends a leaf when it has STP_LEAF_PATCHES patches, or when the next patch's lattice and place do
 * not fit with the others'. *out: free with free(). Errors: OUT_OF_MEMORY. */
stp_status stp_leaf_cut(stp_leaf_run **out, uint32_t *count, uint32_t patch_count,
                        stp_extent_of *extent_of, const void *context, stp_error *err);

#endif

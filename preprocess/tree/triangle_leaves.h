/* Makes leaf chunks from triangles: patches of up to 21 triangles near each other, and patches near
 * each other in one leaf.
 *
 * All triangles are held in memory, plus about 20 bytes each and 2 per vertex. A triangle with a
 * corner that does not exist or is not finite is dropped and counted. A vertex has one position in
 * all patches, so there are no cracks. Threads: one maker; leaves may be built on any. */
#ifndef STP_PREPROCESS_TREE_TRIANGLE_LEAVES_H
#define STP_PREPROCESS_TREE_TRIANGLE_LEAVES_H

#include "preprocess/patch/triangle_build.h"
#include "preprocess/tree/chunk_build.h"
#include "preprocess/tree/leaf_cut.h"

typedef struct stp_triangle_counts {
    uint64_t triangles; /* stored triangles, three samples each */
    uint64_t rejected;
} stp_triangle_counts;

typedef struct stp_triangle_leaves {
    stp_triangle_source source; /* owns order and exponents */
    stp_triangle_part *parts;
    uint32_t part_count;
    stp_leaf_run *leaves; /* of parts */
    uint32_t leaf_count;
    uint16_t intensity_max; /* of all corners */
    stp_triangle_counts counts;
    stp_dbox box; /* of all corners */
} stp_triangle_leaves;

/* Cuts the triangles into leaves. set: borrowed as long as the leaves are used. side: the longest
 * of the model's box. Errors: OUT_OF_MEMORY, LIMIT. */
stp_status stp_triangle_leaves_create(stp_triangle_leaves *out, const stp_triangle_set *set,
                                      double precision, double side, stp_error *err);
/* Builds one leaf. intensity_max: what 255 stands for. Errors: OUT_OF_MEMORY, LIMIT. */
stp_status stp_triangle_leaf_build(const stp_triangle_leaves *leaves, uint32_t leaf,
                                   uint16_t intensity_max, stp_built_chunk *out, stp_error *err);
void stp_triangle_leaves_clear(stp_triangle_leaves *leaves);

#endif

/* A chunk out of items: patches of neighbours, child by child, and the vertices for its parent.
 * First all chunks of a tier are built; then tangential errors are measured, for which a chunk's
 * neighbours count. Threads: any, one chunk each. */
#ifndef STP_PREPROCESS_TREE_CHUNK_BUILD_H
#define STP_PREPROCESS_TREE_CHUNK_BUILD_H

#include "base/spill.h"
#include "formats/chunk/measure/surroundings.h"
#include "preprocess/patch/displacement.h"
#include "preprocess/patch/patch_build.h"

/* Items that one child chunk refines (all items of a leaf: one group). */
typedef struct stp_item_group {
    const stp_item *items;
    /* Which runs of items become patches, linked to the child's; NULL: that is to be found. Of all
     * groups or of none. */
    const uint32_t *run_ends;
    uint32_t count, run_count; /* of items, of runs */
} stp_item_group;

/* What the items of a chunk have at most. */
typedef struct stp_chunk_extent {
    stp_dbox box; /* world */
    double area, bound;
    int finest, coarsest; /* exponents of lattices */
} stp_chunk_extent;

/* Of no items, whose patches' vertices have no finer lattice than vertex_least. */
stp_chunk_extent stp_chunk_extent_none(int vertex_least);
void stp_chunk_extent_add(stp_chunk_extent *e, stp_dvec3 centre, double area, double bound,
                          int exponent);
/* Whether a chunk can hold them: whether its patches' origins can be told in steps of any of the
 * lattices. */
bool stp_chunk_extent_fits(const stp_chunk_extent *e);

typedef struct stp_built_chunk {
    stp_chunk *chunk;
    stp_dvec3 origin;
    stp_carry *carry;   /* by level-0 sample; of a leaf NULL */
    stp_item *vertices; /* one a patch, in the chunk's order */
    uint32_t vertex_count;
    uint32_t *run_ends; /* which runs of vertices become the parent's patches */
    uint32_t run_count;
    stp_spill *spill;              /* where carry, vertices and all of the chunk's arrays lie */
    void *chunk_arrays;            /* in the spill's files; NULL: the chunk has its own memory */
    stp_displacement displacement; /* of a leaf out of points */
} stp_built_chunk;

/* Makes patch `index` of a leaf with all its levels, and its vertex. */
typedef stp_status stp_patch_maker(const void *context, uint32_t index, stp_dvec3 chunk_origin,
                                   stp_patch *patch, stp_patch_samples *samples, stp_item *vertex,
                                   stp_error *err);

/* A leaf of patches that are made elsewhere, at least 1, in the order of their vertices' runs.
 * origin: a multiple of twice every lattice of the patches and their vertices. Errors: those of
 * `make`, OUT_OF_MEMORY. Free with stp_built_chunk_clear. */
stp_status stp_chunk_build_made(stp_built_chunk *out, stp_dvec3 origin, uint32_t patch_count,
                                stp_patch_maker *make, const void *context, stp_error *err);
/* Without tangential errors. A leaf out of points: vertices have no finer lattice than
 * vertex_least, items none that is more than STP_VERTEX_OCTAVES finer; `resolution` is what its
 * displacement is held against. Errors: OUT_OF_MEMORY, LIMIT
 * (they are too far apart). Free with stp_built_chunk_clear. */
stp_status stp_chunk_build_leaf(stp_built_chunk *out, const stp_item_group *points,
                                int vertex_least, const stp_resolution *resolution, stp_error *err);
/* A chunk out of its children's vertices, which it stores as they are: patch.child is the number of
 * the group, at most 64. Errors: likewise. */
stp_status stp_chunk_build_inner(stp_built_chunk *out, const stp_item_group *groups,
                                 uint32_t group_count, stp_error *err);
/* Moves a chunk that was built to the spill, borrowed, until it is needed again. Errors:
 * OUT_OF_MEMORY, IO. */
stp_status stp_built_chunk_stow(stp_built_chunk *built, stp_spill *spill, stp_error *err);
stp_placed_chunk stp_built_chunk_place(const stp_built_chunk *built);
/* Sets the tangential errors of patches and vertices. Errors: OUT_OF_MEMORY. */
stp_status stp_built_chunk_measure(stp_built_chunk *built, const stp_surroundings *around,
                                   stp_error *err);
void stp_built_chunk_clear(stp_built_chunk *built);

#endif

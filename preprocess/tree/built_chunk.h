/* Chunks that are built, until they are written. Threads: any, one chunk each. */
#ifndef STP_PREPROCESS_TREE_BUILT_CHUNK_H
#define STP_PREPROCESS_TREE_BUILT_CHUNK_H

#include "base/pool.h"
#include "base/spill.h"
#include "formats/chunk/measure/surroundings.h"
#include "preprocess/patch/displacement.h"
#include "preprocess/patch/item.h"

typedef struct stp_built_chunk {
    stp_chunk *chunk;
    stp_dvec3 origin;
    stp_carry *carry;   /* by level-0 sample; NULL for a leaf */
    uint64_t *sources;  /* by level-0 sample: items' sources; plain memory; NULL: no items */
    stp_item *vertices; /* one per patch, in the chunk's order */
    uint32_t vertex_count;
    uint32_t *run_ends; /* ends of the runs of vertices that become the parent's patches */
    uint32_t run_count;
    stp_spill *spill;              /* where carry, vertices and all of the chunk's arrays lie */
    void *chunk_arrays;            /* in the spill's files; NULL: in the chunk's own memory */
    stp_displacement displacement; /* of a leaf of points */
    bool limited; /* by holes: patches have tangential errors before they are measured */
} stp_built_chunk;

/* Moves a built chunk to the spill, borrowed, until the chunk is needed again. Errors:
 * OUT_OF_MEMORY, IO. */
stp_status stp_built_chunk_stow(stp_built_chunk *built, stp_spill *spill, stp_error *err);
stp_placed_chunk stp_built_chunk_place(const stp_built_chunk *built);
/* Cuts the chunk, which has a parent, into blocks, unless who made it did so for this codec.
 * Errors: OUT_OF_MEMORY. */
stp_status stp_built_chunk_cut(const stp_built_chunk *built, stp_codec codec, stp_error *err);
/* Sets the tangential errors of patches and vertices. pool: its threads share the work; NULL: this
 * thread alone. Errors: OUT_OF_MEMORY. */
stp_status stp_built_chunk_measure(stp_built_chunk *built, const stp_surroundings *around,
                                   stp_pool *pool, stp_error *err);
void stp_built_chunk_clear(stp_built_chunk *built);

#endif

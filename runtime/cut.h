/* The cut through the chunk tree: which chunks are drawn, and which patches of them are left to
 * their children.
 *
 * Every patch of a chunk draws from one child only (DESIGN "The tree"), so refinement is child by
 * child: a chunk is drawn but for the patches of the children that are drawn. Threads: any. */
#ifndef STP_RUNTIME_CUT_H
#define STP_RUNTIME_CUT_H

#include "runtime/level_choice.h"
#include "runtime/model.h"

#include <stddef.h>

typedef struct stp_draw {
    uint32_t chunk;
    int finest;              /* no level finer than this is drawn */
    float scale;             /* pixels per world unit at most, -1: nothing bounds it */
    uint64_t drawn_children; /* bit k: child k is drawn, or out of sight, so skip its patches */
} stp_draw;

typedef struct stp_miss {
    uint32_t chunk;
    int finest;
    float priority; /* pixels of error that its parent shows */
} stp_miss;

/* Zero is an empty cut; arrays grow and are kept. */
typedef struct stp_cut {
    stp_draw *draws; /* by chunk id */
    size_t draw_count, draw_capacity;
    uint32_t *passed; /* drawn by their children alone: kept, so that a cut can fall back on them */
    size_t passed_count, passed_capacity;
    stp_miss *misses; /* worst first */
    size_t miss_count, miss_capacity;
    uint32_t *stack;
    size_t stack_capacity;
} stp_cut;

/* Finest level at which a chunk can be drawn now, or STP_LEVEL_COUNT if not at all. */
typedef int stp_cut_available(const void *context, uint32_t chunk);

typedef struct stp_cut_params {
    const stp_model *model;
    const stp_gpu_frame *frame; /* its quality[0], the threshold: <= 0 takes every leaf's level 0 */
    stp_dvec3 eye;
    stp_cut_available *available; /* never asked for the root, which is always there */
    const void *context;
} stp_cut_params;

/* The chunk record that shaders and the CPU read for one draw. */
stp_gpu_chunk stp_gpu_chunk_from_draw(const stp_model *model, const stp_draw *draw, stp_dvec3 eye);

/* Whether the child that refines a patch is drawn, or out of sight, so that the patch is not drawn.
 */
bool stp_patch_refined(const stp_draw *draw, const stp_gpu_patch *patch);

/* Errors: OUT_OF_MEMORY. */
stp_status stp_cut_select(stp_cut *cut, const stp_cut_params *params, stp_error *err);
void stp_cut_destroy(stp_cut *cut);

#endif

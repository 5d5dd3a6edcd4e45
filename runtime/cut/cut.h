/* The cut through the tree: which blocks are drawn, and which patches their parents leave to them.
 *
 * A patch of a chunk with children is refined by patches of one block of a child. So refinement
 * goes block by block: while a block is not drawn, the patches above it are.
 * If the file links the patches of chunk and child, refinement goes patch by patch: if the finest
 * level of a patch is good enough, its block draws it, and the block below leaves out the patches
 * that it stands for (runtime/cut/sight.c). This pays because most of a surface is far less curved
 * than its worst patch. A block draws only patches that are left to it, so it draws nothing where
 * the block above is missing. Threads: any. */
#ifndef STP_RUNTIME_CUT_CUT_H
#define STP_RUNTIME_CUT_CUT_H

#include "base/pool.h"
#include "runtime/cut/level_choice.h"
#include "runtime/cut/occlusion.h"
#include "runtime/cut/scene.h"

#include <stddef.h>

typedef struct stp_draw {
    uint32_t block;
    int finest;     /* no level finer than this is drawn */
    bool has_whole; /* under its chunk, some drawn block draws all of its patches in sight */
} stp_draw;

typedef struct stp_miss {
    uint32_t block;
    int finest;
    float gain; /* (pixels of the screen) * (pixels of error removed) / (bytes to read) */
} stp_miss;

/* What the cut decided about a block. */
enum {
    STP_CUT_LEFT,   /* not drawn: what is above draws its patches */
    STP_CUT_HIDDEN, /* out of sight: so is every patch above that refers to it */
    STP_CUT_WHOLE,  /* drawn: all patches in sight */
    /* Drawn: the patches that are left to it. The state is STP_CUT_LINKED + the link of its first
     * patch. The links of a cut count the patches of all such blocks. */
    STP_CUT_LINKED
};

typedef struct stp_cut_block {
    size_t state;
    /* 0: no block below may be wanted. Otherwise blocks below gain less than this; INFINITY if this
     * block is drawn. */
    float limit;
} stp_cut_block;

/* What the patches in sight above a block say: the last cut in which one refers to the block, and
 * in which one is too coarse. In the latter: the least limit of their blocks, and whether one is
 * drawn. */
typedef struct stp_cut_reference {
    uint32_t seen, asked;
    float limit;
    bool drawn;
} stp_cut_reference;

/* Chunks of one tier of the tree whose children are to be decided. */
typedef struct stp_cut_tier {
    struct stp_cut_visit *visits;
    size_t count, capacity;
} stp_cut_tier;

/* Zero is an empty cut. Arrays grow and are reused. */
typedef struct stp_cut {
    stp_draw *draws; /* by block number: a parent comes before its children */
    size_t draw_count, draw_capacity;
    size_t link_count;
    uint32_t *passed; /* blocks that only blocks below draw; kept resident to fall back on */
    size_t passed_count, passed_capacity;
    stp_miss *misses; /* greatest gain first; a parent comes before its children */
    size_t miss_count, miss_capacity;
    stp_occluded *occluded; /* what was left out as hidden; besides patches */
    size_t occluded_count, occluded_capacity;
    stp_cut_block *blocks; /* by block number; zero except for the touched ones */
    uint32_t *touched;
    stp_cut_reference *references; /* by block number */
    uint32_t serial;               /* of this cut */
    size_t reference_capacity;
    size_t block_capacity, touched_capacity, touched_count;
    struct stp_cut_answer *answers; /* by block number (runtime/cut/cut_ask.h) */
    struct stp_cut_child *children; /* of the chunks of a tier */
    size_t answer_capacity, child_capacity, child_count;
    stp_cut_tier tiers[2]; /* this tier of the tree, and the next */
} stp_cut;

#define STP_CUT_NEVER (STP_LEVEL_COUNT + 1)

/* What the cut asks the cache, from any thread of the pool. The cut never asks about blocks of
 * roots, which are always resident. */
typedef struct stp_cut_source {
    const void *context;
    /* The finest level at which a block can be drawn now; STP_LEVEL_COUNT if none; STP_CUT_NEVER if
     * the block will not come: it counts as missing, and the cut does not look below it. */
    int (*available)(const void *context, uint32_t block);
    /* The finest level that the block needs, no finer than the estimate; NULL: the estimate.
     * *lacks: it is there, but not for each patch that needs it. */
    int (*needed)(const void *context, uint32_t block, int estimate, bool *lacks);
    /* The block's patches if they are resident, else NULL. They tell which blocks below are needed;
     * until they are there, the blocks below tell it themselves, less exactly. NULL: never. */
    const struct stp_resident *(*resident)(const void *context, uint32_t block);
    /* Whether the block was part of the last cut; NULL: ignored. */
    bool (*was_drawn)(const void *context, uint32_t block);
    /* A block is asked for after the next one, or, `next`, is the next one: fetches the memory that
     * the answer reads. May be NULL. */
    void (*prefetch)(const void *context, uint32_t block, bool next);
} stp_cut_source;

/* Where no patches above tell what is needed (stp_cut_source.resident), a block that was drawn
 * stays drawn until its error falls below this share of the threshold. So a block near the
 * threshold does not come and go with each move. */
#define STP_CUT_HYSTERESIS 0.8f

typedef struct stp_cut_params {
    const stp_scene *scene;
    const stp_gpu_frame *frame; /* quality[0] is the threshold; if <= 0: level 0 of every leaf */
    stp_dvec3 eye;
    stp_cut_source source;
    uint32_t hidden_models;         /* bit i: model i of the scene is not drawn */
    const stp_occlusion *occlusion; /* what an earlier picture hides; may be NULL */
    stp_pool *pool;                 /* whose threads ask; NULL: the caller's alone */
} stp_cut_params;

/* The record that shaders and the CPU read for one draw. */
static inline stp_gpu_chunk stp_gpu_chunk_from_draw(const stp_scene *scene, const stp_draw *draw,
                                                    stp_dvec3 eye)
{
    return stp_scene_record(scene, draw->block, draw->finest, eye);
}

/* Errors: OUT_OF_MEMORY. */
stp_status stp_cut_select(stp_cut *cut, const stp_cut_params *params, stp_error *err);
void stp_cut_destroy(stp_cut *cut);

#endif

/* Joins the models of a picture into one list of chunks and one of blocks. A block's number stands
 * for a model, a chunk of it and a block of that, so later stages deal with blocks only.
 *
 * Chunks of a model follow each other, its root first. Blocks are numbered chunk by chunk, so the
 * blocks of all children of a chunk follow each other. Ownership: models are borrowed and must
 * outlive the scene. Threads: read-only after creation, so any. */
#ifndef STP_RUNTIME_CUT_SCENE_H
#define STP_RUNTIME_CUT_SCENE_H

#include "runtime/cut/model.h"
#include "runtime/gl/gpu_layout.h"

#include <stdbool.h>
#include <stddef.h>

/* As many as stp_draw_params.hidden_models has bits. */
#define STP_SCENE_MODELS_LIMIT 32

typedef struct stp_scene_model {
    const stp_model *model;
    uint32_t first;       /* the number of its root */
    uint32_t first_block; /* the number of its root's first block */
} stp_scene_model;

/* Numbers of blocks: [begin, end). */
typedef struct stp_scene_run {
    uint32_t begin, end;
} stp_scene_run;

/* Zero is an empty scene. */
typedef struct stp_scene {
    const stp_chunk_entry *entries; /* by number; parent and first_child are numbers too */
    const stp_block *blocks;        /* by number; chunk is a number too */
    const uint32_t *first_block;    /* by chunk; then block_count */
    /* By chunk: its parent is not linked, or it is above such a chunk. Its blocks are not drawn one
     * by one, but all in sight or none. */
    bool *undivided;
    uint32_t chunk_count, block_count;
    stp_scene_model models[STP_SCENE_MODELS_LIMIT];
    size_t model_count;
    /* What the scene owns: the directory of several models. One model lends its own. */
    stp_chunk_entry *joined_entries;
    stp_block *joined_blocks;
    uint32_t *joined_first;
} stp_scene;

/* Errors: INVALID_ARGUMENT (none, too many), LIMIT (too many chunks or blocks), OUT_OF_MEMORY. */
stp_status stp_scene_create(stp_scene *out, const stp_model *const *models, size_t count,
                            stp_error *err);
void stp_scene_destroy(stp_scene *scene);

/* Which of STP_PATCH_SHAPES some model has, as its header says. */
unsigned stp_scene_shapes(const stp_scene *scene);
/* Whether any model draws chosen samples alone (stp_model_choose). */
bool stp_scene_is_chosen(const stp_scene *scene);
/* Whether any closed surface has openings (docs/closed.md). */
bool stp_scene_has_openings(const stp_scene *scene);
/* Whether all models are grids of heights. */
bool stp_scene_is_grid(const stp_scene *scene);
/* Whether all models have discs that meet as they are, since they are grids of heights or holes of
 * theirs may only grow, and there is one of these. */
bool stp_scene_holes_grow(const stp_scene *scene);
/* The model that a chunk belongs to. */
const stp_scene_model *stp_scene_find(const stp_scene *scene, uint32_t chunk);
/* The model that a block belongs to. *out is the block as the model's file knows it. */
const stp_scene_model *stp_scene_find_block(const stp_scene *scene, uint32_t block,
                                            const stp_block **out);
/* The entry of a block's chunk. */
const stp_chunk_entry *stp_scene_entry(const stp_scene *scene, uint32_t block);

/* The record that shaders and the CPU read of a block that is drawn at levels >= finest; without
 * where the block is in the Object Texture. */
stp_gpu_chunk stp_scene_record(const stp_scene *scene, uint32_t block, int finest, stp_dvec3 eye);

/* Whether a block's chunk is the root of a model. */
bool stp_scene_is_root(const stp_scene *scene, uint32_t block);

/* The blocks of a chunk, and those of all its children. */
stp_scene_run stp_scene_blocks(const stp_scene *scene, uint32_t chunk);
stp_scene_run stp_scene_blocks_below(const stp_scene *scene, uint32_t chunk);
/* The block that refines a patch of a chunk, and which of its patches is the first to do so.
 * STP_BLOCK_NONE: no single block does. */
uint32_t stp_scene_block_below(const stp_scene *scene, uint32_t chunk, const stp_patch *patch,
                               uint16_t *first_below);

#endif

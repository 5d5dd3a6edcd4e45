/* Joins the models of a picture into one list of chunks. A chunk's number says which chunk of which
 * model is meant, so later stages deal with chunks only.
 *
 * The chunks of a model follow each other, its root first. Ownership: models are borrowed and must
 * the scene. Threads: read-only after creation, so any. */
#ifndef STP_RUNTIME_CUT_SCENE_H
#define STP_RUNTIME_CUT_SCENE_H

#include "runtime/cut/model.h"

#include <stdbool.h>
#include <stddef.h>

/* As many as stp_draw_params.hidden_models has bits. */
#define STP_SCENE_MODELS_LIMIT 32

typedef struct stp_scene_model {
    const stp_model *model;
    uint32_t first; /* the number of its root */
} stp_scene_model;

/* Zero is an empty scene. */
typedef struct stp_scene {
    const stp_chunk_entry *entries; /* by number; parent and first_child are numbers too */
    uint32_t chunk_count;
    stp_scene_model models[STP_SCENE_MODELS_LIMIT];
    size_t model_count;
    stp_chunk_entry *joined; /* entries of several models; NULL for one: entries are its own */
} stp_scene;

/* Errors: INVALID_ARGUMENT (none, too many), LIMIT (too many chunks), OUT_OF_MEMORY. */
stp_status stp_scene_create(stp_scene *out, const stp_model *const *models, size_t count,
                            stp_error *err);
void stp_scene_destroy(stp_scene *scene);

/* Which of STP_PATCH_SHAPES some model has, as its header says. */
unsigned stp_scene_shapes(const stp_scene *scene);
/* Whether any closed surface has openings (docs/closed.md). */
bool stp_scene_has_openings(const stp_scene *scene);
/* The model that a chunk belongs to. */
const stp_scene_model *stp_scene_find(const stp_scene *scene, uint32_t chunk);

#endif

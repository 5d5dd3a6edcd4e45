/* The models that the viewer shows at once.
 * Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_VIEW_SCENE_H
#define STP_TOOLS_VIEW_VIEW_SCENE_H

#include "tools/draw/draw_options.h"

#include <stdbool.h>
#include <stddef.h>

#define VIEW_MODELS_LIMIT 32

/* Units: of lengths along x and y, of heights, and of any length. */
typedef enum view_unit { VIEW_UNIT_LEVEL, VIEW_UNIT_HEIGHT, VIEW_UNIT_ANY } view_unit;

typedef struct view_model {
    char *path;
    const char *name; /* the last part of the path or address, without secrets */
    stp_model *model;
    bool hidden;
    char sources[160];    /* the files that the model was made of */
    char system[160];     /* coordinate system; "" if unknown */
    char units[2][32];    /* by view_unit: "m" or "US ft"; "" if unknown */
    double intensity_top; /* the scans' own number for intensity 1; 0: not known */
} view_model;

/* Zero is empty. */
typedef struct view_scene {
    view_model models[VIEW_MODELS_LIMIT];
    size_t count;
    stp_dbox box; /* box of the models that are shown, or of all if none is */
    stp_ball ball;
    uint64_t point_count; /* of the same models */
    uint32_t attributes;  /* STP_HAS_* that any model has */
    double intensity_top; /* as of its models with intensities, if they agree; else 0 */
} view_scene;

/* Adds a model. options: say where models of web servers are cached. Errors: those of
 * draw_options_open_model; LIMIT, EXISTS (the model is already there), OUT_OF_MEMORY. */
stp_status view_scene_add(view_scene *scene, const draw_options *options, const char *path,
                          stp_error *err);
/* Gives the scene a model by this name, in place of the one of that name, if there is one: *old is
 * that, and the caller's. *model is the scene's from then on. Errors: LIMIT, OUT_OF_MEMORY. */
stp_status view_scene_put(view_scene *scene, const char *path, stp_model **model, stp_model **old,
                          stp_error *err);
/* The index of a model by its path; `count` if there is none. */
size_t view_scene_find(const view_scene *scene, const char *path);
/* "" if it is not known, or if models or axes do not agree. */
const char *view_scene_unit(const view_scene *scene, view_unit of);
void view_scene_remove(view_scene *scene, size_t index);
/* Bit set of the models that are hidden, as in stp_draw_params. */
uint32_t view_scene_hidden(const view_scene *scene);
/* Recomputes box and counts after models were shown or hidden. */
void view_scene_update(view_scene *scene);
void view_scene_clear(view_scene *scene);

#endif

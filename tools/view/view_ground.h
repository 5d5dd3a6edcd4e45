/* Finds the ground under a position: the highest sample below it. Reads the model's own tree, finer
 * from call to call, so walking needs no picture of the ground.
 *
 * Keeps at most VIEW_GROUND_CHUNKS decoded chunks and reads at most one chunk per call. Threads:
 * the main thread only. */
#ifndef STP_TOOLS_VIEW_VIEW_GROUND_H
#define STP_TOOLS_VIEW_VIEW_GROUND_H

#include "runtime/cut/model.h"

#define VIEW_GROUND_CHUNKS 12

typedef struct view_ground_chunk {
    const stp_model *model;
    stp_chunk *chunk;
    uint64_t used; /* number of the call that used it last */
} view_ground_chunk;

/* Zero is empty. */
typedef struct view_ground {
    view_ground_chunk chunks[VIEW_GROUND_CHUNKS];
    uint64_t calls;
} view_ground;

typedef struct view_ground_params {
    const stp_model *model;
    stp_dvec3 position;
    stp_dvec3 up; /* unit */
    double reach; /* samples within this distance of the line down count */
} view_ground_params;

/* Gets the height of the ground along up. Returns false and keeps *height if there is no ground, or
 * the model cannot be read there. */
bool view_ground_find(view_ground *ground, const view_ground_params *params, double *height);
/* Frees the chunks of a model before it is closed; NULL: of all models. */
void view_ground_forget(view_ground *ground, const stp_model *model);

#endif

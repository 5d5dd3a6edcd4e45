/* The patches of a cut that are in sight: where every road of projection begins, and what tells
 * which tiles of the picture may be covered. On all threads of a pool, since a cut has up to some
 * hundred thousand patches and about half of a closed model's turn away.
 * Threads: the render thread. */
#ifndef STP_RUNTIME_CUT_SIGHT_H
#define STP_RUNTIME_CUT_SIGHT_H

#include "base/pool.h"
#include "runtime/cut/cut.h"
#include "runtime/cut/tiles.h"
#include "runtime/stream/chunk_cache.h"

/* Numbers in the Object Texture, by draw, ascending. */
typedef struct stp_sight_list {
    uint32_t *items;
    size_t *begin; /* of each draw's; begin[number of draws]: how many there are */
    size_t item_capacity, begin_capacity;
} stp_sight_list;

typedef enum stp_sight_kind {
    STP_SIGHT_PATCHES,
    /* Of patches for which level 3 does, which are not among the patches then: its sample. In a
     * whole view of a large model nine patches of ten are such, and a point costs far less than a
     * patch whose levels are chosen. Empty unless asked for. */
    STP_SIGHT_VERTICES,
    STP_SIGHT_STRIPS,    /* the strips among the patches once more */
    STP_SIGHT_TRIANGLES, /* and the triangles */
    STP_SIGHT_COUNT
} stp_sight_kind;

/* Zero is nothing in sight; arrays grow and are kept. */
typedef struct stp_sight {
    stp_sight_list lists[STP_SIGHT_COUNT];
    bool *below; /* by link of the cut: drawn by the child's patch, or one below that */
    size_t below_capacity;
    float radius_px; /* greatest projected radius of any sample that may be drawn of what was looked
                        at */
} stp_sight;

typedef struct stp_sight_params {
    const stp_scene *scene;
    const stp_chunk_cache *cache; /* the draws' chunks are resident */
    const stp_gpu_frame *frame;
    stp_dvec3 eye;
    stp_pool *pool;
    stp_tiles *tiles; /* marked where patches in sight may cover them */
    bool vertices;    /* list these apart */
} stp_sight_params;

/* A picture's cut begins: nothing of it was looked at. Errors: OUT_OF_MEMORY. */
stp_status stp_sight_begin(stp_sight *sight, const stp_cut *cut, stp_error *err);
/* Looks at some draws of the cut, in order: a chunk before its children. Errors: OUT_OF_MEMORY. */
stp_status stp_sight_look(stp_sight *sight, const stp_sight_params *params, const stp_draw *draws,
                          size_t count, stp_error *err);
/* Whether one patch of a drawn chunk is in sight, and drawn; after looking. briefs: the chunk's. */
bool stp_patch_in_sight(const stp_sight *sight, const stp_sight_params *params,
                        const stp_draw *draw, const stp_patch_brief *briefs, uint32_t patch);
void stp_sight_destroy(stp_sight *sight);

#endif

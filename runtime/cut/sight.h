/* Finds the patches of a cut that are in sight. Every road of projection starts from this list, and
 * the list tells which tiles of the picture may be covered. All threads of a pool work on it: a cut
 * has up to some hundred thousand patches, and about half of a closed model's face away.
 * Threads: the render thread. */
#ifndef STP_RUNTIME_CUT_SIGHT_H
#define STP_RUNTIME_CUT_SIGHT_H

#include "base/pool.h"
#include "runtime/cut/cut.h"
#include "runtime/cut/tiles.h"
#include "runtime/stream/cache/block_cache.h"

/* Numbers of patches in the Object Texture or names of samples, draw by draw, ascending. */
typedef struct stp_sight_list {
    uint32_t *items;
    size_t *begin; /* where each draw's items begin; begin[number of draws]: the total count */
    size_t item_capacity, begin_capacity;
} stp_sight_list;

typedef enum stp_sight_kind {
    STP_SIGHT_PATCHES,
    /* The samples of the patches for which level 3 is fine enough; these patches are not listed
     * under STP_SIGHT_PATCHES. In a whole view of a large model they are nine patches of ten, and a
     * point costs far less than choosing a patch's levels. Empty unless asked for. */
    STP_SIGHT_VERTICES,
    /* The patches that are drawn as level 2, a sample for each quarter; not listed under
     * STP_SIGHT_PATCHES. The name of the first sample | (samples - 1) << STP_NAME_BITS. Empty
     * unless asked for. */
    STP_SIGHT_QUARTERS,
    STP_SIGHT_STRIPS,    /* those of STP_SIGHT_PATCHES that are strips */
    STP_SIGHT_TRIANGLES, /* those that are triangles */
    STP_SIGHT_SQUARES, /* squares drawn as triangles or splats of maps, not in STP_SIGHT_PATCHES */
    STP_SIGHT_COUNT
} stp_sight_kind;

/* Zero: nothing is in sight. Arrays grow and are reused. */
typedef struct stp_sight {
    stp_sight_list lists[STP_SIGHT_COUNT];
    const stp_cut *cut; /* borrowed from stp_sight_begin */
    bool *below;        /* by link of the cut: the patch draws, or a patch further below */
    size_t below_capacity;
    uint32_t (*openings)[STP_OPENING_WORDS]; /* by draw: the set through which it may be seen */
    size_t opening_capacity;
    size_t hidden;   /* patches that the occlusion hides, of the draws looked at */
    float radius_px; /* greatest projected radius of any sample that may be drawn of the draws
                        looked at */
} stp_sight;

typedef struct stp_sight_params {
    const stp_scene *scene;
    const stp_block_cache *cache; /* the draws' blocks are resident */
    const stp_gpu_frame *frame;
    stp_dvec3 eye;
    stp_pool *pool;
    stp_tiles *tiles;               /* gets marks where patches in sight may cover tiles */
    bool vertices;                  /* fill STP_SIGHT_VERTICES */
    bool quarters;                  /* fill STP_SIGHT_QUARTERS */
    const stp_occlusion *occlusion; /* what an earlier picture hides; may be NULL */
    /* A square whose level 0 is drawn is listed under STP_SIGHT_SQUARES if its samples are seen
     * with a greater radius than this: of a grid, of a map. Infinity: none is. */
    float grids_px, maps_px;
} stp_sight_params;

/* Begins the cut of a picture, with nothing looked at yet. The cut is borrowed until the next call.
 * Errors: OUT_OF_MEMORY. */
stp_status stp_sight_begin(stp_sight *sight, const stp_cut *cut, stp_error *err);
/* Looks at some draws of the cut, in order: a parent before its children. Errors: OUT_OF_MEMORY. */
stp_status stp_sight_look(stp_sight *sight, const stp_sight_params *params, const stp_draw *draws,
                          size_t count, stp_error *err);
/* Whether a patch of a drawn block is in sight and drawn by this block. Call after looking. briefs:
 * of the block. */
bool stp_patch_in_sight(const stp_sight *sight, const stp_sight_params *params,
                        const stp_draw *draw, const stp_patch_brief *briefs, uint32_t patch);
void stp_sight_destroy(stp_sight *sight);

#endif

/* The cut through the chunk tree: which chunks are drawn, and which of their patches the children
 * draw instead.
 *
 * Each patch of a chunk belongs to one child. So refinement goes child by child: if a child is
 * drawn, the chunk leaves the child's patches out.
 * If the file links the patches of chunk and child, refinement goes patch by patch: if the finest
 * level of a patch is good enough, the chunk draws the patch, and the child leaves out the patches
 * that this patch stands for (runtime/cut/sight.c). This pays because most of a surface is far less
 * curved than its worst patch. Threads: any. */
#ifndef STP_RUNTIME_CUT_CUT_H
#define STP_RUNTIME_CUT_CUT_H

#include "runtime/cut/level_choice.h"
#include "runtime/cut/scene.h"

#include <stddef.h>

typedef struct stp_draw {
    uint32_t chunk;
    int finest;               /* no level finer than this is drawn */
    uint64_t drawn_children;  /* bit k: child k is drawn, or out of sight */
    uint64_t linked_children; /* bit k: child k draws only the patches that this chunk leaves it */
    bool has_whole;           /* some drawn child draws all of its patches in sight */
    size_t links;             /* number of the link of the first child's first patch */
    size_t parent_link; /* link of this chunk's first patch; STP_LINK_NONE: draws all patches */
} stp_draw;

/* A link belongs to a patch whose patch vertex is a level-0 sample of the linked parent chunk. The
 * links of a cut are numbered parent by parent, child by child. */
#define STP_LINK_NONE SIZE_MAX

typedef struct stp_miss {
    uint32_t chunk;
    int finest;
    float gain; /* (pixels of the screen) * (pixels of error removed) / (bytes to read) */
} stp_miss;

/* Zero is an empty cut. Arrays grow and are reused. */
typedef struct stp_cut {
    stp_draw *draws; /* by chunk id: a parent comes before its children */
    size_t draw_count, draw_capacity;
    size_t link_count;
    uint32_t *passed; /* chunks that only their children draw; kept resident to fall back on */
    size_t passed_count, passed_capacity;
    stp_miss *misses; /* greatest gain first; a parent comes before its children */
    size_t miss_count, miss_capacity;
    struct stp_cut_visit *stack;
    size_t stack_capacity;
} stp_cut;

#define STP_CUT_NEVER (STP_LEVEL_COUNT + 1)

/* What the cut asks the cache. The cut never asks about a root, since roots are always resident. */
typedef struct stp_cut_source {
    const void *context;
    /* The finest level at which a chunk can be drawn now; STP_LEVEL_COUNT if none; STP_CUT_NEVER if
     * the chunk will not come: it counts as missing, and the cut does not look below it. */
    int (*available)(const void *context, uint32_t chunk);
    /* Whether the chunk was part of the last cut; NULL: ignored. */
    bool (*was_drawn)(const void *context, uint32_t chunk);
} stp_cut_source;

/* A chunk that was drawn stays drawn until its error falls below this share of the threshold. So a
 * chunk near the threshold does not come and go with each move. */
#define STP_CUT_HYSTERESIS 0.8f

typedef struct stp_cut_params {
    const stp_scene *scene;
    const stp_gpu_frame *frame; /* quality[0] is the threshold; if <= 0: level 0 of every leaf */
    stp_dvec3 eye;
    stp_cut_source source;
    uint32_t hidden_models; /* bit i: model i of the scene is not drawn */
} stp_cut_params;

/* The chunk record that shaders and the CPU read for one draw of an entry. */
stp_gpu_chunk stp_gpu_chunk_from_draw(const stp_chunk_entry *entry, const stp_draw *draw,
                                      stp_dvec3 eye);

/* Errors: OUT_OF_MEMORY. */
stp_status stp_cut_select(stp_cut *cut, const stp_cut_params *params, stp_error *err);
void stp_cut_destroy(stp_cut *cut);

#endif

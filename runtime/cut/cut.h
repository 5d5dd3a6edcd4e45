/* The cut through the chunk tree: which chunks are drawn, and which patches of them are left to
 * their children.
 *
 * Every patch of a chunk draws from one child only, so refinement is child by
 * child: a chunk is drawn but for the patches of the children that are drawn. Where the file links
 * the patches of both, it is patch by patch: a patch whose finest level does is drawn though its
 * child is there, and the child leaves out what that patch stands for (runtime/cut/sight.c). Most
 * of a surface is far less curved than its worst patch. Threads: any. */
#ifndef STP_RUNTIME_CUT_CUT_H
#define STP_RUNTIME_CUT_CUT_H

#include "runtime/cut/level_choice.h"
#include "runtime/cut/scene.h"

#include <stddef.h>

typedef struct stp_draw {
    uint32_t chunk;
    int finest;               /* no level finer than this is drawn */
    uint64_t drawn_children;  /* bit k: child k is drawn, or out of sight */
    uint64_t linked_children; /* of these: draws only what patches here leave to it */
    bool has_whole;           /* another of these draws all of what it has in sight */
    size_t links;             /* number of the link of its first child's first patch */
    size_t parent_link;       /* of its own first patch; STP_LINK_NONE: it draws all of them */
} stp_draw;

/* A link is a patch of a chunk whose vertex is a level-0 sample of its linked parent. Those of a
 * cut are numbered, parent by parent, child by child. */
#define STP_LINK_NONE SIZE_MAX

typedef struct stp_miss {
    uint32_t chunk;
    int finest;
    float gain; /* pixels of the screen times pixels of error that it takes away, a byte to read */
} stp_miss;

/* Zero is an empty cut; arrays grow and are kept. */
typedef struct stp_cut {
    stp_draw *draws; /* by chunk id: a chunk after its parent */
    size_t draw_count, draw_capacity;
    size_t link_count;
    uint32_t *passed; /* drawn by their children alone: kept, so that a cut can fall back on them */
    size_t passed_count, passed_capacity;
    stp_miss *misses; /* greatest gain first; a chunk's parent before it */
    size_t miss_count, miss_capacity;
    struct stp_cut_visit *stack;
    size_t stack_capacity;
} stp_cut;

#define STP_CUT_NEVER (STP_LEVEL_COUNT + 1)

/* What the cut asks of the cache; never of a root, which is always there. */
typedef struct stp_cut_source {
    const void *context;
    /* Finest level at which a chunk can be drawn now, STP_LEVEL_COUNT if not at all, or
     * STP_CUT_NEVER: it is missed, and what is below it is not even looked for. */
    int (*available)(const void *context, uint32_t chunk);
    /* Whether it was part of the last cut; NULL: no matter. */
    bool (*was_drawn)(const void *context, uint32_t chunk);
} stp_cut_source;

/* A chunk that was drawn is drawn until its error is less than this share of the threshold: what is
 * at the threshold does not come and go with each move. */
#define STP_CUT_HYSTERESIS 0.8f

typedef struct stp_cut_params {
    const stp_scene *scene;
    const stp_gpu_frame *frame; /* its quality[0], the threshold: <= 0 takes every leaf's level 0 */
    stp_dvec3 eye;
    stp_cut_source source;
    uint32_t hidden_models; /* bit i: model i of the scene is not drawn */
} stp_cut_params;

/* Whether all of a chunk's children are drawn, or out of sight. */
bool stp_draw_passes(const stp_draw *draw, const stp_chunk_entry *entry);

/* The chunk record that shaders and the CPU read for one draw of an entry. */
stp_gpu_chunk stp_gpu_chunk_from_draw(const stp_chunk_entry *entry, const stp_draw *draw,
                                      stp_dvec3 eye);

/* Errors: OUT_OF_MEMORY. */
stp_status stp_cut_select(stp_cut *cut, const stp_cut_params *params, stp_error *err);
void stp_cut_destroy(stp_cut *cut);

#endif

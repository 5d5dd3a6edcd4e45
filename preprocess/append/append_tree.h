/* The tree of a model that grows: its tiers, each of kept and of new chunks. */
#ifndef STP_PREPROCESS_APPEND_APPEND_TREE_H
#define STP_PREPROCESS_APPEND_APPEND_TREE_H

#include "formats/chunk/shelf.h"
#include "preprocess/append/append_job.h"
#include "preprocess/tree/chunk_build.h"

/* A chunk of a tier. */
typedef struct stp_grown_node {
    uint32_t old;    /* the chunk of the file that it is, or is but for raised errors; else
                        STP_CHUNK_NONE */
    uint32_t was;    /* the chunk whose place a new chunk takes; STP_CHUNK_NONE: none */
    uint32_t parent; /* the chunk above it in the file; STP_CHUNK_NONE: none */
    bool kept;       /* its payload stays; else `built` replaces it */
    uint32_t cell;   /* of a new leaf */
    uint32_t first_child, child_count; /* in the tier below */
    uint32_t vertex_count;
    uint64_t points_under;
    stp_built_chunk built;
    stp_chunk_entry entry; /* of a new chunk */
    void *payload;
    uint32_t handle; /* of the writer */
} stp_grown_node;

/* All chunks of one depth, in order. */
typedef struct stp_grown_tier {
    stp_grown_node *nodes;
    uint32_t count;
    stp_chunk_boxes boxes;
    bool leaves;
} stp_grown_tier;

typedef struct stp_growth {
    stp_append *a;
    stp_point_item_params items;
    stp_shelf *shelf;
    stp_grown_tier below, tier;
    uint32_t *todo; /* nodes of the tier that a step treats */
    uint32_t todo_count;
    stp_built_chunk *raised; /* by place in todo, while kept chunks are checked */
} stp_growth;

/* Lists the leaves: kept ones, and the cells in place of touched ones. Errors: OUT_OF_MEMORY. */
stp_status stp_growth_leaves(stp_growth *g, stp_error *err);
/* Makes the tier the one below, and lists the chunks above it. Errors: OUT_OF_MEMORY, LIMIT. */
stp_status stp_growth_rise(stp_growth *g, stp_error *err);
/* Whether the tier is the root alone. */
bool stp_growth_is_root(const stp_growth *g);
/* Builds the tier's new chunks, measures them, raises kept ones where needed, and encodes all that
 * are not kept. Errors: those of stp_chunk_build, of reading chunks, and CANCELLED. */
stp_status stp_growth_build(stp_growth *g, stp_error *err);
void stp_growth_clear(stp_growth *g);

#endif

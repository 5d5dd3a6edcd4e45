/* Builds a chunk from items: patches of neighbours, child by child, and the patch vertices for its
 * parent. First all chunks of a tier are built. Then tangential errors are measured, which needs a
 * chunk's neighbours. Threads: any, one chunk each. */
#ifndef STP_PREPROCESS_TREE_CHUNK_BUILD_H
#define STP_PREPROCESS_TREE_CHUNK_BUILD_H

#include "preprocess/patch/partition.h"
#include "preprocess/patch/patch_build.h"
#include "preprocess/patch/point_item.h"
#include "preprocess/tree/built_chunk.h"

/* The most patches that one patch above stands for. If one of them is too coarse, a view reads all
 * of them, so few are better; each patch above takes some bytes, too. */
#define STP_ABOVE_SAMPLES 16

/* Patches of a chunk that stay as they are in a new chunk, because the child that refines them
 * stays. */
typedef struct stp_kept_patches {
    stp_placed_chunk above; /* the chunk that had them, with all levels */
    const stp_chunk
        *below;     /* the child, whose errors may be raised; it has all patches linked to */
    uint32_t child; /* its place among the children of `above` */
} stp_kept_patches;

/* The extremes of a chunk's items. */
typedef struct stp_chunk_extent {
    stp_dbox box; /* world */
    double area, bound;
    int finest, coarsest; /* exponents of lattices */
} stp_chunk_extent;

/* Makes the items that `order` names, at most STP_PATCH_SAMPLES. */
typedef void stp_run_maker(const void *context, const uint32_t *order, uint32_t count,
                           stp_item *items);
/* Makes the places of all items, by which runs are found. */
typedef void stp_place_maker(const void *context, stp_dvec3 origin, stp_place *places);

/* Items that one child chunk refines. All items of a leaf are one group. */
typedef struct stp_item_group {
    const stp_kept_patches *kept; /* in place of items; NULL: none */
    const stp_item *items;
    /* In place of items, of a leaf: makes those of a run just before they become a patch, lest
     * large items of all samples go through memory. NULL: items has them. */
    stp_run_maker *make;
    stp_place_maker *places; /* then, unless runs are known */
    const void *context;
    const stp_chunk_extent *extent; /* then: of all items */
    /* The ends of the runs of items that become patches, linked to the child's. NULL: the build
     * finds the runs. Set in all groups or in none. */
    const uint32_t *run_ends;
    /* Of squares of a grid: ends, among the runs, of those that lie together. Their patches become
     * one patch of the parent, or several of up to 64; samples are merged by plain means. NULL: the
     * build finds what lies together. */
    const uint32_t *together_ends;
    const stp_patch_grid *run_grids; /* by run, of squares; NULL: none */
    const stp_holes *holes; /* by sheet (patch_build.h), the same for all groups; NULL: none */
    bool regular; /* items are of a grid of heights, or stand for such; the same for all groups */
    uint32_t count, run_count, together_count; /* of items; of runs; of runs that lie together */
} stp_item_group;

/* The extent of no items. vertex_least: exponent of the finest lattice of patch vertices. */
stp_chunk_extent stp_chunk_extent_none(int vertex_least);
void stp_chunk_extent_add(stp_chunk_extent *e, stp_dvec3 centre, double area, double bound,
                          int exponent);
/* Whether one chunk can hold the items: the origins of its patches can be given in steps of any of
 * the lattices. */
bool stp_chunk_extent_fits(const stp_chunk_extent *e);

/* Makes patch `index` of a leaf with all its levels, and its patch vertex. */
typedef stp_status stp_patch_maker(const void *context, uint32_t index, stp_dvec3 chunk_origin,
                                   stp_patch *patch, stp_patch_samples *samples, stp_item *vertex,
                                   stp_error *err);

/* Builds a leaf of patches, at least 1, that `make` makes. The patches are ordered by the runs of
 * their vertices. origin: a multiple of twice every lattice of the patches and their vertices.
 * Errors: those of `make`, OUT_OF_MEMORY. Free with stp_built_chunk_clear. */
stp_status stp_chunk_build_made(stp_built_chunk *out, stp_dvec3 origin, uint32_t patch_count,
                                stp_patch_maker *make, const void *context, stp_error *err);
/* Builds a leaf of points, without tangential errors. params: what the items were made with,
 * borrowed; no item's lattice is more than STP_VERTEX_OCTAVES finer than vertex_least. Errors:
 * OUT_OF_MEMORY, LIMIT (the points are too far apart). Free with stp_built_chunk_clear. */
stp_status stp_chunk_build_leaf(stp_built_chunk *out, const stp_item_group *points,
                                const stp_point_item_params *params, stp_error *err);
/* Builds a chunk, without tangential errors, from its children's patch vertices, which it stores
 * unchanged. patch.child is the number of the group, at most 64 groups. Errors: likewise. */
stp_status stp_chunk_build_inner(stp_built_chunk *out, const stp_item_group *groups,
                                 uint32_t group_count, stp_error *err);
#endif

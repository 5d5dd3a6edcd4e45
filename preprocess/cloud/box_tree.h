/* Boxes over runs of a cloud's order, over runs of those runs, and so on up to one: for searches
 * that must find all there is, wherever it lies.
 *
 * A leaf is the box of 256 points that follow each other, a node above it that of 16 below. Takes a
 * fifth of a byte a point. Threads: any may search a tree that is made. */
#ifndef STP_PREPROCESS_CLOUD_BOX_TREE_H
#define STP_PREPROCESS_CLOUD_BOX_TREE_H

#include "base/pool.h"
#include "base/spill.h"
#include "base/vec.h"
#include "preprocess/cloud/nearest_list.h"

#include <stdbool.h>
#include <stdint.h>

/* Enough for 2^32 points. */
#define STP_BOX_TIERS 7

struct stp_cloud;

typedef struct stp_box_tree {
    stp_dbox *boxes;                   /* tier by tier, leaves first */
    uint32_t begin[STP_BOX_TIERS + 1]; /* of each tier; the end of the last */
    unsigned tier_count;               /* 0: no points */
} stp_box_tree;

/* Over the points as they are sorted. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_box_tree_create(stp_box_tree *out, const struct stp_cloud *cloud, stp_pool *pool,
                               stp_error *err);
void stp_box_tree_clear(stp_box_tree *tree, stp_spill *spill);

/* Fills the list with the nearest distinct positions to a point's but its own, exactly. What the
 * list holds before bounds the search: places of the cloud at true distances, or nothing. */
void stp_box_tree_nearest(const struct stp_cloud *cloud, uint32_t self, stp_nearest_list *list);

/* Calls visit(context, begin, end) for the runs of points in all leaves of which test(context, box)
 * holds, as it does for the nodes above them, in the points' order; ends when visit returns false.
 * False if it did. */
bool stp_box_tree_walk(const struct stp_cloud *cloud, bool (*test)(void *, const stp_dbox *),
                       bool (*visit)(void *, uint32_t begin, uint32_t end), void *context);

#endif

/* A tree of boxes over runs of a cloud's order, for searches that must find everything, wherever it
 * lies.
 *
 * A leaf is the box of 64 consecutive points. A node above is the box of 16 boxes below, up to one
 * root. The tree takes 0.8 bytes per point. Threads: any number may search a finished tree.
 */
#ifndef STP_PREPROCESS_CLOUD_BOX_TREE_H
#define STP_PREPROCESS_CLOUD_BOX_TREE_H

#include "preprocess/cloud/cloud.h"
#include "preprocess/cloud/nearest_list.h"

#include <stdbool.h>
#include <stdint.h>

/* Builds the tree over the sorted points. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_box_tree_create(stp_box_tree *out, const stp_cloud *cloud, stp_pool *pool,
                               stp_error *err);
void stp_box_tree_clear(stp_box_tree *tree, stp_spill *spill);

/* Searches leave out points that are not here (cloud_blocks.h), and ask for their blocks: the
 * cloud then says that it missed something, and the search must be done again. */

/* Fills the list with the nearest distinct positions to a point's position, without its own,
 * exactly. If the list is full before, its farthest entry bounds the search: the entries must then
 * be places of the cloud at true distances. Otherwise leave the list empty. */
void stp_box_tree_nearest(const stp_cloud *cloud, uint64_t self, stp_nearest_list *list);

/* Calls visit(context, begin, end) for the run of points of each leaf, in the points' order. A node
 * for which test(context, box) is false is skipped with everything below it. The walk ends when
 * visit returns false; then the function returns false. */
bool stp_box_tree_walk(const stp_cloud *cloud, bool (*test)(void *, const stp_dbox *),
                       bool (*visit)(void *, uint64_t begin, uint64_t end), void *context);

#endif

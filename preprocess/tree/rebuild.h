/* Rebuilds an inner chunk from its children as a file holds them, for `stipple verify --repair`.
 *
 * It works like the making of the tree, but from stored values. Areas follow from radii. What a
 * patch vertex stands for follows from its patch's bound. So errors come out greater, never less.
 * Threads: any. */
#ifndef STP_PREPROCESS_TREE_REBUILD_H
#define STP_PREPROCESS_TREE_REBUILD_H

#include "formats/chunk/measure/surroundings.h"

/* Is a stp_parent_build; see formats/chunk/repair/repair.h. */
stp_status stp_rebuild_parent(const stp_placed_chunk *children, uint32_t count, stp_chunk **out,
                              stp_dvec3 *origin, stp_carry **carry, stp_error *err);

#endif

/* An inner chunk out of its children as a file holds them: for `stipple verify --repair`.
 *
 * As in the tree's making, but of what is stored: areas follow from radii, and what a patch vertex
 * stands for from its patch's bound, so errors come out greater, never less. Threads: any. */
#ifndef STP_PREPROCESS_TREE_REBUILD_H
#define STP_PREPROCESS_TREE_REBUILD_H

#include "formats/chunk/measure/surroundings.h"

/* A stp_parent_build (formats/chunk/repair/repair.h), which see. */
stp_status stp_rebuild_parent(const stp_placed_chunk *children, uint32_t count, stp_chunk **out,
                              stp_dvec3 *origin, stp_carry **carry, stp_error *err);

#endif

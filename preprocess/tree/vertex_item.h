/* Patch vertices of stored chunks as items of the chunk above.
 *
 * The file does not tell all that was known when the vertex was made. Areas follow from radii. What
 * a vertex stands for follows from its patch's bound. So errors of what is built of them come out
 * greater, never less. Threads: any (pure functions). */
#ifndef STP_PREPROCESS_TREE_VERTEX_ITEM_H
#define STP_PREPROCESS_TREE_VERTEX_ITEM_H

#include "formats/chunk/measure/surroundings.h"
#include "preprocess/patch/item.h"

/* Exponent of the lowest set bit of a point's coordinates; INT_MAX if all are 0. */
int stp_lowest_bits(stp_dvec3 p);
/* Patch p's vertex. shared: the exponent of a lattice that the item should have if it lies on it;
 * INT_MIN for none. */
stp_item stp_vertex_item(const stp_placed_chunk *placed, uint32_t p, int shared);

#endif

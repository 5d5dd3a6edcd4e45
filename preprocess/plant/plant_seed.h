/* Finds rings to begin a chain with if no border leads to one: between two forks, under a tip or a
 * lid.
 *
 * In a regular tube six triangles meet at a vertex. Walk along edges and leave each vertex by the
 * edge opposite to the one you came by, with three triangles on either side. The walk goes around
 * the tube and comes back: it is a ring. If a walk does not come back within STP_PLANT_RING_LIMIT
 * steps, or meets another kind of vertex, it is no ring wherever it begins. So each walk is tried
 * once. Threads: one at a time. */
#ifndef STP_PREPROCESS_PLANT_PLANT_SEED_H
#define STP_PREPROCESS_PLANT_PLANT_SEED_H

#include "preprocess/plant/plant_rings.h"

typedef struct stp_plant_seeds {
    uint32_t (*tried)[3]; /* by vertex: the walks tried, by the lesser neighbour on them */
    uint32_t *set_aside;  /* triangles taken temporarily */
} stp_plant_seeds;

/* Makes room for pieces of up to most_triangles triangles. Errors: OUT_OF_MEMORY. */
stp_status stp_plant_seeds_create(stp_plant_seeds *out, uint32_t most_triangles, stp_error *err);
void stp_plant_seeds_clear(stp_plant_seeds *seeds);
/* Begins a piece: no walk has been tried. */
void stp_plant_seeds_begin(stp_plant_seeds *seeds, const stp_plant_piece *piece);
/* Looks for a ring through the vertex among triangles that are not taken, and follows its whole
 * chain from end to end. False if there is none. */
bool stp_plant_seeds_follow(stp_plant_seeds *seeds, stp_plant_rings *rings, uint32_t vertex);

#endif

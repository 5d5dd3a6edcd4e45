/* Rings to begin a chain with where no border leads to one: between two forks, under a tip or a
 * lid.
 *
 * In a regular tube six triangles meet at a vertex, and a way that always leaves by the edge
 * opposite to the one it came by (three triangles on either side) goes around the tube and comes
 * back. A way that does not come back within STP_PLANT_RING_LIMIT steps, or meets another kind of
 * vertex, is no ring wherever it is begun, so that each is walked once. Threads: one at a time. */
#ifndef STP_PREPROCESS_PLANT_PLANT_SEED_H
#define STP_PREPROCESS_PLANT_PLANT_SEED_H

#include "preprocess/plant/plant_rings.h"

typedef struct stp_plant_seeds {
    uint32_t (*tried)[3]; /* of each vertex: the ways walked, by the lesser neighbour on them */
    uint32_t *set_aside;  /* triangles taken for a while */
} stp_plant_seeds;

/* Room for pieces of so many triangles. Errors: OUT_OF_MEMORY. */
stp_status stp_plant_seeds_create(stp_plant_seeds *out, uint32_t most_triangles, stp_error *err);
void stp_plant_seeds_clear(stp_plant_seeds *seeds);
/* No way of the piece has been walked. */
void stp_plant_seeds_begin(stp_plant_seeds *seeds, const stp_plant_piece *piece);
/* Follows the whole chain, from end to end, that a ring through the vertex is part of, among
 * triangles that are not taken; false if there is none. */
bool stp_plant_seeds_follow(stp_plant_seeds *seeds, stp_plant_rings *rings, uint32_t vertex);

#endif

/* Rings of vertices in a plant's piece, one after the other along a branch (MKC08, section 4.3).
 *
 * Found by topology alone: from a ring on, the triangles around its vertices that are not taken yet
 * must be those of one section, whose other vertices are the next ring: one closed row of three or
 * more, or one vertex (a tip). So a chain goes on until a fork, a border, a tip or a lid (the
 * triangles of a ring alone). Rings need not have equally many vertices. Each step takes time in
 * proportion to its triangles. Threads: one at a time. */
#ifndef STP_PREPROCESS_PLANT_PLANT_RINGS_H
#define STP_PREPROCESS_PLANT_PLANT_RINGS_H

#include "preprocess/plant/plant_piece.h"

/* Most vertices of a ring, and most triangles around one of them. */
enum { STP_PLANT_RING_LIMIT = 64, STP_PLANT_STAR_LIMIT = 128 };

typedef struct stp_plant_rings {
    const stp_plant_piece *piece;
    uint32_t ring_count, vertex_count, triangle_count;
    uint32_t *begins;   /* ring_count + 1 places in vertices */
    uint32_t *vertices; /* each ring's, in order around it */
    uint32_t *sections; /* ring_count places in triangles: section i joins rings i and i + 1 */
    uint32_t *triangles;
    /* All that follows is the search's own. */
    uint8_t *taken;       /* of each triangle */
    uint32_t *ring_of;    /* of each vertex; UINT32_MAX: of none */
    uint32_t (*links)[2]; /* of each vertex: its neighbours in its ring */
    uint8_t *link_counts;
} stp_plant_rings;

/* Room for pieces of so many triangles. Errors: OUT_OF_MEMORY. */
stp_status stp_plant_rings_create(stp_plant_rings *out, uint32_t most_triangles, stp_error *err);
void stp_plant_rings_clear(stp_plant_rings *rings);
/* Nothing of the piece is taken. */
void stp_plant_rings_begin(stp_plant_rings *rings, const stp_plant_piece *piece);
/* Follows the chain from a ring of count vertices, in order, none of which is of a chain. What it
 * takes stays taken. Fewer than two rings: there is no tube. */
void stp_plant_rings_follow(stp_plant_rings *rings, const uint32_t *ring, uint32_t count);
/* Gives back what the last chain took. */
void stp_plant_rings_undo(stp_plant_rings *rings);

#endif

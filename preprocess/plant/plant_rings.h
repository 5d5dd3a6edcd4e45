/* Rings of vertices in a plant's piece, one after the other along a branch (MKC08, section 4.3).
 *
 *     o-----------o-----------o---.
 *     | section 0 | section 1 |    > o
 *     o-----------o-----------o---'
 *   ring 0      ring 1      ring 2   ring 3: a tip
 *
 * Rings are found by topology alone. Take the free triangles around the last ring: they must be
 * exactly one section. Their other vertices are the next ring: one closed row of three or more, or
 * one vertex (a tip). The chain goes on until a fork, a border, a tip or a lid (triangles with
 * corners only in the ring). Rings may differ in their number of vertices. Each step takes time
 * proportional to its triangles. Threads: one at a time. */
#ifndef STP_PREPROCESS_PLANT_PLANT_RINGS_H
#define STP_PREPROCESS_PLANT_PLANT_RINGS_H

#include "preprocess/plant/plant_piece.h"

/* Most vertices of a ring, and most triangles around one of them. */
enum { STP_PLANT_RING_LIMIT = 64, STP_PLANT_STAR_LIMIT = 128 };

typedef struct stp_plant_rings {
    const stp_plant_piece *piece;
    uint32_t ring_count, vertex_count, triangle_count;
    uint32_t *begins;   /* ring_count + 1 places in vertices */
    uint32_t *vertices; /* ring by ring, in order around each */
    uint32_t *sections; /* ring_count places in triangles: section i joins rings i and i + 1 */
    uint32_t *triangles;
    /* The search's own data: */
    uint8_t *taken;       /* of each triangle */
    uint32_t *ring_of;    /* of each vertex; UINT32_MAX: of none */
    uint32_t (*links)[2]; /* of each vertex: its neighbours in its ring */
    uint8_t *link_counts;
} stp_plant_rings;

/* Makes room for pieces of up to most_triangles triangles. Errors: OUT_OF_MEMORY. */
stp_status stp_plant_rings_create(stp_plant_rings *out, uint32_t most_triangles, stp_error *err);
void stp_plant_rings_clear(stp_plant_rings *rings);
/* Begins a piece: none of its triangles is taken. */
void stp_plant_rings_begin(stp_plant_rings *rings, const stp_plant_piece *piece);
/* Follows the chain from a ring of count vertices, in order around it; no vertex belongs to a
 * chain. Triangles that the chain takes stay taken. If the chain has fewer than two rings, there is
 * no tube. */
void stp_plant_rings_follow(stp_plant_rings *rings, const uint32_t *ring, uint32_t count);
/* Gives back the triangles that the last chain took. */
void stp_plant_rings_undo(stp_plant_rings *rings);

#endif

/* Turns branches of a plant's mesh into tubes (MKC08, section 4.3): each ring of a chain becomes a
 * vertex.
 *
 * The vertex's position is the ring's mean. Its direction is the mean of those of the segments on
 * its sides. Its radius is
 *
 *     radius = L / (2 pi),    L: length of the ring, seen along the tube
 *
 * By Cauchy's formula a convex outline of length L is on average as wide as a circle of that
 * radius. So the silhouette keeps its area for any number of vertices. (The paper takes the
 * greatest distance from the mean, which makes a three-sided twig a fifth wider than it looks.) A
 * tip's radius is near zero.
 *
 * Only thin sections become tubes. A section stays triangles if one of its rings has more than the
 * greatest radius or is not roughly a circle. A tube stays triangles if it is not twice as long as
 * wide. A chain's first or last section stays triangles if it flares: a fork begins there, and the
 * ring goes around the fork's other arms. Threads: any, one finder each. */
#ifndef STP_PREPROCESS_PLANT_PLANT_TUBE_H
#define STP_PREPROCESS_PLANT_PLANT_TUBE_H

#include "preprocess/plant/plant_lines.h"
#include "preprocess/plant/plant_rings.h"
#include "preprocess/plant/plant_seed.h"

typedef struct stp_plant_tubes {
    stp_plant_rings rings;
    stp_plant_seeds seeds;
    uint8_t *is_seen;       /* by vertex: its border has been walked */
    uint32_t (*borders)[2]; /* by vertex: its neighbours along open edges */
    uint8_t *border_counts;
    stp_line_vertex *vertices; /* by ring of a chain */
    uint8_t *is_thin;
} stp_plant_tubes;

/* Makes room for pieces of up to most_triangles triangles. Errors: OUT_OF_MEMORY. */
stp_status stp_plant_tubes_create(stp_plant_tubes *out, uint32_t most_triangles, stp_error *err);
void stp_plant_tubes_clear(stp_plant_tubes *tubes);
/* Adds the piece's tubes to lines, and sets the fates of the triangles that they replace to
 * STP_LINE_TUBE. Errors: OUT_OF_MEMORY. */
stp_status stp_plant_tubes_find(stp_plant_tubes *tubes, const stp_plant_piece *piece,
                                double greatest_radius, stp_plant_lines *lines, uint8_t *fates,
                                stp_error *err);

#endif

/* Branches of a plant's mesh to tubes (MKC08, section 4.3): each ring of a chain becomes a vertex.
 *
 * Its position is the ring's mean, its direction the mean of the segments' at its sides. Its radius
 * is the ring's length around, seen along the tube, over 2 pi: by Cauchy's formula a convex outline
 * so long is on average as wide as a circle of that radius, so that the silhouette keeps its area
 * whatever the ring's number of vertices (the paper takes the greatest distance from the mean,
 * which makes a three-sided twig a fifth wider than it looks). A tip's radius is near zero.
 *
 * Only what is thin is a tube. A section stays triangles where a ring of its has more than the
 * greatest radius, or is no rough circle; and so do tubes not twice as long as wide, and a chain's
 * first and last section where they flare: there a fork begins, and the ring goes around its other
 * arms. Threads: any,
 * one finder each. */
#ifndef STP_PREPROCESS_PLANT_PLANT_TUBE_H
#define STP_PREPROCESS_PLANT_PLANT_TUBE_H

#include "preprocess/plant/plant_lines.h"
#include "preprocess/plant/plant_rings.h"
#include "preprocess/plant/plant_seed.h"

typedef struct stp_plant_tubes {
    stp_plant_rings rings;
    stp_plant_seeds seeds;
    uint8_t *is_seen;       /* of each vertex: its border has been walked along */
    uint32_t (*borders)[2]; /* of each vertex: its neighbours along open edges */
    uint8_t *border_counts;
    stp_line_vertex *vertices; /* of each ring of a chain */
    uint8_t *is_thin;
} stp_plant_tubes;

/* Room for pieces of so many triangles. Errors: OUT_OF_MEMORY. */
stp_status stp_plant_tubes_create(stp_plant_tubes *out, uint32_t most_triangles, stp_error *err);
void stp_plant_tubes_clear(stp_plant_tubes *tubes);
/* Adds the piece's tubes to lines, and sets the fates of the mesh's triangles that they replace to
 * STP_LINE_TUBE. Errors: OUT_OF_MEMORY. */
stp_status stp_plant_tubes_find(stp_plant_tubes *tubes, const stp_plant_piece *piece,
                                double greatest_radius, stp_plant_lines *lines, uint8_t *fates,
                                stp_error *err);

#endif

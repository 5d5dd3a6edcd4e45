/* Leaves of a plant's mesh to ribbons (MKC08, section 4.3, generalised).
 *
 * A leaf is a small part all of whose vertices lie on its one border. The border is read as a
 * ribbon in every way there is: its vertices are taken in pairs that face each other across a line
 * through the leaf, which ends in a vertex (a point) or in the middle of a pair (a cut). The best
 * reading is the one whose pairs are most nearly at right angles to the line and whose area is most
 * nearly the leaf's; of about equally good ones the longer one, and that with fewer vertices. Where
 * none is good the part is no leaf.
 *
 * Each pair becomes a vertex: the mean of both, its radius half their distance. A point stays where
 * it is; its radius is near zero. So a leaf of four triangles becomes four vertices, a card of two
 * triangles two. A ribbon ends at its last vertex, cut square (shaders/README.md).
 * Threads: any. */
#ifndef STP_PREPROCESS_PLANT_PLANT_LEAF_H
#define STP_PREPROCESS_PLANT_PLANT_LEAF_H

#include "preprocess/plant/plant_lines.h"
#include "preprocess/plant/plant_piece.h"

enum {
    STP_PLANT_LEAF_VERTICES = 16, /* most of a leaf's border */
    STP_PLANT_RIBBON_VERTICES = STP_PLANT_LEAF_VERTICES / 2 + 1
};

/* The piece as a ribbon; returns how many vertices, 0: it is no leaf, or larger than size_limit
 * (its box's diagonal, the model's unit). Directions are the means of the vertices' normals; those
 * that leave the leaf's own by more than 60 degrees, or are missing, give way to that. */
uint32_t stp_plant_leaf_read(const stp_plant_piece *piece, double size_limit,
                             stp_line_vertex out[STP_PLANT_RIBBON_VERTICES]);

#endif

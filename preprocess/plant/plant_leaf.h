/* Turns leaves of a plant's mesh into ribbons (MKC08, section 4.3, generalised).
 *
 * A leaf is a small part whose vertices all lie on its one border. The border is read as a ribbon
 * in every possible way. A reading pairs vertices that face each other across a line through the
 * leaf. The line ends in a vertex (a point) or in the middle of a pair (a cut).
 *
 *             b---d           pairs: (b, c), (d, e)
 *     point a <    > f        ends: point a and point f
 *             c---e
 *
 * The best reading has pairs most nearly at right angles to the line, and an area most nearly the
 * leaf's. Among readings that are about equally good, a longer one and one with fewer vertices win.
 * If no reading is good, the part is no leaf.
 *
 * Each pair becomes a vertex: its position is the pair's mean, its radius half the pair's distance.
 * A point stays where it is, with a radius near zero. So a leaf of four triangles becomes four
 * vertices, and a card of two triangles becomes two. A ribbon is cut square at its last vertex
 * (shaders/README.md). Threads: any. */
#ifndef STP_PREPROCESS_PLANT_PLANT_LEAF_H
#define STP_PREPROCESS_PLANT_PLANT_LEAF_H

#include "preprocess/plant/plant_lines.h"
#include "preprocess/plant/plant_piece.h"

enum {
    STP_PLANT_LEAF_VERTICES = 16, /* most vertices of a leaf's border */
    STP_PLANT_RIBBON_VERTICES = STP_PLANT_LEAF_VERTICES / 2 + 1
};

/* Reads the piece as a ribbon. Returns the number of vertices; 0: the piece is no leaf, or larger
 * than size_limit (diagonal of its box, in the model's unit). Directions are the means of the
 * vertices' normals. A direction that is missing, or off the leaf's own normal by more than 60
 * degrees, becomes the leaf's own. */
uint32_t stp_plant_leaf_read(const stp_plant_piece *piece, double size_limit,
                             stp_line_vertex out[STP_PLANT_RIBBON_VERTICES]);

#endif

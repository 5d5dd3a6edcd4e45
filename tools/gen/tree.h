/* The plant of `stipple gen tree`, and what is known of it: every ring, every leaf.
 *
 * A trunk carries limbs, limbs carry branches, branches twigs, twigs sprigs. Each is a tube of its
 * own that begins on the axis of its bearer: tapering rings of 8 (trunk, limbs), 6, 5 and 3
 * vertices, joined by long triangles, with one vertex as its tip. Twigs and sprigs end in a leaf of
 * four triangles over six vertices, as in MKC08, section 4.3: two ends and two pairs between.
 * Units: metres, +y up, the root at the origin. Threads: any. */
#ifndef STP_TOOLS_GEN_TREE_H
#define STP_TOOLS_GEN_TREE_H

#include "tools/gen/surface.h"

/* Largest number of vertices. */
#define GEN_TREE_VERTEX_LIMIT ((uint64_t)16 << 20)

enum { GEN_TREE_LEVELS = 5, GEN_LEAF_VERTICES = 6, GEN_LEAF_TRIANGLES = 4 };

/* The vertices lie on a circle around the centre; the axis is the direction of growth. */
typedef struct gen_tree_ring {
    stp_dvec3 centre, axis, side; /* axis and side: unit, at right angles; side: to vertex 0 */
    double radius;
} gen_tree_ring;

/* ring_count rings of `sides` vertices each, then the tip, in this order in the mesh. */
typedef struct gen_tree_tube {
    uint32_t first_ring, ring_count, sides, level;
    uint32_t first_vertex, first_triangle;
} gen_tree_tube;

/* Tubes come first, level by level, then leaves. The vertices of a leaf are: base, first pair,
 * second pair, tip. */
typedef struct gen_tree {
    gen_mesh mesh; /* with normals and colours */
    size_t tube_count, ring_count, leaf_count;
    gen_tree_tube *tubes;
    gen_tree_ring *rings;
    uint32_t first_leaf_vertex, first_leaf_triangle;
} gen_tree;

/* Grows a tree of about vertex_count vertices: at least a few hundred, at most the limit. The same
 * arguments make the same tree. Errors: OUT_OF_MEMORY. */
stp_status gen_tree_grow(gen_tree *out, uint64_t vertex_count, uint64_t seed, stp_error *err);
void gen_tree_clear(gen_tree *tree);

#endif

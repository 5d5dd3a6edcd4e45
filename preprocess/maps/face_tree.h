/* Finds the triangles of a mesh that meet a box. Threads: any number may search a finished tree. */
#ifndef STP_PREPROCESS_MAPS_FACE_TREE_H
#define STP_PREPROCESS_MAPS_FACE_TREE_H

#include "base/vec.h"
#include "formats/scan/mesh/mesh.h"

/* A binary tree of boxes: node k has the children 2 k and 2 k + 1, the root is node 1. */
typedef struct stp_face_tree {
    const stp_mesh *mesh; /* borrowed */
    uint32_t *order;      /* triangles along the Morton curve */
    uint32_t count;       /* of triangles that have an area and finite corners */
    stp_dbox *boxes;      /* by node */
    uint32_t leaf_count;  /* a power of two; leaf i is node leaf_count + i; 0: no triangles */
} stp_face_tree;

/* Errors: OUT_OF_MEMORY, LIMIT (2^32 triangles). Free with stp_face_tree_clear. */
stp_status stp_face_tree_create(stp_face_tree *out, const stp_mesh *mesh, stp_error *err);
void stp_face_tree_clear(stp_face_tree *tree);
/* Lists the triangles whose boxes meet the box, in the tree's order. *out: free with free().
 * Errors: OUT_OF_MEMORY. */
stp_status stp_face_tree_find(const stp_face_tree *tree, const stp_dbox *box, uint32_t **out,
                              size_t *count, stp_error *err);

/* A triangle's corner. */
static inline stp_dvec3 stp_face_corner(const stp_mesh *mesh, uint32_t triangle, int k)
{
    return mesh->positions[mesh->triangles[triangle][k]];
}

#endif

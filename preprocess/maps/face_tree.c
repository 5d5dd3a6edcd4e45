/* Finds the triangles of a mesh that meet a box. */
#include "preprocess/maps/face_tree.h"

#include "base/memory.h"
#include "preprocess/cloud/morton.h"

#include <stdlib.h>

#define LEAF_TRIANGLES 64u

static stp_dbox triangle_box(const stp_mesh *mesh, uint32_t triangle)
{
    stp_dbox box = stp_dbox_empty();
    for (int k = 0; k < 3; k++)
        stp_dbox_add(&box, stp_face_corner(mesh, triangle, k));
    return box;
}

static bool is_valid(const stp_mesh *mesh, uint32_t triangle)
{
    stp_dvec3 at[3];
    for (int k = 0; k < 3; k++) {
        at[k] = stp_face_corner(mesh, triangle, k);
        if (!stp_dvec3_finite(at[k]))
            return false;
    }
    return stp_dvec3_length(
               stp_dvec3_cross(stp_dvec3_sub(at[1], at[0]), stp_dvec3_sub(at[2], at[0]))) > 0.0;
}

static stp_status order_triangles(stp_face_tree *tree, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_mesh *mesh = tree->mesh;
    const uint32_t all = (uint32_t)mesh->triangle_count;
    stp_morton_place *places = NULL;
    stp_dbox box = stp_dbox_empty();
    STP_TRY(stp_alloc(&places, all, sizeof *places, "triangles", err));
    for (uint32_t t = 0; t < all; t++)
        if (is_valid(mesh, t)) {
            const stp_dbox own = triangle_box(mesh, t);
            stp_dbox_join(&box, &own);
            places[tree->count++].index = t;
        }
    const stp_morton_grid grid = stp_morton_grid_of(&box);
    for (uint32_t i = 0; i < tree->count; i++) {
        const stp_dbox own = triangle_box(mesh, places[i].index);
        places[i].code = stp_morton_code(&grid, stp_dbox_middle(&own));
    }
    stp_morton_order(places, tree->count);
    STP_TRY(stp_alloc(&tree->order, tree->count, sizeof *tree->order, "triangles", err));
    for (uint32_t i = 0; i < tree->count; i++)
        tree->order[i] = places[i].index;
done:
    free(places);
    return status;
}

static stp_status make_boxes(stp_face_tree *tree, stp_error *err)
{
    stp_status status = STP_OK;
    tree->leaf_count = tree->count > 0 ? 1 : 0;
    while ((uint64_t)tree->leaf_count * LEAF_TRIANGLES < tree->count)
        tree->leaf_count *= 2;
    const uint32_t leaves = tree->leaf_count;
    STP_TRY(stp_alloc(&tree->boxes, 2 * (size_t)leaves, sizeof *tree->boxes, "boxes", err));
    for (uint32_t k = 0; k < 2 * leaves; k++)
        tree->boxes[k] = stp_dbox_empty();
    for (uint32_t i = 0; i < tree->count; i++) {
        const stp_dbox own = triangle_box(tree->mesh, tree->order[i]);
        stp_dbox_join(&tree->boxes[leaves + i / LEAF_TRIANGLES], &own);
    }
    for (uint32_t k = leaves; k-- > 1;) {
        stp_dbox_join(&tree->boxes[k], &tree->boxes[2 * k]);
        stp_dbox_join(&tree->boxes[k], &tree->boxes[2 * k + 1]);
    }
done:
    return status;
}

stp_status stp_face_tree_create(stp_face_tree *out, const stp_mesh *mesh, stp_error *err)
{
    stp_status status = STP_OK;
    stp_face_tree made = {.mesh = mesh};
    if (mesh->triangle_count > UINT32_MAX)
        return stp_error_set(err, STP_LIMIT,
                             "the meshes have more than 2^32 triangles: split the input into "
                             "several models");
    STP_TRY(order_triangles(&made, err));
    STP_TRY(make_boxes(&made, err));
    *out = made;
    made = (stp_face_tree){0};
done:
    stp_face_tree_clear(&made);
    return status;
}

void stp_face_tree_clear(stp_face_tree *tree)
{
    free(tree->order);
    free(tree->boxes);
    *tree = (stp_face_tree){0};
}

/* The next node after k and all below it, depth first; 0 if there is none. */
static uint32_t node_after(uint32_t k)
{
    while (k & 1u)
        k /= 2;
    return k > 0 ? k + 1 : 0;
}

stp_status stp_face_tree_find(const stp_face_tree *tree, const stp_dbox *box, uint32_t **out,
                              size_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t *found = NULL;
    size_t n = 0, capacity = 0;
    for (uint32_t k = tree->leaf_count > 0; k > 0;) {
        if (!stp_dbox_meet(box, &tree->boxes[k])) {
            k = node_after(k);
            continue;
        }
        if (k < tree->leaf_count) {
            k *= 2;
            continue;
        }
        const uint32_t begin = (k - tree->leaf_count) * LEAF_TRIANGLES;
        STP_TRY(stp_grow(&found, &capacity, n + LEAF_TRIANGLES, sizeof *found, "triangles", err));
        for (uint32_t i = begin; i < begin + LEAF_TRIANGLES && i < tree->count; i++) {
            const stp_dbox own = triangle_box(tree->mesh, tree->order[i]);
            if (stp_dbox_meet(box, &own))
                found[n++] = tree->order[i];
        }
        k = node_after(k);
    }
    *out = found;
    *count = n;
    found = NULL;
done:
    free(found);
    return status;
}

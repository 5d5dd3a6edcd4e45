/* Orders the leaves of a model. */
#include "preprocess/tree/leaf_order.h"

#include "base/memory.h"
#include "preprocess/cloud/morton.h"

#include <stdlib.h>

/* All leaves of a model, kind by kind. */
typedef struct listing {
    stp_leaf_place *places;
    stp_morton_place *codes;
    uint32_t count;
    stp_morton_grid grid;
} listing;

static void list(listing *l, stp_leaf_kind kind, uint32_t index, stp_dvec3 middle)
{
    l->places[l->count] = (stp_leaf_place){kind, index};
    l->codes[l->count] = (stp_morton_place){stp_morton_code(&l->grid, middle), l->count};
    l->count++;
}

stp_status stp_leaf_order(const stp_cloud *cloud, const stp_line_leaves *lines,
                          const stp_triangle_leaves *triangles, stp_leaf_place **out,
                          uint32_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t cells = cloud->cell_count, line_leaves = lines ? lines->leaf_count : 0;
    const uint32_t triangle_leaves = triangles ? triangles->leaf_count : 0;
    const uint32_t all = cells + line_leaves + triangle_leaves;
    listing l = {0};
    stp_leaf_place *places = NULL;
    stp_dbox box = cells > 0 ? cloud->box : stp_dbox_empty();
    if (lines)
        stp_dbox_join(&box, &lines->box);
    if (triangles)
        stp_dbox_join(&box, &triangles->box);
    l.grid = stp_morton_grid_of(&box);
    STP_TRY(stp_alloc(&l.places, all, sizeof *l.places, "chunks", err));
    STP_TRY(stp_alloc(&l.codes, all, sizeof *l.codes, "chunks", err));
    STP_TRY(stp_alloc(&places, all, sizeof *places, "chunks", err));
    for (uint32_t i = 0; i < cells; i++)
        list(&l, STP_LEAF_CELL, i, stp_dbox_middle(&cloud->cells[i].box));
    for (uint32_t i = 0; i < line_leaves; i++)
        list(&l, STP_LEAF_LINES, i, lines->leaves[i].middle);
    for (uint32_t i = 0; i < triangle_leaves; i++)
        list(&l, STP_LEAF_TRIANGLES, i, triangles->leaves[i].middle);
    if (all > cells) /* cells alone are in order already */
        stp_morton_order(l.codes, all);
    for (uint32_t i = 0; i < all; i++)
        places[i] = l.places[l.codes[i].index];
    *out = places;
    *count = all;
done:
    free(l.places);
    free(l.codes);
    return status;
}

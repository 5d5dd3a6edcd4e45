/* In which order the leaves of a model stand. */
#include "preprocess/leaf_order.h"

#include "base/memory.h"
#include "preprocess/morton.h"

#include <stdlib.h>

typedef struct coded_leaf {
    uint64_t code;
    stp_leaf_place place;
} coded_leaf;

static int compare_leaves(const void *a, const void *b)
{
    const coded_leaf *x = a, *y = b;
    if (x->code != y->code)
        return x->code < y->code ? -1 : 1;
    if (x->place.kind != y->place.kind)
        return x->place.kind < y->place.kind ? -1 : 1;
    return x->place.index < y->place.index ? -1 : x->place.index > y->place.index;
}

stp_status stp_leaf_order(const stp_cloud *cloud, const stp_line_leaves *lines,
                          const stp_triangle_leaves *triangles, stp_leaf_place **out,
                          uint32_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t cells = cloud->cell_count, line_leaves = lines ? lines->leaf_count : 0;
    const uint32_t triangle_leaves = triangles ? triangles->leaf_count : 0;
    const uint32_t all = cells + line_leaves + triangle_leaves;
    coded_leaf *coded = NULL;
    stp_leaf_place *places = NULL;
    uint32_t at = 0;
    stp_dbox box = cells > 0 ? cloud->box : stp_dbox_empty();
    if (lines)
        stp_dbox_join(&box, &lines->box);
    if (triangles)
        stp_dbox_join(&box, &triangles->box);
    const stp_morton_grid grid = stp_morton_grid_of(&box);
    STP_TRY(stp_alloc(&coded, all, sizeof *coded, "chunks", err));
    STP_TRY(stp_alloc(&places, all, sizeof *places, "chunks", err));
    for (uint32_t i = 0; i < cells; i++)
        coded[at++] = (coded_leaf){stp_morton_code(&grid, stp_dbox_middle(&cloud->cells[i].box)),
                                   {STP_LEAF_CELL, i}};
    for (uint32_t i = 0; i < line_leaves; i++)
        coded[at++] =
            (coded_leaf){stp_morton_code(&grid, lines->leaves[i].middle), {STP_LEAF_LINES, i}};
    for (uint32_t i = 0; i < triangle_leaves; i++)
        coded[at++] = (coded_leaf){stp_morton_code(&grid, triangles->leaves[i].middle),
                                   {STP_LEAF_TRIANGLES, i}};
    if (all > cells)
        qsort(coded, all, sizeof *coded, compare_leaves);
    for (uint32_t i = 0; i < all; i++)
        places[i] = coded[i].place;
    *out = places;
    *count = all;
done:
    free(coded);
    return status;
}

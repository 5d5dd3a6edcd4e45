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
    if (x->place.is_lines != y->place.is_lines)
        return x->place.is_lines ? 1 : -1;
    return x->place.index < y->place.index ? -1 : x->place.index > y->place.index;
}

static stp_dvec3 middle_of(const stp_dbox *box)
{
    return stp_dvec3_scale(stp_dvec3_add(box->min, box->max), 0.5);
}

stp_status stp_leaf_order(const stp_cloud *cloud, const stp_line_leaves *lines,
                          stp_leaf_place **out, uint32_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t cells = cloud->cell_count, all = cells + (lines ? lines->leaf_count : 0);
    coded_leaf *coded = NULL;
    stp_leaf_place *places = NULL;
    stp_dbox box = cells > 0 ? cloud->box : stp_dbox_empty();
    if (lines)
        stp_dbox_join(&box, &lines->box);
    const stp_morton_grid grid = stp_morton_grid_of(&box);
    STP_TRY(stp_alloc(&coded, all, sizeof *coded, "chunks", err));
    STP_TRY(stp_alloc(&places, all, sizeof *places, "chunks", err));
    for (uint32_t i = 0; i < all; i++) {
        const bool is_lines = i >= cells;
        const uint32_t index = is_lines ? i - cells : i;
        stp_dvec3 at = is_lines ? lines->leaves[index].middle : middle_of(&cloud->cells[index].box);
        coded[i] = (coded_leaf){stp_morton_code(&grid, at), {is_lines, index}};
    }
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

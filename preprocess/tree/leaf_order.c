/* Orders the leaves of a model. */
#include "preprocess/tree/leaf_order.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_blocks.h"
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

stp_dbox stp_leaf_sources_box(const stp_cloud *cloud, const stp_leaf_sources *from)
{
    stp_dbox box = cloud->count > 0 ? cloud->box : stp_dbox_empty();
    if (from->lines)
        stp_dbox_join(&box, &from->lines->box);
    if (from->triangles)
        stp_dbox_join(&box, &from->triangles->box);
    if (from->grid)
        stp_dbox_join(&box, &from->grid->box);
    if (from->maps)
        stp_dbox_join(&box, &from->maps->box);
    return box;
}

static void list_all(listing *l, const stp_cloud *cloud, const stp_leaf_sources *from)
{
    for (uint32_t i = 0; i < cloud->cell_count; i++)
        if (!from->depths ||
            stp_depth_loose(from->depths, cloud->cells[i].begin, cloud->cells[i].end) > 0)
            list(l, STP_LEAF_CELL, i, stp_dbox_middle(&cloud->cells[i].box));
    for (uint32_t i = 0; from->lines && i < from->lines->leaf_count; i++)
        list(l, STP_LEAF_LINES, i, from->lines->leaves[i].middle);
    for (uint32_t i = 0; from->triangles && i < from->triangles->leaf_count; i++)
        list(l, STP_LEAF_TRIANGLES, i, from->triangles->leaves[i].middle);
    for (uint32_t i = 0; from->grid && i < stp_height_grid_tile_count(from->grid); i++)
        if (from->grid->tile_samples[i] > 0)
            list(l, STP_LEAF_TILE, i, stp_height_grid_tile_middle(from->grid, i));
    for (uint32_t i = 0; from->maps && i < from->maps->leaf_count; i++)
        list(l, STP_LEAF_MAPS, i, from->maps->leaves[i].middle);
    for (uint32_t i = 0; from->depths && i < from->depths->leaf_count; i++)
        list(l, STP_LEAF_DEPTHS, i, from->depths->leaves[i].middle);
}

stp_status stp_leaf_order(const stp_cloud *cloud, const stp_leaf_sources *from,
                          stp_leaf_place **out, uint32_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t most = cloud->cell_count + (from->lines ? from->lines->leaf_count : 0) +
                          (from->triangles ? from->triangles->leaf_count : 0) +
                          (from->grid ? stp_height_grid_tile_count(from->grid) : 0) +
                          (from->maps ? from->maps->leaf_count : 0) +
                          (from->depths ? from->depths->leaf_count : 0);
    const stp_dbox box = stp_leaf_sources_box(cloud, from);
    listing l = {.grid = stp_morton_grid_of(&box)};
    stp_leaf_place *places = NULL;
    STP_TRY(stp_alloc(&l.places, most, sizeof *l.places, "chunks", err));
    STP_TRY(stp_alloc(&l.codes, most, sizeof *l.codes, "chunks", err));
    STP_TRY(stp_alloc(&places, most, sizeof *places, "chunks", err));
    list_all(&l, cloud, from);
    if (l.count > 0 && l.places[l.count - 1].kind != STP_LEAF_CELL) /* cells alone are in order */
        stp_morton_order(l.codes, l.count);
    for (uint32_t i = 0; i < l.count; i++)
        places[i] = l.places[l.codes[i].index];
    *out = places;
    *count = l.count;
done:
    free(l.places);
    free(l.codes);
    return status;
}

bool stp_leaves_are_whole_grid(const stp_leaf_sources *from, const stp_leaf_place *leaves,
                               uint32_t count)
{
    uint32_t tiles = 0;
    for (uint32_t i = 0; i < count; i++)
        tiles += leaves[i].kind == STP_LEAF_TILE;
    return from->grid && tiles == count &&
           from->grid->count == (uint64_t)from->grid->raster.columns * from->grid->raster.rows;
}

void stp_leaf_ask(const stp_cloud *cloud, const stp_leaf_sources *from, const stp_leaf_place *leaf)
{
    if (leaf->kind == STP_LEAF_DEPTHS)
        stp_depth_leaf_ask(from->depths, leaf->index);
    if (leaf->kind == STP_LEAF_MAPS)
        stp_map_leaf_ask(from->maps, leaf->index);
    if (leaf->kind != STP_LEAF_CELL)
        return;
    const stp_cell *cell = &cloud->cells[leaf->index];
    const stp_rank_part own = stp_cloud_own(cloud);
    for (uint64_t i = cell->begin; i < cell->end; i++)
        if (i < own.begin || i >= own.end)
            (void)stp_cloud_has(cloud, i);
}

/* Builds the leaf of a cell of the cloud. */
#include "preprocess/tree/point_leaf.h"

#include "base/memory.h"
#include "preprocess/patch/lattice.h"

#include <math.h>
#include <stdlib.h>

/* What is kept of a point until it becomes an item. */
typedef struct leaf_point {
    uint32_t at; /* place in the cell */
    int exponent;
} leaf_point;

typedef struct point_leaf {
    const stp_cloud *cloud;
    const stp_point_item_params *params;
    uint64_t begin; /* of the cell */
    leaf_point *points;
    uint32_t count;
} point_leaf;

static uint64_t place_of(const point_leaf *l, uint32_t i)
{
    return l->begin + l->points[i].at;
}

static const stp_cloud_point *point_of(const point_leaf *l, uint32_t i)
{
    return &l->cloud->points[place_of(l, i)];
}

static void take_points(point_leaf *l, const stp_cell *cell, const uint64_t *only)
{
    for (uint64_t i = cell->begin; i < cell->end; i++) {
        const stp_cloud_point *p = &l->cloud->points[i];
        const uint64_t bit = i - l->cloud->first;
        if (only && !(only[bit / 64] >> bit % 64 & 1u))
            continue;
        l->points[l->count++] =
            (leaf_point){(uint32_t)(i - cell->begin),
                         stp_point_exponent(p->position, (double)p->spacing, l->params)};
    }
}

/* Settles the lattices. Returns the extent of the items. */
static stp_chunk_extent settle(point_leaf *l)
{
    stp_chunk_extent all = stp_chunk_extent_none(l->params->vertex_least);
    double most = 0.0;
    for (uint32_t i = 0; i < l->count; i++)
        stp_dbox_add(&all.box, point_of(l, i)->position);
    const int finest = stp_point_finest(stp_dbox_side(&all.box));
    for (uint32_t i = 0; i < l->count; i++) {
        const stp_cloud_point *p = point_of(l, i);
        const int exponent = stp_point_exponent_lifted(p->position, l->points[i].exponent, finest);
        l->points[i].exponent = exponent;
        all.finest = exponent < all.finest ? exponent : all.finest;
        all.coarsest = exponent > all.coarsest ? exponent : all.coarsest;
        most = stp_max(most, stp_point_spacing_on((double)p->spacing, exponent, l->params));
    }
    all.area = most * most;
    all.bound = stp_radius_on_grid(l->params->lambda * most, 0.0, STP_RADII_BY_OCTAVE);
    return all;
}

/* stp_run_maker. */
static void make_items(const void *context, const uint32_t *order, uint32_t count, stp_item *items)
{
    const point_leaf *l = context;
    for (uint32_t i = 0; i < count; i++)
        stp_point_item_make(&items[i], l->cloud, place_of(l, order[i]),
                            l->points[order[i]].exponent, l->params);
}

/* stp_place_maker. */
static void make_places(const void *context, stp_dvec3 origin, stp_place *places)
{
    const point_leaf *l = context;
    for (uint32_t i = 0; i < l->count; i++) {
        const uint64_t at = place_of(l, i);
        const stp_cloud_point *point = &l->cloud->points[at];
        const vec3s p = stp_dvec3_to_float(stp_dvec3_sub(point->position, origin));
        const vec3s n = stp_cloud_normal(l->cloud, at);
        places[i] = (stp_place){.key = {p.x, p.y, p.z, n.x, n.y, n.z},
                                .spacing = (float)stp_point_spacing_on(
                                    (double)point->spacing, l->points[i].exponent, l->params),
                                .sheet = l->cloud->sheets[at]};
    }
}

stp_status stp_point_leaf_build(stp_built_chunk *out, const stp_cloud *cloud, const stp_cell *cell,
                                const uint64_t *only, const stp_point_item_params *params,
                                stp_error *err)
{
    stp_status status = STP_OK;
    point_leaf l = {.cloud = cloud, .params = params, .begin = cell->begin};
    STP_TRY(stp_alloc_unset(&l.points, cell->end - cell->begin, sizeof *l.points, "samples", err));
    take_points(&l, cell, only);
    const stp_chunk_extent extent = settle(&l);
    const stp_item_group group = {.make = make_items,
                                  .places = make_places,
                                  .context = &l,
                                  .extent = &extent,
                                  .count = l.count};
    STP_TRY(stp_chunk_build_leaf(out, &group, params, err));
done:
    free(l.points);
    return status;
}

/* Counts points, samples and distances again after gaps were filled. */
#include "preprocess/gaps/map_account.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/maps/face_tree.h"
#include "preprocess/maps/map_distance.h"
#include "preprocess/maps/map_try.h"

#include <stdlib.h>
#include <string.h>

/* A point this near to a map of its own part, in its spacings, needs no other surface. */
#define NEAR_SPACINGS 0.25

typedef struct accounting {
    const stp_maps *maps;
    const stp_cloud *cloud;
    const stp_maps_params *params;
    const stp_map_owners *owners;
    stp_mesh seams; /* cells at borders, and the triangles between; vertices are borrowed */
    stp_face_tree tree;
    stp_maps_counts *counts; /* by cell */
} accounting;

static stp_status make_seams(accounting *a, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_map_fill *fill = &a->maps->fill;
    const stp_mesh *border = &fill->border.mesh;
    stp_mesh *seams = &a->seams;
    seams->positions = border->positions;
    seams->vertex_count = border->vertex_count;
    seams->triangle_count = border->triangle_count + fill->count;
    STP_TRY(
        stp_alloc(&seams->triangles, seams->triangle_count, sizeof *seams->triangles, "maps", err));
    if (border->triangle_count > 0)
        memcpy(seams->triangles, border->triangles,
               border->triangle_count * sizeof *seams->triangles);
    if (fill->count > 0)
        memcpy(seams->triangles + border->triangle_count, fill->triangles,
               fill->count * sizeof *seams->triangles);
    STP_TRY(stp_face_tree_create(&a->tree, seams, err));
done:
    return status;
}

/* The distance from the seams, if that is within the limit. */
static stp_status seam_distance(const accounting *a, stp_dvec3 p, double limit, double *out,
                                stp_error *err)
{
    stp_status status = STP_OK;
    const stp_dbox at = {p, p}, box = stp_dbox_grown(&at, limit);
    uint32_t *found = NULL;
    size_t count = 0;
    *out = INFINITY;
    STP_TRY(stp_face_tree_find(&a->tree, &box, &found, &count, err));
    for (size_t i = 0; i < count; i++) {
        const stp_dvec3 corners[3] = {stp_face_corner(&a->seams, found[i], 0),
                                      stp_face_corner(&a->seams, found[i], 1),
                                      stp_face_corner(&a->seams, found[i], 2)};
        *out = stp_min(*out, stp_triangle_distance(p, corners));
    }
done:
    free(found);
    return status;
}

static stp_status account_point(const accounting *a, uint32_t i, stp_maps_counts *counts,
                                stp_error *err)
{
    stp_status status = STP_OK;
    const stp_map_owners *owners = a->owners;
    const stp_cloud_point *point = &a->cloud->points[i];
    const double limit = stp_map_limit(a->cloud, a->params, i);
    const uint32_t part = owners->numbers[i];
    double distance = INFINITY, seam = INFINITY;
    for (uint32_t m = owners->first[part]; m < owners->first[part + 1]; m++)
        distance = stp_min(distance, stp_map_distance(&a->maps->maps[m], point->position));
    if (distance > NEAR_SPACINGS * (double)point->spacing)
        STP_TRY(seam_distance(a, point->position, limit, &seam, err));
    distance = stp_min(distance, seam);
    owners->mapped[i] = distance <= limit;
    if (owners->mapped[i])
        stp_maps_counts_add(counts, distance);
done:
    return status;
}

static stp_status account_cell(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    const accounting *a = context;
    const stp_cell *cell = &a->cloud->cells[index];
    (void)worker;
    for (uint32_t i = (uint32_t)cell->begin; i < cell->end; i++)
        if (a->owners->mapped[i])
            STP_TRY(account_point(a, i, &a->counts[index], err));
done:
    return status;
}

/* Counts maps and samples, and finds their box. */
static void count_maps(stp_maps *maps)
{
    maps->box = stp_dbox_empty();
    for (uint32_t m = 0; m < maps->count; m++) {
        const stp_map *map = &maps->maps[m];
        maps->counts.maps += map->count > 0;
        maps->counts.samples += map->count;
        for (uint32_t row = 0; row < map->rows && map->count > 0; row++)
            for (uint32_t column = 0; column < map->columns; column++)
                if (stp_map_at(map, column, row)->flags & STP_MAP_SUPPORTED)
                    stp_dbox_add(&maps->box, stp_map_world(map, column, row));
    }
}

stp_status stp_maps_account(stp_maps *maps, const stp_cloud *cloud, const stp_maps_params *params,
                            const stp_map_owners *owners, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    accounting a = {.maps = maps, .cloud = cloud, .params = params, .owners = owners};
    stp_ranks *ranks = cloud->blocks ? cloud->blocks->ranks : NULL;
    STP_TRY(make_seams(&a, err));
    STP_TRY(stp_alloc(&a.counts, cloud->cell_count, sizeof *a.counts, "maps", err));
    STP_TRY(stp_cloud_run_own(cloud, pool, account_cell, &a, err));
    for (unsigned rank = 0; rank < stp_ranks_count(ranks); rank++) {
        const stp_rank_part part = stp_cloud_cells(cloud, ranks, rank);
        STP_TRY(stp_ranks_broadcast(ranks, rank, a.counts + part.begin,
                                    (part.end - part.begin) * sizeof *a.counts, err));
    }
    maps->counts =
        (stp_maps_counts){.between = maps->fill.count, .open_edges = maps->fill.open_edges};
    count_maps(maps);
    for (uint32_t c = 0; c < cloud->cell_count; c++) {
        maps->counts.represented += a.counts[c].represented;
        maps->counts.greatest = stp_max(maps->counts.greatest, a.counts[c].greatest);
        maps->counts.sum += a.counts[c].sum;
    }
done:
    stp_face_tree_clear(&a.tree);
    free(a.seams.triangles);
    free(a.counts);
    return status;
}

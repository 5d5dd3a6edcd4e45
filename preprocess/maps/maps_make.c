/* Makes elevation maps of a cloud's surface. */
#include "preprocess/maps/maps_make.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/gaps/map_account.h"
#include "preprocess/gaps/map_trim.h"
#include "preprocess/maps/maps_share.h"
#include "preprocess/maps/part_merge.h"

#include <stdatomic.h>
#include <stdlib.h>

/* Cells are cut into parts that keep this share of the cone, and at most so many degrees. If parts
 * are small, merging chooses where maps meet: there are fewer maps. But cuts by planes are
 * straighter, so gaps between them are filled better. */
#define CUT_SHARE 0.75
#define CUT_MOST 45.0

typedef struct work {
    stp_cloud *cloud;
    const stp_maps_params *params;
    const stp_progress *progress;
    stp_face_tree faces;
    double cut_cosine; /* of the cone that parts keep before they are merged */
    stp_cell_parts *cells;
    uint32_t cell_count;  /* before points leave the cloud, and cells with them */
    uint32_t *cell_first; /* by cell: the number of its first part among all */
    uint32_t part_count;
    stp_part *parts;   /* of all cells */
    uint32_t *numbers; /* by point: its part in its cell, then among all, then its merged part */
    bool *mapped;      /* by point: a map stands for it */
    uint32_t *order;   /* places, merged part after merged part */
    uint32_t *begins;  /* by merged part: where its places begin; then their number */
    uint32_t merged_count;
    stp_rank_part own;         /* cells, then merged parts, of this rank */
    uint32_t *map_first;       /* by merged part: its first map; then the number of maps */
    stp_map_list *lists;       /* by merged part */
    atomic_uint_fast64_t done; /* points, of twice as many: cut, then sampled */
} work;

static stp_status advance(work *w, uint64_t points, stp_error *err)
{
    const uint64_t all = 2 * (uint64_t)w->cloud->count / stp_ranks_count(w->params->ranks);
    const uint64_t done = atomic_fetch_add(&w->done, points) + points;
    return stp_progress_update(w->progress, "maps", done < all ? done : all, all, err);
}

static stp_status cut_cell(void *context, size_t place, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    work *w = context;
    const uint32_t index = (uint32_t)(w->own.begin + place);
    const stp_cell *cell = &w->cloud->cells[index];
    (void)worker;
    STP_TRY(stp_cell_parts_cut(&w->cells[index], w->cloud, index, w->cut_cosine, w->numbers, err));
    STP_TRY(advance(w, cell->end - cell->begin, err));
done:
    return status;
}

/* Cuts this rank's cells, and gets the parts of the others. */
static stp_status cut_cells(work *w, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = w->params->ranks;
    w->own = stp_cloud_cells(w->cloud, ranks, ranks ? ranks->self : 0);
    STP_TRY(stp_cloud_run(w->cloud, pool, w->own.end - w->own.begin, cut_cell, w, err));
    STP_TRY(stp_cell_parts_share(ranks, w->cloud, w->cells, w->numbers, err));
done:
    return status;
}

/* Numbers the parts of all cells, and moves them to one array. */
static stp_status number_parts(work *w, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cloud *cloud = w->cloud;
    STP_TRY(stp_alloc(&w->cell_first, cloud->cell_count, sizeof *w->cell_first, "maps", err));
    for (uint32_t c = 0; c < cloud->cell_count; c++) {
        w->cell_first[c] = w->part_count;
        w->part_count += w->cells[c].part_count;
    }
    STP_TRY(stp_alloc(&w->parts, w->part_count, sizeof *w->parts, "maps", err));
    for (uint32_t c = 0; c < cloud->cell_count; c++) {
        for (uint32_t p = 0; p < w->cells[c].part_count; p++) {
            w->parts[w->cell_first[c] + p] = w->cells[c].parts[p];
            w->cells[c].parts[p].corners = NULL;
        }
        for (uint64_t i = cloud->cells[c].begin; i < cloud->cells[c].end; i++)
            if (w->numbers[i] != STP_PART_NONE)
                w->numbers[i] += w->cell_first[c];
        stp_spill_relieve(cloud->spill);
    }
done:
    return status;
}

/* Lists the pairs of all cells, and those across cells. */
static stp_status list_pairs(const work *w, stp_part_pair **out, size_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_part_pair *pairs = NULL;
    size_t n = 0, most = 0;
    for (uint32_t c = 0; c < w->cloud->cell_count; c++)
        most += w->cells[c].pair_count + w->cells[c].border_count;
    STP_TRY(stp_alloc(&pairs, most, sizeof *pairs, "maps", err));
    for (uint32_t c = 0; c < w->cloud->cell_count; c++) {
        const stp_cell_parts *cell = &w->cells[c];
        const uint32_t first = w->cell_first[c];
        for (size_t i = 0; i < cell->pair_count; i++)
            pairs[n++] = (stp_part_pair){first + cell->pairs[i].a, first + cell->pairs[i].b};
        for (size_t i = 0; i < cell->border_count; i++) {
            const uint32_t other = w->numbers[cell->borders[i].place];
            if (other != STP_PART_NONE)
                pairs[n++] = stp_part_pair_of(first + cell->borders[i].part, other);
        }
    }
    *count = stp_part_pairs_sort(pairs, n);
    *out = pairs;
done:
    return status;
}

/* Numbers the merged parts that are large enough in the order of their first points, and sorts the
 * places by them. The other parts are none. */
static stp_status order_places(work *w, const uint32_t *roots, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud *cloud = w->cloud;
    uint32_t *merged = NULL; /* by root: one more than its number, or 0 */
    STP_TRY(stp_alloc(&merged, w->part_count, sizeof *merged, "maps", err));
    STP_TRY(stp_alloc(&w->begins, (size_t)w->part_count + 2, sizeof *w->begins, "maps", err));
    STP_TRY(stp_spill_alloc(cloud->spill, &w->order, cloud->count, sizeof *w->order, "maps", err));
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i)) {
        if (w->numbers[i] == STP_PART_NONE)
            continue;
        uint32_t *number = &merged[roots[w->numbers[i]]];
        if (w->parts[roots[w->numbers[i]]].points < STP_MAP_POINTS_LEAST) {
            w->numbers[i] = STP_PART_NONE;
            continue;
        }
        if (*number == 0)
            *number = ++w->merged_count;
        w->numbers[i] = *number - 1;
        w->begins[*number + 1]++;
    }
    for (uint32_t m = 0; m < w->merged_count; m++)
        w->begins[m + 2] += w->begins[m + 1];
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i))
        if (w->numbers[i] != STP_PART_NONE)
            w->order[w->begins[w->numbers[i] + 1]++] = i;
done:
    free(merged);
    return status;
}

static stp_status merge_parts(work *w, stp_error *err)
{
    stp_status status = STP_OK;
    stp_part_pair *pairs = NULL;
    size_t pair_count = 0;
    uint32_t *roots = NULL;
    stp_part_field field = {0};
    const double cone_rad = w->params->cone_deg * M_PI / 180.0;
    STP_TRY(list_pairs(w, &pairs, &pair_count, err));
    STP_TRY(stp_part_field_create(&field, w->cloud, w->numbers, w->part_count, cone_rad, err));
    STP_TRY(stp_parts_merge(w->parts, w->part_count, pairs, pair_count, cos(cone_rad), &field,
                            &roots, err));
    stp_part_field_clear(&field);
    STP_TRY(order_places(w, roots, err));
done:
    stp_part_field_clear(&field);
    free(pairs);
    free(roots);
    return status;
}

static stp_status sample_one(void *context, size_t place, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    work *w = context;
    const uint32_t index = (uint32_t)(w->own.begin + place);
    const uint32_t begin = w->begins[index], count = w->begins[index + 1] - begin;
    (void)worker;
    STP_TRY(stp_map_list_make(&w->lists[index], w->cloud, w->params,
                              w->params->mesh ? &w->faces : NULL, w->numbers, w->mapped,
                              w->order + begin, count, err));
    STP_TRY(advance(w, count, err));
done:
    return status;
}

/* Samples this rank's merged parts, and gets the maps of the others. */
static stp_status sample_parts(work *w, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = w->params->ranks;
    STP_TRY(stp_alloc(&w->lists, w->merged_count, sizeof *w->lists, "maps", err));
    w->own = stp_maps_rank_part(ranks, ranks ? ranks->self : 0, w->begins, w->merged_count);
    STP_TRY(stp_cloud_run(w->cloud, pool, w->own.end - w->own.begin, sample_one, w, err));
    STP_TRY(stp_map_lists_share(ranks, w->cloud, w->lists, w->begins, w->merged_count, w->order,
                                w->mapped, err));
done:
    return status;
}

static int compare_guests(const void *a, const void *b)
{
    const stp_map_guest *p = a, *q = b;
    if (p->place != q->place)
        return p->place < q->place ? -1 : 1;
    if (p->distance != q->distance)
        return p->distance < q->distance ? -1 : 1;
    return (p->list > q->list) - (p->list < q->list);
}

/* Gives each guest to the map that it is nearest to, and numbers it as that map's points. */
static stp_status settle_guests(work *w, stp_error *err)
{
    stp_status status = STP_OK;
    stp_map_guest *guests = NULL;
    size_t count = 0, n = 0;
    for (uint32_t m = 0; m < w->merged_count; m++)
        count += w->lists[m].guest_count;
    STP_TRY(stp_alloc(&guests, count, sizeof *guests, "points", err));
    for (uint32_t m = 0; m < w->merged_count; m++)
        for (size_t i = 0; i < w->lists[m].guest_count; i++) {
            guests[n] = w->lists[m].guests[i];
            guests[n++].list = m;
        }
    if (n > 0)
        qsort(guests, n, sizeof *guests, compare_guests);
    for (size_t i = 0; i < n; i++) {
        bool *mapped = &w->mapped[guests[i].place];
        if (*mapped)
            continue;
        stp_maps_counts_add(&w->lists[guests[i].list].counts, guests[i].distance);
        w->numbers[guests[i].place] = guests[i].list;
        *mapped = true;
    }
done:
    free(guests);
    return status;
}

/* Makes all lists one. */
static stp_status gather(work *w, stp_maps *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_maps all = {.box = stp_dbox_empty(), .spill = w->cloud->spill};
    for (uint32_t m = 0; m < w->merged_count; m++)
        all.counts.maps += w->lists[m].count;
    STP_TRY(stp_alloc(&all.maps, all.counts.maps, sizeof *all.maps, "maps", err));
    STP_TRY(
        stp_alloc(&w->map_first, (size_t)w->merged_count + 1, sizeof *w->map_first, "maps", err));
    for (uint32_t m = 0; m < w->merged_count; m++) {
        stp_map_list *list = &w->lists[m];
        for (size_t i = 0; i < list->count; i++)
            all.maps[all.count++] = list->maps[i];
        if (list->count > 0)
            stp_dbox_join(&all.box, &list->box);
        list->count = 0; /* the maps have moved */
        w->map_first[m + 1] = all.count;
        all.counts.samples += list->counts.samples;
        all.counts.represented += list->counts.represented;
        all.counts.greatest = stp_max(all.counts.greatest, list->counts.greatest);
        all.counts.sum += list->counts.sum;
    }
    *out = all;
done:
    return status;
}

/* Makes the maps disjoint, fills what is between them, and counts again. */
static stp_status fill_gaps(work *w, stp_maps *maps, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_map_owners owners = {w->numbers, w->map_first, w->mapped};
    STP_TRY(stp_maps_trim(maps->maps, maps->count, err));
    STP_TRY(stp_map_fill_create(&maps->fill, maps->maps, maps->count, err));
    STP_TRY(stp_maps_account(maps, w->cloud, w->params, &owners, pool, err));
done:
    return status;
}

/* Removes the points that maps stand for. Cells that have become small are joined. */
static void keep_others(stp_cloud *cloud, const bool *mapped)
{
    uint32_t kept = 0, cells = 0;
    for (uint32_t c = 0; c < cloud->cell_count; c++) {
        const stp_cell cell = cloud->cells[c];
        const uint32_t begin = kept;
        for (uint64_t i = cell.begin; i < cell.end; i++) {
            if (mapped[i])
                continue;
            cloud->points[kept] = cloud->points[i];
            cloud->sheets[kept] = cloud->sheets[i];
            cloud->marks[kept++] = cloud->marks[i];
        }
        stp_spill_relieve(cloud->spill);
        if (kept == begin)
            continue;
        if (cells > 0 && kept - cloud->cells[cells - 1].begin <= STP_CELL_POINTS)
            cloud->cells[cells - 1].end = kept;
        else
            cloud->cells[cells++] = (stp_cell){.begin = begin, .end = kept};
    }
    for (uint32_t c = 0; c < cells; c++) {
        stp_cell *cell = &cloud->cells[c];
        cell->box = stp_points_box(cloud->points + cell->begin, cell->end - cell->begin);
    }
    cloud->count = kept;
    cloud->cell_count = cells;
}

static void clear_work(work *w)
{
    for (uint32_t c = 0; w->cells && c < w->cell_count; c++)
        stp_cell_parts_clear(&w->cells[c]);
    free(w->cells);
    for (uint32_t p = 0; w->parts && p < w->part_count; p++)
        free(w->parts[p].corners);
    free(w->parts);
    for (uint32_t m = 0; w->lists && m < w->merged_count; m++)
        stp_map_list_clear(&w->lists[m], w->cloud->spill);
    free(w->lists);
    free(w->cell_first);
    free(w->begins);
    free(w->map_first);
    stp_spill_free(w->cloud->spill, w->numbers);
    stp_spill_free(w->cloud->spill, w->order);
    stp_spill_free(w->cloud->spill, w->mapped);
    stp_face_tree_clear(&w->faces);
}

stp_status stp_maps_make(stp_maps *out, stp_cloud *cloud, const stp_maps_params *params,
                         stp_pool *pool, const stp_progress *progress, stp_error *err)
{
    stp_status status = STP_OK;
    const double cone = params->cone_deg;
    const double cut_deg = params->fill ? cone : fmin(CUT_SHARE * cone, CUT_MOST);
    work w = {.cloud = cloud,
              .cell_count = cloud->cell_count,
              .params = params,
              .progress = progress,
              .cut_cosine = cos(cut_deg * M_PI / 180.0)};
    STP_TRY(stp_alloc(&w.cells, cloud->cell_count, sizeof *w.cells, "maps", err));
    STP_TRY(
        stp_spill_alloc(cloud->spill, &w.numbers, cloud->count, sizeof *w.numbers, "maps", err));
    STP_TRY(stp_spill_alloc(cloud->spill, &w.mapped, cloud->count, sizeof *w.mapped, "maps", err));
    STP_TRY(cut_cells(&w, pool, err));
    STP_TRY(number_parts(&w, err));
    STP_TRY(merge_parts(&w, err));
    if (params->mesh)
        STP_TRY(stp_face_tree_create(&w.faces, params->mesh, err));
    STP_TRY(sample_parts(&w, pool, err));
    STP_TRY(settle_guests(&w, err));
    STP_TRY(gather(&w, out, err));
    if (params->fill)
        STP_TRY(fill_gaps(&w, out, pool, err));
    out->paper = params->paper;
    out->counts.as_points = cloud->count - out->counts.represented;
    keep_others(cloud, w.mapped);
done:
    clear_work(&w);
    return status;
}

void stp_maps_clear(stp_maps *maps)
{
    for (uint32_t i = 0; i < maps->count; i++)
        stp_spill_free(maps->spill, maps->maps[i].samples);
    free(maps->maps);
    stp_map_fill_clear(&maps->fill);
    *maps = (stp_maps){0};
}

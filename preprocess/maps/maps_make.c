/* Makes elevation maps of a cloud's surface. */
#include "preprocess/maps/maps_make.h"

#include "base/memory.h"
#include "preprocess/gaps/map_account.h"
#include "preprocess/gaps/map_trim.h"
#include "preprocess/maps/maps_share.h"
#include "preprocess/maps/maps_work.h"
#include "preprocess/maps/parts/part_merge.h"
#include "preprocess/maps/parts/part_within.h"

#include <stdlib.h>
#include <string.h>

/* Cells are cut into parts that keep this share of the cone, and at most so many degrees. If parts
 * are small, merging chooses where maps meet: there are fewer maps. But cuts by planes are
 * straighter, so gaps between them are filled better. */
#define CUT_SHARE 0.75
#define CUT_MOST 45.0

typedef stp_maps_work work;

static stp_status advance(work *w, uint64_t points, stp_error *err)
{
    const uint64_t all = 2 * (uint64_t)w->cloud->count / stp_ranks_count(w->ranks);
    const uint64_t done = atomic_fetch_add(&w->done_points, points) + points;
    return stp_progress_update(w->progress, "maps", done < all ? done : all, all, err);
}

/* Runs a task for each of some cells or lists, again for those that missed points of other ranks.
 */
static stp_status run_all(work *w, stp_rank_part part, stp_pool *pool, stp_pool_task *task,
                          stp_error *err)
{
    stp_status status = STP_OK;
    for (uint64_t left = 1; left > 0;) {
        STP_TRY(stp_cloud_run(w->cloud, pool, part.end - part.begin, task, w, err));
        left = 0;
        for (uint64_t i = part.begin; i < part.end; i++)
            left += !w->done[i];
        STP_TRY(stp_cloud_sum(w->cloud, &left, 1, err));
        STP_TRY(stp_cloud_fetch(w->cloud, err));
    }
done:
    return status;
}

static stp_status cut_cell(void *context, size_t place, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    work *w = context;
    const uint32_t index = (uint32_t)(stp_cloud_own_cells(w->cloud).begin + place);
    const stp_cell *cell = &w->cloud->cells[index];
    bool missed = false;
    stp_cloud seen = *w->cloud;
    seen.missed = &missed;
    (void)worker;
    if (w->done[index])
        return STP_OK;
    STP_TRY(stp_cell_parts_cut(&w->cells[index], &seen, index, w->cut_cosine, w->numbers, err));
    if (missed) /* other ranks have points around the cell: they come before the next try */
        goto done;
    seen.spill = NULL; /* what a cell needs is small */
    STP_TRY(stp_cell_parts_merge(&w->cells[index], &seen, index, w->params->cone_deg * M_PI / 180.0,
                                 w->numbers, err));
    w->done[index] = true;
    STP_TRY(advance(w, cell->end - cell->begin, err));
done:
    return status;
}

/* Cuts the own cells, and gets the parts of the others. */
static stp_status cut_cells(work *w, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_alloc(&w->done, w->cell_count, sizeof *w->done, "maps", err));
    STP_TRY(run_all(w, stp_cloud_own_cells(w->cloud), pool, cut_cell, err));
    STP_TRY(stp_cell_parts_share(w->ranks, w->cloud, w->cells, err));
done:
    free(w->done);
    w->done = NULL;
    return status;
}

/* Numbers the parts of all cells, and moves them to one array. */
static stp_status number_parts(work *w, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cloud *cloud = w->cloud;
    const unsigned ranks = stp_ranks_count(w->ranks);
    STP_TRY(stp_alloc(&w->cell_first, cloud->cell_count, sizeof *w->cell_first, "maps", err));
    for (uint32_t c = 0; c < cloud->cell_count; c++) {
        w->cell_first[c] = w->part_count;
        w->part_count += w->cells[c].part_count;
    }
    STP_TRY(stp_alloc(&w->parts, w->part_count, sizeof *w->parts, "maps", err));
    for (uint32_t c = 0; c < cloud->cell_count; c++) {
        stp_cell_parts *cell = &w->cells[c];
        for (uint32_t p = 0; p < cell->part_count; p++)
            w->parts[w->cell_first[c] + p] = cell->parts[p];
        free(cell->parts);
        cell->parts = NULL;
    }
    STP_TRY(stp_alloc(&w->part_firsts, (size_t)ranks + 1, sizeof *w->part_firsts, "ranks", err));
    for (unsigned rank = 1; rank <= ranks; rank++) {
        const uint64_t cell = rank < ranks ? stp_cloud_cells(cloud, w->ranks, rank).begin : 0;
        const bool none = rank == ranks || cell == cloud->cell_count;
        w->part_firsts[rank] = none ? w->part_count : w->cell_first[cell];
    }
    const stp_rank_part own = stp_cloud_own_cells(cloud);
    for (uint64_t c = own.begin; c < own.end; c++, stp_spill_relieve(cloud->spill))
        for (uint64_t i = cloud->cells[c].begin; i < cloud->cells[c].end; i++)
            if (w->numbers[i] != STP_PART_NONE)
                w->numbers[i] += w->cell_first[c];
done:
    return status;
}

/* Lists the pairs of all cells, and those across cells. */
static stp_status list_pairs(const work *w, stp_bytes *out, size_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_rank_part own = stp_cloud_own_cells(w->cloud);
    for (uint64_t c = own.begin; c < own.end; c++) {
        const stp_cell_parts *cell = &w->cells[c];
        for (size_t i = 0; i < cell->border_count; i++) {
            const uint32_t other = w->numbers[cell->borders[i].place];
            const stp_part_pair pair =
                stp_part_pair_of(w->cell_first[c] + cell->borders[i].part, other);
            if (other != STP_PART_NONE)
                STP_TRY(stp_bytes_append(out, &pair, sizeof pair, err));
        }
    }
    out->size = stp_part_pairs_sort((stp_part_pair *)out->data, out->size / sizeof(stp_part_pair)) *
                sizeof(stp_part_pair);
    if (w->ranks)
        STP_TRY(stp_ranks_join(w->ranks, out, err));
    for (uint32_t c = 0; c < w->cloud->cell_count; c++)
        for (size_t i = 0; i < w->cells[c].pair_count; i++) {
            const stp_part_pair *pair = &w->cells[c].pairs[i];
            const stp_part_pair both = {w->cell_first[c] + pair->a, w->cell_first[c] + pair->b};
            STP_TRY(stp_bytes_append(out, &both, sizeof both, err));
        }
    *count = stp_part_pairs_sort((stp_part_pair *)out->data, out->size / sizeof(stp_part_pair));
done:
    return status;
}

/* Merges parts, and forgets what is known of cells. */
static stp_status merge_parts(work *w, stp_error *err)
{
    stp_status status = STP_OK;
    stp_bytes pairs = {0};
    size_t pair_count = 0;
    uint32_t *roots = NULL;
    stp_part_field field = {0};
    const double cone_rad = w->params->cone_deg * M_PI / 180.0;
    STP_TRY(stp_cloud_refresh(w->cloud, STP_ARRAY_NUMBERS, err));
    STP_TRY(list_pairs(w, &pairs, &pair_count, err));
    stp_cloud_let_go(w->cloud);
    for (uint32_t c = 0; c < w->cell_count; c++)
        stp_cell_parts_clear(&w->cells[c]);
    STP_TRY(stp_part_field_create(&field, w->cloud, stp_cloud_own(w->cloud), w->numbers,
                                  w->part_count, w->ranks ? w->part_firsts : NULL, cone_rad, err));
    STP_TRY(stp_parts_merge(w->parts, w->part_count, (const stp_part_pair *)pairs.data, pair_count,
                            cos(cone_rad), &field, &roots, err));
    stp_part_field_clear(&field);
    STP_TRY(stp_maps_number_lists(w, roots, err));
    STP_TRY(stp_maps_find_places(w, err));
done:
    stp_part_field_clear(&field);
    free(pairs.data);
    free(roots);
    return status;
}

static stp_status sample_one(void *context, size_t place, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    work *w = context;
    const uint32_t index = (uint32_t)(w->own.begin + place);
    const uint32_t count = w->begins[index + 1] - w->begins[index];
    uint32_t *places = w->places + stp_maps_place_begin(w, index);
    bool *taken = w->taken + stp_maps_place_begin(w, index);
    bool missed = false;
    stp_cloud seen = *w->cloud;
    seen.missed = &missed;
    (void)worker;
    if (w->done[index])
        return STP_OK;
    STP_TRY(stp_map_list_make(&w->lists[index], &seen, w->params,
                              w->params->mesh ? &w->faces : NULL, w->numbers, places, taken, count,
                              err));
    if (missed) /* other ranks have points of the list or around it */
        goto done;
    w->done[index] = true;
    STP_TRY(advance(w, count, err));
done:
    return status;
}

/* Samples the own lists, and gets the maps of the others, without samples unless all need them. */
static stp_status sample_parts(work *w, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_alloc(&w->lists, w->list_count, sizeof *w->lists, "maps", err));
    STP_TRY(stp_alloc(&w->done, w->list_count, sizeof *w->done, "maps", err));
    STP_TRY(run_all(w, w->own, pool, sample_one, err));
    stp_cloud_let_go(w->cloud);
    STP_TRY(stp_maps_mark_taken(w, err));
    STP_TRY(stp_maps_settle_guests(w, err));
    STP_TRY(
        stp_map_lists_share(w->ranks, w->cloud, w->lists, w->list_firsts, w->params->fill, err));
done:
    return status;
}

/* Makes all lists one. */
static stp_status gather(work *w, stp_maps *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_maps all = {.box = stp_dbox_empty(), .spill = w->cloud->spill};
    for (uint32_t m = 0; m < w->list_count; m++)
        all.counts.maps += w->lists[m].count;
    STP_TRY(stp_alloc(&all.maps, all.counts.maps, sizeof *all.maps, "maps", err));
    STP_TRY(stp_alloc(&w->map_first, (size_t)w->list_count + 1, sizeof *w->map_first, "maps", err));
    if (w->ranks && !w->params->fill) {
        all.ranks = w->ranks;
        STP_TRY(
            stp_alloc(&all.firsts, (size_t)w->ranks->count + 1, sizeof *all.firsts, "ranks", err));
    }
    for (uint32_t m = 0; m < w->list_count; m++) {
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
    for (unsigned rank = 0; all.ranks && rank <= all.ranks->count; rank++)
        all.firsts[rank] = w->map_first[w->list_firsts[rank]];
    *out = all;
    all = (stp_maps){0};
done:
    free(all.maps);
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

static void clear_work(work *w)
{
    for (uint32_t c = 0; w->cells && c < w->cell_count; c++)
        stp_cell_parts_clear(&w->cells[c]);
    free(w->cells);
    for (uint32_t p = 0; w->parts && p < w->part_count; p++)
        free(w->parts[p].corners);
    free(w->parts);
    for (uint32_t m = 0; w->lists && m < w->list_count; m++)
        stp_map_list_clear(&w->lists[m], w->cloud->spill);
    free(w->lists);
    free(w->done);
    free(w->cell_first);
    free(w->part_firsts);
    free(w->list_firsts);
    free(w->begins);
    free(w->map_first);
    if (w->cloud->blocks)
        w->cloud->blocks->numbers = NULL;
    stp_spill_free(w->cloud->spill, w->numbers);
    stp_spill_free(w->cloud->spill, w->places);
    stp_spill_free(w->cloud->spill, w->taken);
    stp_spill_free(w->cloud->spill, w->mapped);
    stp_face_tree_clear(&w->faces);
}

/* Makes the arrays by point. */
static stp_status begin(work *w, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud *cloud = w->cloud;
    STP_TRY(stp_alloc(&w->cells, cloud->cell_count, sizeof *w->cells, "maps", err));
    STP_TRY(stp_cloud_array(cloud, &w->numbers, sizeof *w->numbers, "maps", err));
    STP_TRY(stp_cloud_array(cloud, &w->mapped, sizeof *w->mapped, "maps", err));
    if (cloud->blocks)
        cloud->blocks->numbers = w->numbers;
done:
    return status;
}

stp_status stp_maps_make(stp_maps *out, stp_cloud *cloud, const stp_maps_params *params,
                         stp_pool *pool, const stp_progress *progress, stp_error *err)
{
    stp_status status = STP_OK;
    const double cone = params->cone_deg;
    const double cut_deg = params->fill ? cone : fmin(CUT_SHARE * cone, CUT_MOST);
    work w = {.cloud = cloud,
              .ranks = cloud->blocks ? cloud->blocks->ranks : NULL,
              .cell_count = cloud->cell_count,
              .params = params,
              .progress = progress,
              .cut_cosine = cos(cut_deg * M_PI / 180.0)};
    STP_TRY(begin(&w, err));
    STP_TRY(cut_cells(&w, pool, err));
    STP_TRY(number_parts(&w, err));
    STP_TRY(merge_parts(&w, err));
    if (params->mesh)
        STP_TRY(stp_face_tree_create(&w.faces, params->mesh, err));
    STP_TRY(sample_parts(&w, pool, err));
    STP_TRY(gather(&w, out, err));
    if (params->fill)
        STP_TRY(fill_gaps(&w, out, pool, err));
    out->paper = params->paper;
    out->counts.as_points = cloud->count - out->counts.represented;
    STP_TRY(stp_maps_keep_others(&w, pool, err));
done:
    clear_work(&w);
    return status;
}

void stp_maps_clear(stp_maps *maps)
{
    for (uint32_t i = 0; i < maps->count; i++)
        stp_spill_free(maps->spill, maps->maps[i].samples);
    free(maps->maps);
    free(maps->firsts);
    stp_map_fill_clear(&maps->fill);
    *maps = (stp_maps){0};
}

/* Runs the units on the pool. */
#include "preprocess/surface/surface.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/surface/given_normals.h"
#include "preprocess/surface/normals.h"
#include "preprocess/surface/scattered.h"
#include "preprocess/surface/surface_ranks.h"

#include <stdatomic.h>
#include <stdlib.h>

/* Each thread finds at least this many units left as large as the one it takes. */
#define LEFT_BY_THREAD 3u

typedef struct finding {
    stp_cloud *cloud;
    const stp_surface_params *params;
    const stp_progress *progress;
    atomic_uint_fast64_t done_count, grown_count, errors[STP_NORMAL_ERROR_BINS];
    stp_rank_part own;   /* cells that this rank looks at */
    uint32_t *unit_ends; /* by unit: one past its last cell */
    bool *unit_done;
    uint32_t unit_count;
    uint64_t own_points;
    stp_graph *graphs; /* by cell */
    vec3s *averaged;   /* averaged normals by point, if given ones are noisy: a copy, since units
                          still read the given ones */
} finding;

/* Groups consecutive cells of this rank into units, smaller ones towards the end, so that threads
 * end at about the same time. */
static stp_status make_units(finding *f, unsigned threads, stp_error *err)
{
    const stp_cloud *cloud = f->cloud;
    stp_status status =
        stp_alloc(&f->unit_ends, cloud->cell_count, sizeof *f->unit_ends, "cells", err);
    f->own =
        stp_cloud_cells(cloud, f->params->ranks, f->params->ranks ? f->params->ranks->self : 0);
    if (status == STP_OK)
        status = stp_alloc(&f->unit_done, cloud->cell_count, sizeof *f->unit_done, "cells", err);
    if (f->own.end > f->own.begin)
        f->own_points = cloud->cells[f->own.end - 1].end - cloud->cells[f->own.begin].begin;
    for (uint64_t c = f->own.begin, begin = c; status == STP_OK && c < f->own.end; c++) {
        const bool last = c + 1 == f->own.end;
        const uint64_t first = cloud->cells[begin].begin;
        const uint64_t left = cloud->cells[f->own.end - 1].end - first;
        const uint64_t share = left / (LEFT_BY_THREAD * threads);
        const uint64_t most = f->params->unit_points;
        if (last || cloud->cells[c + 1].end - first > (share < most ? share : most)) {
            f->unit_ends[f->unit_count++] = (uint32_t)(c + 1);
            begin = c + 1;
        }
    }
    return status;
}

/* Writes a unit's results to the cloud. Returns how many planes are wide. */
static uint64_t write_back(stp_cloud *cloud, const stp_unit *unit)
{
    uint64_t wide = 0;
    for (uint32_t i = 0; i < unit->ring_end[0]; i++) {
        stp_cloud_point *out = &cloud->points[unit->places[i]];
        out->spacing = unit->cloud.points[i].spacing;
        if (!out->given)
            out->normal = unit->cloud.points[i].normal;
        if (unit->wide && unit->wide[i]) {
            cloud->marks[unit->places[i]] |= unit->wide[i];
            wide++;
        }
    }
    return wide;
}

static stp_status find_unit(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    finding *f = context;
    stp_unit unit = {0};
    stp_normal_errors errors = {{0}};
    const uint32_t first = index > 0 ? f->unit_ends[index - 1] : (uint32_t)f->own.begin;
    const uint32_t end = f->unit_ends[index];
    unsigned rings = f->params->pieces ? STP_UNIT_RINGS : STP_UNIT_RINGS - 1;
    bool missed = false;
    stp_cloud seen = *f->cloud;
    seen.missed = &missed;
    (void)worker;
    if (f->unit_done[index])
        return STP_OK;
    STP_TRY(stp_unit_create(&unit, &seen, first, end, f->params->k, rings, err));
    if (missed) /* other ranks have points around the unit: they come before the next try */
        goto done;
    STP_TRY(stp_normals_estimate(
        &unit, f->params->shifts ? f->params->shifts + unit.places[0] : NULL, &errors, err));
    for (unsigned i = 0; i < STP_NORMAL_ERROR_BINS; i++)
        atomic_fetch_add(&f->errors[i], errors.counts[i]);
    for (uint32_t c = first; f->graphs && c < end; c++)
        STP_TRY(
            stp_graph_create(&f->graphs[c], &unit, &f->cloud->cells[c], f->params->stations, err));
    if (f->averaged)
        stp_given_average(f->averaged + unit.places[0], &unit);
    atomic_fetch_add(&f->grown_count, write_back(f->cloud, &unit));
    stp_scattered_mark(f->cloud, &unit);
    f->unit_done[index] = true;
    uint64_t done = atomic_fetch_add(&f->done_count, unit.ring_end[0]) + unit.ring_end[0];
    status = stp_progress_update(f->progress, f->params->shifts ? "layers" : "surface", done,
                                 f->own_points, err);
done:
    stp_unit_clear(&unit);
    return status;
}

/* Runs the units, those again that missed points of other ranks. */
static stp_status find_units(finding *f, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    for (uint64_t left = 1; left > 0;) {
        STP_TRY(stp_cloud_run(f->cloud, pool, f->unit_count, find_unit, f, err));
        left = 0;
        for (uint32_t i = 0; i < f->unit_count; i++)
            left += !f->unit_done[i];
        STP_TRY(stp_cloud_sum(f->cloud, &left, 1, err));
        STP_TRY(stp_cloud_fetch(f->cloud, err));
    }
    stp_cloud_let_go(f->cloud);
done:
    return status;
}

/* Adds up what the ranks counted. */
static stp_status sum_counts(stp_surface_counts *found, stp_normal_errors *errors, finding *f,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = f->params->ranks;
    for (unsigned rank = 0; rank < stp_ranks_count(ranks); rank++) {
        uint64_t counts[STP_NORMAL_ERROR_BINS + 1] = {atomic_load(&f->grown_count)};
        for (unsigned i = 0; i < STP_NORMAL_ERROR_BINS; i++)
            counts[i + 1] = atomic_load(&f->errors[i]);
        STP_TRY(stp_ranks_broadcast(ranks, rank, counts, sizeof counts, err));
        found->grown += counts[0];
        for (unsigned i = 0; i < STP_NORMAL_ERROR_BINS; i++) {
            found->computed += counts[i + 1];
            errors->counts[i] += counts[i + 1];
        }
    }
    found->normal_error = stp_normal_errors_median(errors);
done:
    return status;
}

/* Replaces noisy given normals by the averaged ones. Returns how many. */
static uint64_t take_averaged(finding *f)
{
    uint64_t count = 0;
    const stp_rank_part own = stp_cloud_own(f->cloud);
    for (uint64_t i = own.begin; i < own.end; i++) {
        stp_cloud_step(f->cloud->spill, i);
        if (f->cloud->points[i].given != STP_GIVEN_INPUT)
            continue;
        f->cloud->points[i].normal = f->averaged[i];
        f->cloud->marks[i] |= STP_MARK_WIDE;
        count++;
    }
    return count;
}

void stp_surface_clear(stp_graph **graphs, const stp_cloud *cloud)
{
    for (uint32_t c = 0; *graphs && c < cloud->cell_count; c++)
        stp_graph_clear(&(*graphs)[c], cloud->spill);
    free(*graphs);
    *graphs = NULL;
}

stp_status stp_surface_find(stp_graph **graphs, stp_cloud *cloud, const stp_surface_params *params,
                            stp_surface_counts *counts, stp_pool *pool,
                            const stp_progress *progress, stp_error *err)
{
    stp_status status = STP_OK;
    finding f = {.cloud = cloud, .params = params, .progress = progress};
    stp_surface_counts found = {0};
    stp_normal_errors errors = {{0}};
    bool noisy = false;
    STP_TRY(make_units(&f, stp_pool_thread_count(pool), err));
    if (params->pieces)
        STP_TRY(stp_alloc(&f.graphs, cloud->cell_count, sizeof *f.graphs, "cells", err));
    STP_TRY(stp_given_noisy(cloud, &noisy, err));
    if (noisy)
        STP_TRY(stp_cloud_array(cloud, &f.averaged, sizeof *f.averaged, "normals", err));
    STP_TRY(find_units(&f, pool, err));
    STP_TRY(stp_surface_share(params->ranks, cloud,
                              &(stp_surface_arrays){f.graphs, f.averaged, params->shifts}, err));
    found.averaged = f.averaged ? take_averaged(&f) : 0;
    STP_TRY(stp_cloud_sum(cloud, &found.averaged, 1, err));
    STP_TRY(sum_counts(&found, &errors, &f, err));
    if (counts)
        *counts = found;
    *graphs = f.graphs;
    f.graphs = NULL;
done:
    stp_surface_clear(&f.graphs, cloud);
    stp_spill_free(cloud->spill, f.averaged);
    free(f.unit_ends);
    free(f.unit_done);
    return status;
}

/* Cuts cells that are too wide for one chunk's lattices. */
#include "preprocess/tree/cell_cut.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/tree/chunk_build.h"

#include <stdlib.h>

typedef struct cutter {
    stp_cloud *cloud;
    const stp_point_item_params *params;
    bool *fits; /* by cell */
    stp_cell *cells;
    size_t count, capacity;
} cutter;

static void add_spacing(stp_chunk_extent *e, const cutter *c, stp_dvec3 position, double spacing)
{
    stp_chunk_extent_add(e, position, spacing * spacing, c->params->lambda * spacing,
                         stp_point_exponent(position, spacing, c->params));
}

/* Whether the cell fits, wherever in it the points of least and greatest spacing lie. */
static stp_status check_cell(void *context, size_t index, unsigned worker, stp_error *err)
{
    const cutter *c = context;
    const stp_cell *cell = &c->cloud->cells[index];
    stp_chunk_extent e = stp_chunk_extent_none(c->params->vertex_least);
    float least = INFINITY, most = 0.0f;
    (void)worker;
    (void)err;
    for (uint64_t i = cell->begin; i < cell->end; i++) {
        least = fminf(least, c->cloud->points[i].spacing);
        most = fmaxf(most, c->cloud->points[i].spacing);
    }
    add_spacing(&e, c, cell->box.min, (double)least);
    add_spacing(&e, c, cell->box.max, (double)most);
    c->fits[index] = least > 0.0f && stp_chunk_extent_fits(&e);
    return STP_OK;
}

static stp_status add_cell(cutter *c, uint64_t begin, uint64_t end, stp_error *err)
{
    stp_status status =
        stp_grow(&c->cells, &c->capacity, c->count + 1, sizeof *c->cells, "cells", err);
    if (status == STP_OK)
        c->cells[c->count++] =
            (stp_cell){begin, end, stp_points_box(c->cloud->points + begin, end - begin)};
    return status;
}

/* Cuts the cell into runs of points, each as long as it fits. Points that only rounding separates
 * do not ask for a finer lattice. */
static stp_status cut_cell(cutter *c, const stp_cell *cell, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_extent run = stp_chunk_extent_none(c->params->vertex_least);
    uint64_t begin = cell->begin;
    for (uint64_t i = cell->begin; i < cell->end; i++) {
        const stp_cloud_point *p = &c->cloud->points[i];
        stp_chunk_extent more = run;
        add_spacing(&more, c, p->position, (double)p->spacing);
        if (stp_point_is_rounded(p->position, more.finest))
            more.finest = run.finest;
        if (i > begin && !stp_chunk_extent_fits(&more)) {
            STP_TRY(add_cell(c, begin, i, err));
            begin = i;
            more = stp_chunk_extent_none(c->params->vertex_least);
            add_spacing(&more, c, p->position, (double)p->spacing);
        }
        run = more;
    }
    STP_TRY(add_cell(c, begin, cell->end, err));
done:
    return status;
}

stp_status stp_cells_cut(stp_cloud *cloud, const stp_point_item_params *params, stp_pool *pool,
                         stp_error *err)
{
    stp_status status = STP_OK;
    cutter c = {.cloud = cloud, .params = params};
    const stp_rank_part own = stp_cloud_own_cells(cloud);
    uint64_t wide = 0;
    STP_TRY(stp_alloc(&c.fits, cloud->cell_count, sizeof *c.fits, "cells", err));
    STP_TRY(stp_cloud_run_own(cloud, pool, check_cell, &c, err));
    for (uint64_t i = own.begin; i < own.end; i++)
        wide += !c.fits[i];
    STP_TRY(stp_cloud_sum(cloud, &wide, 1, err));
    for (uint64_t i = own.begin; i < own.end && wide > 0; i++) {
        const stp_cell *cell = &cloud->cells[i];
        STP_TRY(c.fits[i] ? add_cell(&c, cell->begin, cell->end, err) : cut_cell(&c, cell, err));
    }
    if (wide > 0) {
        uint32_t count = (uint32_t)c.count;
        STP_TRY(stp_cloud_join_cells(cloud, &c.cells, &count, err));
        free(cloud->cells);
        cloud->cells = c.cells;
        cloud->cell_count = count;
        c.cells = NULL;
    }
done:
    free(c.cells);
    free(c.fits);
    return status;
}

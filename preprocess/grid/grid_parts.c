/* Puts grids of heights of several files into one. */
#include "preprocess/grid/grid_parts.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

/* Columns and rows go on if they are off by no more than this part of a cell. */
#define OFF_MOST 1e-4
#define WORD 64u

/* Whole cells from one raster to the other, and its far ends, along x and down y. False if they are
 * not whole. */
static bool find_place(const stp_scan_raster *from, const stp_scan_raster *to, double first[2],
                       double end[2])
{
    const double cells[2] = {(to->x - from->x) / from->dx, (from->y - to->y) / from->dy};
    const double steps[2] = {to->dx / from->dx, to->dy / from->dy};
    const uint32_t counts[2] = {to->columns, to->rows};
    for (int k = 0; k < 2; k++) {
        first[k] = nearbyint(cells[k]);
        end[k] = first[k] + counts[k];
        if (!(fabs(cells[k] - first[k]) <= OFF_MOST &&
              fabs(steps[k] - 1.0) * counts[k] <= OFF_MOST))
            return false;
    }
    return true;
}

bool stp_grid_parts_join(stp_scan_raster *out, const stp_scan_raster *parts, size_t count)
{
    double low[2] = {0.0, 0.0}, high[2] = {0.0, 0.0}; /* from the first part's first sample */
    for (size_t i = 0; i < count; i++) {
        double first[2], end[2];
        if (!find_place(&parts[0], &parts[i], first, end))
            return false;
        for (int k = 0; k < 2; k++) {
            low[k] = fmin(low[k], first[k]);
            high[k] = fmax(high[k], end[k]);
        }
    }
    const double columns = high[0] - low[0], rows = high[1] - low[1];
    if (columns * rows >= UINT32_MAX)
        return false;
    *out = parts[0];
    out->order = 0;
    out->columns = (uint32_t)columns;
    out->rows = (uint32_t)rows;
    out->x += low[0] * out->dx;
    out->y -= low[1] * out->dy;
    return true;
}

stp_grid_part stp_grid_part_at(const stp_scan_raster *whole, const stp_scan_raster *file,
                               uint64_t first)
{
    return (stp_grid_part){.first = first,
                           .count = (uint64_t)file->columns * file->rows,
                           .column = (uint32_t)nearbyint((file->x - whole->x) / whole->dx),
                           .row = (uint32_t)nearbyint((whole->y - file->y) / whole->dy),
                           .raster = *file};
}

stp_status stp_grid_part_begin(stp_grid_part *part, const stp_height_grid *grid,
                               const stp_scan_raster *file, uint64_t first, stp_error *err)
{
    stp_grid_part next = stp_grid_part_at(&grid->raster, file, first);
    next.box = grid->box;
    const stp_status status =
        stp_alloc(&next.there, (size_t)(next.count / WORD + 1), sizeof *next.there, "marks", err);
    if (status != STP_OK)
        return status;
    for (uint64_t i = 0; i < next.count; i++)
        if (!isnan(grid->z[stp_grid_part_place(&next, &grid->raster, i)]))
            next.there[i / WORD] |= UINT64_C(1) << i % WORD;
    stp_grid_part_clear(part);
    *part = next;
    return STP_OK;
}

uint64_t stp_grid_part_place(const stp_grid_part *part, const stp_scan_raster *whole,
                             uint64_t index)
{
    uint32_t at[2];
    stp_scan_raster_find(&part->raster, index, at);
    return (uint64_t)(part->row + at[1]) * whole->columns + part->column + at[0];
}

bool stp_grid_parts_overlap(const stp_grid_part *parts, size_t count)
{
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < i; k++) {
            const stp_grid_part *a = &parts[i], *b = &parts[k];
            if (a->column < b->column + b->raster.columns &&
                b->column < a->column + a->raster.columns && a->row < b->row + b->raster.rows &&
                b->row < a->row + a->raster.rows)
                return true;
        }
    return false;
}

void stp_grid_part_forget(const stp_grid_part *part, stp_height_grid *grid)
{
    for (uint64_t i = 0; i < part->count; i++) {
        const uint64_t place = stp_grid_part_place(part, &grid->raster, i);
        if (!(part->there[i / WORD] >> i % WORD & 1) && !isnan(grid->z[place]))
            stp_height_grid_unset(grid, place);
    }
    grid->box = part->box;
}

void stp_grid_part_clear(stp_grid_part *part)
{
    free(part->there);
    *part = (stp_grid_part){0};
}

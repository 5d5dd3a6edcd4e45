/* Makes the rasters of all inputs one. */
#include "tools/prep/prep_grids.h"

#include "base/memory.h"
#include "preprocess/grid/grid_parts.h"

#include <math.h>
#include <stdlib.h>

/* Places of the whole for each record, at most. */
#define PLACES_A_RECORD 4.0

/* Whether the corners of a file's raster lie where another file's way moves them. */
static bool is_moved_by(const stp_prep_file *file, stp_projection *way)
{
    const stp_scan_raster *r = &file->raster;
    if (!way || !file->raster_nodes)
        return way == NULL && file->raster_nodes == NULL;
    const uint32_t across = stp_raster_node_count(r->columns);
    const uint32_t down = stp_raster_node_count(r->rows);
    const uint32_t nodes[2][2] = {{0, 0}, {across - 1, down - 1}};
    for (int k = 0; k < 2; k++) {
        const uint32_t column = stp_raster_node_column(nodes[k][0], r->columns);
        const uint32_t row = stp_raster_node_column(nodes[k][1], r->rows);
        const stp_dvec3 moved = stp_projection_apply(way, stp_scan_raster_at(r, column, row, 0.0));
        const stp_dvec3 there = file->raster_nodes[(size_t)nodes[k][1] * across + nodes[k][0]];
        if (moved.x != there.x || moved.y != there.y)
            return false;
    }
    return true;
}

/* Lists the rasters of the inputs that can be read. Returns how many, or 0 if some input has none
 * or is moved in another way than `way`. */
static size_t list_parts(const prep_inputs *in, stp_projection *way, stp_scan_raster *parts)
{
    size_t count = 0;
    for (size_t i = 0; i < in->count; i++) {
        if (in->facts[i].why)
            continue;
        if (in->files[i].raster.columns == 0 || !is_moved_by(&in->files[i], way))
            return 0;
        parts[count++] = in->files[i].raster;
    }
    return count;
}

static stp_status join(prep_inputs *in, stp_prep_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    stp_scan_raster *parts = NULL;
    stp_prep_file whole = {0};
    size_t first = 0;
    while (in->facts[first].why) /* one input at least can be read */
        first++;
    stp_projection *way = in->facts[first].way.projection;
    STP_TRY(stp_alloc(&parts, in->count, sizeof *parts, "grids", err));
    const size_t count = list_parts(in, way, parts);
    if (count == 0 || !stp_grid_parts_join(&whole.raster, parts, count) ||
        (double)whole.raster.columns * whole.raster.rows >
            PLACES_A_RECORD * (double)source->point_count)
        goto done;
    if (way)
        STP_TRY(prep_system_move_raster(&whole, way, err));
    in->raster_nodes = whole.raster_nodes;
    source->raster = whole.raster;
    source->raster_nodes = whole.raster_nodes;
done:
    free(parts);
    return status;
}

stp_status prep_grids_find(prep_inputs *in, stp_prep_source *source, stp_error *err)
{
    if (in->count > 1)
        return in->numbers.joined.list.count > 0 ? STP_OK : join(in, source, err);
    source->raster = in->files[0].raster;
    source->raster_nodes = in->files[0].raster_nodes;
    return STP_OK;
}

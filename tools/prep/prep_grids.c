/* Makes the rasters of all inputs one, and says why it cannot. */
#include "tools/prep/prep_grids.h"

#include "base/memory.h"
#include "preprocess/grid/grid_parts.h"

#include <math.h>
#include <stdio.h>
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

/* What of the options needs points one by one; NULL: none. */
static const char *option_against(const stp_prep_params *params, bool appends, bool heights)
{
    return appends                                            ? "--append adds points"
           : params->maps                                     ? "--maps makes maps of points"
           : params->join_layers                              ? "--layers joined moves points"
           : heights && params->outliers != STP_OUTLIERS_KEEP ? "--outliers looks at points"
           : heights && params->orient != STP_ORIENT_AUTO     ? "--orient turns points"
                                                              : NULL;
}

/* Why the input's own rows and columns are none; NULL: they may be. */
static const char *own_fault(const prep_inputs *in, const stp_prep_file *file)
{
    if (file->raster.columns > 0)
        return in->params.recompute_normals ? "--recompute-normals asks points for them" : NULL;
    if (file->image_count > 0)
        return NULL;
    if (file->station_count > 1)
        return "it holds several scans";
    if (file->grid.columns == 0)
        return "none are read from it";
    return file->station_count == 0    ? "it does not say from where its points were seen"
           : file->grid.cell_count > 0 ? "it tells them of some points alone"
                                       : NULL;
}

void prep_grids_print(const stp_prep_stats *stats, const prep_inputs *in,
                      const stp_prep_params *params, bool appends)
{
    const char *path = in->paths[0];
    size_t heights = 0, read = 0;
    for (size_t i = 0; i < in->count; i++)
        if (!in->facts[i].why) {
            heights += in->files[i].raster.columns > 0;
            read++;
        }
    const bool is_mixed = heights > 0 && heights < read;
    if (stats->keeps_grid || stats->images > 0 || (heights == 0 && !in->params.keep_grid))
        return;
    const char *why = option_against(params, appends, heights > 0);
    for (size_t i = 0; !why && !is_mixed && i < in->count; i++)
        if (!in->facts[i].why) {
            why = own_fault(in, &in->files[i]);
            path = in->paths[i];
        }
    if (!why)
        why = heights == 0 ? "many points lie more than a quarter of a pixel off its rays, or most "
                             "of its pixels are missing"
              : is_mixed   ? "other inputs are no grids of heights"
              : read > 1 && in->numbers.joined.list.count > 0
                  ? "--attributes keeps numbers of points"
              : read > 1 ? "those of the inputs do not go on from one to the other"
                         : "its map is torn";
    fprintf(stderr, "%s: rows and columns are not kept: %s\n", path, why);
}

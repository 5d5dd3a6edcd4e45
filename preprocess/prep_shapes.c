/* Cuts lines and triangles into leaves. */
#include "preprocess/prep_job.h"

static uint64_t shape_bytes(const stp_line_set *lines, const stp_triangle_set *triangles)
{
    uint64_t bytes = 0;
    if (lines)
        bytes += lines->vertex_count * (sizeof *lines->vertices + sizeof(stp_strip_part) / 8) +
                 lines->strip_count * sizeof(stp_strip_part);
    if (triangles)
        bytes += triangles->vertex_count * (sizeof *triangles->vertices + sizeof(int16_t)) +
                 triangles->triangle_count * (sizeof *triangles->triangles + 2 * sizeof(uint64_t));
    return bytes;
}

stp_status stp_prep_cut_shapes(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    stp_prep_shapes *out = &job->shapes;
    const stp_prep_source *source = job->source;
    stp_tree_params *tree = &job->tree;
    stp_prep_stats *stats = job->stats;
    const char *name = source->files[0].name;
    const uint64_t bytes = shape_bytes(source->lines, source->triangles);
    if (bytes > job->plan.memory_bytes / 2)
        return stp_error_set(err, STP_LIMIT,
                             "%s: its lines and triangles take %.0f MB, and no more than half of "
                             "%.0f MB may be theirs: give more memory (--memory) or split the "
                             "model",
                             name, 1e-6 * (double)bytes, 1e-6 * (double)job->plan.memory_bytes);
    double side = 0.0;
    STP_TRY(stp_prep_side(&side, source, stats, err));
    if (source->lines)
        STP_TRY(stp_line_leaves_create(&out->lines, source->lines, tree->resolution.precision, side,
                                       err));
    if (source->triangles)
        STP_TRY(stp_triangle_leaves_create(&out->triangles, source->triangles,
                                           tree->resolution.precision, side, err));
    stats->lines = out->lines.counts;
    stats->triangles = out->triangles.counts;
    tree->sources.lines = out->lines.leaf_count > 0 ? &out->lines : NULL;
    tree->sources.triangles = out->triangles.leaf_count > 0 ? &out->triangles : NULL;
    if (stats->points_out == 0 && !tree->sources.lines && !tree->sources.triangles)
        status = stp_error_set(err, STP_EMPTY,
                               "%s: no valid point, and none in its lines and triangles: there is "
                               "nothing to write",
                               name);
done:
    return status;
}

void stp_prep_clear_shapes(stp_prep_shapes *shapes)
{
    stp_line_leaves_clear(&shapes->lines);
    stp_triangle_leaves_clear(&shapes->triangles);
    stp_map_leaves_clear(&shapes->map_leaves);
    stp_depth_images_clear(&shapes->depths);
}

/* Cuts lines and triangles into leaves; how far points and shapes reach. */
#include "preprocess/prep_job.h"

static void add_finite(stp_dbox *box, const stp_line_vertex *vertices, uint64_t count)
{
    for (uint64_t i = 0; i < count; i++)
        if (stp_dvec3_finite(vertices[i].position))
            stp_dbox_add(box, vertices[i].position);
}

stp_status stp_prep_side(double *out, const stp_prep_source *source, const stp_prep_stats *stats,
                         stp_error *err)
{
    stp_dbox box = stats->box;
    if (source->lines)
        add_finite(&box, source->lines->vertices, source->lines->vertex_count);
    if (source->triangles)
        add_finite(&box, source->triangles->vertices, source->triangles->vertex_count);
    *out = 0.0;
    if (stp_dbox_is_empty(&box))
        return STP_OK;
    const double far = fmax(fmax(fmax(fabs(box.min.x), fabs(box.min.y)), fabs(box.min.z)),
                            fmax(fmax(fabs(box.max.x), fabs(box.max.y)), fabs(box.max.z)));
    *out = stp_dbox_side(&box);
    if (far > STP_COORDINATE_LIMIT)
        return stp_error_set(err, STP_LIMIT,
                             "%s: a coordinate is %g, and they may reach %g: give the scan in "
                             "larger units, or without points that are none",
                             source->files[0].name, far, STP_COORDINATE_LIMIT);
    if (*out > 0.0 && *out < STP_SIDE_LEAST)
        return stp_error_set(err, STP_LIMIT,
                             "%s: it is only %g across, and %g is the least: give the scan in "
                             "smaller units",
                             source->files[0].name, *out, STP_SIDE_LEAST);
    return STP_OK;
}

/* Per triangle of a mesh under maps: itself, and its place and share of boxes (face_tree.h). */
#define FACE_BYTES 20u

static uint64_t shape_bytes(const stp_line_set *lines, const stp_triangle_set *triangles,
                            const stp_mesh *mesh)
{
    uint64_t bytes = 0;
    if (lines)
        bytes += lines->vertex_count * (sizeof *lines->vertices + sizeof(stp_strip_part) / 8) +
                 lines->strip_count * sizeof(stp_strip_part);
    if (triangles)
        bytes += triangles->vertex_count * (sizeof *triangles->vertices + sizeof(int16_t)) +
                 triangles->triangle_count * (sizeof *triangles->triangles + 2 * sizeof(uint64_t));
    if (mesh)
        bytes += mesh->vertex_count * sizeof *mesh->positions + mesh->triangle_count * FACE_BYTES;
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
    const uint64_t bytes = shape_bytes(source->lines, source->triangles, source->mesh);
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

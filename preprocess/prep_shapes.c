/* Cuts lines and triangles into leaves; how far points and shapes reach. */
#include "preprocess/prep_shapes.h"

#include "base/memory.h"
#include "preprocess/gaps/fill_triangles.h"

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

/* Appends triangles and their vertices to triangles between maps. */
static stp_status append(stp_triangle_set *set, const stp_triangle_set *other, stp_error *err)
{
    stp_status status = STP_OK;
    size_t vertex_capacity = set->vertex_count, lattice_capacity = vertex_capacity;
    size_t capacity = set->triangle_count;
    const uint64_t vertices = set->vertex_count + other->vertex_count;
    if (vertices > UINT32_MAX)
        return stp_error_set(err, STP_LIMIT,
                             "the maps' borders and the triangles have more than 2^32 vertices: "
                             "give --gaps overlap");
    STP_TRY(stp_grow(&set->vertices, &vertex_capacity, vertices, sizeof *set->vertices, "triangles",
                     err));
    STP_TRY(stp_grow(&set->lattices, &lattice_capacity, vertices, sizeof *set->lattices,
                     "triangles", err));
    STP_TRY(stp_grow(&set->triangles, &capacity, set->triangle_count + other->triangle_count,
                     sizeof *set->triangles, "triangles", err));
    for (uint64_t t = 0; t < other->triangle_count; t++, set->triangle_count++)
        for (int k = 0; k < 3; k++)
            set->triangles[set->triangle_count][k] =
                (uint32_t)set->vertex_count + other->triangles[t][k];
    for (uint64_t v = 0; v < other->vertex_count; v++, set->vertex_count++) {
        set->vertices[set->vertex_count] = other->vertices[v];
        set->lattices[set->vertex_count] = STP_LATTICE_ANY;
    }
done:
    return status;
}

stp_status stp_prep_fill_maps(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    stp_prep_shapes *out = &job->shapes;
    const stp_prep_source *source = job->source;
    const stp_dbox box = stp_leaf_sources_box(&job->cloud, &job->tree.sources);
    const stp_point_item_params items = stp_tree_item_params(&job->tree, &box);
    double side = 0.0;
    if (job->maps.fill.count == 0)
        return STP_OK;
    STP_TRY(stp_fill_triangles(&out->fill, &job->maps, &items, err));
    if (source->triangles && source->triangles->triangle_count > 0)
        STP_TRY(append(&out->fill, source->triangles, err));
    STP_TRY(stp_prep_side(&side, source, job->stats, err));
    stp_triangle_leaves_clear(&out->triangles);
    STP_TRY(stp_triangle_leaves_create(&out->triangles, &out->fill, job->tree.resolution.precision,
                                       side, err));
    job->stats->triangles = out->triangles.counts;
    job->tree.sources.triangles = &out->triangles;
done:
    return status;
}

void stp_prep_clear_shapes(stp_prep_shapes *shapes)
{
    stp_triangle_set_clear(&shapes->fill);
    stp_line_leaves_clear(&shapes->lines);
    stp_triangle_leaves_clear(&shapes->triangles);
    stp_map_leaves_clear(&shapes->map_leaves);
    stp_depth_images_clear(&shapes->depths);
}

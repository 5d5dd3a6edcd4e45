/* Exports the points and shapes of a chunk file as PLY, LAS or LAZ. */
#include "tools/file/export_file.h"

#include "base/memory.h"
#include "formats/chunk/repair/repair_note.h"
#include "formats/scan/ply/ply_write.h"
#include "tools/file/export_las.h"
#include "tools/file/export_numbers.h"
#include "tools/file/export_shapes.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Number of points per write. */
#define BATCH_COUNT 4096u

/* The output of points and what is chosen for it. */
typedef struct sink {
    stp_ply_writer *ply; /* or */
    stp_las_writer *las;
    export_numbers *numbers;
    const bool *stand_ins; /* per chunk: its samples stand in for lost points */
    export_shapes *shapes;
    const export_filter *filter;
    int level;
    bool counts; /* only counts, in `chosen`, what would be written */
    uint64_t chosen;
} sink;

/* A positive number of the metadata; `otherwise` if there is none. */
static double noted(const stp_chunk_file_info *info, const char *name, double otherwise)
{
    cJSON *metadata = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(metadata, name);
    const double value = cJSON_IsNumber(number) ? number->valuedouble : 0.0;
    cJSON_Delete(metadata);
    return value > 0.0 && isfinite(value) ? value : otherwise;
}

/* The error that writing may add to coordinates. For an exact model it is a quarter of half the
 * inputs' step, because the stored positions already use half of that half step. */
static double allowed_error(const stp_chunk_file_info *info)
{
    cJSON *metadata = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    const bool exact = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(metadata, "exact"));
    cJSON_Delete(metadata);
    return noted(info, "precision", INFINITY) * (exact ? 0.25 : 1.0);
}

/* Decides between floats and doubles. Floats do if their spacing at the farthest coordinate is
 * below 1/64 of the least distance between samples, and so below half of the lattice's step, and
 * below the allowed error, so that georeferenced points come back as they were. */
static stp_status needs_double(stp_chunk_file *file, bool *out, stp_error *err)
{
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    const stp_dvec3 far = {fmax(fabs(info->box.min.x), fabs(info->box.max.x)),
                           fmax(fabs(info->box.min.y), fabs(info->box.max.y)),
                           fmax(fabs(info->box.min.z), fabs(info->box.max.z))};
    double float_step = ldexp(fmax(far.x, fmax(far.y, far.z)), -23);
    double radius = INFINITY;
    for (uint32_t id = 0; id < info->chunk_count; id++) {
        stp_chunk_entry entry;
        stp_status status = stp_chunk_file_entry(file, id, &entry, err);
        if (status != STP_OK)
            return status;
        if (entry.child_count == 0)
            radius = fmin(radius, (double)entry.radius_min);
    }
    *out = float_step > fmin(radius / info->lambda / 64.0, allowed_error(info));
    return STP_OK;
}

static stp_point point_of(const stp_sample *s, const stp_patch *patch, stp_dvec3 origin,
                          double intensity_step)
{
    stp_point p = {.position = stp_dvec3_add(origin, stp_sample_position(s, patch)),
                   .intensity = stp_sample_intensity(s, intensity_step),
                   .class_id = s->class_id,
                   .outlier = (s->flags & STP_SAMPLE_OUTLIER) != 0};
    if (stp_sample_is_flat(s)) /* else the direction is a tube's tangent */
        p.normal = stp_normal_decode(s->normal);
    for (int i = 0; i < 3; i++)
        p.rgb[i] = (uint16_t)(s->rgb[i] * 257);
    return p;
}

/* Points that are written together. */
typedef struct batch {
    stp_point points[BATCH_COUNT];
    float radii[BATCH_COUNT];
    uint8_t *packed; /* attributes; NULL: none */
    size_t count;
} batch;

static stp_status flush(batch *b, const sink *out, stp_error *err)
{
    const size_t count = b->count;
    b->count = 0;
    if (count == 0)
        return STP_OK;
    return out->las
               ? stp_las_writer_numbered_points(out->las, b->points, b->packed, count, err)
               : stp_ply_writer_wide_points(out->ply, b->points, b->radii, b->packed, count, err);
}

static stp_status add_point(batch *b, const stp_chunk *chunk, const stp_patch *patch, uint32_t k,
                            stp_dvec3 origin, sink *out, stp_error *err)
{
    const stp_sample *s = &chunk->samples[out->level][k];
    const size_t stride = out->numbers->stride;
    const uint8_t *packed = b->packed ? out->numbers->packed + k * stride : NULL;
    b->radii[b->count] = (float)stp_sample_radius(s, patch);
    b->points[b->count] = point_of(s, patch, origin, out->filter->intensity_step);
    if (!export_filter_takes(out->filter, s, b->points[b->count].position, packed))
        return STP_OK;
    out->chosen++;
    if (out->counts)
        return STP_OK;
    if (packed)
        memcpy(b->packed + b->count * stride, packed, stride);
    return ++b->count == BATCH_COUNT ? flush(b, out, err) : STP_OK;
}

static stp_status export_chunk(const stp_chunk *chunk, stp_dvec3 origin, sink *out, stp_error *err)
{
    const uint32_t *first = chunk->level_begin[out->level];
    stp_status status = STP_OK;
    batch *b = NULL;
    STP_TRY(stp_alloc(&b, 1, sizeof *b, "points", err));
    STP_TRY(export_numbers_read(out->numbers, chunk, out->level, err));
    if (out->numbers->list)
        STP_TRY(stp_alloc(&b->packed, BATCH_COUNT, out->numbers->stride, "attributes", err));
    for (uint32_t i = 0; i < chunk->patch_count; i++) {
        const stp_patch *patch = &chunk->patches[i];
        unsigned skipped = 0;
        STP_TRY(export_shapes_patch(out->shapes, patch, &chunk->samples[out->level][first[i]],
                                    origin, &skipped, err));
        for (uint32_t k = first[i] + skipped; k < first[i + 1]; k++)
            STP_TRY(add_point(b, chunk, patch, k, origin, out, err));
    }
    STP_TRY(flush(b, out, err));
done:
    if (b)
        free(b->packed);
    free(b);
    return status;
}

/* The box of a chunk in world coordinates. */
static stp_dbox box_of(const stp_chunk_entry *entry)
{
    return (stp_dbox){stp_dvec3_add(entry->origin, stp_dvec3_from_float(entry->box_min)),
                      stp_dvec3_add(entry->origin, stp_dvec3_from_float(entry->box_max))};
}

static stp_status export_chunks(stp_chunk_file *file, sink *out, const stp_progress *progress,
                                stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    uint64_t done_count = 0;
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    for (uint32_t id = 0; id < info->chunk_count; id++) {
        stp_chunk_entry entry;
        STP_TRY(stp_chunk_file_entry(file, id, &entry, err));
        if (entry.child_count != 0 || out->stand_ins[id])
            continue;
        const stp_dbox box = box_of(&entry);
        done_count += entry.sample_count[0];
        if (!export_filter_meets(out->filter, &box))
            continue;
        STP_TRY(stp_chunk_file_read(file, id, out->level, &chunk, err));
        STP_TRY(export_chunk(chunk, entry.origin, out, err));
        stp_chunk_destroy(&chunk);
        STP_TRY(stp_progress_update(progress, out->counts ? "count" : "export", done_count,
                                    info->point_count, err));
    }
done:
    stp_chunk_destroy(&chunk);
    return status;
}

/* Counts the points that will be written. */
static stp_status count_points(stp_chunk_file *file, sink *out, const stp_progress *progress,
                               uint64_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    *count = 0;
    if (export_filter_chooses(out->filter)) {
        out->counts = true;
        STP_TRY(export_chunks(file, out, progress, err));
        out->counts = false;
        *count = out->chosen;
        if (*count == 0)
            status = stp_error_set(err, STP_EMPTY,
                                   "%s: no point is chosen by --where and --clip: there is nothing "
                                   "to write",
                                   stp_chunk_file_path(file));
    } else {
        for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
            stp_chunk_entry entry;
            STP_TRY(stp_chunk_file_entry(file, id, &entry, err));
            if (entry.child_count == 0 && !out->stand_ins[id])
                *count += entry.sample_count[out->level];
        }
        *count -= out->shapes->repeated;
    }
done:
    return status;
}

/* Finds the chunks that a repair put in the place of lost ones, and counts their samples. */
static stp_status find_stand_ins(stp_chunk_file *file, bool **marks, uint64_t *count,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    STP_TRY(stp_alloc(marks, info->chunk_count, sizeof **marks, "chunks", err));
    stp_repair_note_stand_ins(info->metadata_json, *marks, info->chunk_count);
    for (uint32_t id = 0; id < info->chunk_count; id++) {
        stp_chunk_entry entry;
        if (!(*marks)[id])
            continue;
        STP_TRY(stp_chunk_file_entry(file, id, &entry, err));
        (*marks)[id] = entry.child_count == 0;
        *count += entry.child_count == 0 ? entry.sample_count[0] : 0;
    }
done:
    return status;
}

/* STP_POINT_HAS_* of a chunk file. */
static uint32_t point_attributes(const stp_chunk_file_info *info)
{
    uint32_t out = STP_POINT_HAS_NORMAL;
    out |= info->attributes & STP_HAS_COLOUR ? (uint32_t)STP_POINT_HAS_COLOUR : 0;
    out |= info->attributes & STP_HAS_INTENSITY ? (uint32_t)STP_POINT_HAS_INTENSITY : 0;
    out |= info->attributes & STP_HAS_CLASS ? (uint32_t)STP_POINT_HAS_CLASS : 0;
    out |= info->attributes & STP_HAS_OUTLIERS ? (uint32_t)STP_POINT_HAS_OUTLIER : 0;
    return out;
}

static stp_status create_ply(stp_ply_writer **out, stp_chunk_file *file,
                             const export_params *params, const export_numbers *numbers,
                             uint64_t count, const export_shapes *shapes, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    stp_ply_writer_params ply = {.force = params->force,
                                 .vertex_count = count,
                                 .triangle_count = shapes->triangle_count,
                                 .edge_count = shapes->edge_count,
                                 .attributes = point_attributes(info),
                                 .numbers = numbers->list};
    STP_TRY(needs_double(file, &ply.double_coordinates, err));
    STP_TRY(stp_ply_writer_create(out, params->output, &ply, err));
done:
    return status;
}

static stp_status create_las(stp_las_writer **out, stp_chunk_file *file,
                             const export_params *params, const export_numbers *numbers,
                             stp_error *err)
{
    stp_status status = STP_OK;
    char *wkt = NULL;
    const uint32_t normals = STP_POINT_HAS_NORMAL; /* LAS has none */
    stp_las_writer_params las = {.force = params->force,
                                 .packed = export_las_is_packed(params->output),
                                 .attributes =
                                     point_attributes(stp_chunk_file_get_info(file)) & ~normals,
                                 .numbers = numbers->list};
    STP_TRY(export_las_params(&las, &wkt, file, err));
    STP_TRY(stp_las_writer_create(out, params->output, &las, err));
done:
    free(wkt);
    return status;
}

stp_status export_file(stp_chunk_file *file, const export_params *params, uint64_t *left_out,
                       stp_error *err)
{
    stp_status status = STP_OK;
    stp_las_writer *las = NULL;
    stp_ply_writer *ply = NULL;
    bool *stand_ins = NULL;
    export_shapes shapes = {0};
    export_numbers numbers = {0};
    export_filter filter;
    uint64_t count = 0;
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    *left_out = 0;
    STP_TRY(find_stand_ins(file, &stand_ins, left_out, err));
    if (*left_out >= info->point_count) {
        status = stp_error_set(err, STP_EMPTY,
                               "%s: all of its points are lost: there is nothing to write",
                               stp_chunk_file_path(file));
        goto done;
    }
    STP_TRY(export_shapes_find(&shapes, file, stand_ins, err));
    STP_TRY(export_numbers_open(&numbers, file, err));
    STP_TRY(export_filter_make(&filter, &params->choice, file, &numbers, err));
    sink out = {.numbers = &numbers,
                .stand_ins = stand_ins,
                .shapes = &shapes,
                .filter = &filter,
                .level = params->choice.level};
    STP_TRY(count_points(file, &out, params->progress, &count, err));
    if (export_las_is_named(params->output))
        STP_TRY(create_las(&las, file, params, &numbers, err));
    else
        STP_TRY(create_ply(&ply, file, params, &numbers, count, &shapes, err));
    out.las = las;
    out.ply = ply;
    STP_TRY(export_chunks(file, &out, params->progress, err));
    if (las) {
        STP_TRY(stp_las_writer_finish(&las, err));
    } else {
        STP_TRY(export_shapes_write(&shapes, ply, err));
        STP_TRY(stp_ply_writer_finish(&ply, err));
    }
done:
    free(stand_ins);
    export_shapes_clear(&shapes);
    export_numbers_clear(&numbers);
    stp_ply_writer_destroy(&ply);
    stp_las_writer_destroy(&las);
    return status;
}

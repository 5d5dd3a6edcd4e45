/* Finds the samples of a model along a line. */
#include "tools/profile/profile_cut.h"

#include "base/memory.h"
#include "base/sort.h"
#include "formats/chunk/repair/repair_note.h"
#include "tools/file/export_filter.h"

#include <math.h>
#include <stdlib.h>

/* The usual width is so many times the spacing of the model's samples. */
#define USUAL_SPACINGS 2.0

/* The radius of a full patch's vertex, which is a leaf's greatest, in spacings: 1.4 times the side
 * of 8 x 8 samples. */
#define VERTEX_SPACINGS 11.2

/* A line with its direction, and which samples count. */
typedef struct ruler {
    const profile_line *line;
    double direction[2]; /* unit */
    double length, half_width;
    export_filter filter;
    export_numbers numbers;
} ruler;

static ruler ruler_of(const profile_line *line, double width)
{
    const double x = line->to[0] - line->from[0], y = line->to[1] - line->from[1];
    const double length = hypot(x, y);
    return (ruler){.line = line,
                   .direction = {x / length, y / length},
                   .length = length,
                   .half_width = 0.5 * width};
}

/* How far along the line a place is, and how far beside the segment. */
static void measure(const ruler *r, double x, double y, double *along, double *beside)
{
    const double dx = x - r->line->from[0], dy = y - r->line->from[1];
    const double at = dx * r->direction[0] + dy * r->direction[1];
    const double off = dy * r->direction[0] - dx * r->direction[1];
    const double beyond = fmax(0.0, fmax(-at, at - r->length));
    *along = fmin(fmax(at, 0.0), r->length);
    *beside = hypot(off, beyond);
}

/* Whether a chunk may have samples near the line: whether the line meets the circle around its box.
 */
static bool is_near(const ruler *r, const stp_chunk_entry *e)
{
    const double x = 0.5 * ((double)e->box_min.x + (double)e->box_max.x);
    const double y = 0.5 * ((double)e->box_min.y + (double)e->box_max.y);
    const double radius =
        0.5 * hypot((double)(e->box_max.x - e->box_min.x), (double)(e->box_max.y - e->box_min.y));
    double along = 0.0, beside = 0.0;
    measure(r, e->origin.x + x, e->origin.y + y, &along, &beside);
    return beside <= (radius + r->half_width) * (1.0 + 1e-6);
}

static stp_status add_point(profile *out, const profile_point *point, stp_error *err)
{
    const stp_status status = stp_grow(&out->points, &out->capacity, out->count + 1,
                                       sizeof *out->points, "points of the profile", err);
    if (status == STP_OK)
        out->points[out->count++] = *point;
    return status;
}

static stp_status add_chunk(profile *out, const stp_chunk *chunk, stp_dvec3 origin, const ruler *r,
                            stp_error *err)
{
    stp_status status = STP_OK;
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_patch *patch = &chunk->patches[p];
        if (patch->flags & STP_PATCH_SHAPES)
            continue;
        for (uint32_t i = chunk->level_begin[0][p]; i < chunk->level_begin[0][p + 1]; i++) {
            const stp_sample *s = &chunk->samples[0][i];
            profile_point point = {.position = stp_dvec3_add(origin, stp_sample_position(s, patch)),
                                   .rgb = {s->rgb[0], s->rgb[1], s->rgb[2]}};
            double beside = 0.0;
            measure(r, point.position.x, point.position.y, &point.distance, &beside);
            const uint8_t *packed =
                r->numbers.list ? r->numbers.packed + i * r->numbers.stride : NULL;
            if (beside <= r->half_width &&
                export_filter_takes(&r->filter, s, point.position, packed))
                STP_TRY(add_point(out, &point, err));
        }
    }
done:
    return status;
}

static int compare(const void *a, const void *b)
{
    const profile_point *p = a, *q = b;
    if (p->distance != q->distance)
        return p->distance < q->distance ? -1 : 1;
    return (p->position.z > q->position.z) - (p->position.z < q->position.z);
}

/* Twice the median, over the leaves, of a leaf's spacing. */
static stp_status usual_width(stp_chunk_file *file, double *out, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    double *radii = NULL;
    uint32_t count = 0;
    STP_TRY(stp_alloc(&radii, info->chunk_count, sizeof *radii, "chunks", err));
    for (uint32_t id = 0; id < info->chunk_count; id++) {
        stp_chunk_entry entry;
        STP_TRY(stp_chunk_file_entry(file, id, &entry, err));
        if (entry.child_count == 0)
            radii[count++] = (double)entry.radius_max;
    }
    stp_sort_doubles(radii, count);
    *out = USUAL_SPACINGS * radii[count / 2] / VERTEX_SPACINGS;
done:
    free(radii);
    return status;
}

static stp_status read_leaves(profile *out, stp_chunk_file *file, ruler *r, const bool *skip,
                              const stp_progress *progress, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    for (uint32_t id = 0; id < info->chunk_count; id++) {
        stp_chunk_entry entry;
        STP_TRY(stp_chunk_file_entry(file, id, &entry, err));
        if (entry.child_count == 0 && !skip[id] && is_near(r, &entry)) {
            STP_TRY(stp_chunk_file_read(file, id, 0, &chunk, err));
            if (r->filter.conditional)
                STP_TRY(export_numbers_read(&r->numbers, chunk, 0, err));
            STP_TRY(add_chunk(out, chunk, entry.origin, r, err));
            stp_chunk_destroy(&chunk);
        }
        STP_TRY(stp_progress_update(progress, "profile", id + 1, info->chunk_count, err));
    }
done:
    stp_chunk_destroy(&chunk);
    return status;
}

/* Prepares the condition; without one, no attributes are read. */
static stp_status choose(ruler *r, stp_chunk_file *file, stp_error *err)
{
    stp_status status = STP_OK;
    const export_choice choice = {.where = r->line->where};
    if (choice.where == NULL)
        return STP_OK;
    STP_TRY(export_numbers_open(&r->numbers, file, err));
    STP_TRY(export_filter_make(&r->filter, &choice, file, &r->numbers, err));
done:
    return status;
}

stp_status profile_find(profile *out, stp_chunk_file *file, const profile_line *line,
                        const stp_progress *progress, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    profile found = {.width = line->width, .coloured = info->attributes & STP_HAS_COLOUR};
    ruler r = {0};
    bool *skip = NULL;
    STP_TRY(stp_alloc(&skip, info->chunk_count, sizeof *skip, "chunks", err));
    stp_repair_note_stand_ins(info->metadata_json, skip, info->chunk_count);
    if (!(found.width > 0.0))
        STP_TRY(usual_width(file, &found.width, err));
    r = ruler_of(line, found.width);
    STP_TRY(choose(&r, file, err));
    found.length = r.length;
    STP_TRY(read_leaves(&found, file, &r, skip, progress, err));
    if (found.count == 0) {
        status = stp_error_set(err, STP_EMPTY,
                               "%s has no point%s within %g of the line: give another --line (the "
                               "model reaches from %.9g,%.9g to %.9g,%.9g) or a wider --width",
                               stp_chunk_file_path(file),
                               line->where ? " that fulfils --where" : "", r.half_width,
                               info->box.min.x, info->box.min.y, info->box.max.x, info->box.max.y);
        goto done;
    }
    qsort(found.points, found.count, sizeof *found.points, compare);
    *out = found;
    found = (profile){0};
done:
    free(skip);
    export_numbers_clear(&r.numbers);
    profile_clear(&found);
    return status;
}

void profile_clear(profile *p)
{
    free(p->points);
    *p = (profile){0};
}

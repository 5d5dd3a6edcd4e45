/* Reads the points of a source. */
#include "preprocess/prep_read.h"

#include "base/memory.h"
#include "preprocess/prep_grid.h"
#include "preprocess/prep_read_part.h"
#include "preprocess/prep_rejects.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Few enough to stay in a core's own cache until they are taken. */
#define READ_POINTS 8192u
/* Points are nearly black up to this in all channels. Black means "no colour" if at least one in
 * BLACK_SHARE points is black, and BLACK_TIMES as many as are nearly so: dark things are seldom
 * exactly black. */
#define DARK_MOST (8u * 257u)
#define BLACK_SHARE 100u
#define BLACK_TIMES 20u

void stp_prep_count(stp_prep_stats *stats, const stp_cloud_point *p)
{
    stats->points_unstationed += p->station == 0;
    if (p->intensity > stats->intensity_max)
        stats->intensity_max = p->intensity;
}

static bool is_black(const stp_cloud_point *p)
{
    return (p->rgb[0] | p->rgb[1] | p->rgb[2]) == 0;
}

static void count_dark(stp_prep_stats *stats, const stp_cloud_point *p)
{
    if (is_black(p))
        stats->points_black++;
    else if (p->rgb[0] <= DARK_MOST && p->rgb[1] <= DARK_MOST && p->rgb[2] <= DARK_MOST)
        stats->points_dark++;
}

static stp_status add_point(stp_prep_job *job, const stp_point *point, stp_error *err)
{
    stp_cloud *cloud = &job->cloud;
    const stp_prep_source *source = job->source;
    stp_prep_stats *stats = job->stats;
    uint64_t place = stats->points_in++;
    stp_reject reject = (stp_reject)point->reject;
    if (reject == STP_REJECT_NONE && stp_scan_is_nowhere(point->position))
        reject = STP_REJECT_NOT_FINITE;
    const bool parts = stp_prep_grid_has_parts(job);
    const uint64_t end = parts ? job->part.first + job->part.count : source->point_count;
    if (stats->keeps_grid ? place >= end
                          : reject == STP_REJECT_NONE && cloud->count == cloud->capacity)
        return stp_error_set(err, STP_CORRUPT,
                             "%s gives more points than the %llu it counts: it changed while it "
                             "was read, run again",
                             source->files[0].name, (unsigned long long)source->point_count);
    if (stats->keeps_grid)
        stp_prep_grid_add(job, point, place, &reject);
    if (reject != STP_REJECT_NONE) {
        stats->rejected[reject]++;
        return stp_prep_reject(job, place, reject, err);
    }
    stp_dbox_add(&stats->box, point->position);
    if (stats->keeps_grid)
        return STP_OK;
    stp_cloud_point *out = &cloud->points[cloud->first + cloud->count++];
    *out = (stp_cloud_point){.position = point->position,
                             .source = (cloud->first_record + place) & STP_PLACE_MASK,
                             .rgb = {point->rgb[0], point->rgb[1], point->rgb[2]},
                             .intensity = point->intensity,
                             .class_id = point->class_id,
                             .station = point->station};
    stp_prep_count(stats, out);
    count_dark(stats, out);
    float length = glms_vec3_norm(point->normal);
    if (isfinite(length) && length > 0.0f) {
        out->normal = glms_vec3_scale(point->normal, 1.0f / length);
        out->given = STP_GIVEN_INPUT;
    }
    return STP_OK;
}

/* Whether a number is what the point says in a sample's field, and no more. Of an intensity: its
 * place on the scale; decide_attributes (prep.c) knows which steps the scale has. */
static bool is_told(const stp_attribute *attribute, const stp_point *point, uint64_t word)
{
    if (attribute->coarse == STP_COARSE_INTENSITY)
        return (double)point->intensity == nearbyint((double)word / attribute->coarse_scale);
    const double bits = nearbyint(point->rgb[attribute->coarse - STP_COARSE_RED] / 257.0);
    return word == (uint64_t)(bits * attribute->coarse_scale + 0.5);
}

/* Notes which colours and intensities are more than a sample has of them. */
static void compare_coarse(stp_prep_job *job, const stp_point *points, const uint8_t *packed,
                           size_t count)
{
    const stp_attribute_list *list = job->source->kept;
    const size_t stride = stp_attribute_list_bytes(list);
    for (uint32_t a = 0; a < list->count; a++) {
        const stp_attribute *attribute = &list->items[a];
        const uint8_t *at = packed;
        packed += stp_attribute_bytes(attribute->type);
        if (attribute->coarse == STP_COARSE_NOT || job->unlike >> a & 1)
            continue;
        for (size_t i = 0; i < count; i++)
            if (!is_told(attribute, &points[i],
                         stp_attribute_get(attribute->type, at + i * stride)))
                job->unlike |= UINT64_C(1) << a;
    }
}

/* Keeps the pixels that the points read last tell, which begin at `place`. */
static void keep_pixels(stp_prep_job *job, const stp_point *points, uint64_t place, size_t count)
{
    const size_t file = job->source->file ? *job->source->file : 0;
    const bool told = job->source->files[file].pixels_told;
    for (size_t i = 0; job->cloud.pixels && i < count && place + i < job->source->point_count; i++)
        job->cloud.pixels[place + i] = told ? points[i].pixel : STP_POINT_NO_PIXEL;
}

/* Keeps the attributes of the points read last, which begin at `place`. */
static void keep_numbers(stp_prep_job *job, const stp_point *points, uint64_t place, size_t count)
{
    const stp_prep_source *source = job->source;
    const uint64_t left = place < job->records.end ? job->records.end - place : 0;
    const size_t stride = job->numbers ? stp_attribute_list_bytes(source->kept) : 0;
    const uint8_t *packed = job->numbers ? source->numbers(source->context) : NULL;
    if (packed)
        compare_coarse(job, points, packed, count);
    if (packed)
        memcpy(job->numbers + (place - job->records.begin) * stride, packed,
               stride * (count < left ? count : left));
}

/* The state to return to if a file breaks off. */
typedef struct read_mark {
    size_t file;
    uint64_t count;
    stp_prep_stats stats;
} read_mark;

/* Forgets the points of a file that cannot be read on. False if the error ends the run. */
static bool leave_out(stp_prep_job *job, const stp_error *why, const read_mark *mark)
{
    const stp_prep_source *source = job->source;
    size_t file = 0;
    if (!source->leaves_out || !source->leaves_out(source->context, why, &file))
        return false;
    if (mark->file == file) {
        job->cloud.count = mark->count;
        if (stp_prep_grid_has_parts(job))
            stp_grid_part_forget(&job->part, &job->grid);
        else
            job->grid.count = 0;
        *job->stats = mark->stats;
    }
    return true;
}

static void set_grey(stp_cloud_point *p)
{
    for (int c = 0; c < 3; c++)
        p->rgb[c] = STP_POINT_GREY;
}

/* A cloud without colours is drawn in a neutral light grey. */
static void default_colour(stp_cloud *cloud)
{
    for (uint64_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i))
        set_grey(stp_cloud_begin(cloud) + i);
}

/* Gives the grey to points that have no colour among others that have: scanners and programs write
 * black there. The numbers of their colours are kept exactly, if attributes are. */
static stp_status fill_colours(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud *cloud = &job->cloud;
    stp_prep_stats *stats = job->stats;
    const stp_attribute_list *kept = job->source->kept;
    uint64_t counts[] = {stats->points_black, stats->points_dark, cloud->count};
    if (job->in_parts)
        STP_TRY(stp_ranks_sum(job->params->ranks, counts, 3, err));
    if (counts[0] == counts[2] || counts[0] < counts[2] / BLACK_SHARE + 1 ||
        counts[0] < BLACK_TIMES * counts[1])
        return STP_OK;
    stats->points_uncoloured = counts[0];
    for (uint64_t i = cloud->first; i < cloud->first + cloud->count;
         i++, stp_cloud_step(cloud->spill, i))
        if (is_black(&cloud->points[i]))
            set_grey(&cloud->points[i]);
    for (uint32_t a = 0; kept && a < kept->count; a++)
        if (kept->items[a].coarse >= STP_COARSE_RED && kept->items[a].coarse <= STP_COARSE_BLUE)
            job->unlike |= UINT64_C(1) << a;
done:
    return status;
}

/* Reads on until a file breaks off that cannot be left out, or to the end. */
static stp_status read_records(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_prep_source *source = job->source;
    stp_prep_stats *stats = job->stats;
    stp_point *points = NULL;
    stp_error own = {0}, *why = err ? err : &own;
    read_mark mark = {.file = SIZE_MAX};
    STP_TRY(stp_alloc(&points, READ_POINTS, sizeof *points, "points", err));
    for (;;) {
        size_t count = 0;
        status = source->read(source->context, points, READ_POINTS, &count, why);
        if (status != STP_OK && !job->in_parts && leave_out(job, why, &mark))
            continue;
        if (status != STP_OK || count == 0)
            break;
        if (source->file && *source->file != mark.file) {
            mark = (read_mark){*source->file, job->cloud.count, *stats};
            if (stp_prep_grid_has_parts(job))
                STP_TRY(stp_grid_part_begin(&job->part, &job->grid,
                                            &source->files[mark.file].raster, stats->points_in,
                                            err));
        }
        keep_numbers(job, points, stats->points_in, count);
        keep_pixels(job, points, stats->points_in, count);
        for (size_t i = stp_prep_grid_take(job, points, count); i < count;
             i += 1 + stp_prep_grid_take(job, points + i + 1, count - i - 1)) {
            if (points[i].station > source->station_count)
                points[i].station = 0;
            if (job->orient.mode == STP_ORIENT_POSITION)
                points[i].station = 1;
            STP_TRY(add_point(job, &points[i], err));
        }
        stp_spill_relieve(job->spill);
        STP_TRY(
            stp_progress_update(job->progress, "read", stats->points_in, source->point_count, err));
    }
done:
    free(points);
    return status;
}

/* Why no point is stored, and what to do. */
static const char *why_none(const stp_prep_stats *stats)
{
    static const char *const reasons[STP_REJECT_COUNT] = {
        [STP_REJECT_NOT_FINITE] = "their coordinates are no numbers: export the file again",
        [STP_REJECT_NO_RETURN] = "no ray has a return: export the file again",
        [STP_REJECT_INVALID] = "all are marked invalid: --withheld keep stores withheld ones",
        [STP_REJECT_OUTSIDE] = "all lie outside: give other --bounds",
        [STP_REJECT_WHERE] = "none is as --where says: give another condition"};
    for (int r = 0; stats->points_in > 0 && r < STP_REJECT_COUNT; r++)
        if (reasons[r] && stats->rejected[r] == stats->points_in)
            return reasons[r];
    return "there is nothing to write";
}

stp_status stp_prep_read(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud *cloud = &job->cloud;
    const stp_prep_source *source = job->source;
    stp_prep_stats *stats = job->stats;
    if (job->in_parts) {
        STP_TRY(stp_prep_read_part(job, read_records, err));
    } else {
        STP_TRY(stp_prep_make_room(job, 0, source->point_count, err));
        if (stats->keeps_grid)
            STP_TRY(stp_prep_grid_begin(job, err));
        STP_TRY(read_records(job, err));
    }
    if (!(source->attributes & STP_POINT_HAS_COLOUR))
        default_colour(cloud);
    else if (!stats->keeps_grid)
        STP_TRY(fill_colours(job, err));
    if (!job->in_parts)
        stats->points_out = stats->keeps_grid ? job->grid.count : cloud->count;
    if (stats->points_out == 0 && !(source->lines && source->lines->strip_count > 0) &&
        !(source->triangles && source->triangles->triangle_count > 0))
        status = stp_error_set(err, STP_EMPTY, "%s: no valid point among %llu: %s",
                               source->files[0].name, (unsigned long long)stats->points_in,
                               why_none(stats));
done:
    return status;
}

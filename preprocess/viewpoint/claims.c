/* Checks claimed stations against the points; finds cameras and normals of images. */
#include "preprocess/viewpoint/claims.h"

#include "preprocess/surface/image_normals.h"
#include "preprocess/viewpoint/seen_from.h"

/* If a map meets a smaller share of an image's pixels, the first view treats the image like other
 * points. */
#define FITTING_LEAST 0.95

static void take_off(stp_cloud *cloud, const stp_file_points *points, stp_prep_stats *stats)
{
    for (uint64_t i = points->begin; i < points->end; i++, stp_cloud_step(cloud->spill, i))
        if (cloud->points[i].station > 0) {
            cloud->points[i].station = 0;
            stats->points_unstationed++;
        }
}

/* A guessed station is true. */
static void put_on(stp_cloud *cloud, const stp_file_points *points, uint32_t station,
                   stp_prep_stats *stats)
{
    for (uint64_t i = points->begin; i < points->end; i++, stp_cloud_step(cloud->spill, i)) {
        cloud->points[i].station = (uint16_t)(station + 1);
        stats->points_unstationed--;
    }
}

/* Checks one file: its claim, then its image. */
static stp_status check_file(stp_first_camera *out, stp_cloud *cloud, const stp_prep_file *file,
                             const stp_dvec3 *stations, const stp_file_points *points,
                             stp_pool *pool, stp_prep_stats *stats, stp_error *err)
{
    stp_status status = STP_OK;
    stp_file_image image = {0};
    const bool one = file->station_count == 1;
    const stp_dvec3 position = one ? stations[file->station_begin] : (stp_dvec3){0.0, 0.0, 0.0};
    bool seen = one;
    if (file->grid.columns > 0)
        STP_TRY(stp_file_image_create(&image, points, &file->grid, err));
    if (one && file->station_word != STP_STATION_TOLD)
        STP_TRY(stp_seen_from(&seen, points, image.count > 0 ? &image : NULL, position,
                              file->station_word, err));
    if (one && !seen) {
        const bool counts = stp_ranks_is_first(points->ranks);
        if (file->station_word != STP_STATION_GUESSED)
            take_off(cloud, points, stats);
        stats->stations_off += counts;
        stats->stations_refused += counts && file->station_word == STP_STATION_CLAIMED;
    } else if (seen && file->station_word == STP_STATION_GUESSED) {
        put_on(cloud, points, file->station_begin, stats);
    }
    if (image.count > 0 && seen)
        STP_TRY(stp_image_normals(points, &file->grid, position, pool, &stats->normals_seen, err));
    if (out->why == STP_FIRST_WHOLE && image.count > 0 && seen) {
        const stp_image_map map = stp_image_fit(&image, position);
        if (map.fitting >= FITTING_LEAST)
            *out = stp_image_view_from(&image, &map, position);
    } else if (out->why == STP_FIRST_WHOLE && image.count > 0) {
        stp_image_view_along(&image, out);
    }
done:
    stp_file_image_clear(&image);
    return status;
}

/* Finds the normals of a file's images, of which each has a station that is told. */
static stp_status check_images(const stp_cloud *cloud, const stp_prep_file *file,
                               const stp_dvec3 *stations, const stp_file_points *points,
                               stp_pool *pool, stp_prep_stats *stats, stp_error *err)
{
    stp_status status = STP_OK;
    for (uint32_t i = 0; i < file->image_count; i++) {
        const stp_scan_image *image = &file->images[i];
        if (image->first + image->count > file->point_count)
            break;
        const uint64_t first = points->first_place + image->first;
        const stp_scan_grid grid = {.columns = image->columns, .rows = image->rows};
        const stp_file_points own = {
            .cloud = cloud,
            .begin = stp_find_source(cloud, points->begin, points->end, first),
            .end = stp_find_source(cloud, points->begin, points->end, first + image->count),
            .first_place = first,
            .pixels_told = file->pixels_told};
        STP_TRY(stp_image_normals(&own, &grid, stations[file->station_begin + image->station - 1],
                                  pool, &stats->normals_seen, err));
    }
done:
    return status;
}

/* Whether no point of a file is stored. */
static stp_status is_empty(bool *out, const stp_file_points *points, stp_error *err)
{
    uint64_t count = points->end - points->begin;
    const stp_status status = stp_ranks_sum(points->ranks, &count, 1, err);
    *out = count == 0;
    return status;
}

/* Whether several ranks have records [first, next). */
static bool is_split(const stp_ranks *ranks, const uint64_t *begins, uint64_t first, uint64_t next)
{
    bool split = false;
    for (unsigned rank = 1; begins && rank < ranks->count; rank++)
        split = split || (begins[rank] > first && begins[rank] < next);
    return split;
}

stp_status stp_claims_check(stp_first_camera *out, stp_cloud *cloud, const stp_prep_source *source,
                            stp_ranks *ranks, const uint64_t *begins, stp_pool *pool,
                            stp_prep_stats *stats, stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t end = cloud->first + cloud->count;
    stp_file_points points = {
        .cloud = cloud, .begin = cloud->first, .first_place = cloud->first_record};
    *out = (stp_first_camera){0};
    for (size_t f = 0; f < source->file_count; f++) {
        const stp_prep_file *file = &source->files[f];
        const uint64_t next = points.first_place + file->point_count;
        points.end =
            f + 1 == source->file_count ? end : stp_find_source(cloud, points.begin, end, next);
        bool empty = true;
        points.ranks = is_split(ranks, begins, points.first_place, next) ? ranks : NULL;
        STP_TRY(is_empty(&empty, &points, err));
        if (!empty)
            STP_TRY(check_file(out, cloud, file, source->stations, &points, pool, stats, err));
        STP_TRY(check_images(cloud, file, source->stations, &points, pool, stats, err));
        points.begin = points.end;
        points.first_place = next;
    }
done:
    return status;
}

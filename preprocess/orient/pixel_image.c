/* Finds the points of images, and compares those of neighbouring pixels. */
#include "preprocess/orient/pixel_image.h"

#include "base/memory.h"
#include "base/sort.h"
#include "preprocess/prep.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Points lie on one surface if they are this many times the median off. */
#define MEDIANS 6.0
/* About how many pairs tell the median, and how many pixels lie from one to the other: enough for
 * the camera's steps to count. */
#define PAIRS 65536u
#define PAIR_PIXELS 16u

static size_t count_images(const stp_prep_source *source)
{
    size_t count = source->file_count;
    for (size_t f = 0; f < source->file_count; f++)
        count += source->files[f].image_count;
    return count;
}

stp_status stp_pixel_images_list(stp_pixel_images *images, const stp_prep_source *source,
                                 uint64_t first, stp_error *err)
{
    const stp_status status =
        stp_alloc(&images->list, count_images(source), sizeof *images->list, "images", err);
    if (status != STP_OK)
        return status;
    for (size_t f = 0; f < source->file_count; f++) {
        const stp_prep_file *file = &source->files[f];
        const stp_scan_grid *grid = &file->grid;
        const stp_dvec3 *stations = source->stations + file->station_begin;
        const uint64_t own = (uint64_t)grid->columns * grid->rows;
        if (own > 0 && own <= file->point_count && grid->cell_count == 0 &&
            file->station_count == 1)
            images->list[images->count++] = (stp_pixel_image){.station = stations[0],
                                                              .first = first,
                                                              .count = own,
                                                              .columns = grid->columns,
                                                              .rows = grid->rows};
        for (uint32_t i = 0; i < file->image_count; i++) {
            const stp_scan_image *image = &file->images[i];
            if (image->first + image->count > file->point_count) /* it is not read as a whole */
                break;
            images->list[images->count++] =
                (stp_pixel_image){.station = stations[image->station - 1],
                                  .first = first + image->first,
                                  .count = image->count,
                                  .told = file->pixels_told,
                                  .columns = image->columns,
                                  .rows = image->rows};
        }
        first += file->point_count;
    }
    return STP_OK;
}

stp_pixel_image *stp_pixel_image_of(const stp_pixel_images *images, const stp_cloud_point *point)
{
    size_t low = 0, high = images->count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (images->list[middle].first <= point->source)
            low = middle + 1;
        else
            high = middle;
    }
    stp_pixel_image *m = low > 0 ? &images->list[low - 1] : NULL;
    return m && point->source - m->first < m->count ? m : NULL;
}

/* The pixel of a point, or STP_PIXEL_NONE. */
static uint64_t pixel_of(const stp_cloud *cloud, const stp_pixel_image *m, uint64_t point)
{
    const uint64_t source = cloud->points[point].source;
    const uint64_t pixel =
        m->told ? cloud->pixels[source - cloud->first_record] : source - m->first;
    return pixel < stp_pixel_count(m) ? pixel : STP_PIXEL_NONE;
}

/* Puts a point into its image. Returns whether one more pixel has a point. */
static bool add_point(const stp_cloud *cloud, const stp_pixel_image *m, uint64_t point)
{
    const uint64_t pixel = pixel_of(cloud, m, point);
    if (pixel == STP_PIXEL_NONE)
        return false;
    const uint64_t before = stp_pixel_point(m, pixel);
    if (before == STP_PIXEL_NONE || cloud->points[point].source < cloud->points[before].source)
        stp_pixel_set(m, pixel, point);
    return before == STP_PIXEL_NONE;
}

/* Leaves no pixels to images that have no points. */
static void empty_images(const stp_pixel_images *images, const stp_cloud *cloud)
{
    const uint64_t end = cloud->first + cloud->count;
    for (uint64_t i = cloud->first; i < end; i++, stp_cloud_step(cloud->spill, i)) {
        stp_pixel_image *m = stp_pixel_image_of(images, &cloud->points[i]);
        if (m)
            m->has_points = true;
    }
    for (size_t i = 0; i < images->count; i++) {
        stp_pixel_image *m = &images->list[i];
        m->columns = m->has_points ? m->columns : 0;
    }
}

stp_status stp_pixel_images_room(stp_pixel_images *images, const stp_cloud *cloud, stp_error *err)
{
    stp_status status = STP_OK;
    const bool wide = cloud->first + cloud->count > UINT32_MAX;
    uint64_t pixels = 0;
    for (size_t i = 0; i < images->count; i++)
        pixels += stp_pixel_count(&images->list[i]);
    STP_TRY(stp_spill_alloc(cloud->spill, &images->points, pixels, sizeof *images->points, "pixels",
                            err));
    if (wide)
        STP_TRY(stp_spill_alloc(cloud->spill, &images->high, pixels, sizeof *images->high, "pixels",
                                err));
    if (pixels > 0) /* STP_PIXEL_NONE */
        memset(images->points, 0xff, pixels * sizeof *images->points);
    if (pixels > 0 && wide)
        memset(images->high, 0xff, pixels);
    pixels = 0;
    for (size_t i = 0; i < images->count; i++) {
        stp_pixel_image *m = &images->list[i];
        if (stp_pixel_count(m) == 0)
            continue;
        m->points = images->points + pixels;
        m->high = wide ? images->high + pixels : NULL;
        pixels += stp_pixel_count(m);
    }
done:
    return status;
}

stp_status stp_pixel_images_create(stp_pixel_images *out, const stp_cloud *cloud,
                                   const stp_prep_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    stp_pixel_images images = {0};
    const uint64_t end = cloud->first + cloud->count;
    STP_TRY(stp_pixel_images_list(&images, source, cloud->first_record, err));
    empty_images(&images, cloud);
    STP_TRY(stp_pixel_images_room(&images, cloud, err));
    for (uint64_t i = cloud->first; i < end; i++, stp_cloud_step(cloud->spill, i)) {
        const stp_pixel_image *m = stp_pixel_image_of(&images, &cloud->points[i]);
        images.point_count += m && add_point(cloud, m, i);
    }
    *out = images;
    images = (stp_pixel_images){0};
done:
    stp_pixel_images_clear(&images, cloud);
    return status;
}

void stp_pixel_images_clear(stp_pixel_images *images, const stp_cloud *cloud)
{
    stp_spill_free(cloud->spill, images->points);
    stp_spill_free(cloud->spill, images->high);
    free(images->list);
    *images = (stp_pixel_images){0};
}

double stp_pixel_step(const stp_cloud *cloud, const stp_pixel_image *image, uint64_t a, uint64_t b)
{
    const stp_dvec3 p = cloud->points[a].position, q = cloud->points[b].position;
    const stp_dvec3 step = stp_dvec3_sub(q, p), ray = stp_dvec3_sub(p, image->station);
    const double off_a = stp_dvec3_dot(stp_dvec3_from_float(stp_cloud_normal(cloud, a)), step);
    const double off_b = stp_dvec3_dot(stp_dvec3_from_float(stp_cloud_normal(cloud, b)), step);
    return fmax(fabs(off_a), fabs(off_b)) / stp_dvec3_dot(ray, ray);
}

uint64_t stp_pixel_pair(const stp_pixel_image *image, uint64_t i, uint32_t pixels, uint64_t *a)
{
    const uint64_t pixel = i / 2;
    const bool below = i % 2;
    const uint32_t column = (uint32_t)(pixel % image->columns);
    const uint32_t row = (uint32_t)(pixel / image->columns);
    *a = stp_pixel_point(image, pixel);
    if (*a == STP_PIXEL_NONE || (below ? image->rows - row : image->columns - column) <= pixels)
        return STP_PIXEL_NONE;
    return stp_pixel_point(image, pixel + (uint64_t)pixels * (below ? image->columns : 1));
}

stp_status stp_pixel_step_most(double *out, const stp_cloud *cloud, const stp_pixel_image *image,
                               stp_error *err)
{
    const uint64_t pairs = 2 * stp_pixel_count(image);
    const uint64_t step = (pairs / PAIRS + 1) | 1; /* odd: both directions count */
    double *found = NULL;
    size_t count = 0;
    stp_status status = stp_alloc(&found, (size_t)(pairs / step) + 1, sizeof *found, "pixels", err);
    if (status != STP_OK)
        return status;
    for (uint64_t i = 0; i < pairs; i += step) {
        uint64_t a;
        const uint64_t b = stp_pixel_pair(image, i, PAIR_PIXELS, &a);
        if (b != STP_PIXEL_NONE)
            found[count++] = stp_pixel_step(cloud, image, a, b);
    }
    stp_sort_doubles(found, count);
    *out = count > 0 ? MEDIANS * found[count / 2] : 0.0;
    free(found);
    return STP_OK;
}

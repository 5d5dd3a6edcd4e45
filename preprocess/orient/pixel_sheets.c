/* Joins the sheets of a depth camera's image. */
#include "preprocess/orient/pixel_sheets.h"

#include "base/memory.h"
#include "base/sort.h"
#include "preprocess/orient/forest.h"

#include <math.h>
#include <stdlib.h>

/* Points lie on one surface if they are this many times the median off. */
#define MEDIANS 6.0
/* About how many pairs tell the median, and how many pixels lie from one to the other: enough for
 * the camera's steps to count. */
#define PAIRS 65536u
#define PAIR_PIXELS 16u

/* An image, and which records and pixels of all images are its own. */
typedef struct image {
    stp_dvec3 station;
    uint64_t first, begin;
    uint32_t columns, rows;
} image;

typedef struct joining {
    stp_cloud *cloud;
    image *images; /* in the order of records */
    size_t count;
    uint64_t pixels;
    uint32_t *points;  /* by pixel of all images: the point, or NONE */
    stp_forest forest; /* of sheets */
} joining;

#define NONE UINT32_MAX

static uint64_t pixels_of(const image *m)
{
    return (uint64_t)m->columns * m->rows;
}

/* Lists the images that one station saw and whose pixels are their files' records. */
static stp_status list_images(joining *j, const stp_prep_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t first = 0;
    STP_TRY(stp_alloc(&j->images, source->file_count, sizeof *j->images, "images", err));
    for (size_t f = 0; f < source->file_count; f++) {
        const stp_prep_file *file = &source->files[f];
        const uint64_t pixels = (uint64_t)file->grid.columns * file->grid.rows;
        if (pixels > 0 && pixels <= file->point_count && file->grid.cell_count == 0 &&
            file->station_count == 1) {
            j->images[j->count++] = (image){source->stations[file->station_begin], first, j->pixels,
                                            file->grid.columns, file->grid.rows};
            j->pixels += pixels;
        }
        first += file->point_count;
    }
done:
    return status;
}

/* The image that a record may belong to: the last one that begins no later. */
static const image *image_of(const joining *j, uint64_t record)
{
    size_t low = 0, high = j->count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (j->images[middle].first <= record)
            low = middle + 1;
        else
            high = middle;
    }
    return low > 0 ? &j->images[low - 1] : NULL;
}

/* Finds the points of all images. Returns a number above those of all sheets. */
static uint32_t find_points(joining *j)
{
    const stp_cloud *cloud = j->cloud;
    uint32_t sheets = 0;
    for (uint64_t i = 0; i < j->pixels; i++)
        j->points[i] = NONE;
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i)) {
        const uint64_t record = cloud->points[i].source;
        const image *m = image_of(j, record);
        if (cloud->sheets[i] == STP_SHEET_NONE)
            continue;
        sheets = cloud->sheets[i] >= sheets ? cloud->sheets[i] + 1 : sheets;
        if (m && record - m->first < pixels_of(m) && cloud->points[i].given == STP_GIVEN_IMAGE)
            j->points[m->begin + (record - m->first)] = i;
    }
    return sheets;
}

/* How far two points are off each other's plane, by the square of the distance to the camera. */
static double distance_of(const stp_cloud *cloud, const image *m, uint32_t a, uint32_t b)
{
    const stp_dvec3 p = cloud->points[a].position, q = cloud->points[b].position;
    const stp_dvec3 step = stp_dvec3_sub(q, p), ray = stp_dvec3_sub(p, m->station);
    const double off_a = stp_dvec3_dot(stp_dvec3_from_float(stp_cloud_normal(cloud, a)), step);
    const double off_b = stp_dvec3_dot(stp_dvec3_from_float(stp_cloud_normal(cloud, b)), step);
    return fmax(fabs(off_a), fabs(off_b)) / stp_dvec3_dot(ray, ray);
}

/* The other point of pair i of an image: so many pixels to the right of a pixel, or below it. NONE
 * if one of them is not. */
static uint32_t other_of(const joining *j, const image *m, uint64_t i, uint32_t pixels,
                         uint32_t *point)
{
    const uint64_t pixel = i / 2;
    const bool below = i % 2;
    const uint32_t column = (uint32_t)(pixel % m->columns), row = (uint32_t)(pixel / m->columns);
    const uint32_t *own = j->points + m->begin;
    *point = own[pixel];
    if (*point == NONE || (below ? m->rows - row : m->columns - column) <= pixels)
        return NONE;
    return own[pixel + (uint64_t)pixels * (below ? m->columns : 1)];
}

/* The median of all pairs; 0 without any. Errors: OUT_OF_MEMORY. */
static stp_status find_median(const joining *j, const image *m, double *out, stp_error *err)
{
    const uint64_t pairs = 2 * pixels_of(m);
    const uint64_t step = (pairs / PAIRS + 1) | 1; /* odd: both directions count */
    double *found = NULL;
    size_t count = 0;
    stp_status status = stp_alloc(&found, (size_t)(pairs / step) + 1, sizeof *found, "pixels", err);
    if (status != STP_OK)
        return status;
    for (uint64_t i = 0; i < pairs; i += step) {
        uint32_t a;
        const uint32_t b = other_of(j, m, i, PAIR_PIXELS, &a);
        if (b != NONE)
            found[count++] = distance_of(j->cloud, m, a, b);
    }
    stp_sort_doubles(found, count);
    *out = count > 0 ? found[count / 2] : 0.0;
    free(found);
    return STP_OK;
}

static void join_image(joining *j, const image *m, double limit)
{
    const uint32_t *sheets = j->cloud->sheets;
    for (uint64_t i = 0; i < 2 * pixels_of(m); i++) {
        uint32_t a;
        const uint32_t b = other_of(j, m, i, 1, &a);
        if (b != NONE && distance_of(j->cloud, m, a, b) <= limit)
            stp_forest_join(&j->forest, sheets[a], sheets[b], false);
    }
}

stp_status stp_pixel_sheets_join(stp_cloud *cloud, const stp_prep_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    joining j = {.cloud = cloud};
    uint8_t parity = 0;
    STP_TRY(list_images(&j, source, err));
    STP_TRY(stp_spill_alloc(cloud->spill, &j.points, j.pixels, sizeof *j.points, "pixels", err));
    STP_TRY(stp_forest_create(&j.forest, find_points(&j), cloud->spill, err));
    for (size_t i = 0; i < j.count; i++) {
        double median = 0.0;
        STP_TRY(find_median(&j, &j.images[i], &median, err));
        join_image(&j, &j.images[i], MEDIANS * median);
    }
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i))
        if (cloud->sheets[i] != STP_SHEET_NONE)
            cloud->sheets[i] = stp_forest_find(&j.forest, cloud->sheets[i], &parity);
done:
    stp_forest_clear(&j.forest);
    stp_spill_free(cloud->spill, j.points);
    free(j.images);
    return status;
}

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

typedef struct image {
    stp_cloud *cloud;
    stp_dvec3 station;
    uint32_t *points; /* by pixel: the point, or NONE */
    uint32_t columns, rows;
    stp_forest forest; /* of sheets */
} image;

#define NONE UINT32_MAX

static bool is_of_image(const stp_cloud *cloud, uint32_t i)
{
    return cloud->points[i].given == STP_GIVEN_IMAGE && cloud->sheets[i] != STP_SHEET_NONE;
}

/* Finds the points of the image, whose first record is `first`. *sheets: more than all numbers of
 * sheets. Returns how many points there are. */
static uint32_t find_points(image *m, uint64_t first, uint32_t *sheets)
{
    const uint64_t pixels = (uint64_t)m->columns * m->rows;
    const stp_cloud *cloud = m->cloud;
    uint32_t count = 0;
    *sheets = 0;
    for (uint64_t i = 0; i < pixels; i++)
        m->points[i] = NONE;
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i)) {
        const uint64_t pixel = cloud->points[i].source - first; /* before it: a large number */
        if (cloud->sheets[i] != STP_SHEET_NONE && cloud->sheets[i] >= *sheets)
            *sheets = cloud->sheets[i] + 1;
        if (pixel >= pixels || !is_of_image(cloud, i))
            continue;
        m->points[pixel] = i;
        count++;
    }
    return count;
}

/* How far two points are off each other's plane, by the square of the distance to the camera. */
static double distance_of(const image *m, uint32_t a, uint32_t b)
{
    const stp_dvec3 p = m->cloud->points[a].position, q = m->cloud->points[b].position;
    const stp_dvec3 step = stp_dvec3_sub(q, p), ray = stp_dvec3_sub(p, m->station);
    const double off_a = stp_dvec3_dot(stp_dvec3_from_float(stp_cloud_normal(m->cloud, a)), step);
    const double off_b = stp_dvec3_dot(stp_dvec3_from_float(stp_cloud_normal(m->cloud, b)), step);
    return fmax(fabs(off_a), fabs(off_b)) / stp_dvec3_dot(ray, ray);
}

/* The other point of pair i: so many pixels to the right of a pixel, or below it. NONE if one of
 * them is not. */
static uint32_t other_of(const image *m, uint64_t i, uint32_t pixels, uint32_t *point)
{
    const uint64_t pixel = i / 2;
    const bool below = i % 2;
    const uint32_t column = (uint32_t)(pixel % m->columns), row = (uint32_t)(pixel / m->columns);
    *point = m->points[pixel];
    if (*point == NONE || (below ? m->rows - row : m->columns - column) <= pixels)
        return NONE;
    return m->points[pixel + (uint64_t)pixels * (below ? m->columns : 1)];
}

/* The median of all pairs; 0 without any. Errors: OUT_OF_MEMORY. */
static stp_status find_median(const image *m, double *out, stp_error *err)
{
    const uint64_t pairs = 2 * (uint64_t)m->columns * m->rows;
    const uint64_t step = (pairs / PAIRS + 1) | 1; /* odd: both directions count */
    double *found = NULL;
    size_t count = 0;
    stp_status status = stp_alloc(&found, (size_t)(pairs / step) + 1, sizeof *found, "pixels", err);
    if (status != STP_OK)
        return status;
    for (uint64_t i = 0; i < pairs; i += step) {
        uint32_t a;
        const uint32_t b = other_of(m, i, PAIR_PIXELS, &a);
        if (b != NONE)
            found[count++] = distance_of(m, a, b);
    }
    stp_sort_doubles(found, count);
    *out = count > 0 ? found[count / 2] : 0.0;
    free(found);
    return STP_OK;
}

static void join(image *m, double limit)
{
    const uint64_t pairs = 2 * (uint64_t)m->columns * m->rows;
    for (uint64_t i = 0; i < pairs; i++) {
        uint32_t a;
        const uint32_t b = other_of(m, i, 1, &a);
        if (b != NONE && distance_of(m, a, b) <= limit)
            stp_forest_join(&m->forest, m->cloud->sheets[a], m->cloud->sheets[b], false);
    }
}

static stp_status join_image(stp_cloud *cloud, const stp_prep_file *file, stp_dvec3 station,
                             uint64_t first, stp_error *err)
{
    stp_status status = STP_OK;
    image m = {
        .cloud = cloud, .station = station, .columns = file->grid.columns, .rows = file->grid.rows};
    uint32_t sheets = 0;
    double median = 0.0;
    uint8_t parity = 0;
    STP_TRY(stp_spill_alloc(cloud->spill, &m.points, (size_t)m.columns * m.rows, sizeof *m.points,
                            "pixels", err));
    if (find_points(&m, first, &sheets) == 0)
        goto done;
    STP_TRY(stp_forest_create(&m.forest, sheets, cloud->spill, err));
    STP_TRY(find_median(&m, &median, err));
    join(&m, MEDIANS * median);
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i))
        if (cloud->sheets[i] != STP_SHEET_NONE)
            cloud->sheets[i] = stp_forest_find(&m.forest, cloud->sheets[i], &parity);
done:
    stp_forest_clear(&m.forest);
    stp_spill_free(cloud->spill, m.points);
    return status;
}

stp_status stp_pixel_sheets_join(stp_cloud *cloud, const stp_prep_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t first = 0;
    for (size_t f = 0; f < source->file_count; f++) {
        const stp_prep_file *file = &source->files[f];
        const uint64_t pixels = (uint64_t)file->grid.columns * file->grid.rows;
        if (pixels > 0 && pixels <= file->point_count && file->grid.cell_count == 0 &&
            file->station_count == 1)
            STP_TRY(join_image(cloud, file, source->stations[file->station_begin], first, err));
        first += file->point_count;
    }
done:
    return status;
}

/* Guesses that an image without a place is a depth camera's, and its pinhole. */
#include "formats/scan/grid/depth_guess.h"

#include "base/memory.h"
#include "formats/scan/grid/raster.h"

#include <stdio.h>
#include <stdlib.h>

/* Sizes of usual depth cameras, with their focal lengths in pixels. The axis goes through the
 * middle. Kinect and Xtion; Kinect 2; RealSense; Azure Kinect; LiDAR of phones. */
static const struct {
    uint32_t width, height;
    double focal;
} cameras[] = {{640, 480, 525.0}, {320, 240, 262.5}, {512, 424, 365.0}, {1280, 720, 640.0},
               {848, 480, 424.0}, {640, 360, 320.0}, {480, 270, 240.0}, {424, 240, 212.0},
               {640, 576, 504.0}, {320, 288, 252.0}, {256, 192, 213.0}};

enum { VALUES = 65536 };

#define MILLIMETRES_USUAL 10000u /* few depth cameras measure farther */
#define RUN_SHARE 0.8            /* of the zeros lie in runs */

/* Numbers up to this are millimetres, 13 m; others count 5000 to the metre, as TUM's do. */
#define MILLIMETRES_MOST 13000u
/* The least distance that cameras measure is not below so many of either unit. */
#define NEAREST 100u
#define NEAR_PART 0.025  /* of the greatest depth */
#define SMALL_PART 0.1   /* of the median: no camera's, beside a zero */
#define SMALL_SHARE 0.01 /* of the pixels beside zeros may be small */
#define ZERO_LEAST 0.002
#define ZERO_MOST 0.95
#define EDGE_PART 0.05    /* of the depth: a surface ends there */
#define EDGE_LEAST 0.0005 /* of the pairs of pixels */
#define EDGE_MOST 0.1
#define JOINED_PART 0.03 /* of the depth: pixels beside each other on one surface */
#define SLANT_PART 0.08  /* of the depth: so much a window differs at its ends, or more */
#define FIT_PART 0.25 /* of the squares that the other fit leaves: one fits, the other does not */
#define FIT_TIMES 2u  /* so many times as many windows fit perspective as fit heights */
enum {
    RUN_LEAST = 8,
    WINDOW_PART = 40, /* of the width: a quarter of a window */
    FITS_LEAST = 500  /* windows: fewer say nothing */
};

typedef struct depths {
    uint32_t width, height, lowest, median, highest;
    bool floats; /* metres; z has millimetres */
    uint64_t zeros, in_runs, beside_zeros, small, pairs, edges, bent, straight;
    uint16_t *z;
    uint32_t *histogram;
} depths;

static stp_status load(depths *d, stp_raster_file *raster, stp_error *err)
{
    stp_status status = STP_OK;
    double *row = NULL;
    const size_t count = (size_t)d->width * d->height;
    STP_TRY(stp_alloc(&row, d->width, sizeof *row, "a row of depths", err));
    STP_TRY(stp_alloc_unset(&d->z, count, sizeof *d->z, "depths", err));
    STP_TRY(stp_alloc(&d->histogram, VALUES, sizeof *d->histogram, "depths", err));
    for (uint32_t r = 0; r < d->height; r++) {
        STP_TRY(stp_raster_read(raster, r, row, err));
        for (uint32_t c = 0; c < d->width; c++) {
            const double number = d->floats ? 1000.0 * row[c] : row[c];
            const uint16_t z = (uint16_t)(number > 0.0 && number < VALUES ? number : 0.0);
            d->z[(size_t)r * d->width + c] = z;
            d->histogram[z]++;
        }
    }
    d->zeros = d->histogram[0];
done:
    free(row);
    return status;
}

/* The least number that a part of the pixels with depths is not above. */
static uint32_t quantile(const depths *d, double part)
{
    const double wanted = part * ((double)d->width * d->height - (double)d->zeros);
    uint64_t below = 0;
    uint32_t value = 0;
    while (value + 1 < VALUES && (below == 0 || (double)below < wanted))
        below += d->histogram[++value];
    return value;
}

/* Counts a window of one slanted surface whose ends are first and last, if at its quarters depth or
 * 1 / depth alone is linear. quarter: to the next of five pixels. */
static void count_window(depths *d, const uint16_t *z, size_t quarter)
{
    const double first = z[0], last = z[4 * quarter], slant = last - first, sum = first + last;
    double linear = 0.0, perspective = 0.0;
    if (!(slant * slant > SLANT_PART * SLANT_PART * sum * sum))
        return;
    for (unsigned k = 1; k < 4; k++) {
        const double t = 0.25 * k, here = z[k * quarter];
        const double of_heights = here - (first + t * slant);
        const double of_depths = here - 1.0 / ((1.0 - t) / first + t / last);
        linear += of_heights * of_heights;
        perspective += of_depths * of_depths;
    }
    d->bent += perspective < FIT_PART * linear;
    d->straight += linear < FIT_PART * perspective;
}

/* Counts one line of pixels: zeros, edges, and windows. */
static void count_line(depths *d, const uint16_t *z, size_t count, size_t stride)
{
    const size_t quarter = d->width / WINDOW_PART;
    size_t joined = 0; /* pixels before this one, on one surface with it */
    for (size_t i = 1; i < count; i++) {
        const double here = z[i * stride], before = z[(i - 1) * stride];
        const double step = here > before ? here - before : before - here;
        const double near = here < before ? here : before, far = near + step;
        joined = near > 0.0 && step <= JOINED_PART * near ? joined + 1 : 0;
        if (near > 0.0) {
            d->pairs++;
            d->edges += step > EDGE_PART * near;
        } else if (far > 0.0) {
            d->beside_zeros++;
            d->small += far < SMALL_PART * d->median;
        }
        if (joined >= 4 * quarter)
            count_window(d, z + (i - 4 * quarter) * stride, quarter * stride);
    }
}

static void count_runs(depths *d)
{
    for (uint32_t r = 0; r < d->height; r++) {
        const uint16_t *z = d->z + (size_t)r * d->width;
        for (uint32_t c = 0, end; c < d->width; c = end + 1) {
            for (end = c; end < d->width && z[end] == 0;)
                end++;
            d->in_runs += end - c >= RUN_LEAST ? end - c : 0;
        }
    }
}

/* Whether surfaces end in the image, and its holes are as those of cameras. */
static bool has_edges(depths *d)
{
    count_runs(d);
    return (double)d->edges >= EDGE_LEAST * (double)d->pairs && d->highest <= MILLIMETRES_USUAL &&
           (double)d->in_runs >= RUN_SHARE * (double)d->zeros;
}

static bool are_depths(depths *d)
{
    const double count = (double)d->width * d->height, zeros = (double)d->zeros / count;
    if (!(zeros >= ZERO_LEAST && zeros <= ZERO_MOST))
        return false;
    d->lowest = quantile(d, 0.001);
    d->median = quantile(d, 0.5);
    d->highest = quantile(d, 0.99);
    if (d->lowest < NEAREST || d->lowest < NEAR_PART * d->highest)
        return false;
    for (uint32_t r = 0; r < d->height; r++)
        count_line(d, d->z + (size_t)r * d->width, d->width, 1);
    for (uint32_t c = 0; c < d->width; c++)
        count_line(d, d->z + c, d->height, d->width);
    return (double)d->small <= SMALL_SHARE * (double)d->beside_zeros &&
           (double)d->edges <= EDGE_MOST * (double)d->pairs &&
           (d->bent + d->straight >= FITS_LEAST ? d->bent >= FIT_TIMES * d->straight
                                                : has_edges(d));
}

static double scale_of(const depths *d)
{
    return d->floats ? 1.0 : d->highest <= MILLIMETRES_MOST ? 0.001 : 0.0002;
}

/* Looks at an image. told: it is a depth camera's if it can be, and scale stays 0. */
static stp_status look(stp_depth_look *out, const char *path, bool told, stp_error *err)
{
    stp_status status = STP_OK;
    stp_raster_file *raster = NULL;
    depths d = {0};
    *out = (stp_depth_look){0};
    STP_TRY(stp_raster_open(&raster, path, STP_RASTER_HEIGHTS, 1, err));
    const stp_raster_info *info = stp_raster_get_info(raster);
    if (info->channels != 1 || (!info->floats && (info->full <= 255.0 || info->full >= VALUES)) ||
        info->spaced || info->placed || info->scale != 0.0 || info->has_none)
        goto done;
    for (size_t i = 0; i < sizeof cameras / sizeof *cameras; i++)
        if (info->width == cameras[i].width && info->height == cameras[i].height)
            *out = (stp_depth_look){cameras[i].focal, info->width, info->height, info->floats, 0.0};
    if (out->focal == 0.0 || told)
        goto done;
    d.floats = info->floats;
    d.width = info->width;
    d.height = info->height;
    STP_TRY(load(&d, raster, err));
    out->scale = are_depths(&d) ? scale_of(&d) : 0.0;
done:
    stp_raster_close(&raster);
    free(d.z);
    free(d.histogram);
    return status;
}

stp_status stp_depth_look_at(stp_depth_look *out, const char *path, stp_error *err)
{
    return look(out, path, false, err);
}

stp_status stp_depth_guess(stp_grid_params *params, char *note, size_t note_bytes, const char *path,
                           stp_error *err)
{
    stp_status status = STP_OK;
    stp_depth_look seen;
    const bool told = params->series == STP_SERIES_DEPTHS;
    if (params->fx > 0.0 || params->dx > 0.0 || params->series == STP_SERIES_HEIGHTS)
        return STP_OK;
    STP_TRY(look(&seen, path, told, err));
    if (seen.focal == 0.0 || (!told && seen.scale == 0.0))
        goto done;
    params->fx = params->fy = seen.focal;
    params->cx = 0.5 * (seen.width - 1);
    params->cy = 0.5 * (seen.height - 1);
    if (params->scale == 0.0)
        params->scale = seen.scale;
    snprintf(note, note_bytes,
             "taken as a depth camera's image (--pinhole %g,%g,%g,%g --height-scale %g): give the "
             "camera's own numbers, or --spacing 1 if these are heights",
             params->fx, params->fy, params->cx, params->cy, params->scale);
done:
    return status;
}

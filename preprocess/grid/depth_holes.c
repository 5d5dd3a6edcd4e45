/* Finds where images have no samples. */
#include "preprocess/grid/depth_holes.h"

#include "base/memory.h"
#include "preprocess/patch/partition.h"

#include <math.h>
#include <stdlib.h>

/* An image whose columns turn so far, of a full turn, goes all around. */
#define ROUND_SHARE 0.98

struct stp_depth_open {
    const stp_depth_images *images;
    uint32_t image;
};

static uint32_t limit(int64_t at, uint32_t count)
{
    return at < 0 ? 0 : at < count ? (uint32_t)at : count - 1;
}

/* The rays by square of an image, row by row. */
static uint32_t *rays_of(const stp_depth_images *images, uint32_t image)
{
    return images->pieces.of_square + images->cameras[image].first_square;
}

/* stp_holes_place. */
static stp_dvec3 direction_of(const void *context, int64_t column, int64_t row)
{
    const struct stp_depth_open *open = context;
    const stp_pixel_image *m = &open->images->pixels.list[open->image];
    const uint32_t c = limit(column, m->columns) / STP_SQUARE_SIDE;
    const uint32_t r = limit(row, m->rows) / STP_SQUARE_SIDE;
    const stp_depth_rays *rays = &open->images->pieces.rays[rays_of(
        open->images, open->image)[(size_t)r * stp_depth_squares(m->columns) + c]];
    double out[3];
    out[rays->axis] = rays->sign;
    for (unsigned k = 0; k < 2; k++) {
        const double *t = rays->tilt[k];
        out[(rays->axis + 1 + k) % 3] =
            rays->sign * (t[0] + (double)column * t[1] + (double)row * t[2]);
    }
    return stp_dvec3_normalize((stp_dvec3){out[0], out[1], out[2]});
}

/* Squares without points have the rays of the nearest square that has some. *told: one has. */
static stp_status spread_rays(const stp_depth_images *images, uint32_t image, bool *told,
                              stp_error *err)
{
    stp_status status = STP_OK;
    const stp_pixel_image *m = &images->pixels.list[image];
    const uint32_t columns = stp_depth_squares(m->columns), rows = stp_depth_squares(m->rows);
    const size_t count = (size_t)columns * rows;
    uint32_t *of = rays_of(images, image), *queue = NULL;
    size_t end = 0;
    STP_TRY(stp_alloc(&queue, count, sizeof *queue, "squares", err));
    for (size_t i = 0; i < count; i++)
        if (of[i] != STP_DEPTH_NO_RAYS)
            queue[end++] = (uint32_t)i;
    *told = end > 0;
    for (size_t i = 0; i < end; i++) {
        const uint32_t c = queue[i] % columns, r = queue[i] / columns;
        const uint32_t beside[4] = {
            c > 0 ? queue[i] - 1 : queue[i], c + 1 < columns ? queue[i] + 1 : queue[i],
            r > 0 ? queue[i] - columns : queue[i], r + 1 < rows ? queue[i] + columns : queue[i]};
        for (int k = 0; k < 4; k++) {
            if (of[beside[k]] != STP_DEPTH_NO_RAYS)
                continue;
            of[beside[k]] = of[queue[i]];
            queue[end++] = beside[k];
        }
    }
done:
    free(queue);
    return status;
}

/* The ways between the directions of neighbouring columns and rows. */
static void step_of(const struct stp_depth_open *open, int64_t column, int64_t row, double out[2])
{
    const stp_dvec3 at = direction_of(open, column, row);
    out[0] = stp_dvec3_length(stp_dvec3_sub(direction_of(open, column + 1, row), at));
    out[1] = stp_dvec3_length(stp_dvec3_sub(direction_of(open, column, row + 1), at));
}

static stp_holes_grid grid_of(const struct stp_depth_open *open)
{
    const stp_pixel_image *m = &open->images->pixels.list[open->image];
    double step[2], most = 0.0;
    for (uint32_t r = 0; r < m->rows; r += STP_SQUARE_SIDE) {
        step_of(open, m->columns / 2, r, step);
        most = fmax(most, step[0]);
    }
    step_of(open, m->columns / 2, m->rows / 2, step);
    return (stp_holes_grid){.columns = m->columns,
                            .rows = m->rows,
                            .cell = fmin(step[0], step[1]),
                            .rays = true,
                            .round = most * m->columns > ROUND_SHARE * 2.0 * M_PI,
                            .station = m->station,
                            .place = direction_of,
                            .context = open};
}

static stp_status add_holes(const struct stp_depth_open *open, stp_holes *out, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_pixel_image *m = &open->images->pixels.list[open->image];
    bool told;
    STP_TRY(spread_rays(open->images, open->image, &told, err));
    if (!told) /* all its points are beside it */
        return STP_OK;
    const stp_holes_grid grid = grid_of(open);
    STP_TRY(stp_holes_create(out, &grid, err));
    for (uint64_t i = 0; i < stp_pixel_count(m); i++) {
        stp_cloud_stride(open->images->cloud->spill, i, 1);
        if (stp_pixel_point(m, i) == STP_PIXEL_NONE)
            stp_holes_add(out, (uint32_t)(i % m->columns), (uint32_t)(i / m->columns));
    }
    stp_holes_finish(out);
done:
    return status;
}

stp_status stp_depth_images_keep_open(stp_depth_images *images, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t count = images->pixels.count;
    STP_TRY(stp_alloc(&images->holes, count + 1, sizeof *images->holes, "holes", err));
    STP_TRY(stp_alloc(&images->open, count, sizeof *images->open, "holes", err));
    for (uint32_t i = 0; i < count; i++) {
        images->open[i] = (struct stp_depth_open){images, i};
        if (images->pixels.list[i].has_points)
            STP_TRY(add_holes(&images->open[i], &images->holes[i + 1], err));
    }
done:
    return status;
}

void stp_depth_keep_open(const stp_depth_images *images, uint32_t image, stp_item *items,
                         uint32_t count)
{
    for (uint32_t i = 0; images->holes && i < count; i++) {
        stp_disc *disc = &items[i].disc;
        items[i].sheet = STP_SHEET_APART | (image + 1);
        disc->radius = stp_holes_radius(&images->holes[image + 1], disc->centre, disc->radius);
        disc->reach = disc->bound = disc->radius;
    }
}

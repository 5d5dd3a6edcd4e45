/* Fits planes to windows of an image. */
#include "preprocess/surface/image_normals.h"

#include "base/memory.h"
#include "base/sort.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* Pixels: the side of a tile; the step between pixels where noise is measured; the reach of the
 * windows for that. */
#define TILE 32u
#define NOISE_STRIDE 3u
#define NOISE_REACH 3
/* Least windows of a tile. */
#define WINDOWS_LEAST 5u
/* A window for noise takes pixels whose inverse depth differs by at most this part. */
#define NEAR 0.2
/* If the noise is below this part of the pixels' spacing, planes of near points are good enough. */
#define QUIET 0.25
/* A noise below this part of the pixels' spacing is no noise, but rounding. */
#define EXACT 1e-9
/* Windows without noise lie within steps of depth if they face the same way: the length of their
 * mean normal. Otherwise the image is exact. */
#define STEPS_ALIKE 0.9995
/* Reach in pixels to each side: of the first window and of the widest one. A window has at most 9 x
 * 9 pixels. */
#define FIRST_REACH 2
#define LAST_REACH 64
#define WINDOW 81u
/* Least pixels of a plane. */
#define PIXELS_LEAST 6u
/* In deviations. A pixel farther off does not belong to the plane. */
#define OUTSIDE 3.0
/* A plane with a residual of this many times the noise is wrong. */
#define EXCESS 2.0
/* The angle is sure enough at this error, in radians. */
#define SURE (2.0 * STP_IMAGE_NORMAL_ERROR)
/* Normals of neighbours are averaged if they are this much alike, as a cosine: 4 SURE. */
#define ALIKE 0.9982f
/* Tangent of the greatest angle to the ray. Nothing is seen at a more grazing angle. */
#define STEEPEST 5.7
/* Most pixels of an image per point. */
#define SPARSEST 64u

/* A pixel's point relative to the ray of another pixel, the middle: tangents x and y, and the
 * middle's distance over the point's depth, less 1. */
typedef struct sight {
    double x, y, depth;
} sight;

/* depth = at_x x + at_y y + offset. */
typedef struct image_plane {
    double at_x, at_y, offset;
    double rms;    /* of the residuals */
    double unsure; /* deviation of the slope at a noise of 1 */
} image_plane;

/* Axes with the ray through a pixel. */
typedef struct pixel_axes {
    stp_dvec3 axes[3]; /* the third is the ray */
    double distance;
} pixel_axes;

typedef struct pixel_grid {
    const stp_file_points *points;
    stp_dvec3 station;
    uint32_t columns, rows, tile_columns, tile_rows;
    uint32_t *at;    /* by pixel: the point's number in its file, from 1; 0: none */
    vec3s *normals;  /* by pixel: of its plane; zero: none */
    double *noise;   /* by tile: noise of inverse depths, the median of its windows */
    double *most;    /* by tile: the noise that most windows do not exceed */
    double *angle;   /* by tile: between pixels, radians */
    stp_dvec3 *even; /* by tile: sum of the normals of windows without noise */
    unsigned *evens; /* by tile: their number */
    atomic_uint_fast64_t count;
} pixel_grid;

static const stp_cloud_point *point_at(const pixel_grid *g, int64_t column, int64_t row)
{
    if (column < 0 || row < 0 || column >= g->columns || row >= g->rows)
        return NULL;
    const uint32_t at = g->at[(size_t)row * g->columns + (size_t)column];
    return at > 0 ? &g->points->cloud->points[g->points->begin + at - 1] : NULL;
}

/* False if the pixel has no point, or the point no ray. */
static bool axes_at(const pixel_grid *g, uint32_t column, uint32_t row, pixel_axes *out)
{
    const stp_cloud_point *p = point_at(g, column, row);
    if (!p)
        return false;
    const stp_dvec3 d = stp_dvec3_sub(p->position, g->station);
    out->distance = stp_dvec3_length(d);
    stp_dvec3_axes(out->axes, stp_dvec3_normalize(d));
    return out->distance > 0.0 && isfinite(out->distance);
}

/* False if no point is in front of the station. */
static bool see(const pixel_grid *g, const pixel_axes *axes, int64_t column, int64_t row,
                sight *out)
{
    const stp_cloud_point *p = point_at(g, column, row);
    if (!p)
        return false;
    const stp_dvec3 d = stp_dvec3_sub(p->position, g->station);
    const double depth = stp_dvec3_dot(d, axes->axes[2]);
    if (!(depth > 0.01 * axes->distance))
        return false;
    *out = (sight){.x = stp_dvec3_dot(d, axes->axes[0]) / depth,
                   .y = stp_dvec3_dot(d, axes->axes[1]) / depth,
                   .depth = axes->distance / depth - 1.0};
    return true;
}

/* Collects a window's pixels: every stride-th, up to `reach` on each side. */
static unsigned look(const pixel_grid *g, const pixel_axes *axes, uint32_t column, uint32_t row,
                     int reach, int stride, sight *out)
{
    unsigned count = 0;
    for (int r = -reach; r <= reach; r += stride)
        for (int c = -reach; c <= reach; c += stride)
            count += see(g, axes, (int64_t)column + c, (int64_t)row + r, &out[count]);
    return count;
}

/* Fits a plane by least squares. False if there are too few pixels, or all are on a line. */
static bool fit_plane(const sight *s, unsigned count, image_plane *out)
{
    double x = 0.0, y = 0.0, depth = 0.0, xx = 0.0, xy = 0.0, yy = 0.0, xd = 0.0, yd = 0.0;
    double left = 0.0;
    if (count < PIXELS_LEAST)
        return false;
    for (unsigned i = 0; i < count; i++) {
        x += s[i].x / count;
        y += s[i].y / count;
        depth += s[i].depth / count;
    }
    for (unsigned i = 0; i < count; i++) {
        const double dx = s[i].x - x, dy = s[i].y - y, dd = s[i].depth - depth;
        xx += dx * dx;
        xy += dx * dy;
        yy += dy * dy;
        xd += dx * dd;
        yd += dy * dd;
    }
    const double determinant = xx * yy - xy * xy;
    if (!(determinant > 1e-3 * (xx + yy) * (xx + yy)))
        return false;
    out->at_x = (yy * xd - xy * yd) / determinant;
    out->at_y = (xx * yd - xy * xd) / determinant;
    out->offset = depth - out->at_x * x - out->at_y * y;
    out->unsure = sqrt((xx + yy) / determinant);
    for (unsigned i = 0; i < count; i++) {
        const double off = s[i].depth - out->offset - out->at_x * s[i].x - out->at_y * s[i].y;
        left += off * off;
    }
    out->rms = sqrt(left / (count - 3));
    return true;
}

/* Drops pixels that are off the plane by more than `most`, plus `slope` times their distance from
 * the middle. */
static unsigned keep_near(const image_plane *p, double most, double slope, sight *s, unsigned count)
{
    unsigned kept = 0;
    for (unsigned i = 0; i < count; i++) {
        const double off = s[i].depth - p->offset - p->at_x * s[i].x - p->at_y * s[i].y;
        if (fabs(off) <= most + slope * sqrt(s[i].x * s[i].x + s[i].y * s[i].y))
            s[kept++] = s[i];
    }
    return kept;
}

/* The plane's normal: faces the station, and is no more slanted than STEEPEST. */
static stp_dvec3 normal_of(const pixel_axes *axes, const image_plane *p)
{
    const double forward = 1.0 + p->offset;
    const double tangent = hypot(p->at_x, p->at_y) / forward;
    const double scale = tangent > STEEPEST ? STEEPEST / tangent : 1.0;
    const stp_dvec3 n = stp_dvec3_add(stp_dvec3_scale(axes->axes[0], scale * p->at_x),
                                      stp_dvec3_add(stp_dvec3_scale(axes->axes[1], scale * p->at_y),
                                                    stp_dvec3_scale(axes->axes[2], forward)));
    return stp_dvec3_normalize(stp_dvec3_scale(n, -1.0));
}

/* Measures the noise and the angle between pixels of a tile. */
static void measure_tile(pixel_grid *g, uint32_t tile_column, uint32_t tile_row)
{
    const uint32_t side = (TILE + NOISE_STRIDE - 1) / NOISE_STRIDE;
    double noises[((TILE + NOISE_STRIDE - 1) / NOISE_STRIDE) *
                  ((TILE + NOISE_STRIDE - 1) / NOISE_STRIDE)];
    double angles[sizeof noises / sizeof *noises];
    const size_t tile = (size_t)tile_row * g->tile_columns + tile_column;
    unsigned count = 0;
    for (uint32_t i = 0; i < side * side; i++) {
        const uint32_t column = tile_column * TILE + i % side * NOISE_STRIDE;
        const uint32_t row = tile_row * TILE + i / side * NOISE_STRIDE;
        pixel_axes axes;
        image_plane plane;
        sight window[WINDOW], beside = {0.0, 0.0, 0.0};
        if (!axes_at(g, column, row, &axes) || (!see(g, &axes, (int64_t)column + 1, row, &beside) &&
                                                !see(g, &axes, column, (int64_t)row + 1, &beside)))
            continue;
        unsigned seen = look(g, &axes, column, row, NOISE_REACH, 1, window);
        seen = keep_near(&(image_plane){.unsure = 0.0}, NEAR, 0.0, window, seen);
        if (!fit_plane(window, seen, &plane))
            continue;
        noises[count] = plane.rms / axes.distance;
        angles[count] = hypot(beside.x, beside.y);
        if (plane.rms <= EXACT * angles[count]) {
            g->even[tile] = stp_dvec3_add(g->even[tile], normal_of(&axes, &plane));
            g->evens[tile]++;
        }
        count++;
    }
    stp_sort_doubles(noises, count);
    stp_sort_doubles(angles, count);
    g->noise[tile] = count >= WINDOWS_LEAST ? noises[count / 2] : 0.0;
    g->most[tile] = count >= WINDOWS_LEAST ? noises[count * 4 / 5] : 0.0;
    g->angle[tile] = count >= WINDOWS_LEAST ? angles[count / 2] : 0.0;
}

/* Fits the plane at a pixel in growing windows. False if there is none. */
static bool plane_at(const pixel_grid *g, const pixel_axes *axes, uint32_t column, uint32_t row,
                     double noise, image_plane *out)
{
    image_plane best = {.unsure = 0.0};
    double slope = STEEPEST;
    bool found = false;
    for (int reach = FIRST_REACH; reach <= LAST_REACH; reach *= 2) {
        sight window[WINDOW];
        image_plane plane;
        unsigned count = look(g, axes, column, row, reach, reach > 4 ? reach / 4 : 1, window);
        count = keep_near(&best, OUTSIDE * noise, slope, window, count);
        if (!fit_plane(window, count, &plane))
            continue;
        if (found && plane.rms > EXCESS * noise)
            break;
        best = plane;
        found = true;
        slope = fmin(OUTSIDE * noise * plane.unsure, STEEPEST);
        const double squared = plane.at_x * plane.at_x + plane.at_y * plane.at_y;
        if (noise * plane.unsure <= SURE * sqrt(1.0 + squared))
            break;
    }
    *out = best;
    return found && 1.0 + best.offset > 0.0;
}

static stp_status measure_row(void *context, size_t index, unsigned worker, stp_error *err)
{
    pixel_grid *g = context;
    (void)worker;
    (void)err;
    for (uint32_t tile = 0; tile < g->tile_columns; tile++)
        measure_tile(g, tile, (uint32_t)index);
    return STP_OK;
}

static stp_status set_row(void *context, size_t index, unsigned worker, stp_error *err)
{
    pixel_grid *g = context;
    (void)worker;
    (void)err;
    for (size_t i = 0; i < (size_t)TILE * g->columns; i++) {
        const uint32_t column = (uint32_t)(i % g->columns);
        const uint32_t row = (uint32_t)(index * TILE + i / g->columns);
        const size_t tile = index * g->tile_columns + column / TILE;
        pixel_axes axes;
        image_plane plane;
        if (!(g->noise[tile] > 0.0) || !axes_at(g, column, row, &axes))
            continue;
        const double noise = g->noise[tile] * axes.distance;
        if (point_at(g, column, row)->given || !(noise > QUIET * g->angle[tile]) ||
            !plane_at(g, &axes, column, row, noise, &plane))
            continue;
        g->normals[(size_t)row * g->columns + column] =
            stp_dvec3_to_float(normal_of(&axes, &plane));
    }
    return STP_OK;
}

/* The mean of the normals of 3 x 3 pixels that are alike. A wide window has few of its pixels, and
 * the next pixel's window has others. */
static vec3s mean_around(const pixel_grid *g, uint32_t column, uint32_t row)
{
    const vec3s own = g->normals[(size_t)row * g->columns + column];
    vec3s sum = {{0.0f, 0.0f, 0.0f}};
    for (uint32_t r = row > 0 ? row - 1 : 0; r <= row + 1 && r < g->rows; r++)
        for (uint32_t c = column > 0 ? column - 1 : 0; c <= column + 1 && c < g->columns; c++) {
            const vec3s other = g->normals[(size_t)r * g->columns + c];
            if (glms_vec3_dot(own, other) >= ALIKE)
                sum = glms_vec3_add(sum, other);
        }
    return glms_vec3_normalize(sum);
}

static stp_status mean_row(void *context, size_t index, unsigned worker, stp_error *err)
{
    pixel_grid *g = context;
    const uint32_t row = (uint32_t)index;
    uint64_t count = 0;
    (void)worker;
    (void)err;
    for (uint32_t column = 0; column < g->columns; column++) {
        const size_t pixel = (size_t)row * g->columns + column;
        if (glms_vec3_norm2(g->normals[pixel]) == 0.0f)
            continue;
        stp_cloud_point *p = &g->points->cloud->points[g->points->begin + g->at[pixel] - 1];
        p->normal = mean_around(g, column, row);
        p->given = STP_GIVEN_IMAGE;
        count++;
    }
    atomic_fetch_add(&g->count, count);
    return STP_OK;
}

static stp_status place_points(pixel_grid *g, const stp_scan_grid *grid, stp_error *err)
{
    const stp_cloud *cloud = g->points->cloud;
    const uint64_t count = stp_grid_count(g->points, grid);
    const stp_status status = stp_spill_alloc(cloud->spill, &g->at, (size_t)g->columns * g->rows,
                                              sizeof *g->at, "an image", err);
    for (uint64_t i = 0; status == STP_OK && i < count; i++, stp_cloud_step(cloud->spill, i)) {
        stp_grid_point p;
        if (stp_grid_find(&p, g->points, grid, i))
            g->at[(size_t)p.row * g->columns + p.column] = (uint32_t)(p.at - g->points->begin) + 1;
    }
    return status;
}

/* Whether depths come in steps, and some windows lie within one. */
static bool has_steps(const pixel_grid *g, size_t tiles)
{
    stp_dvec3 sum = {0.0, 0.0, 0.0};
    double count = 0.0;
    for (size_t i = 0; i < tiles; i++) {
        sum = stp_dvec3_add(sum, g->even[i]);
        count += g->evens[i];
    }
    return count > 0.0 && stp_dvec3_length(sum) > STEPS_ALIKE * count;
}

/* If depths come in steps, most windows of a tile may lie within one step. So the noise of a tile
 * is what most of its windows do not exceed, but at most twice the image's median. Most of a tile
 * may even lie within one step: then it has the median, which is that of the tiles with noise. */
static stp_status decide_noise(pixel_grid *g, size_t tiles, stp_error *err)
{
    double *sorted = NULL;
    size_t count = 0;
    const stp_status status = stp_alloc(&sorted, tiles, sizeof *sorted, "an image", err);
    if (status != STP_OK)
        return status;
    const bool steps = has_steps(g, tiles);
    for (size_t i = 0; i < tiles; i++) {
        sorted[count] = g->noise[i];
        count += g->angle[i] > 0.0 && (!steps || g->noise[i] > EXACT * g->angle[i]);
    }
    stp_sort_doubles(sorted, count);
    const double middle = count > 0 ? sorted[count / 2] : 0.0;
    for (size_t i = 0; i < tiles; i++) {
        const bool within = steps && g->angle[i] > 0.0 && g->most[i] <= EXACT * g->angle[i];
        g->noise[i] = within ? middle : fmax(g->noise[i], fmin(g->most[i], 2.0 * middle));
    }
    free(sorted);
    return STP_OK;
}

stp_status stp_image_normals(const stp_file_points *points, const stp_scan_grid *grid,
                             stp_dvec3 station, stp_pool *pool, uint64_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    pixel_grid g = {.points = points,
                    .station = station,
                    .columns = grid->columns,
                    .rows = grid->rows,
                    .tile_columns = (grid->columns - 1) / TILE + 1,
                    .tile_rows = (grid->rows - 1) / TILE + 1};
    const uint64_t pixels = (uint64_t)grid->columns * grid->rows;
    if (grid->rows == 0 || pixels > SPARSEST * (uint64_t)(points->end - points->begin))
        return STP_OK;
    const size_t tiles = (size_t)g.tile_columns * g.tile_rows;
    STP_TRY(place_points(&g, grid, err));
    STP_TRY(stp_alloc(&g.noise, tiles, sizeof *g.noise, "an image", err));
    STP_TRY(stp_alloc(&g.most, tiles, sizeof *g.most, "an image", err));
    STP_TRY(stp_alloc(&g.angle, tiles, sizeof *g.angle, "an image", err));
    STP_TRY(stp_alloc(&g.even, tiles, sizeof *g.even, "an image", err));
    STP_TRY(stp_alloc(&g.evens, tiles, sizeof *g.evens, "an image", err));
    STP_TRY(stp_cloud_run(points->cloud, pool, g.tile_rows, measure_row, &g, err));
    STP_TRY(decide_noise(&g, tiles, err));
    STP_TRY(stp_spill_alloc(points->cloud->spill, &g.normals, pixels, sizeof *g.normals, "an image",
                            err));
    memset(g.normals, 0, pixels * sizeof *g.normals);
    STP_TRY(stp_cloud_run(points->cloud, pool, g.tile_rows, set_row, &g, err));
    STP_TRY(stp_cloud_run(points->cloud, pool, g.rows, mean_row, &g, err));
    *count += atomic_load(&g.count);
done:
    free(g.angle);
    free(g.even);
    free(g.evens);
    free(g.most);
    free(g.noise);
    stp_spill_free(points->cloud->spill, g.at);
    stp_spill_free(points->cloud->spill, g.normals);
    return status;
}

/* Finds cameras of scans that are images. */
#include "preprocess/viewpoint/image_fit.h"

#include "base/memory.h"
#include "base/sort.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Least pixels for a map. */
#define PIXELS_LEAST 16u
/* Unknowns of a map; its last number is 1. */
#define UNKNOWNS 8
/* The opening of a view along parallel rays: nearly parallel, but with depth. */
#define ALONG_FOVY_DEG 20.0
/* Parallel rays must meet this share of the pixels to within ALONG_OFF of the image's smaller side.
 * A scanner that moves along one axis still sees the other axis in perspective. */
#define ALONG_FITTING 0.95
#define ALONG_OFF (1.0 / 64.0)
#define DEGREES (3.14159265358979323846 / 180.0)

/* ---- pixels ---- */

uint64_t stp_find_source(const stp_cloud *cloud, uint64_t begin, uint64_t end, uint64_t source)
{
    while (begin < end) {
        const uint64_t middle = begin + (end - begin) / 2;
        if (cloud->points[middle].source < source)
            begin = middle + 1;
        else
            end = middle;
    }
    return begin;
}

static void add_pixel(stp_file_image *image, uint32_t column, uint32_t row, stp_dvec3 position)
{
    image->pixels[image->count++] = (stp_pixel){.x = (2.0 * column + 1.0) / image->columns - 1.0,
                                                .y = (2.0 * row + 1.0) / image->rows - 1.0,
                                                .position = position};
}

uint64_t stp_grid_count(const stp_file_points *p, const stp_scan_grid *grid)
{
    return grid->cells ? grid->cell_count : p->end - p->begin;
}

bool stp_grid_find(stp_grid_point *out, const stp_file_points *p, const stp_scan_grid *grid,
                   uint64_t i)
{
    const stp_cloud_point *points = p->cloud->points;
    if (grid->cells) {
        const uint64_t place = p->first_place + grid->cells[i].place;
        *out = (stp_grid_point){stp_find_source(p->cloud, p->begin, p->end, place),
                                grid->cells[i].column, grid->cells[i].row};
        if (out->at >= p->end || points[out->at].source != place)
            return false;
    } else {
        const uint64_t source = points[p->begin + i].source;
        const uint64_t place = p->pixels_told ? p->cloud->pixels[source - p->cloud->first_record]
                                              : source - p->first_place;
        *out = (stp_grid_point){p->begin + i, (uint32_t)(place % grid->columns),
                                (uint32_t)(place / grid->columns)};
    }
    return out->column < grid->columns && out->row < grid->rows;
}

stp_status stp_file_image_create(stp_file_image *out, const stp_file_points *p,
                                 const stp_scan_grid *grid, stp_error *err)
{
    stp_file_image image = {.columns = grid->columns, .rows = grid->rows};
    const uint64_t count = stp_grid_count(p, grid);
    const uint64_t stride = count / STP_IMAGE_PIXELS + 1;
    stp_status status =
        stp_alloc(&image.pixels, count / stride + 1, sizeof *image.pixels, "an image", err);
    if (status != STP_OK)
        return status;
    for (uint64_t i = 0; i < count; i += stride) {
        stp_grid_point found;
        stp_cloud_stride(p->cloud->spill, i, stride);
        if (stp_grid_find(&found, p, grid, i))
            add_pixel(&image, found.column, found.row, p->cloud->points[found.at].position);
    }
    *out = image;
    return STP_OK;
}

void stp_file_image_clear(stp_file_image *image)
{
    free(image->pixels);
    *image = (stp_file_image){0};
}

/* ---- least squares ---- */

/* Solves n equations by elimination. False if they have no single solution. */
static bool solve(double (*a)[UNKNOWNS + 1], int n)
{
    for (int c = 0; c < n; c++) {
        int best = c;
        for (int r = c + 1; r < n; r++)
            if (fabs(a[r][c]) > fabs(a[best][c]))
                best = r;
        if (!(fabs(a[best][c]) > 1e-12))
            return false;
        for (int k = 0; k <= n; k++) {
            const double swapped = a[c][k];
            a[c][k] = a[best][k];
            a[best][k] = swapped;
        }
        for (int r = 0; r < n; r++) {
            const double factor = r == c ? 0.0 : a[r][c] / a[c][c];
            for (int k = c; k <= n; k++)
                a[r][k] -= factor * a[c][k];
        }
    }
    for (int c = 0; c < n; c++)
        a[c][n] /= a[c][c];
    return true;
}

/* Adds an equation: a row of weights and their sum. */
static void add_equation(double (*a)[UNKNOWNS + 1], const double *row, double sum, int n)
{
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < n; k++)
            a[i][k] += row[i] * row[k];
        a[i][n] += row[i] * sum;
    }
}

static void apply(const double m[3][3], const double v[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
}

static bool invert(const double m[3][3], double out[3][3])
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            const int a = (k + 1) % 3, b = (k + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
            out[i][k] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
        }
    const double determinant = m[0][0] * out[0][0] + m[0][1] * out[1][0] + m[0][2] * out[2][0];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            out[i][k] /= determinant;
    return isfinite(1.0 / determinant) && determinant != 0.0;
}

/* ---- from an eye ---- */

/* Tangents of the ray to a pixel's point. False if the ray does not point forwards. */
static bool ray_of(const stp_image_map *map, const stp_pixel *pixel, stp_dvec3 eye, double out[3])
{
    const stp_dvec3 d = stp_dvec3_sub(pixel->position, eye);
    const double depth = stp_dvec3_dot(d, map->axes[2]);
    if (!(depth > 1e-6 * stp_dvec3_length(d)))
        return false;
    out[0] = stp_dvec3_dot(d, map->axes[0]) / depth;
    out[1] = stp_dvec3_dot(d, map->axes[1]) / depth;
    out[2] = 1.0;
    return true;
}

/* The distance of a map's pixel from the true one, in pixels. */
static double off_by(const stp_file_image *image, const double found[3], const stp_pixel *pixel)
{
    return 0.5 * hypot((found[0] / found[2] - pixel->x) * image->columns,
                       (found[1] / found[2] - pixel->y) * image->rows);
}

stp_image_map stp_image_fit(const stp_file_image *image, stp_dvec3 eye)
{
    stp_image_map map = {0};
    stp_dvec3 sum = {0.0, 0.0, 0.0};
    double a[UNKNOWNS][UNKNOWNS + 1] = {{0.0}}, ray[3], found[3];
    uint32_t meets = 0;
    for (uint32_t i = 0; i < image->count; i++)
        sum =
            stp_dvec3_add(sum, stp_dvec3_normalize(stp_dvec3_sub(image->pixels[i].position, eye)));
    if (image->count < PIXELS_LEAST || !(stp_dvec3_length(sum) > 0.01 * image->count))
        return map;
    stp_dvec3_axes(map.axes, stp_dvec3_normalize(sum));
    for (uint32_t i = 0; i < image->count; i++) {
        const stp_pixel *p = &image->pixels[i];
        if (!ray_of(&map, p, eye, ray))
            continue;
        const double of_x[UNKNOWNS] = {ray[0], ray[1],         1.0,           0.0, 0.0,
                                       0.0,    -p->x * ray[0], -p->x * ray[1]};
        const double of_y[UNKNOWNS] = {0.0,           0.0, 0.0, ray[0], ray[1], 1.0, -p->y * ray[0],
                                       -p->y * ray[1]};
        add_equation(a, of_x, p->x, UNKNOWNS);
        add_equation(a, of_y, p->y, UNKNOWNS);
    }
    if (!solve(a, UNKNOWNS))
        return map;
    for (int i = 0; i < 9; i++)
        map.to_pixel[i / 3][i % 3] = i < UNKNOWNS ? a[i][UNKNOWNS] : 1.0;
    if (!invert(map.to_pixel, map.to_ray))
        return map;
    for (uint32_t i = 0; i < image->count; i++) {
        if (!ray_of(&map, &image->pixels[i], eye, ray))
            continue;
        apply(map.to_pixel, ray, found);
        meets += found[2] > 0.0 && off_by(image, found, &image->pixels[i]) <= 1.0;
    }
    map.fitting = (double)meets / image->count;
    return map;
}

/* The direction through a place in the image, of any length. */
static stp_dvec3 direction_at(const stp_image_map *map, double x, double y)
{
    const double pixel[3] = {x, y, 1.0};
    double ray[3];
    apply(map->to_ray, pixel, ray);
    const double sign = ray[2] < 0.0 ? -1.0 : 1.0;
    return stp_dvec3_scale(stp_dvec3_add(stp_dvec3_add(stp_dvec3_scale(map->axes[0], ray[0]),
                                                       stp_dvec3_scale(map->axes[1], ray[1])),
                                         stp_dvec3_scale(map->axes[2], ray[2])),
                           sign);
}

/* Median depth along an axis of the points in the middle half of the image; of all points if there
 * are none. */
static double middle_depth(const stp_file_image *image, stp_dvec3 eye, stp_dvec3 forward)
{
    double depths[1024];
    for (double half = 0.5;; half = 2.0) {
        size_t count = 0;
        const uint32_t stride = image->count / 1024u + 1;
        for (uint32_t i = 0; i < image->count; i += stride) {
            const stp_pixel *p = &image->pixels[i];
            if (fabs(p->x) <= half && fabs(p->y) <= half)
                depths[count++] = stp_dvec3_dot(stp_dvec3_sub(p->position, eye), forward);
        }
        stp_sort_doubles(depths, count);
        if (count > 0 || half > 1.0)
            return count > 0 ? depths[count / 2] : 1.0;
    }
}

/* The image's own up: against its rows, or along them if columns, rows and forwards are
 * left-handed. */
static stp_dvec3 up_of(stp_dvec3 column, stp_dvec3 row, stp_dvec3 forward)
{
    const bool downwards = stp_dvec3_dot(stp_dvec3_cross(column, row), forward) > 0.0;
    const stp_dvec3 up = downwards ? stp_dvec3_scale(row, -1.0) : row;
    return stp_dvec3_normalize(
        stp_dvec3_sub(up, stp_dvec3_scale(forward, stp_dvec3_dot(up, forward))));
}

static double tangent_between(stp_dvec3 a, stp_dvec3 b)
{
    return stp_dvec3_length(stp_dvec3_cross(a, b)) / stp_dvec3_dot(a, b);
}

stp_first_camera stp_image_view_from(const stp_file_image *image, const stp_image_map *map,
                                     stp_dvec3 eye)
{
    const stp_dvec3 forward = stp_dvec3_normalize(direction_at(map, 0.0, 0.0));
    const stp_dvec3 left = direction_at(map, -1.0, 0.0), right = direction_at(map, 1.0, 0.0);
    const stp_dvec3 first = direction_at(map, 0.0, -1.0), last = direction_at(map, 0.0, 1.0);
    const double wide = 0.5 * (tangent_between(forward, left) + tangent_between(forward, right));
    const double high = 0.5 * (tangent_between(forward, first) + tangent_between(forward, last));
    const double depth = middle_depth(image, eye, forward);
    return (stp_first_camera){
        .why = STP_FIRST_SCANNER,
        .eye = eye,
        .look = stp_dvec3_add(eye, stp_dvec3_scale(forward, depth)),
        .up = up_of(stp_dvec3_sub(stp_dvec3_normalize(right), stp_dvec3_normalize(left)),
                    stp_dvec3_sub(stp_dvec3_normalize(last), stp_dvec3_normalize(first)), forward),
        .fovy_deg = 2.0 * atan(high) / DEGREES,
        .aspect = wide / high};
}

/* ---- along parallel rays ---- */

/* position ~ axes[0] x + axes[1] y + axes[2]. */
static bool fit_plane(const stp_file_image *image, stp_dvec3 axes[3])
{
    double out[3][3];
    for (int axis = 0; axis < 3; axis++) {
        double a[UNKNOWNS][UNKNOWNS + 1] = {{0.0}};
        for (uint32_t i = 0; i < image->count; i++) {
            const stp_pixel *p = &image->pixels[i];
            const double row[3] = {p->x, p->y, 1.0};
            const stp_dvec3 v = stp_dvec3_sub(p->position, image->pixels[0].position);
            add_equation(a, row, axis == 0 ? v.x : axis == 1 ? v.y : v.z, 3);
        }
        if (!solve(a, 3))
            return false;
        for (int i = 0; i < 3; i++)
            out[i][axis] = a[i][3];
    }
    for (int i = 0; i < 3; i++)
        axes[i] = (stp_dvec3){out[i][0], out[i][1], out[i][2]};
    axes[2] = stp_dvec3_add(axes[2], image->pixels[0].position);
    return true;
}

static stp_dvec3 plane_at(const stp_dvec3 axes[3], const stp_pixel *p)
{
    return stp_dvec3_add(
        axes[2], stp_dvec3_add(stp_dvec3_scale(axes[0], p->x), stp_dvec3_scale(axes[1], p->y)));
}

/* The direction in which points leave the plane: the main axis of their offsets, by power iteration
 * with the covariance. */
static stp_dvec3 offset_axis(const stp_file_image *image, const stp_dvec3 axes[3])
{
    double c[3][3] = {{0.0}};
    for (uint32_t i = 0; i < image->count; i++) {
        const stp_dvec3 v =
            stp_dvec3_sub(image->pixels[i].position, plane_at(axes, &image->pixels[i]));
        const double row[3] = {v.x, v.y, v.z};
        for (int k = 0; k < 9; k++)
            c[k / 3][k % 3] += row[k / 3] * row[k % 3];
    }
    stp_dvec3 axis = stp_dvec3_normalize(stp_dvec3_cross(axes[0], axes[1]));
    for (int turn = 0; turn < 64; turn++) {
        const double from[3] = {axis.x, axis.y, axis.z};
        double to[3];
        apply(c, from, to);
        const stp_dvec3 next = {to[0], to[1], to[2]};
        if (!(stp_dvec3_length(next) > 0.0))
            break;
        axis = stp_dvec3_normalize(next);
    }
    return axis;
}

static double squared_from(const stp_pixel *p, double x, double y)
{
    return (p->x - x) * (p->x - x) + (p->y - y) * (p->y - y);
}

bool stp_image_view_along(const stp_file_image *image, stp_first_camera *out)
{
    stp_dvec3 axes[3], box[2] = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    double bulge = 0.0, middle = 0.0, x = 0.0, y = 0.0;
    uint32_t meets = 0;
    if (image->count < PIXELS_LEAST || !fit_plane(image, axes))
        return false;
    stp_dvec3 back = offset_axis(image, axes);
    const double most =
        2.0 * ALONG_OFF * fmin(stp_dvec3_length(axes[0]), stp_dvec3_length(axes[1]));
    for (uint32_t i = 0; i < image->count; i++) {
        x += image->pixels[i].x / image->count;
        y += image->pixels[i].y / image->count;
    }
    for (uint32_t i = 0; i < image->count; i++)
        middle += squared_from(&image->pixels[i], x, y) / image->count;
    for (uint32_t i = 0; i < image->count; i++) {
        const stp_pixel *p = &image->pixels[i];
        const stp_dvec3 off = stp_dvec3_sub(p->position, plane_at(axes, p));
        meets += stp_dvec3_length(stp_dvec3_cross(off, back)) <= most;
        bulge += (squared_from(p, x, y) - middle) * stp_dvec3_dot(off, back);
    }
    if ((double)meets < ALONG_FITTING * image->count)
        return false;
    if (bulge > 0.0) /* the rim would be nearer than the middle */
        back = stp_dvec3_scale(back, -1.0);
    const stp_dvec3 forward = stp_dvec3_scale(back, -1.0);
    const stp_dvec3 up = up_of(axes[0], axes[1], forward), right = stp_dvec3_cross(forward, up);
    for (uint32_t i = 0; i < image->count; i++) {
        const stp_dvec3 p = stp_dvec3_sub(image->pixels[i].position, axes[2]);
        const stp_dvec3 v = {stp_dvec3_dot(p, right), stp_dvec3_dot(p, up), stp_dvec3_dot(p, back)};
        box[0] = (stp_dvec3){fmin(box[0].x, v.x), fmin(box[0].y, v.y), fmin(box[0].z, v.z)};
        box[1] = (stp_dvec3){fmax(box[1].x, v.x), fmax(box[1].y, v.y), fmax(box[1].z, v.z)};
    }
    const stp_dvec3 half = stp_dvec3_scale(stp_dvec3_sub(box[1], box[0]), 0.5);
    const stp_dvec3 centre = stp_dvec3_scale(stp_dvec3_add(box[0], box[1]), 0.5);
    if (!(half.x > 0.0) || !(half.y > 0.0))
        return false;
    out->look =
        stp_dvec3_add(axes[2], stp_dvec3_add(stp_dvec3_scale(right, centre.x),
                                             stp_dvec3_add(stp_dvec3_scale(up, centre.y),
                                                           stp_dvec3_scale(back, centre.z))));
    const double distance = half.y / tan(0.5 * ALONG_FOVY_DEG * DEGREES) + half.z;
    out->why = STP_FIRST_SCANNER;
    out->eye = stp_dvec3_add(out->look, stp_dvec3_scale(back, distance));
    out->up = up;
    out->fovy_deg = ALONG_FOVY_DEG;
    out->aspect = half.x / half.y;
    return true;
}

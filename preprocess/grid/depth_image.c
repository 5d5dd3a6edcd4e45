/* Finds cameras' rays, and cuts images into patches and leaves. */
#include "preprocess/grid/depth_image.h"

#include "base/memory.h"
#include "formats/chunk/codec/square/square.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Farthest that a point may lie off its ray, in pixels. */
#define OFF_MOST 0.0625
/* Least variance of columns and of rows, from -1 to 1, that tells rays. */
#define SPREAD_LEAST 1e-9
/* Neighbours on one surface lie this near to each other's planes, in pixels' widths. */
#define STEP_WIDTHS 2.0
/* A disc is at most as wide as that of a pixel this many times as large. */
#define WIDEST_PIXEL 4.0
/* Discs have sizes of so many steps an octave, lest noise makes each a size of its own. */
#define SIZE_STEPS 4.0

/* ---- rays ---- */

/* Sums over points at columns and rows from -1 to 1, of their two tangents. */
typedef struct ray_sums {
    double basis[3][3], tangent[2][3];
    double sign; /* of depths */
    uint64_t count;
} ray_sums;

/* Solves sums x = v in place of v. False if the points are all in one line of the image. */
static bool solve(const double sums[3][3], double v[3])
{
    double m[3][3];
    memcpy(m, sums, sizeof m);
    for (int i = 0; i < 3; i++) { /* sums of squares need no pivot */
        if (!(m[i][i] > SPREAD_LEAST * sums[0][0]))
            return false;
        for (int j = i + 1; j < 3; j++) {
            const double part = m[j][i] / m[i][i];
            for (int k = i; k < 3; k++)
                m[j][k] -= part * m[i][k];
            v[j] -= part * v[i];
        }
    }
    for (int i = 2; i >= 0; i--) {
        for (int k = i + 1; k < 3; k++)
            v[i] -= m[i][k] * v[k];
        v[i] /= m[i][i];
    }
    return true;
}

static double centred(uint32_t at, uint32_t count)
{
    return count > 1 ? 2.0 * at / (count - 1) - 1.0 : 0.0;
}

/* Of a pixel at depth 1, with a sign. */
static double area_of(const stp_depth_rays *r)
{
    return r->tilt[0][1] * r->tilt[1][2] - r->tilt[0][2] * r->tilt[1][1];
}

/* How far a point is off the ray of its pixel, in pixels. */
static double off_ray(const stp_depth_rays *r, const double at[3], double column, double row)
{
    const double(*t)[3] = r->tilt;
    double off[2];
    for (int k = 0; k < 2; k++)
        off[k] = at[1 + k] / at[0] - (t[k][0] + column * t[k][1] + row * t[k][2]);
    return hypot(off[0] * t[1][2] - off[1] * t[0][2], off[1] * t[0][1] - off[0] * t[1][1]) /
           fabs(area_of(r));
}

/* A pixel's point relative to the station, axes in order from the rays' axis on. */
static void see(const stp_depth_images *images, uint32_t image, uint32_t point, double out[3])
{
    const stp_dvec3 v =
        stp_dvec3_sub(images->cloud->points[point].position, images->pixels.list[image].station);
    const double all[3] = {v.x, v.y, v.z};
    for (unsigned i = 0; i < 3; i++)
        out[i] = all[(images->rays[image].axis + i) % 3];
}

/* The axis nearest to where the camera looks. */
static unsigned main_axis(const stp_depth_images *images, const stp_pixel_image *m)
{
    stp_dvec3 sum = {0.0, 0.0, 0.0};
    for (uint64_t i = 0; i < stp_pixel_count(m); i++) {
        stp_cloud_stride(images->cloud->spill, i, 1);
        if (m->points[i] != STP_PIXEL_NONE)
            sum =
                stp_dvec3_add(sum, stp_dvec3_normalize(stp_dvec3_sub(
                                       images->cloud->points[m->points[i]].position, m->station)));
    }
    const double x = fabs(sum.x), y = fabs(sum.y), z = fabs(sum.z);
    return z >= x && z >= y ? 2 : y >= x ? 1 : 0;
}

/* Sums up an image's points. False if some lie behind the camera. */
static bool sum_rays(const stp_depth_images *images, uint32_t image, ray_sums *s)
{
    const stp_pixel_image *m = &images->pixels.list[image];
    for (uint64_t i = 0; i < stp_pixel_count(m); i++) {
        stp_cloud_stride(images->cloud->spill, i, 1);
        if (m->points[i] == STP_PIXEL_NONE)
            continue;
        const double basis[3] = {1.0, centred((uint32_t)(i % m->columns), m->columns),
                                 centred((uint32_t)(i / m->columns), m->rows)};
        double at[3];
        see(images, image, m->points[i], at);
        s->sign = s->count++ > 0 ? s->sign : copysign(1.0, at[0]);
        if (!(at[0] * s->sign > 0.0))
            return false;
        for (int j = 0; j < 3; j++) {
            for (int k = 0; k < 3; k++)
                s->basis[j][k] += basis[j] * basis[k];
            for (int k = 0; k < 2; k++)
                s->tangent[k][j] += basis[j] * at[1 + k] / at[0];
        }
    }
    return true;
}

/* Whether all points lie near the rays of their pixels. */
static bool all_on_rays(const stp_depth_images *images, uint32_t image)
{
    const stp_pixel_image *m = &images->pixels.list[image];
    for (uint64_t i = 0; i < stp_pixel_count(m); i++) {
        double at[3];
        stp_cloud_stride(images->cloud->spill, i, 1);
        if (m->points[i] == STP_PIXEL_NONE)
            continue;
        see(images, image, m->points[i], at);
        const uint64_t column = i % m->columns, row = i / m->columns;
        if (!(off_ray(&images->rays[image], at, (double)column, (double)row) <= OFF_MOST))
            return false;
    }
    return true;
}

/* False if the image's points do not lie on a pinhole camera's rays. Adds their number to *count.
 */
static bool find_rays(const stp_depth_images *images, uint32_t image, uint64_t *count)
{
    const stp_pixel_image *m = &images->pixels.list[image];
    stp_depth_rays *r = &images->rays[image];
    ray_sums s = {0};
    r->axis = main_axis(images, m);
    if (!sum_rays(images, image, &s))
        return false;
    for (int k = 0; k < 2; k++) {
        double *v = s.tangent[k];
        if (!solve(s.basis, v))
            return false;
        r->tilt[k][0] = v[0] - v[1] - v[2];
        r->tilt[k][1] = 2.0 * v[1] / (m->columns - 1);
        r->tilt[k][2] = 2.0 * v[2] / (m->rows - 1);
    }
    r->turned = area_of(r) * s.sign > 0.0;
    *count += s.count;
    return all_on_rays(images, image);
}

/* ---- squares ---- */

/* The side of a pixel at a point's depth, on a plane across the axis. */
static double pixel_side(const stp_depth_images *images, uint32_t image, uint32_t point)
{
    double at[3];
    see(images, image, point, at);
    return fabs(at[0]) * sqrt(fabs(area_of(&images->rays[image])));
}

double stp_depth_spacing(const stp_depth_images *images, uint32_t image, uint32_t point)
{
    const stp_cloud_point *p = &images->cloud->points[point];
    const stp_dvec3 ray =
        stp_dvec3_normalize(stp_dvec3_sub(p->position, images->pixels.list[image].station));
    const double facing =
        stp_has_normal(p) ? fabs(stp_dvec3_dot(stp_dvec3_from_float(p->normal), ray)) : 1.0;
    const double wide = sqrt(fmin(1.0 / fmax(facing, 1e-3), WIDEST_PIXEL));
    return exp2(nearbyint(SIZE_STEPS * log2(wide * pixel_side(images, image, point))) / SIZE_STEPS);
}

stp_dvec3 stp_depth_view(const stp_depth_images *images, uint32_t image, uint32_t point)
{
    double at[3];
    see(images, image, point, at);
    return (stp_dvec3){at[1] / at[0], at[2] / at[0], log(fabs(at[0]))};
}

/* A point without a normal says nothing of its plane: the other one must be near. */
static bool is_one_surface(const stp_depth_images *images, uint32_t image, uint32_t a, uint32_t b)
{
    const stp_pixel_image *m = &images->pixels.list[image];
    const stp_cloud_point *p = &images->cloud->points[a], *q = &images->cloud->points[b];
    const stp_dvec3 ray = stp_dvec3_sub(p->position, m->station);
    const double squared = stp_dvec3_dot(ray, ray);
    const double widths = STEP_WIDTHS * pixel_side(images, image, a) / squared;
    const double step = stp_has_normal(p) && stp_has_normal(q)
                            ? stp_pixel_step(images->cloud, m, a, b)
                            : stp_dvec3_length(stp_dvec3_sub(p->position, q->position)) / squared;
    return step <= fmax(widths, images->rays[image].step_most);
}

static unsigned root_of(const uint8_t parent[STP_SQUARE_SAMPLES], unsigned i)
{
    while (parent[i] != i)
        i = parent[i];
    return i;
}

/* Joins a pixel of a square with those before it: to the left and in the row above. */
static void join_before(const stp_depth_images *images, uint32_t image,
                        const uint32_t points[STP_SQUARE_SIDE][STP_SQUARE_SIDE], unsigned column,
                        unsigned row, uint8_t parent[STP_SQUARE_SAMPLES])
{
    static const int before[4][2] = {{-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
    for (int k = 0; k < 4; k++) {
        const unsigned c = column + (unsigned)before[k][0], r = row + (unsigned)before[k][1];
        if (c >= STP_SQUARE_SIDE || r >= STP_SQUARE_SIDE || points[r][c] == STP_PIXEL_NONE ||
            !is_one_surface(images, image, points[row][column], points[r][c]))
            continue;
        const unsigned a = root_of(parent, row * STP_SQUARE_SIDE + column);
        const unsigned b = root_of(parent, r * STP_SQUARE_SIDE + c);
        parent[a > b ? a : b] = (uint8_t)(a < b ? a : b);
    }
}

/* Patches of all images. */
typedef struct listing {
    stp_depth_square *squares;
    size_t count, capacity;
} listing;

/* Cuts a square into the pieces that neighbours join. */
static stp_status cut_square(listing *l, const stp_depth_images *images, uint32_t image,
                             uint32_t column, uint32_t row, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t points[STP_SQUARE_SIDE][STP_SQUARE_SIDE];
    uint8_t parent[STP_SQUARE_SAMPLES];
    stp_depth_square pieces[STP_SQUARE_SAMPLES] = {0};
    for (unsigned i = 0; i < STP_SQUARE_SAMPLES; i++) {
        const unsigned c = i % STP_SQUARE_SIDE, r = i / STP_SQUARE_SIDE;
        points[r][c] =
            stp_depth_point(images, image, column * STP_SQUARE_SIDE + c, row * STP_SQUARE_SIDE + r);
        parent[i] = (uint8_t)i;
        if (points[r][c] != STP_PIXEL_NONE)
            join_before(images, image, points, c, r, parent);
    }
    for (unsigned k = 0; k < STP_SQUARE_SAMPLES; k++) {
        const unsigned c = stp_square_column(k), r = stp_square_row(k);
        const unsigned root = root_of(parent, r * STP_SQUARE_SIDE + c);
        if (points[r][c] == STP_PIXEL_NONE)
            continue;
        pieces[root].samples |= UINT64_C(1) << k;
    }
    for (unsigned i = 0; i < STP_SQUARE_SAMPLES; i++) {
        if (pieces[i].samples == 0)
            continue;
        pieces[i].image = image;
        pieces[i].column = column;
        pieces[i].row = row;
        STP_TRY(
            stp_grow(&l->squares, &l->capacity, l->count + 1, sizeof *l->squares, "patches", err));
        l->squares[l->count++] = pieces[i];
    }
done:
    return status;
}

/* Squares near each other follow each other: they stand in Morton order, in parts as long as the
 * image's shorter side. */
static stp_status cut_image(listing *l, const stp_depth_images *images, uint32_t image,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const stp_pixel_image *m = &images->pixels.list[image];
    const bool turned = images->rays[image].turned;
    const uint32_t columns = ((turned ? m->rows : m->columns) - 1) / STP_SQUARE_SIDE + 1;
    const uint32_t rows = ((turned ? m->columns : m->rows) - 1) / STP_SQUARE_SIDE + 1;
    const bool wide = columns > rows;
    uint32_t side = 1;
    while (side < (wide ? rows : columns))
        side *= 2;
    for (uint64_t begin = 0; begin < (wide ? columns : rows); begin += side)
        for (uint64_t i = 0; i < (uint64_t)side * side; i++) {
            const uint64_t c = stp_square_column((uint32_t)i) + (wide ? begin : 0);
            const uint64_t r = stp_square_row((uint32_t)i) + (wide ? 0 : begin);
            stp_cloud_stride(images->cloud->spill, i * STP_SQUARE_SAMPLES, STP_SQUARE_SAMPLES);
            if (c < columns && r < rows)
                STP_TRY(cut_square(l, images, image, (uint32_t)c, (uint32_t)r, err));
        }
done:
    return status;
}

/* ---- leaves ---- */

typedef struct cutting {
    const stp_depth_images *images;
    const stp_point_item_params *params;
} cutting;

static stp_leaf_extent extent_of(const void *context, uint32_t index)
{
    const cutting *c = context;
    const stp_depth_images *images = c->images;
    const stp_depth_square *square = &images->squares[index];
    stp_leaf_extent out = {stp_dbox_empty(), INT_MAX, INT_MIN};
    for (unsigned k = 0; k < STP_SQUARE_SAMPLES; k++) {
        if (!(square->samples >> k & 1u))
            continue;
        const uint32_t point = stp_depth_square_point(images, square, k);
        const stp_dvec3 at = images->cloud->points[point].position;
        const int exponent =
            stp_point_exponent(at, stp_depth_spacing(images, square->image, point), c->params);
        stp_dbox_add(&out.box, at);
        out.finest = exponent < out.finest ? exponent : out.finest;
        out.coarsest = exponent > out.coarsest ? exponent : out.coarsest;
    }
    return out;
}

static stp_status cut_leaves(stp_depth_images *images, const stp_point_item_params *params,
                             stp_error *err)
{
    stp_status status = STP_OK;
    const cutting c = {images, params};
    listing l = {0};
    for (size_t i = 0; i < images->pixels.count; i++)
        STP_TRY(cut_image(&l, images, (uint32_t)i, err));
    images->squares = l.squares;
    images->square_count = (uint32_t)l.count;
    l.squares = NULL;
    STP_TRY(stp_leaf_cut(&images->leaves, &images->leaf_count, images->square_count, extent_of, &c,
                         err));
done:
    free(l.squares);
    return status;
}

stp_status stp_depth_images_create(stp_depth_images *out, const stp_cloud *cloud,
                                   const struct stp_prep_source *source, bool noisy,
                                   const stp_point_item_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_depth_images made = {.cloud = cloud};
    uint64_t points = 0;
    bool found = true;
    STP_TRY(stp_pixel_images_create(&made.pixels, cloud, source, err));
    STP_TRY(stp_alloc(&made.rays, made.pixels.count, sizeof *made.rays, "images", err));
    for (size_t i = 0; found && i < made.pixels.count; i++) {
        found = find_rays(&made, (uint32_t)i, &points);
        if (found && noisy)
            STP_TRY(stp_pixel_step_most(&made.rays[i].step_most, cloud, &made.pixels.list[i], err));
    }
    if (found && points == cloud->count) {
        STP_TRY(cut_leaves(&made, params, err));
        *out = made;
        made = (stp_depth_images){.cloud = cloud};
    }
done:
    stp_depth_images_clear(&made);
    return status;
}

stp_status stp_depth_images_fit(bool *out, size_t *images, const stp_cloud *part,
                                const struct stp_prep_source *source, stp_ranks *ranks,
                                stp_error *err)
{
    stp_status status = STP_OK;
    stp_depth_images made = {.cloud = part};
    uint64_t points = 0;
    STP_TRY(stp_pixel_images_create(&made.pixels, part, source, err));
    STP_TRY(stp_alloc(&made.rays, made.pixels.count, sizeof *made.rays, "images", err));
    uint64_t sums[2] = {0, 0}; /* images on rays; points that are not */
    for (size_t i = 0; i < made.pixels.count; i++)
        if (made.pixels.list[i].has_points)
            sums[0] += find_rays(&made, (uint32_t)i, &points);
    sums[1] = part->count - points;
    STP_TRY(stp_ranks_sum(ranks, sums, 2, err));
    *images = made.pixels.count;
    *out = sums[0] == made.pixels.count && sums[1] == 0;
done:
    stp_depth_images_clear(&made);
    return status;
}

void stp_depth_images_clear(stp_depth_images *images)
{
    if (images->cloud)
        stp_pixel_images_clear(&images->pixels, images->cloud);
    free(images->rays);
    free(images->squares);
    free(images->leaves);
    *images = (stp_depth_images){0};
}

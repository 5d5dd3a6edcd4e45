/* Finds rays piece by piece. */
#include "preprocess/grid/depth_rays.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Sides of pieces, in pixels. */
#define WHOLE (UINT32_C(1) << 31)
#define PIECE_MOST 64u
#define PIECE_LEAST STP_SQUARE_SIDE
/* Farthest that a point may lie off its ray, in pixels: of ideal rays, and of a scanner's. */
static const double off_most[2] = {0.125, 0.25};
/* Least variance of columns and of rows, from -1 to 1, that tells rays. */
#define SPREAD_LEAST 1e-9
/* Pixels around a piece that are asked if its own do not tell its rays. */
#define MARGIN_MOST 128u
/* If more than one of so many pixels would have to leave an image, it is none. */
#define LOOSE_PART 16u
/* A slope of less than this part of the greatest one is rounding. */
#define ROUNDING 0x1p-24

typedef struct rectangle {
    uint32_t column, row, columns, rows;
} rectangle;

/* What rays are found in. */
typedef struct seen_image {
    const stp_cloud *cloud;
    stp_pixel_image *image;
    uint64_t loose; /* points that were taken out */
} seen_image;

static uint64_t pixels_of(const rectangle *in)
{
    return (uint64_t)in->columns * in->rows;
}

/* The point of pixel i of a rectangle, counted row by row, or NULL. *at: its column and row. */
static const stp_cloud_point *point_of(const seen_image *s, const rectangle *in, uint64_t i,
                                       uint32_t at[2])
{
    at[0] = in->column + (uint32_t)(i % in->columns);
    at[1] = in->row + (uint32_t)(i / in->columns);
    const uint64_t place = (uint64_t)at[1] * s->image->columns + at[0];
    const uint64_t point = stp_pixel_point(s->image, place);
    stp_cloud_stride(s->cloud->spill, place, 1);
    return point == STP_PIXEL_NONE ? NULL : &s->cloud->points[point];
}

stp_status stp_depth_squares_check(size_t count, stp_error *err)
{
    if (count < UINT32_MAX)
        return STP_OK;
    return stp_error_set(err, STP_LIMIT,
                         "the images are cut into more than %u squares of pixels: split the input "
                         "into several models",
                         UINT32_MAX - 1);
}

void stp_depth_see(const stp_depth_rays *rays, stp_dvec3 position, double out[3])
{
    const stp_dvec3 v = stp_dvec3_sub(position, rays->station);
    const double all[3] = {v.x, v.y, v.z};
    for (unsigned i = 0; i < 3; i++)
        out[i] = all[(rays->axis + i) % 3];
}

double stp_depth_pixel_side(const stp_depth_rays *rays, const double seen[3])
{
    double side = 0.0;
    for (int k = 1; k < 3; k++) { /* the parts of steps along the axes across, across the ray */
        const stp_dvec3 step = {0.0, rays->tilt[0][k], rays->tilt[1][k]};
        const stp_dvec3 across = stp_dvec3_cross((stp_dvec3){seen[0], seen[1], seen[2]}, step);
        side = fmax(side, stp_dvec3_length(across));
    }
    return side * fabs(seen[0]) / sqrt(seen[0] * seen[0] + seen[1] * seen[1] + seen[2] * seen[2]);
}

/* The longer side of a pixel at depth 1, across the axis. */
static double step_of(const stp_depth_rays *r)
{
    return fmax(hypot(r->tilt[0][1], r->tilt[1][1]), hypot(r->tilt[0][2], r->tilt[1][2]));
}

/* Chooses the axis nearest to where a rectangle's points lie. False: it has none. */
static bool choose_axis(const seen_image *s, const rectangle *in, stp_depth_rays *out)
{
    double sum[3] = {0.0, 0.0, 0.0};
    for (uint64_t i = 0; i < pixels_of(in); i++) {
        uint32_t at[2];
        const stp_cloud_point *p = point_of(s, in, i, at);
        if (!p)
            continue;
        const stp_dvec3 way = stp_dvec3_normalize(stp_dvec3_sub(p->position, s->image->station));
        sum[0] += way.x;
        sum[1] += way.y;
        sum[2] += way.z;
    }
    const double x = fabs(sum[0]), y = fabs(sum[1]), z = fabs(sum[2]);
    out->station = s->image->station;
    out->axis = z >= x && z >= y ? 2 : y >= x ? 1 : 0;
    out->sign = copysign(1.0, sum[out->axis]);
    return x + y + z > 0.0;
}

/* ---- least squares ---- */

/* Sums over points at columns and rows from -1 to 1, of their two tangents. */
typedef struct ray_sums {
    double basis[3][3], tangent[2][3];
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

/* Sums up a rectangle's points. False if some lie on the other side of the station. */
static bool sum_rays(const seen_image *s, const rectangle *in, const stp_depth_rays *rays,
                     ray_sums *sums)
{
    for (uint64_t i = 0; i < pixels_of(in); i++) {
        uint32_t at[2];
        const stp_cloud_point *p = point_of(s, in, i, at);
        if (!p)
            continue;
        const double basis[3] = {1.0, centred(at[0] - in->column, in->columns),
                                 centred(at[1] - in->row, in->rows)};
        double seen[3];
        stp_depth_see(rays, p->position, seen);
        if (!(seen[0] * rays->sign > 0.0))
            return false;
        for (int j = 0; j < 3; j++) {
            for (int k = 0; k < 3; k++)
                sums->basis[j][k] += basis[j] * basis[k];
            for (int k = 0; k < 2; k++)
                sums->tangent[k][j] += basis[j] * seen[1 + k] / seen[0];
        }
    }
    return true;
}

/* Where columns and rows go along axes, what is left of the other slopes is rounding: 0 takes fewer
 * bytes (camera_raster.h). */
static void drop_roundings(double tilt[2][3])
{
    double greatest = 0.0;
    for (int k = 0; k < 2; k++)
        greatest = fmax(greatest, fmax(fabs(tilt[k][1]), fabs(tilt[k][2])));
    for (int k = 0; k < 2; k++)
        for (int i = 1; i < 3; i++)
            if (fabs(tilt[k][i]) < greatest * ROUNDING)
                tilt[k][i] = 0.0;
}

/* Finds the rays of a rectangle, whose axis is known. */
static bool fit(const seen_image *s, const rectangle *in, stp_depth_rays *rays)
{
    ray_sums sums = {0};
    if (!sum_rays(s, in, rays, &sums))
        return false;
    for (int k = 0; k < 2; k++) {
        double *v = sums.tangent[k], *t = rays->tilt[k];
        if (!solve(sums.basis, v))
            return false;
        t[1] = 2.0 * v[1] / (in->columns - 1);
        t[2] = 2.0 * v[2] / (in->rows - 1);
        t[0] = v[0] - v[1] - v[2] - in->column * t[1] - in->row * t[2];
    }
    drop_roundings(rays->tilt);
    return true;
}

/* How far a point is off the ray of its pixel, in longer sides of pixels; a number beyond all if it
 * is on the other side of the station. */
static double off_ray(const stp_depth_rays *r, stp_dvec3 position, const uint32_t at[2],
                      double off[2])
{
    double seen[3];
    stp_depth_see(r, position, seen);
    for (int k = 0; k < 2; k++)
        off[k] =
            seen[1 + k] / seen[0] - (r->tilt[k][0] + at[0] * r->tilt[k][1] + at[1] * r->tilt[k][2]);
    return seen[0] * r->sign > 0.0 ? hypot(off[0], off[1]) / step_of(r) : INFINITY;
}

/* Whether all points of a rectangle lie near their rays. middle: rays meet the points' middle. */
static bool all_on_rays(const seen_image *s, const rectangle *in, stp_depth_rays *rays, double most,
                        bool middle)
{
    double mean[2] = {0.0, 0.0}, count = 0.0, off[2];
    uint32_t at[2];
    for (uint64_t i = 0; middle && i < pixels_of(in); i++) {
        const stp_cloud_point *p = point_of(s, in, i, at);
        if (!p || !(off_ray(rays, p->position, at, off) < INFINITY))
            continue;
        count += 1.0;
        for (int k = 0; k < 2; k++)
            mean[k] += (off[k] - mean[k]) / count;
    }
    rays->tilt[0][0] += mean[0];
    rays->tilt[1][0] += mean[1];
    for (uint64_t i = 0; i < pixels_of(in); i++) {
        const stp_cloud_point *p = point_of(s, in, i, at);
        if (p && !(off_ray(rays, p->position, at, off) <= most))
            return false;
    }
    return true;
}

/* ---- pieces ---- */

static uint32_t less(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

/* A rectangle and what of the image is around it. */
static rectangle widened(const seen_image *s, const rectangle *in, uint32_t margin)
{
    const uint32_t left = less(in->column, margin), above = less(in->row, margin);
    const uint32_t right = less(s->image->columns - in->column - in->columns, margin);
    const uint32_t below = less(s->image->rows - in->row - in->rows, margin);
    return (rectangle){in->column - left, in->row - above, in->columns + left + right,
                       in->rows + above + below};
}

/* Finds the rays of a piece. If its points, as a few in a line, do not tell them, those around it
 * tell their slopes. */
static bool fit_piece(const seen_image *s, const rectangle *in, stp_depth_rays *rays, double most)
{
    uint32_t margin = 0;
    rectangle wide = *in;
    while (!fit(s, &wide, rays)) {
        margin = 2 * margin + PIECE_LEAST;
        wide = widened(s, in, margin);
        if (margin > MARGIN_MOST)
            return false;
    }
    return all_on_rays(s, in, rays, most, margin > 0);
}

/* What of a rectangle's square of so many pixels is inside it. */
static rectangle part_of(const rectangle *in, uint32_t column, uint32_t row, uint32_t side)
{
    return (rectangle){in->column + column, in->row + row, less(in->columns - column, side),
                       less(in->rows - row, side)};
}

/* Notes the rays of a rectangle's squares. of: those of the image. */
static void set_rays(uint32_t *of, const seen_image *s, const rectangle *in, uint32_t rays)
{
    const uint32_t across = stp_depth_squares(s->image->columns);
    for (uint32_t r = 0; r < in->rows; r += STP_SQUARE_SIDE)
        for (uint32_t c = 0; c < in->columns; c += STP_SQUARE_SIDE)
            of[(size_t)(in->row + r) / STP_SQUARE_SIDE * across +
               (in->column + c) / STP_SQUARE_SIDE] = rays;
}

/* Takes the point that is farthest off its ray out of the image. */
static void take_out_worst(seen_image *s, const rectangle *in, const stp_depth_rays *rays)
{
    uint64_t worst = 0;
    double most = -1.0;
    for (uint64_t i = 0; i < pixels_of(in); i++) {
        uint32_t at[2];
        double off[2];
        const stp_cloud_point *p = point_of(s, in, i, at);
        const double far = p ? off_ray(rays, p->position, at, off) : -1.0;
        if (!(far > most))
            continue;
        most = far;
        worst = (uint64_t)at[1] * s->image->columns + at[0];
    }
    stp_pixel_set(s->image, worst, STP_PIXEL_NONE);
    s->loose++;
}

/* Takes points out of a piece's image until the others lie on rays. False if none is left. */
static bool fit_without_worst(seen_image *s, const rectangle *in, stp_depth_rays *rays)
{
    rays->tilt[0][1] = rays->tilt[1][2] =
        1.0; /* any, for points on the other side of the station */
    do {
        if (fit_piece(s, in, rays, off_most[1]))
            return true;
        take_out_worst(s, in, rays);
    } while (choose_axis(s, in, rays));
    return false;
}

/* Cuts a rectangle into pieces of a side. loosens: points that are on no ray leave the image.
 * *found: whether they have rays. */
static stp_status cut(stp_depth_pieces *out, uint32_t *of, seen_image *s, const rectangle *in,
                      uint32_t side, double most, bool loosens, bool *found, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t before = out->count;
    *found = true;
    for (uint64_t r = 0; *found && r < in->rows; r += side)
        for (uint64_t c = 0; *found && c < in->columns; c += side) {
            const rectangle part = part_of(in, (uint32_t)c, (uint32_t)r, side);
            stp_depth_rays rays = {.first = {part.column, part.row}, .side = side};
            set_rays(of, s, &part, STP_DEPTH_NO_RAYS);
            if (!choose_axis(s, &part, &rays) || (loosens && !fit_without_worst(s, &part, &rays)))
                continue;
            *found = loosens || fit_piece(s, &part, &rays, most);
            STP_TRY(stp_grow(&out->rays, &out->capacity, out->count + 1, sizeof *out->rays, "rays",
                             err));
            set_rays(of, s, &part, (uint32_t)out->count);
            out->rays[out->count++] = rays;
        }
done:
    if (status != STP_OK || !*found)
        out->count = before;
    return status;
}

/* Cuts a rectangle as little as its points allow. */
static stp_status cut_least(stp_depth_pieces *out, uint32_t *of, seen_image *s, const rectangle *in,
                            stp_error *err)
{
    stp_status status = STP_OK;
    bool found = false;
    for (int i = 0; !found && i < 2; i++)
        for (uint32_t side = PIECE_MOST; !found && side >= PIECE_LEAST; side /= 2)
            STP_TRY(cut(out, of, s, in, side, off_most[i], false, &found, err));
    if (!found)
        STP_TRY(cut(out, of, s, in, PIECE_LEAST, 0.0, true, &found, err));
done:
    return status;
}

/* Cuts an image: as a whole, else block by block. *found: few points had to leave it. */
static stp_status cut_image(stp_depth_pieces *out, uint32_t *of, seen_image *s, bool *found,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const rectangle all = {0, 0, s->image->columns, s->image->rows};
    STP_TRY(cut(out, of, s, &all, WHOLE, off_most[0], false, found, err));
    if (*found)
        goto done;
    *found = true;
    for (uint32_t r = 0; *found && r < all.rows; r += PIECE_MOST)
        for (uint32_t c = 0; *found && c < all.columns; c += PIECE_MOST) {
            const rectangle block = part_of(&all, c, r, PIECE_MOST);
            STP_TRY(cut_least(out, of, s, &block, err));
            *found = s->loose <= pixels_of(&all) / LOOSE_PART;
        }
done:
    return status;
}

stp_status stp_depth_pieces_add(stp_depth_pieces *pieces, const stp_cloud *cloud,
                                stp_pixel_image *image, bool *found, bool *turned, stp_error *err)
{
    stp_status status = STP_OK;
    seen_image s = {cloud, image, 0};
    const size_t squares =
        (size_t)stp_depth_squares(image->columns) * stp_depth_squares(image->rows);
    const size_t first = pieces->count;
    STP_TRY(stp_grow(&pieces->of_square, &pieces->square_capacity, pieces->square_count + squares,
                     sizeof *pieces->of_square, "squares", err));
    uint32_t *of = pieces->of_square + pieces->square_count;
    pieces->square_count += squares;
    STP_TRY(cut_image(pieces, of, &s, found, err));
    if (*found && s.loose > 0) { /* what is left may need fewer pieces */
        pieces->count = first;
        STP_TRY(cut_image(pieces, of, &s, found, err));
    }
    double area = 0.0;
    for (size_t i = first; i < pieces->count; i++) {
        const double(*t)[3] = pieces->rays[i].tilt;
        area += (t[0][1] * t[1][2] - t[0][2] * t[1][1]) * pieces->rays[i].sign;
    }
    *turned = area > 0.0;
done:
    return status;
}

void stp_depth_pieces_clear(stp_depth_pieces *pieces)
{
    free(pieces->rays);
    free(pieces->of_square);
    *pieces = (stp_depth_pieces){0};
}

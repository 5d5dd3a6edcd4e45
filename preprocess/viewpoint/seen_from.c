/* Checks claimed positions of scanners against the points. */
#include "preprocess/viewpoint/seen_from.h"

#include "base/memory.h"
#include "base/sort.h"
#include "preprocess/viewpoint/own_frame.h"

#include <math.h>
#include <stdlib.h>

/* For an image. */
#define FITTING_LEAST 0.95
#define JUMP 1.05
#define JUMPS_LEAST 64u
#define EVEN_LEAST 0.9
#define BESIDE_IMAGE 0.1
/* For other points: points per pixel; the steepest surface within a pixel; the greatest hidden
 * share; how much more must be hidden from beside. */
#define PIXEL_POINTS 4.0
#define STEEPEST 8.0
#define HIDDEN_MOST 0.05
#define HIDDEN_MORE 1.5
#define HIDDEN_ADDED 0.005
#define BESIDE_POINTS 0.25
/* If all rays are within this cosine of their mean, they are projected to a plane, else to an
 * octahedron. */
#define PLANE_COSINE 0.5
#define POINTS_LEAST 64u
#define MEDIAN_POINTS 1024u
#define SLIMMEST 1e-4 /* least ratio of a layout's sides: limits the memory of squares */
#define DISTANCE_MOST 1e100

/* ---- images ---- */

static stp_dvec3 ray_to(const stp_file_points *p, uint64_t i, stp_dvec3 from, double *distance)
{
    const stp_dvec3 d = stp_dvec3_sub(p->cloud->points[i].position, from);
    *distance = stp_dvec3_length(d);
    return stp_dvec3_normalize(d);
}

/* Whether the steps of rays from pixel to pixel stay even over jumps of the distance. */
static bool is_even(const stp_file_points *p, const stp_file_image *image, stp_dvec3 from)
{
    uint32_t jumps = 0, even = 0;
    const stp_cloud_point *points = p->cloud->points;
    const uint64_t stride = (p->end - p->begin) / STP_SEEN_POINTS + 1;
    for (uint64_t i = p->begin + 1; i + 1 < p->end; i += stride) {
        stp_cloud_stride(p->cloud->spill, i, stride);
        const uint64_t column = (points[i].source - p->first_place) % image->columns;
        double r[3];
        if (points[i].source - points[i - 1].source != 1 || column == 0 ||
            points[i + 1].source - points[i].source != 1 || column + 1 == image->columns)
            continue;
        stp_dvec3 a = ray_to(p, i - 1, from, &r[0]), b = ray_to(p, i, from, &r[1]);
        stp_dvec3 c = ray_to(p, i + 1, from, &r[2]);
        if (fmax(r[0], fmax(r[1], r[2])) < JUMP * fmin(r[0], fmin(r[1], r[2])))
            continue;
        a = stp_dvec3_sub(b, a);
        c = stp_dvec3_sub(c, b);
        jumps++;
        even += stp_dvec3_length(stp_dvec3_sub(c, a)) <
                0.5 * fmax(stp_dvec3_length(a), stp_dvec3_length(c));
    }
    return jumps >= JUMPS_LEAST && even >= EVEN_LEAST * jumps;
}

static bool image_allows(const stp_file_points *p, const stp_file_image *image, stp_dvec3 from)
{
    return stp_image_fit(image, from).fitting >= FITTING_LEAST || is_even(p, image, from);
}

/* ---- other points ---- */

/* How the rays of a position are laid out in a plane. */
typedef struct layout {
    stp_dvec3 from, axes[3];
    bool plane;
    double low[2], size[2]; /* of the part that the points take */
} layout;

/* A place in the plane, and the distance. */
typedef struct spot {
    double u, v, distance;
} spot;

static spot lay(const layout *l, stp_dvec3 position)
{
    const stp_dvec3 d = stp_dvec3_sub(position, l->from);
    const stp_dvec3 n = stp_dvec3_normalize(d);
    double x = stp_dvec3_dot(n, l->axes[0]), y = stp_dvec3_dot(n, l->axes[1]);
    const double z = stp_dvec3_dot(n, l->axes[2]);
    spot s = {x / z, y / z, stp_dvec3_length(d)};
    if (!l->plane) {
        const double sum = fabs(x) + fabs(y) + fabs(z), turned = x / sum;
        if (!(sum > 0.0)) /* the point is at the position */
            return (spot){0.0, 0.0, 0.0};
        x /= sum;
        y /= sum;
        s.u = z < 0.0 ? copysign(1.0 - fabs(y), turned) : x;
        s.v = z < 0.0 ? copysign(1.0 - fabs(turned), y) : y;
    }
    return s;
}

static layout layout_of(const stp_dvec3 *positions, uint32_t count, stp_dvec3 from)
{
    layout l = {.from = from, .plane = true};
    stp_dvec3 sum = {0.0, 0.0, 0.0};
    double high[2] = {-INFINITY, -INFINITY};
    l.low[0] = l.low[1] = INFINITY;
    for (uint32_t i = 0; i < count; i++)
        sum = stp_dvec3_add(sum, stp_dvec3_normalize(stp_dvec3_sub(positions[i], from)));
    stp_dvec3_axes(l.axes, stp_dvec3_length(sum) > 1e-3 * count ? stp_dvec3_normalize(sum)
                                                                : (stp_dvec3){0.0, 0.0, 1.0});
    for (uint32_t i = 0; i < count && l.plane; i++)
        l.plane = stp_dvec3_dot(stp_dvec3_normalize(stp_dvec3_sub(positions[i], from)), l.axes[2]) >
                  PLANE_COSINE;
    for (uint32_t i = 0; i < count; i++) {
        const spot s = lay(&l, positions[i]);
        l.low[0] = fmin(l.low[0], s.u);
        l.low[1] = fmin(l.low[1], s.v);
        high[0] = fmax(high[0], s.u);
        high[1] = fmax(high[1], s.v);
    }
    for (int i = 0; i < 2; i++)
        l.size[i] = high[i] - l.low[i];
    return l;
}

/* Squares of one size over a layout. */
typedef struct squares {
    double side;
    uint64_t columns, rows;
} squares;

static squares squares_of(const layout *l, double count)
{
    squares s = {.side = sqrt(fmax(l->size[0], SLIMMEST * l->size[1]) *
                              fmax(l->size[1], SLIMMEST * l->size[0]) / count)};
    s.columns = (uint64_t)(l->size[0] / s.side) + 1;
    s.rows = (uint64_t)(l->size[1] / s.side) + 1;
    return s;
}

static uint64_t square_at(const layout *l, const squares *s, const spot *at)
{
    const uint64_t column = (uint64_t)((at->u - l->low[0]) / s->side);
    const uint64_t row = (uint64_t)((at->v - l->low[1]) / s->side);
    return (row < s->rows ? row : s->rows - 1) * s->columns +
           (column < s->columns ? column : s->columns - 1);
}

/* The nearest distance in each square; infinite if the square is empty. Free with free(). */
static stp_status nearest_of(float **out, uint64_t *taken, const layout *l, const squares *s,
                             const stp_dvec3 *positions, uint32_t count, stp_error *err)
{
    float *nearest = NULL;
    stp_status status =
        stp_alloc(&nearest, (size_t)(s->columns * s->rows), sizeof *nearest, "depths", err);
    if (status != STP_OK)
        return status;
    for (uint64_t i = 0; i < s->columns * s->rows; i++)
        nearest[i] = INFINITY;
    *taken = 0;
    for (uint32_t i = 0; i < count; i++) {
        const spot at = lay(l, positions[i]);
        float *square = &nearest[square_at(l, s, &at)];
        *taken += isinf(*square) ? 1u : 0u;
        *square = fminf(*square, (float)at.distance);
    }
    *out = nearest;
    return STP_OK;
}

stp_status stp_hidden_share(double *out, const stp_dvec3 *positions, uint32_t count,
                            stp_dvec3 position, stp_error *err)
{
    stp_status status = STP_OK;
    float *nearest = NULL;
    uint64_t taken = 0, hidden = 0;
    const layout l = layout_of(positions, count, position);
    *out = 1.0;
    if (!(l.size[0] > 0.0) || !(l.size[1] > 0.0))
        return STP_OK;
    squares s = squares_of(&l, count / PIXEL_POINTS);
    /* If the points take only a part of the layout, use finer squares. */
    STP_TRY(nearest_of(&nearest, &taken, &l, &s, positions, count, err));
    const double finer = (double)(s.columns * s.rows) / (double)taken;
    if (finer > 1.5) {
        free(nearest);
        nearest = NULL;
        s = squares_of(&l, fmin(finer, 64.0) * count / PIXEL_POINTS);
        STP_TRY(nearest_of(&nearest, &taken, &l, &s, positions, count, err));
    }
    for (uint32_t i = 0; i < count; i++) {
        const spot at = lay(&l, positions[i]);
        hidden += at.distance > nearest[square_at(&l, &s, &at)] * (1.0 + STEEPEST * s.side);
    }
    *out = (double)hidden / count;
done:
    free(nearest);
    return status;
}

/* ---- both ---- */

/* The points of the file, and those of ranks before this one. */
static stp_status count_points(const stp_file_points *p, uint64_t *all, uint64_t *before,
                               stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t own = p->end - p->begin;
    uint64_t *counts = NULL;
    STP_TRY(stp_alloc(&counts, stp_ranks_count(p->ranks), sizeof *counts, "ranks", err));
    STP_TRY(stp_ranks_gather(p->ranks, &own, sizeof own, counts, err));
    *all = *before = 0;
    for (unsigned rank = 0; rank < stp_ranks_count(p->ranks); rank++) {
        *before += p->ranks && rank < p->ranks->self ? counts[rank] : 0;
        *all += counts[rank];
    }
done:
    free(counts);
    return status;
}

/* Takes at most so many of the file's points, evenly; all: how many there are. */
static stp_status sample(stp_dvec3 **out, uint32_t *count, uint64_t *all, const stp_file_points *p,
                         uint32_t most, stp_error *err)
{
    stp_status status = STP_OK;
    stp_bytes bytes = {0};
    uint64_t before = 0;
    STP_TRY(count_points(p, all, &before, err));
    const uint64_t stride = *all / most + 1, own = p->end - p->begin;
    for (uint64_t i = (stride - before % stride) % stride; i < own; i += stride) {
        stp_cloud_stride(p->cloud->spill, i, stride);
        STP_TRY(
            stp_bytes_append(&bytes, &p->cloud->points[p->begin + i].position, sizeof **out, err));
    }
    if (p->ranks)
        STP_TRY(stp_ranks_join(p->ranks, &bytes, err));
    stp_cursor from = {bytes.data, bytes.size};
    *count = (uint32_t)(bytes.size / sizeof **out);
    STP_TRY(stp_packet_take_array(&from, out, *count, sizeof **out, err));
done:
    free(bytes.data);
    return status;
}

/* Of at most MEDIAN_POINTS positions. */
static double median_distance(const stp_dvec3 *positions, uint32_t count, stp_dvec3 from)
{
    double distances[MEDIAN_POINTS];
    for (uint32_t i = 0; i < count; i++)
        distances[i] = stp_dvec3_length(stp_dvec3_sub(positions[i], from));
    stp_sort_doubles(distances, count);
    return count > 0 ? distances[count / 2] : INFINITY;
}

/* The i-th of six places about a position. */
static stp_dvec3 beside(stp_dvec3 position, int i, double step)
{
    const double by = i % 2 ? -step : step;
    return stp_dvec3_add(
        position, (stp_dvec3){i / 2 == 0 ? by : 0.0, i / 2 == 1 ? by : 0.0, i / 2 == 2 ? by : 0.0});
}

static stp_status points_allow(bool *out, const stp_file_points *p, stp_dvec3 position,
                               double distance, stp_station_word word, stp_error *err)
{
    stp_status status = STP_OK;
    stp_dvec3 *positions = NULL;
    uint64_t all;
    uint32_t count = 0;
    double share = 1.0, other = 1.0;
    stp_own_frame frame = STP_OWN_FRAME_NONE;
    STP_TRY(sample(&positions, &count, &all, p, STP_SEEN_POINTS, err));
    if (word == STP_STATION_GUESSED)
        STP_TRY(stp_own_frame_find(&frame, positions, count, err));
    *out = frame == STP_OWN_FRAME_CAMERA;
    if (*out || (word == STP_STATION_GUESSED && frame == STP_OWN_FRAME_NONE))
        goto done;
    STP_TRY(stp_hidden_share(&share, positions, count, position, err));
    *out = share <= HIDDEN_MOST;
    const double step = BESIDE_POINTS * distance;
    int hiding = 0;
    const bool unwritten = word >= STP_STATION_DEFAULT;
    for (int i = 0; *out && unwritten && i < 6; i++) {
        STP_TRY(stp_hidden_share(&other, positions, count, beside(position, i, step), err));
        hiding += other > HIDDEN_MORE * share && other > share + HIDDEN_ADDED;
    }
    *out = *out && (!unwritten || hiding >= 3);
done:
    free(positions);
    return status;
}

/* Whether the pixels allow the position. */
static bool pixels_allow(const stp_file_points *p, const stp_file_image *image, stp_dvec3 position,
                         double distance, stp_station_word word)
{
    int others = 0;
    if (!image_allows(p, image, position))
        return false;
    /* At least two of the six places lie well across the rays. */
    for (int i = 0; word == STP_STATION_DEFAULT && i < 6; i++)
        others += image_allows(p, image, beside(position, i, BESIDE_IMAGE * distance));
    return others <= 2;
}

stp_status stp_seen_from(bool *out, const stp_file_points *p, const stp_file_image *image,
                         stp_dvec3 position, stp_station_word word, stp_error *err)
{
    stp_status status = STP_OK;
    stp_dvec3 *few = NULL;
    uint64_t all = 0;
    uint32_t count = 0;
    *out = false;
    STP_TRY(sample(&few, &count, &all, p, MEDIAN_POINTS, err));
    const double distance = all < POINTS_LEAST ? INFINITY : median_distance(few, count, position);
    if (!(distance < DISTANCE_MOST) ||
        (word == STP_STATION_GUESSED && !stp_own_frame_may_be(few, count)))
        goto done;
    if (image)
        *out = pixels_allow(p, image, position, distance, word);
    else
        STP_TRY(points_allow(out, p, position, distance, word, err));
done:
    free(few);
    return status;
}

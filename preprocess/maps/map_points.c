/* The points of a map, and the surface through them. */
#include "preprocess/maps/map_points.h"

#include "base/memory.h"

#include <stdlib.h>

/* R of the weights, in spacings, by noise. */
#define QUIET_REACH 2.1f
#define WIDE_REACH 2.9f
#define WIDEST_REACH 4.2f
/* R is at most so many squares of the grid: the search stays small where spacings differ. */
#define REACH_MOST 8.0f
#define REACH_LEAST 1.5f
/* The same of points around the map, else they do not count. */
#define AROUND_NORMAL_LEAST 0.2f
/* Times that weights are taken from a height found before. */
#define ROUNDS 2

static float reach_of(const stp_cloud *cloud, uint32_t place, float spacing)
{
    const uint8_t marks = cloud->marks[place];
    const float reach = marks & STP_MARK_WIDEST ? WIDEST_REACH
                        : marks & STP_MARK_WIDE ? WIDE_REACH
                                                : QUIET_REACH;
    return fminf(fmaxf(reach * cloud->points[place].spacing / spacing, REACH_LEAST), REACH_MOST);
}

static stp_map_point make_point(const stp_cloud *cloud, uint32_t place, const stp_map_frame *frame,
                                bool own)
{
    const stp_dvec3 p = stp_map_frame_local(frame, cloud->points[place].position);
    const stp_dvec3 n = stp_dvec3_from_float(stp_cloud_normal(cloud, place));
    const float upwards = (float)stp_dvec3_dot(n, frame->axes[2]);
    const float nz = own ? fmaxf(upwards, STP_MAP_NORMAL_LEAST) : upwards;
    return (stp_map_point){.x = (float)(p.x / frame->spacing),
                           .y = (float)(p.y / frame->spacing),
                           .z = (float)(p.z / frame->spacing),
                           .gx = -(float)stp_dvec3_dot(n, frame->axes[0]) / nz,
                           .gy = -(float)stp_dvec3_dot(n, frame->axes[1]) / nz,
                           .nz = nz,
                           .reach = reach_of(cloud, place, (float)frame->spacing),
                           .place = place,
                           .own = own};
}

#define SQUARE_NONE SIZE_MAX

/* The square of a point, or SQUARE_NONE. */
static size_t square_of(const stp_map_points *p, const stp_map_point *point)
{
    const float x = floorf(point->x) + STP_MAP_MARGIN, y = floorf(point->y) + STP_MAP_MARGIN;
    if (!(x >= 0.0f && y >= 0.0f && x < (float)p->columns && y < (float)p->rows) ||
        (!point->own && point->nz < AROUND_NORMAL_LEAST))
        return SQUARE_NONE;
    return (size_t)y * p->columns + (size_t)x;
}

/* Counts the points of each square, or puts them there. */
static void distribute(stp_map_points *p, const stp_cloud *cloud, const stp_map_places *places,
                       const stp_map_frame *frame, bool put)
{
    for (uint32_t i = 0; i < places->own_count + places->around_count; i++) {
        const bool own = i < places->own_count;
        const uint32_t place = own ? places->own[i] : places->around[i - places->own_count];
        const stp_map_point point = make_point(cloud, place, frame, own);
        const size_t square = square_of(p, &point);
        if (square == SQUARE_NONE)
            continue;
        if (put) {
            p->points[p->begins[square + 1]++] = point;
        } else {
            p->begins[square + 2]++;
            p->own[square] += own;
            p->count++;
        }
    }
}

stp_status stp_map_points_create(stp_map_points *out, const stp_cloud *cloud,
                                 const stp_map_places *places, const stp_map_frame *frame,
                                 uint32_t columns, uint32_t rows, stp_error *err)
{
    stp_status status = STP_OK;
    stp_map_points made = {.columns = columns + 2 * STP_MAP_MARGIN,
                           .rows = rows + 2 * STP_MAP_MARGIN};
    const size_t squares = (size_t)made.columns * made.rows;
    STP_TRY(stp_alloc(&made.begins, squares + 2, sizeof *made.begins, "points", err));
    STP_TRY(stp_alloc(&made.own, squares, sizeof *made.own, "points", err));
    distribute(&made, cloud, places, frame, false);
    STP_TRY(stp_alloc(&made.points, made.count, sizeof *made.points, "points", err));
    for (size_t s = 2; s < squares + 2; s++)
        made.begins[s] += made.begins[s - 1];
    distribute(&made, cloud, places, frame, true);
    *out = made;
    made = (stp_map_points){0};
done:
    stp_map_points_clear(&made);
    return status;
}

void stp_map_points_clear(stp_map_points *p)
{
    free(p->points);
    free(p->begins);
    free(p->own);
    *p = (stp_map_points){0};
}

/* A run of points: those of a row of squares. */
typedef struct run {
    uint32_t begin, end;
} run;

/* The points in squares [column - reach, column + reach) of a row, cut at the margin's border. */
static run run_of(const stp_map_points *p, int64_t column, int64_t row, int64_t reach)
{
    const int64_t middle = column + STP_MAP_MARGIN, r = row + STP_MAP_MARGIN;
    const int64_t first = middle - reach > 0 ? middle - reach : 0;
    const int64_t end = middle + reach < p->columns ? middle + reach : p->columns;
    if (r < 0 || r >= p->rows || first >= end)
        return (run){0, 0};
    const size_t at = (size_t)r * p->columns;
    return (run){p->begins[at + (size_t)first], p->begins[at + (size_t)end]};
}

bool stp_map_points_has(const stp_map_points *p, stp_dvec3 local, const stp_map_frame *frame)
{
    const float x = (float)(local.x / frame->spacing), y = (float)(local.y / frame->spacing);
    const float z = (float)(local.z / frame->spacing);
    if (!(fabsf(x) < (float)INT32_MAX && fabsf(y) < (float)INT32_MAX))
        return false;
    const int64_t column = (int64_t)floorf(x), row = (int64_t)floorf(y);
    if (stp_map_points_in(p, column, row) == 0)
        return false;
    const size_t square =
        (size_t)(row + STP_MAP_MARGIN) * p->columns + (size_t)(column + STP_MAP_MARGIN);
    for (uint32_t i = p->begins[square]; i < p->begins[square + 1]; i++) {
        const stp_map_point *q = &p->points[i];
        if (q->own && q->x == x && q->y == y && q->z == z)
            return true;
    }
    return false;
}

/* The own point nearest to a grid place in the plane; ties by number. */
static uint32_t nearest_to(const stp_map_points *p, uint32_t column, uint32_t row)
{
    const float x = (float)column, y = (float)row;
    for (int64_t reach = 1; reach <= STP_MAP_RINGS; reach++) {
        /* what lies farther than `reach` may be outside of the squares */
        float least = (float)(reach * reach);
        uint32_t found = UINT32_MAX;
        for (int64_t r = (int64_t)row - reach; r < (int64_t)row + reach; r++) {
            const run near = run_of(p, column, r, reach);
            for (uint32_t i = near.begin; i < near.end; i++) {
                const float dx = p->points[i].x - x, dy = p->points[i].y - y;
                if (p->points[i].own && dx * dx + dy * dy < least) {
                    least = dx * dx + dy * dy;
                    found = i;
                }
            }
        }
        if (found != UINT32_MAX)
            return found;
    }
    return UINT32_MAX;
}

/* Weighted sums; places are relative to the grid place. */
typedef struct sums {
    float w, x, y, z, gx, gy, gxx; /* gxx: of g . (x, y) */
    float v, rgb[3], intensity;    /* v: sharper weights, of what is not the shape */
} sums;

static void add_run(sums *s, const stp_map_points *p, run near, vec3s place, float inverse)
{
    for (uint32_t i = near.begin; i < near.end; i++) {
        const stp_map_point *q = &p->points[i];
        const float x = q->x - place.x, y = q->y - place.y, z = q->z - place.z;
        const float t = 1.0f - (x * x + y * y + z * z) * inverse;
        if (!(t > 0.0f))
            continue;
        const float w = t * t * t * t * q->nz;
        s->w += w;
        s->x += w * x;
        s->y += w * y;
        s->z += w * z;
        s->gx += w * q->gx;
        s->gy += w * q->gy;
        s->gxx += w * (q->gx * x + q->gy * y);
    }
}

static void add_colours(sums *s, const stp_map_points *p, const stp_cloud *cloud, run near,
                        vec3s place, float inverse)
{
    for (uint32_t i = near.begin; i < near.end; i++) {
        const stp_map_point *q = &p->points[i];
        const float x = q->x - place.x, y = q->y - place.y, z = q->z - place.z;
        const float t = 1.0f - (x * x + y * y + z * z) * inverse;
        if (!(t > 0.0f))
            continue;
        const stp_cloud_point *point = &cloud->points[q->place];
        const float w = t * t * t * t * t * t * t * t;
        s->v += w;
        s->intensity += w * point->intensity;
        for (int c = 0; c < 3; c++)
            s->rgb[c] += w * point->rgb[c];
    }
}

/* Takes the height of the surface from the sums. */
static void solve(const sums *s, float base, stp_map_spot *out)
{
    const float f = 1.0f / s->w;
    const float x = f * s->x, y = f * s->y;
    out->gx = f * s->gx;
    out->gy = f * s->gy;
    const float off = f * s->gxx - out->gx * x - out->gy * y;
    out->height = base + f * s->z - out->gx * x - out->gy * y - 0.5f * off;
}

/* What is not the shape is that of the points around; of the nearest point if they are all far. */
static void take_colours(const sums *s, const stp_cloud_point *nearest, stp_map_spot *out)
{
    const bool none = !(s->v > 0.0f);
    out->intensity = none ? nearest->intensity : s->intensity / s->v;
    for (int c = 0; c < 3; c++)
        out->rgb[c] = none ? nearest->rgb[c] : s->rgb[c] / s->v;
}

bool stp_map_points_spot(const stp_map_points *p, const stp_cloud *cloud, uint32_t column,
                         uint32_t row, stp_map_spot *out)
{
    const uint32_t nearest = nearest_to(p, column, row);
    if (nearest == UINT32_MAX)
        return false;
    const stp_map_point *first = &p->points[nearest];
    const float reach = first->reach, inverse = 1.0f / (reach * reach);
    const int64_t squares = (int64_t)ceilf(reach);
    vec3s place = {{(float)column, (float)row, 0.0f}};
    *out = (stp_map_spot){.gx = first->gx, .gy = first->gy, .nearest = nearest};
    out->height = first->z + first->gx * (place.x - first->x) + first->gy * (place.y - first->y);
    for (int round = 0; round < ROUNDS; round++) {
        sums s = {0};
        place.z = out->height;
        for (int64_t r = (int64_t)row - squares; r < (int64_t)row + squares; r++)
            add_run(&s, p, run_of(p, column, r, squares), place, inverse);
        if (!(s.w > 0.0f))
            return false;
        solve(&s, place.z, out);
    }
    sums s = {0};
    place.z = out->height;
    for (int64_t r = (int64_t)row - squares; r < (int64_t)row + squares; r++)
        add_colours(&s, p, cloud, run_of(p, column, r, squares), place, inverse);
    take_colours(&s, &cloud->points[first->place], out);
    return true;
}

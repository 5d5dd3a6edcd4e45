/* Makes a map of a part of a surface. */
#include "preprocess/maps/map_make.h"

#include "base/memory.h"
#include "formats/chunk/codec/square/square.h"
#include "formats/chunk/sample/normal_grid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A grid has at most so many squares a point, beside SQUARES_LEAST. */
#define SQUARES_MOST 32.0
#define SQUARES_LEAST 1024.0
/* Height steps in a spacing of the grid. */
#define HEIGHT_STEPS 256.0
/* A map is rough beyond this (roughness). With noise of one spacing, normals are then 16.8 degrees
 * off the true ones for 19.4, with noise of 0.3 as before (statue of 300 K points). */
#define ROUGH_RAD (12.0 * M_PI / 180.0)
/* Heights of neighbours jump if they differ by more than the slope of this many degrees beyond the
 * cone, and this many spacings of the grid. */
#define BEYOND_CONE (10.0 * M_PI / 180.0)
#define SLOPE_MOST (80.0 * M_PI / 180.0)
#define JUMP_LEAST 1.0
/* Places within so many squares on all four sides support a place. */
#define CLOSED_SQUARES 2
/* A point whose spacing is this many times that of the grid supports all places within so many of
 * its own spacings, as its disc would cover them. */
#define SPARSE_SPACINGS 1.4f
#define SPARSE_REACH 1.2f

typedef struct making {
    const stp_cloud *cloud;
    const uint32_t *places;
    uint32_t count;
    double cone_rad;
    stp_map map;
    stp_map_points points;
    stp_map_faces faces;
    uint8_t *covered; /* by place of the grid: sparse points or triangles support it */
    float *heights;   /* in spacings of the grid; NaN: no support */
    float *slopes;    /* of the surface through the points, squared */
} making;

/* Turns the axes in the plane so that the first follows the points' longer side. */
static void turn_axes(const making *m, stp_map_frame *frame)
{
    double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
    for (uint32_t i = 0; i < m->count; i++) {
        const stp_dvec3 p = stp_map_frame_local(frame, m->cloud->points[m->places[i]].position);
        x += p.x;
        y += p.y;
        xx += p.x * p.x;
        xy += p.x * p.y;
        yy += p.y * p.y;
    }
    const double share = 1.0 / m->count;
    const double angle =
        0.5 * atan2(2.0 * (xy - x * y * share), (xx - x * x * share) - (yy - y * y * share));
    frame->axes[0] = stp_dvec3_rotate(frame->axes[0], frame->axes[2], angle);
    frame->axes[1] = stp_dvec3_cross(frame->axes[2], frame->axes[0]);
}

/* Chooses the frame; *far: the far corner of the points in it. */
static void choose_frame(making *m, const stp_normal_cone *cone, stp_dvec3 *far)
{
    stp_map_frame *frame = &m->map.frame;
    stp_dbox box = stp_dbox_empty();
    double area = 0.0;
    frame->origin = m->cloud->points[m->places[0]].position;
    stp_dvec3_axes(frame->axes, cone->axis);
    turn_axes(m, frame);
    for (uint32_t i = 0; i < m->count; i++) {
        const stp_cloud_point *p = &m->cloud->points[m->places[i]];
        const stp_dvec3 n = stp_dvec3_from_float(stp_cloud_normal(m->cloud, m->places[i]));
        const double spacing = (double)p->spacing;
        area += spacing * spacing * fmax(stp_dvec3_dot(n, cone->axis), 0.0);
        stp_dbox_add(&box, stp_map_frame_local(frame, p->position));
    }
    frame->origin = stp_map_frame_world(frame, box.min);
    frame->spacing = sqrt(area / m->count);
    frame->height_step = frame->spacing / HEIGHT_STEPS;
    *far = stp_dvec3_sub(box.max, box.min);
}

void stp_map_jumps(double cone_rad, double out[STP_MAP_BESIDE])
{
    const double slope = tan(fmin(cone_rad + BEYOND_CONE, SLOPE_MOST));
    for (int k = 0; k < STP_MAP_BESIDE; k++)
        out[k] = slope * hypot(stp_map_beside[k][0], stp_map_beside[k][1]) + JUMP_LEAST;
}

double stp_map_squares_most(uint32_t count)
{
    return SQUARES_MOST * count + SQUARES_LEAST;
}

/* Whether a quadrant around a place has a point within CLOSED_SQUARES. */
static bool has_points(const stp_map_points *p, int64_t column, int64_t row, bool right, bool down)
{
    for (int j = 0; j < CLOSED_SQUARES; j++)
        for (int i = 0; i < CLOSED_SQUARES; i++)
            if (stp_map_points_in(p, right ? column + i : column - 1 - i,
                                  down ? row + j : row - 1 - j) > 0)
                return true;
    return false;
}

static bool is_supported(const stp_map_points *p, uint32_t column, uint32_t row)
{
    unsigned near = 0;
    for (unsigned q = 0; q < 4; q++) {
        if (stp_map_points_in(p, (int64_t)column - (q & 1u), (int64_t)row - (q >> 1)) > 0)
            return true;
        near += has_points(p, column, row, (q & 1u) == 0, (q & 2u) == 0);
    }
    return near == 4;
}

/* Marks the places that a sparse point supports. x, y: where it is. */
static void cover(making *m, float x, float y, float reach)
{
    const int64_t columns = m->map.columns, rows = m->map.rows;
    for (int64_t r = (int64_t)ceilf(y - reach); r <= (int64_t)floorf(y + reach); r++)
        for (int64_t c = (int64_t)ceilf(x - reach); c <= (int64_t)floorf(x + reach); c++) {
            const float dx = (float)c - x, dy = (float)r - y;
            if (c >= 0 && r >= 0 && c < columns && r < rows && dx * dx + dy * dy <= reach * reach)
                m->covered[r * columns + c] = 1;
        }
}

static void cover_all(making *m)
{
    for (uint32_t i = 0; i < m->points.count; i++) {
        const stp_map_point *p = &m->points.points[i];
        const float wide = m->cloud->points[p->place].spacing / (float)m->map.frame.spacing;
        if (p->own && wide >= SPARSE_SPACINGS)
            cover(m, p->x, p->y, fminf(SPARSE_REACH * wide, (float)STP_MAP_RINGS));
    }
}

static uint16_t rounded(float value, float most)
{
    return (uint16_t)(fminf(fmaxf(value, 0.0f), most) + 0.5f);
}

static void take_spot(making *m, stp_map_sample *out, const stp_map_spot *spot)
{
    const stp_map_frame *frame = &m->map.frame;
    const uint32_t nearest = m->points.points[spot->nearest].place;
    stp_dvec3 n = stp_dvec3_sub(frame->axes[2],
                                stp_dvec3_add(stp_dvec3_scale(frame->axes[0], (double)spot->gx),
                                              stp_dvec3_scale(frame->axes[1], (double)spot->gy)));
    n = stp_dvec3_normalize(n);
    stp_normal_encode_on(stp_dvec3_to_float(n), STP_NORMAL_BITS, out->normal);
    for (int c = 0; c < 3; c++)
        out->rgb[c] = (uint8_t)rounded(spot->rgb[c] / 257.0f, 255.0f);
    out->intensity = rounded(spot->intensity, 65535.0f);
    out->class_id = m->cloud->points[nearest].class_id;
    out->flags = STP_MAP_SUPPORTED;
    if (m->cloud->marks[nearest] & STP_MARK_ORIENTED)
        out->flags |= STP_MAP_ORIENTED;
    if (m->cloud->marks[nearest] & STP_MARK_CLOSED)
        out->flags |= STP_MAP_CLOSED;
}

/* Samples the surface wherever it is supported. */
static void sample_all(making *m)
{
    stp_map *map = &m->map;
    for (uint32_t row = 0; row < map->rows; row++)
        for (uint32_t column = 0; column < map->columns; column++) {
            const size_t at = (size_t)row * map->columns + column;
            stp_map_spot spot;
            m->heights[at] = NAN;
            if ((!m->covered[at] && !is_supported(&m->points, column, row)) ||
                !stp_map_points_spot(&m->points, m->cloud, column, row, &spot))
                continue;
            m->heights[at] = spot.height;
            m->slopes[at] = spot.gx * spot.gx + spot.gy * spot.gy;
            take_spot(m, &map->samples[at], &spot);
            map->count++;
        }
}

/* Moves the samples onto the mesh, if there is one. */
static stp_status lift(making *m, stp_error *err)
{
    stp_status status = STP_OK;
    float *lifted = NULL;
    double most[STP_MAP_BESIDE];
    if (m->faces.count == 0)
        return STP_OK;
    stp_map_jumps(m->cone_rad, most);
    STP_TRY(stp_alloc(&lifted, (size_t)m->map.columns * m->map.rows, sizeof *lifted, "maps", err));
    stp_map_faces_lift(&m->faces, m->map.columns, m->map.rows, m->slopes, most, m->heights, lifted);
done:
    free(lifted);
    return status;
}

/* Whether heights of neighbours, in rows, columns and diagonals, differ by more than the cone
 * allows. */
static bool jumps(const making *m)
{
    const int64_t columns = m->map.columns, rows = m->map.rows;
    double most[STP_MAP_BESIDE];
    stp_map_jumps(m->cone_rad, most);
    for (int64_t row = 0; row < rows; row++)
        for (int64_t column = 0; column < columns; column++)
            for (int k = 0; k < STP_MAP_BESIDE; k++) {
                const int64_t c = column + stp_map_beside[k][0], r = row + stp_map_beside[k][1];
                if (c < 0 || c >= columns || r >= rows)
                    continue;
                const double step = (double)m->heights[r * columns + c] -
                                    (double)m->heights[row * columns + column];
                if (fabs(step) > most[k]) /* false without support */
                    return true;
            }
    return false;
}

/* Whether most own points have normals that are fitted more widely than the surface averages. */
static bool has_wide_normals(const making *m)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < m->count; i++)
        count += m->cloud->points[m->places[i]].given == STP_GIVEN_IMAGE ||
                 (m->cloud->marks[m->places[i]] & STP_MARK_WIDEST) != 0;
    return 2 * count > m->count;
}

/* The mean angle, radians, between the surface's normals and those of planes through heights. */
static double roughness(const making *m)
{
    const stp_dvec3 *axes = m->map.frame.axes;
    const uint32_t columns = m->map.columns;
    double sum = 0.0;
    uint32_t count = 0;
    for (uint32_t row = 1; row + 1 < m->map.rows; row++)
        for (uint32_t column = 1; column + 1 < columns; column++) {
            const size_t at = (size_t)row * columns + column;
            const float *h = &m->heights[at];
            const double right = 0.5 * ((double)h[1] - (double)h[-1]);
            const double down = 0.5 * ((double)h[columns] - (double)h[-(ptrdiff_t)columns]);
            if (isnan((double)*h + right + down))
                continue;
            const stp_dvec3 n = stp_dvec3_from_float(stp_normal_decode(m->map.samples[at].normal));
            const double cosine = (stp_dvec3_dot(n, axes[2]) - right * stp_dvec3_dot(n, axes[0]) -
                                   down * stp_dvec3_dot(n, axes[1])) /
                                  sqrt(1.0 + right * right + down * down);
            sum += acos(stp_max(-1.0, stp_min(1.0, cosine)));
            count++;
        }
    return count > 0 ? sum / count : 0.0;
}

/* Moves the plane below all heights and rounds the heights to steps. */
static void round_heights(making *m)
{
    stp_map *map = &m->map;
    const size_t all = (size_t)map->columns * map->rows;
    float least = INFINITY;
    for (size_t i = 0; i < all; i++)
        least = fminf(least, m->heights[i]);
    const double base = floor((double)least * HEIGHT_STEPS);
    map->frame.origin =
        stp_map_frame_world(&map->frame, (stp_dvec3){0.0, 0.0, base * map->frame.height_step});
    for (size_t i = 0; i < all; i++)
        if (map->samples[i].flags & STP_MAP_SUPPORTED)
            map->samples[i].height =
                (int32_t)nearbyint((double)m->heights[i] * HEIGHT_STEPS - base);
}

/* What the squares cost that have samples, if the first row is the row `down` of a square, and the
 * first column its column 0 to 7: a full one 1, another one 2, since its samples are merged across
 * rows and columns. band: by column. */
static void weigh_squares(const stp_map *map, uint32_t down, uint8_t *band,
                          uint32_t costs[STP_SQUARE_SIDE])
{
    memset(costs, 0, STP_SQUARE_SIDE * sizeof *costs);
    for (uint32_t row = 0; row < map->rows;) {
        memset(band, 0, map->columns * sizeof *band);
        do
            for (uint32_t c = 0; c < map->columns; c++)
                band[c] += (uint8_t)(stp_map_at(map, c, row)->flags & STP_MAP_SUPPORTED);
        while (++row < map->rows && (row + down) % STP_SQUARE_SIDE != 0);
        for (uint32_t right = 0; right < STP_SQUARE_SIDE; right++)
            for (uint32_t c = 0; c < map->columns;) {
                uint32_t samples = 0;
                do
                    samples += band[c];
                while (++c < map->columns && (c + right) % STP_SQUARE_SIDE != 0);
                if (samples > 0)
                    costs[right] += samples < STP_SQUARE_SAMPLES ? 2u : 1u;
            }
    }
}

/* Puts empty rows and columns before the first ones so that the squares cost least: each is a
 * patch. */
static stp_status fit_squares(stp_map *map, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *band = NULL;
    stp_map_sample *samples = NULL;
    uint32_t least = UINT32_MAX, right = 0, down = 0, costs[STP_SQUARE_SIDE];
    STP_TRY(stp_alloc(&band, map->columns, sizeof *band, "maps", err));
    for (uint32_t r = 0; r < STP_SQUARE_SIDE; r++) {
        weigh_squares(map, r, band, costs);
        for (uint32_t c = 0; c < STP_SQUARE_SIDE; c++)
            if (costs[c] < least) {
                least = costs[c];
                right = c;
                down = r;
            }
    }
    const uint32_t columns = map->columns + right, rows = map->rows + down;
    STP_TRY(stp_alloc(&samples, (size_t)columns * rows, sizeof *samples, "maps", err));
    for (uint32_t row = 0; row < map->rows; row++)
        memcpy(samples + (size_t)(row + down) * columns + right,
               map->samples + (size_t)row * map->columns, map->columns * sizeof *samples);
    map->frame.origin = stp_map_frame_world(
        &map->frame, (stp_dvec3){-map->frame.spacing * right, -map->frame.spacing * down, 0.0});
    map->columns = columns;
    map->rows = rows;
    free(map->samples);
    map->samples = samples;
done:
    free(band);
    return status;
}

stp_status stp_map_make(stp_map *out, bool *fits, const stp_cloud *cloud,
                        const stp_map_places *places, const stp_normal_cone *cone, double cone_rad,
                        stp_error *err)
{
    stp_status status = STP_OK;
    making m = {
        .cloud = cloud, .places = places->own, .count = places->own_count, .cone_rad = cone_rad};
    stp_dvec3 far;
    *fits = false;
    *out = (stp_map){0};
    choose_frame(&m, cone, &far);
    const double columns = floor(far.x / m.map.frame.spacing) + 1.0;
    const double rows = floor(far.y / m.map.frame.spacing) + 1.0;
    if (!(m.map.frame.spacing > 0.0) || columns * rows > stp_map_squares_most(m.count))
        return STP_OK;
    m.map.columns = (uint32_t)columns + 1;
    m.map.rows = (uint32_t)rows + 1;
    m.map.sheet = cloud->sheets[m.places[0]];
    const size_t all = (size_t)m.map.columns * m.map.rows;
    STP_TRY(stp_map_points_create(&m.points, cloud, places, &m.map.frame, m.map.columns - 1,
                                  m.map.rows - 1, err));
    STP_TRY(stp_alloc(&m.map.samples, all, sizeof *m.map.samples, "maps", err));
    STP_TRY(stp_alloc(&m.heights, all, sizeof *m.heights, "maps", err));
    STP_TRY(stp_alloc(&m.covered, all, sizeof *m.covered, "maps", err));
    STP_TRY(stp_alloc(&m.slopes, all, sizeof *m.slopes, "maps", err));
    STP_TRY(
        stp_map_faces_create(&m.faces, places->faces, &m.points, &m.map.frame, &places->box, err));
    cover_all(&m);
    stp_map_faces_cover(&m.faces, m.map.columns, m.map.rows, m.covered);
    sample_all(&m);
    STP_TRY(lift(&m, err));
    if (jumps(&m))
        goto done;
    m.map.rough = m.faces.count == 0 && has_wide_normals(&m) && roughness(&m) > ROUGH_RAD;
    round_heights(&m);
    STP_TRY(fit_squares(&m.map, err));
    *fits = true;
    *out = m.map;
    m.map.samples = NULL;
done:
    stp_map_points_clear(&m.points);
    stp_map_faces_clear(&m.faces);
    free(m.map.samples);
    free(m.slopes);
    free(m.heights);
    free(m.covered);
    return status;
}

/* Voxels, distances and rays. */
#include "preprocess/viewpoint/free_space.h"

#include "base/memory.h"
#include "base/sort.h"
#include "preprocess/cloud/cloud_blocks.h"

#include <math.h>
#include <stdlib.h>

#define SAMPLE 16384u
#define FAR_OUT 100u
/* A normal within 20 degrees of an axis is along it. A normal within 20 degrees of the axis's plane
 * is across it. */
#define ALONG_COSINE 0.94f
#define ACROSS_COSINE 0.34f
/* Points of the classes low and high noise (LAS 1.4 R15, 7 and 18) do not count, unless more than
 * one in NOISE_PART is one: then these numbers mean something else. */
#define LOW_NOISE 7u
#define HIGH_NOISE 18u
#define NOISE_PART 10u
/* Free voxels around the points. */
#define MARGIN 1
#define GOLDEN_RAD 2.39996322972865332

/* Which points count. */
typedef struct choice {
    uint16_t station;
    const stp_dbox *within;
    bool noise_too;
} choice;

static bool is_noise(const stp_cloud_point *p)
{
    return p->class_id == LOW_NOISE || p->class_id == HIGH_NOISE;
}

static bool is_counted(const stp_cloud_point *p, const choice *c)
{
    return (c->station == 0 || p->station == c->station) && (c->noise_too || !is_noise(p)) &&
           !(c->within && stp_dbox_distance_squared(c->within, p->position) > 0.0);
}

static double coordinate(stp_dvec3 p, int axis)
{
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

/* The boxes of the points that count, all and without those far out. Decides whether noise counts.
 */
static stp_status find_boxes(stp_space *out, const stp_cloud *cloud, choice *chosen, stp_error *err)
{
    stp_status status = STP_OK;
    double *values = NULL, ends[3][4];
    stp_cloud_point *points = NULL;
    uint32_t listed = 0, noise = 0;
    STP_TRY(stp_cloud_every(cloud, cloud->count / SAMPLE + 1, &points, &listed, err));
    for (uint32_t i = 0; i < listed; i++)
        noise += is_noise(&points[i]);
    chosen->noise_too = noise > listed / NOISE_PART;
    STP_TRY(stp_alloc(&values, listed, sizeof *values, "coordinates", err));
    for (int axis = 0; axis < 3; axis++) {
        size_t count = 0;
        for (uint32_t i = 0; i < listed; i++)
            if (is_counted(&points[i], chosen))
                values[count++] = coordinate(points[i].position, axis);
        if (count == 0)
            values[count++] = coordinate(points[0].position, axis);
        stp_sort_doubles(values, count);
        ends[axis][0] = values[0];
        ends[axis][1] = values[count / FAR_OUT];
        ends[axis][2] = values[count - 1 - count / FAR_OUT];
        ends[axis][3] = values[count - 1];
    }
    out->all = (stp_dbox){.min = {ends[0][0], ends[1][0], ends[2][0]},
                          .max = {ends[0][3], ends[1][3], ends[2][3]}};
    out->box = (stp_dbox){.min = {ends[0][1], ends[1][1], ends[2][1]},
                          .max = {ends[0][2], ends[1][2], ends[2][2]}};
done:
    free(points);
    free(values);
    return status;
}

bool stp_space_voxel(const stp_space *s, stp_dvec3 position, int at[3])
{
    const stp_dvec3 p = stp_dvec3_scale(stp_dvec3_sub(position, s->origin), 1.0 / s->side);
    for (int axis = 0; axis < 3; axis++) {
        const double v = coordinate(p, axis);
        if (!(v >= 0.0 && v < s->size[axis]))
            return false;
        at[axis] = (int)v;
    }
    return true;
}

static void count_one(uint16_t *count)
{
    if (*count < UINT16_MAX)
        (*count)++;
}

typedef struct counting {
    stp_space *space;
    const stp_cloud *cloud;
    choice chosen;
    uint16_t *noise; /* how many points of noise do not count */
} counting;

/* Counts this process's points. */
static void count_points(void *context)
{
    const counting *c = context;
    const stp_cloud *cloud = c->cloud;
    stp_space *s = c->space;
    const stp_rank_part own = stp_cloud_own(cloud);
    int at[3];
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i)) {
        const stp_cloud_point *p = &cloud->points[i];
        if (!c->chosen.noise_too && is_noise(p))
            count_one(c->noise);
        if (!is_counted(p, &c->chosen) || !stp_space_voxel(s, p->position, at))
            continue;
        const size_t voxel = stp_space_at(s, at[0], at[1], at[2]);
        count_one(&s->count[voxel]);
        for (int axis = 1; axis < 3 && stp_has_normal(p); axis++) {
            const float cosine = fabsf(p->normal.raw[axis]);
            if (cosine > ALONG_COSINE)
                count_one(&s->level[axis][voxel]);
            else if (cosine < ACROSS_COSINE)
                count_one(&s->upright[axis][voxel]);
        }
    }
}

/* Shortens a row's distances by those of a neighbour row: `straight` to the voxel beside, `askew`
 * to that voxel's neighbours along x. */
static void spread_row(uint16_t *row, const uint16_t *from, int size, int straight, int askew)
{
    for (int x = 0; x < size; x++) {
        int least = from[x] + straight;
        const int before = x > 0 ? from[x - 1] + askew : UINT16_MAX;
        const int after = x < size - 1 ? from[x + 1] + askew : UINT16_MAX;
        least = before < least ? before : least;
        least = after < least ? after : least;
        row[x] = least < row[x] ? (uint16_t)least : row[x];
    }
}

/* Shortens a row's distances along the row. */
static void spread_along(uint16_t *row, int size, int way)
{
    for (int i = 1; i < size; i++) {
        const int x = way > 0 ? i : size - 1 - i, by = row[x - way] + 8;
        row[x] = by < row[x] ? (uint16_t)by : row[x];
    }
}

/* One pass of a chamfer distance over the voxels, forwards or backwards. Steps along one, two and
 * three axes cost 8, 11 and 14. */
static void spread(stp_space *s, int way)
{
    static const int rows[4][2] = {{-1, -1}, {0, -1}, {1, -1}, {-1, 0}}; /* y, z: visited before */
    for (int k = 0; k < s->size[2]; k++)
        for (int j = 0; j < s->size[1]; j++) {
            const int y = way > 0 ? j : s->size[1] - 1 - j, z = way > 0 ? k : s->size[2] - 1 - k;
            uint16_t *row = &s->room[stp_space_at(s, 0, y, z)];
            for (int n = 0; n < 4; n++) {
                const int b = y + way * rows[n][0], c = z + way * rows[n][1];
                const int step = rows[n][0] != 0 && rows[n][1] != 0 ? 11 : 8;
                if (b >= 0 && c >= 0 && b < s->size[1] && c < s->size[2])
                    spread_row(row, &s->room[stp_space_at(s, 0, b, c)], s->size[0], step, step + 3);
            }
            spread_along(row, s->size[0], way);
        }
}

static void find_room(stp_space *s, size_t voxels)
{
    for (size_t i = 0; i < voxels; i++)
        s->room[i] = s->count[i] > 0 ? 0 : UINT16_MAX;
    spread(s, 1);
    spread(s, -1);
}

stp_status stp_space_create(stp_space *out, const stp_cloud *cloud, uint16_t station,
                            const stp_dbox *within, stp_error *err)
{
    stp_status status = STP_OK;
    stp_space s = {0};
    size_t voxels = 1;
    counting c = {&s, cloud, {.station = station, .within = within}, NULL};
    STP_TRY(find_boxes(&s, cloud, &c.chosen, err));
    s.side = stp_dbox_side(&s.box) / (STP_SPACE_SIDE - 2 * MARGIN - 1);
    const double least = 1e-9 * (stp_dvec3_length(s.box.min) + stp_dvec3_length(s.box.max));
    s.side = s.side > least ? s.side : fmax(least, 1e-30);
    const stp_dvec3 size = stp_dvec3_scale(stp_dvec3_sub(s.box.max, s.box.min), 1.0 / s.side);
    for (int axis = 0; axis < 3; axis++) {
        s.size[axis] = (int)coordinate(size, axis) + 1 + 2 * MARGIN;
        voxels *= (size_t)s.size[axis];
    }
    s.origin =
        stp_dvec3_sub(s.box.min, stp_dvec3_scale((stp_dvec3){1.0, 1.0, 1.0}, MARGIN * s.side));
    STP_TRY(stp_alloc(&s.count, 5 * voxels + 1, sizeof *s.count, "voxels", err));
    STP_TRY(stp_alloc(&s.room, voxels, sizeof *s.room, "voxels", err));
    for (size_t axis = 1; axis < 3; axis++) {
        s.level[axis] = s.count + axis * voxels;
        s.upright[axis] = s.count + (2 + axis) * voxels;
    }
    c.noise = s.count + 5 * voxels;
    STP_TRY(stp_cloud_in_turn(cloud, count_points, &c, s.count, (5 * voxels + 1) * sizeof *s.count,
                              err));
    s.lacks_noise = *c.noise > 0;
    find_room(&s, voxels);
    *out = s;
    s = (stp_space){0};
done:
    stp_space_clear(&s);
    return status;
}

void stp_space_clear(stp_space *s)
{
    free(s->count);
    free(s->room);
    *s = (stp_space){0};
}

/* The steps of half a voxel from this voxel that surely end in free voxels or outside the grid.
 * find_room's longest step costs 14, so no solid voxel is within room / 14 voxels along any axis.
 * One voxel less is for rounding. */
static int free_steps(const stp_space *s, size_t voxel)
{
    const int voxels = (s->room[voxel] + 13) / 14 - 2;
    return voxels > 0 ? 2 * voxels : 0;
}

/* Leaps over free voxels, and takes shorter leaps where a leap leaves the grid. */
stp_space_hit stp_space_cast(const stp_space *s, stp_dvec3 from, stp_dvec3 direction)
{
    stp_space_hit hit = {0};
    int at[3], leap = 0;
    if (!(stp_dvec3_length(direction) > 0.5))
        return hit;
    for (double d = 0.0;;) {
        if (stp_space_voxel(s, stp_dvec3_add(from, stp_dvec3_scale(direction, d)), at)) {
            hit.distance = d;
            hit.voxel = stp_space_at(s, at[0], at[1], at[2]);
            hit.solid = s->count[hit.voxel] > 0;
            if (hit.solid)
                return hit;
            leap = free_steps(s, hit.voxel);
        } else if (leap > 0) {
            leap /= 2;
            d = hit.distance;
        } else {
            return hit;
        }
        for (int i = 0; i <= leap; i++)
            d += 0.5 * s->side;
    }
}

stp_dvec3 stp_space_direction(int i, int count)
{
    const double z = 1.0 - (2.0 * i + 1.0) / count, across = sqrt(1.0 - z * z);
    return (stp_dvec3){across * cos(GOLDEN_RAD * i), across * sin(GOLDEN_RAD * i), z};
}

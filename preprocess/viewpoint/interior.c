/* Finds insides of rooms. */
#include "preprocess/viewpoint/interior.h"

#include "preprocess/cloud/cloud_blocks.h"

#include <math.h>
#include <stdlib.h>

#define PI 3.14159265358979323846
/* Rays from a place that is considered, and from the one that is taken. */
#define RAYS_FEW 64
#define RAYS 512
#define STEP 3 /* voxels from place to place */
/* Where an eye may be, in parts of the box: greatest distance from the middle; lowest and highest
 * height over the floor. */
#define MIDDLE_PART 0.3
#define LOWEST_PART 0.3
#define HIGHEST_PART 0.6
#define OFF_MIDDLE 0.3 /* cost of a length off the middle, in lengths of room */
/* Sampled points, rays from each, and how many of these may leave the cloud if the point is within.
 */
#define POINTS 4096u
#define OUTSIDE_RAYS 48
#define OUTSIDE_MOST 3
#define GIVEN_LEAST 64u
/* y is up only if it has this many times more floor and ceiling: most scans of interiors are
 * surveys, with z up. Fewer will do if what is inside stands on the low end of y, and not on that
 * of z: on its half are shares of at least and at most this much. SHELL: the part of the box at
 * each side that is walls. */
#define UPWARDS 1.4
#define UPWARDS_STANDING 1.1
#define STANDING_LEAST 0.7
#define LYING_MOST 0.65
#define SHELL 0.08
/* The rule. */
#define ENCLOSED_LEAST 0.8
#define ROOM_LEAST 0.15 /* of the height */
#define LEVEL_LEAST 0.55
#define UPRIGHT_LEAST 0.4
#define WITHIN_LEAST 0.1
#define LINING_LEAST 0.6
#define FLAT_MOST 0.8
#define AGREED 0.8
/* The view. */
#define FANS 72
#define FAN_RAD 0.25
#define FAN_RAYS 9
#define FOVY_DEG 72.0
#define TILT 0.06

static double along(stp_dvec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

/* Counts voxels of floor and ceiling: level ones in the lowest and highest fifth of the box. */
static double floors(const stp_space *s, int axis)
{
    double found = 0.0;
    for (int z = 0; z < s->size[2]; z++)
        for (int y = 0; y < s->size[1]; y++)
            for (int x = 0; x < s->size[0]; x++) {
                const size_t at = stp_space_at(s, x, y, z);
                const int height = axis == 1 ? y : z;
                const bool end = 5 * height < s->size[axis] || 5 * height >= 4 * s->size[axis];
                found += end && s->count[at] > 0 && 2 * s->level[axis][at] > s->count[at];
            }
    return found;
}

/* Of the voxels with points within the shell, the share in the low half of an axis; 0.5 if there
 * are none. */
static double low_share(const stp_space *s, int axis)
{
    size_t low = 0, all = 0;
    int begin[3], end[3];
    for (int k = 0; k < 3; k++) {
        begin[k] = (int)ceil(SHELL * s->size[k]);
        end[k] = s->size[k] - begin[k];
    }
    for (int z = begin[2]; z < end[2]; z++)
        for (int y = begin[1]; y < end[1]; y++)
            for (int x = begin[0]; x < end[0]; x++) {
                const bool solid = s->count[stp_space_at(s, x, y, z)] > 0;
                all += solid;
                low += solid && 2 * (axis == 1 ? y : z) < s->size[axis];
            }
    return all > 0 ? (double)low / (double)all : 0.5;
}

static int find_up(const stp_space *s)
{
    const double more = floors(s, 1) / fmax(floors(s, 2), 1.0);
    const bool stands = low_share(s, 1) >= STANDING_LEAST && low_share(s, 2) <= LYING_MOST;
    return more > (stands ? UPWARDS_STANDING : UPWARDS) ? 1 : 2;
}

/* Whether at least ENCLOSED_LEAST of a few rays end at the cloud. */
static bool is_enclosed(const stp_space *s, stp_dvec3 eye, const stp_dvec3 rays[RAYS_FEW])
{
    int left = 0;
    for (int i = 0; i < RAYS_FEW && (double)(RAYS_FEW - left) / RAYS_FEW >= ENCLOSED_LEAST; i++)
        left += !stp_space_cast(s, eye, rays[i]).solid;
    return (double)(RAYS_FEW - left) / RAYS_FEW >= ENCLOSED_LEAST;
}

/* Whether the box allows an eye here. middle_part: as MIDDLE_PART. */
static bool is_central(const stp_space *s, stp_dvec3 p, int up_axis, double middle_part)
{
    const stp_dvec3 size = stp_dvec3_sub(s->box.max, s->box.min);
    const stp_dvec3 from = stp_dvec3_sub(p, s->box.min);
    for (int axis = 0; axis < 3; axis++) {
        const double part = along(from, axis) / fmax(along(size, axis), 1e-300);
        if (axis == up_axis ? part < LOWEST_PART || part > HIGHEST_PART
                            : fabs(part - 0.5) > middle_part)
            return false;
    }
    return true;
}

/* Finds the best eye. An enclosed place goes before others; then room and nearness to the middle
 * count. False if no place is enclosed. */
static bool find_eye(stp_interior *in, const stp_space *s, double middle_part)
{
    const stp_dvec3 middle = stp_dbox_middle(&s->box);
    const double for_closed = 2.0 * stp_dbox_side(&s->box);
    stp_dvec3 rays[RAYS_FEW];
    double best = -INFINITY;
    bool found = false;
    in->eye = middle;
    in->room = 0.0;
    for (int i = 0; i < RAYS_FEW; i++)
        rays[i] = stp_space_direction(i, RAYS_FEW);
    for (int z = 0; z < s->size[2]; z += STEP)
        for (int y = 0; y < s->size[1]; y += STEP)
            for (int x = 0; x < s->size[0]; x += STEP) {
                const stp_dvec3 p = stp_space_middle(s, x, y, z);
                const double room = s->room[stp_space_at(s, x, y, z)] / STP_SPACE_ROOM * s->side;
                if (room < 2.0 * s->side || !is_central(s, p, in->up_axis, middle_part))
                    continue;
                const double off = stp_dvec3_length(stp_dvec3_sub(p, middle));
                const double open = room - OFF_MIDDLE * off;
                if (!(open + for_closed > best))
                    continue;
                const bool closed = is_enclosed(s, p, rays);
                const double score = open + (closed ? for_closed : 0.0);
                found = found || closed;
                if (score > best) {
                    best = score;
                    in->eye = p;
                    in->room = room;
                }
            }
    return found;
}

/* Measures what rays from the eye hit. */
static void look_around(stp_interior *in, const stp_space *s)
{
    int below = 0, level = 0, around = 0, upright = 0, solid = 0;
    for (int i = 0; i < RAYS; i++) {
        const stp_dvec3 d = stp_space_direction(i, RAYS);
        const stp_space_hit hit = stp_space_cast(s, in->eye, d);
        const double up = along(d, in->up_axis);
        if (!hit.solid)
            continue;
        solid++;
        below += up < -0.6;
        level += up < -0.6 && 2 * s->level[in->up_axis][hit.voxel] > s->count[hit.voxel];
        around += fabs(up) < 0.4;
        upright += fabs(up) < 0.4 && 2 * s->upright[in->up_axis][hit.voxel] > s->count[hit.voxel];
    }
    in->enclosed = (double)solid / RAYS;
    in->level = below > 0 ? (double)level / below : 0.0;
    in->upright = around > 0 ? (double)upright / around : 0.0;
}

/* Whether few rays from the point leave the cloud. They begin a little off the point's own surface.
 */
static bool is_within(const stp_space *s, stp_dvec3 p, const stp_dvec3 rays[OUTSIDE_RAYS])
{
    int left = 0;
    for (int i = 0; i < OUTSIDE_RAYS && left <= OUTSIDE_MOST; i++) {
        const stp_dvec3 from = stp_dvec3_add(p, stp_dvec3_scale(rays[i], 2.5 * s->side));
        left += !stp_space_cast(s, from, rays[i]).solid;
    }
    return left <= OUTSIDE_MOST;
}

/* Whether a side of the point's surface is enclosed. */
static bool has_enclosed_side(const stp_space *s, const stp_cloud_point *p,
                              const stp_dvec3 rays[RAYS_FEW])
{
    const stp_dvec3 off = stp_dvec3_scale(stp_dvec3_from_float(p->normal), 2.5 * s->side);
    return stp_has_normal(p) && (is_enclosed(s, stp_dvec3_add(p->position, off), rays) ||
                                 is_enclosed(s, stp_dvec3_sub(p->position, off), rays));
}

static stp_status ask_points(stp_interior *in, const stp_cloud *cloud, const stp_space *s,
                             stp_error *err)
{
    uint32_t count = 0, within = 0, given = 0, facing = 0;
    double area = 0.0, lining = 0.0;
    int at[3];
    stp_dvec3 rays[OUTSIDE_RAYS], few[RAYS_FEW];
    stp_cloud_point *points = NULL;
    const stp_status status =
        stp_cloud_every(cloud, cloud->count / POINTS + 1, &points, &count, err);
    if (status != STP_OK)
        return status;
    for (int i = 0; i < OUTSIDE_RAYS; i++)
        rays[i] = stp_space_direction(i, OUTSIDE_RAYS);
    for (int i = 0; i < RAYS_FEW; i++)
        few[i] = stp_space_direction(i, RAYS_FEW);
    for (const stp_cloud_point *p = points; p < points + count; p++) {
        const stp_dvec3 d = stp_dvec3_sub(p->position, in->eye);
        within += is_within(s, p->position, rays);
        const bool inside = stp_space_voxel(s, p->position, at);
        const unsigned there = inside ? s->count[stp_space_at(s, at[0], at[1], at[2])] : 0;
        if (there > 0) { /* a point that does not count may be alone in its voxel */
            const double share = 1.0 / there;
            area += share;
            lining += has_enclosed_side(s, p, few) ? share : 0.0;
        }
        if (!p->given)
            continue;
        const stp_space_hit hit = stp_space_cast(s, in->eye, stp_dvec3_normalize(d));
        if (!hit.solid || fabs(hit.distance - stp_dvec3_length(d)) > 2.0 * s->side)
            continue;
        given++;
        facing += stp_dvec3_dot(d, stp_dvec3_from_float(p->normal)) < 0.0;
    }
    in->within = (double)within / count;
    in->lining = area > 0.0 ? lining / area : 0.0;
    in->facing = given >= GIVEN_LEAST ? (double)facing / given : 0.5;
    free(points);
    return STP_OK;
}

stp_status stp_interior_find(stp_interior *out, const stp_cloud *cloud, const stp_space *s,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_interior in = {.up_axis = find_up(s)};
    const stp_dvec3 size = stp_dvec3_sub(s->box.max, s->box.min);
    in.height = along(size, in.up_axis);
    in.width = fmax(size.x, in.up_axis == 1 ? size.z : size.y);
    /* the middle of corridors about a corner or a court is outside: the eye may stand anywhere, if
     * nearly all there is is within */
    stp_interior elsewhere = in;
    if (!find_eye(&in, s, MIDDLE_PART) && find_eye(&elsewhere, s, 0.5)) {
        in = elsewhere;
        in.aside = true;
    }
    look_around(&in, s);
    STP_TRY(ask_points(&in, cloud, s, err));
    const bool lined = in.lining >= LINING_LEAST;
    const bool built = lined && in.level >= LEVEL_LEAST && in.upright >= UPRIGHT_LEAST &&
                       (in.within >= WITHIN_LEAST || in.height <= FLAT_MOST * in.width);
    in.found = (!in.aside || lined) && in.room >= ROOM_LEAST * in.height && in.room > 0.0 &&
               in.enclosed >= ENCLOSED_LEAST && in.facing > 1.0 - AGREED &&
               (built || in.facing >= AGREED);
    *out = in;
done:
    return status;
}

/* A level direction. */
static stp_dvec3 level_direction(int up_axis, double angle)
{
    return up_axis == 1 ? (stp_dvec3){cos(angle), 0.0, sin(angle)}
                        : (stp_dvec3){cos(angle), sin(angle), 0.0};
}

/* The sum of free distances in a fan around a level direction. */
static double free_way(const stp_interior *in, const stp_space *s, double angle)
{
    double sum = 0.0;
    for (int i = 0; i < FAN_RAYS; i++) {
        const double turned = angle + FAN_RAD * (2.0 * i / (FAN_RAYS - 1) - 1.0);
        const stp_space_hit hit = stp_space_cast(s, in->eye, level_direction(in->up_axis, turned));
        sum += hit.solid ? hit.distance : 0.5 * hit.distance; /* nothing to see there */
    }
    return sum;
}

stp_first_camera stp_interior_camera(const stp_interior *in, const stp_space *s)
{
    double best = -1.0, angle = 0.0;
    const stp_dvec3 up = {0.0, in->up_axis == 1, in->up_axis == 2};
    for (int i = 0; i < FANS; i++) {
        const double way = free_way(in, s, 2.0 * PI * i / FANS);
        if (way > best) {
            best = way;
            angle = 2.0 * PI * i / FANS;
        }
    }
    const stp_dvec3 forward = stp_dvec3_normalize(
        stp_dvec3_sub(level_direction(in->up_axis, angle), stp_dvec3_scale(up, TILT)));
    const double distance = stp_space_cast(s, in->eye, forward).distance;
    return (stp_first_camera){
        .why = STP_FIRST_INTERIOR,
        .eye = in->eye,
        .look = stp_dvec3_add(in->eye, stp_dvec3_scale(forward, fmax(distance, s->side))),
        .up = up,
        .fovy_deg = FOVY_DEG,
        .aspect = 1.0};
}

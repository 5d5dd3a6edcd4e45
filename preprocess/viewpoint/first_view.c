/* First cameras: at stations, within interiors. */
#include "preprocess/viewpoint/first_view.h"

#include "base/earth.h"
#include "base/memory.h"
#include "base/sort.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/viewpoint/broad_side.h"
#include "preprocess/viewpoint/interior.h"
#include "preprocess/viewpoint/main_part.h"
#include "preprocess/viewpoint/up_axis.h"

#include <math.h>
#include <stdlib.h>

#define PI 3.14159265358979323846
#define DEGREES (PI / 180.0)
/* RAYS: rays that are examined. LEFT_OUT: share of them that may lie beyond each edge of a view. If
 * more than 4 LEFT_OUT have less than NARROW_COSINE to their mean direction, the rays go all
 * around. */
#define RAYS 16384u
#define LEFT_OUT 0.002
#define NARROW_COSINE 0.4
/* Greatest extent of a cloud, so that nothing overflows. */
#define EXTENT_MOST 1e100
#define FOVY_LEAST_DEG 1.0
#define FOVY_MOST_DEG 110.0
/* For rays that go all around: sectors about up, and the steepest view. */
#define SECTORS 36
#define STEEPEST_RAD 0.35
#define AROUND_FOVY_DEG 70.0
/* Steps from a part to a part of it. SLACK: so much more than the main part is shown, for it is
 * without a hundredth at each end. */
#define MAIN_STEPS 4
#define MAIN_SLACK 1.1
#define MAIN_FOVY_DEG 45.0
/* With noise that its class tells, the model is so many times as wide: the others are shown. */
#define NOISE_TIMES 1.25
/* A broad side is seen from so far to the right and above, in parts of the way off it. */
#define SIDE_RIGHT 0.35
#define SIDE_ABOVE 0.2

/* Unit rays from the eye to some of a station's points or, if box is not NULL, of those in it.
 * Free with free(). */
static stp_status rays_of(stp_dvec3 **out, uint32_t *count, const stp_cloud *cloud,
                          uint16_t station, const stp_dbox *box, stp_dvec3 eye, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud_point *points = NULL;
    uint32_t listed = 0;
    STP_TRY(stp_cloud_every(cloud, cloud->count / RAYS + 1, &points, &listed, err));
    STP_TRY(stp_alloc(out, listed, sizeof **out, "rays", err));
    *count = 0;
    for (uint32_t i = 0; i < listed; i++) {
        const stp_dvec3 d = stp_dvec3_sub(points[i].position, eye);
        const bool listed_too = box ? stp_dbox_distance_squared(box, points[i].position) == 0.0
                                    : points[i].station == station;
        if (listed_too && stp_dvec3_length(d) > 0.0)
            (*out)[(*count)++] = stp_dvec3_normalize(d);
    }
done:
    free(points);
    return status;
}

static stp_dvec3 mean_of(const stp_dvec3 *rays, uint32_t count)
{
    stp_dvec3 sum = {0.0, 0.0, 0.0};
    for (uint32_t i = 0; i < count; i++)
        sum = stp_dvec3_add(sum, rays[i]);
    return stp_dvec3_normalize(sum);
}

/* The range of tangents, along an axis across the view, that holds nearly all rays. */
static void spread_along(double out[2], const stp_dvec3 *rays, uint32_t count, stp_dvec3 forward,
                         stp_dvec3 axis, double *room)
{
    for (uint32_t i = 0; i < count; i++)
        room[i] = stp_dvec3_dot(rays[i], axis) / fmax(stp_dvec3_dot(rays[i], forward), 1e-3);
    stp_sort_doubles(room, count);
    const uint32_t left = (uint32_t)(LEFT_OUT * (count - 1));
    out[0] = room[left];
    out[1] = room[count - 1 - left];
}

/* Turns a camera about its eye from the mean ray to the middle of the rays, and opens it to take
 * them in. Errors: OUT_OF_MEMORY. */
static stp_status take_in(stp_first_camera *camera, stp_dvec3 *forward, const stp_dvec3 *rays,
                          uint32_t count, stp_error *err)
{
    double *room = NULL, wide[2], high[2];
    const stp_status status = stp_alloc(&room, count, sizeof *room, "rays", err);
    if (status != STP_OK)
        return status;
    for (int turn = 0; turn < 2; turn++) {
        const stp_dvec3 right = stp_dvec3_normalize(stp_dvec3_cross(*forward, camera->up));
        const stp_dvec3 above = stp_dvec3_cross(right, *forward);
        spread_along(wide, rays, count, *forward, right, room);
        spread_along(high, rays, count, *forward, above, room);
        if (turn == 0)
            *forward = stp_dvec3_normalize(stp_dvec3_add(
                *forward, stp_dvec3_add(stp_dvec3_scale(right, 0.5 * (wide[0] + wide[1])),
                                        stp_dvec3_scale(above, 0.5 * (high[0] + high[1])))));
    }
    free(room);
    const double half = fmax(fabs(high[0]), fabs(high[1]));
    camera->fovy_deg = fmin(fmax(2.0 * atan(half) / DEGREES, FOVY_LEAST_DEG), FOVY_MOST_DEG);
    camera->aspect = fmax(fabs(wide[0]), fabs(wide[1])) / tan(0.5 * camera->fovy_deg * DEGREES);
    return STP_OK;
}

static bool is_narrow(const stp_dvec3 *rays, uint32_t count, stp_dvec3 mean)
{
    uint32_t within = 0;
    for (uint32_t i = 0; i < count; i++)
        within += stp_dvec3_dot(rays[i], mean) > NARROW_COSINE;
    return within >= (1.0 - 4.0 * LEFT_OUT) * count;
}

/* The wanted up direction; another axis if it is nearly parallel to forward. */
static stp_dvec3 up_across(stp_dvec3 forward, stp_dvec3 wanted)
{
    if (fabs(stp_dvec3_dot(forward, wanted)) > 0.99)
        wanted = fabs(forward.z) < 0.9 ? (stp_dvec3){0.0, 0.0, 1.0} : (stp_dvec3){0.0, 1.0, 0.0};
    return wanted;
}

/* Distance to the surface along the view. If there is none, the distance to the middle of the ray's
 * way through the box. */
static double distance_along(const stp_space *s, stp_dvec3 eye, stp_dvec3 forward)
{
    double d = 0.0, before = INFINITY;
    for (;;) { /* approach the grid in steps that cannot pass it */
        const stp_dvec3 at = stp_dvec3_add(eye, stp_dvec3_scale(forward, d));
        const double away = sqrt(stp_dbox_distance_squared(&s->box, at));
        if (!(away > 0.5 * s->side && away < before))
            break;
        before = away;
        d += away;
    }
    const stp_space_hit hit =
        stp_space_cast(s, stp_dvec3_add(eye, stp_dvec3_scale(forward, d)), forward);
    return fmax(d + (hit.solid ? hit.distance : 0.5 * hit.distance), s->side);
}

/* The level direction with the most voxels of surface around it, weighted by the squared cosine;
 * then tilted to the mean height of these voxels. */
static stp_dvec3 largest_surface(const stp_space *s, stp_dvec3 eye, stp_dvec3 up)
{
    double area[SECTORS] = {0.0}, height[SECTORS] = {0.0}, best = -1.0, angle = 0.0, slope = 0.0;
    const stp_dvec3 other =
        fabs(up.x) < 0.9 ? (stp_dvec3){1.0, 0.0, 0.0} : (stp_dvec3){0.0, 1.0, 0.0};
    const stp_dvec3 b = stp_dvec3_normalize(stp_dvec3_cross(up, other));
    const stp_dvec3 a = stp_dvec3_cross(b, up);
    for (int z = 0; z < s->size[2]; z++)
        for (int y = 0; y < s->size[1]; y++)
            for (int x = 0; x < s->size[0]; x++) {
                if (s->count[stp_space_at(s, x, y, z)] == 0)
                    continue;
                const stp_dvec3 d = stp_dvec3_sub(stp_space_middle(s, x, y, z), eye);
                const double turn = atan2(stp_dvec3_dot(d, b), stp_dvec3_dot(d, a)) / (2.0 * PI);
                const int sector = (int)floor((turn + 1.0) * SECTORS) % SECTORS;
                area[sector] += 1.0;
                height[sector] +=
                    atan2(stp_dvec3_dot(d, up), hypot(stp_dvec3_dot(d, a), stp_dvec3_dot(d, b)));
            }
    for (int middle = 0; middle < SECTORS; middle++) {
        double sum = 0.0, heights = 0.0;
        for (int i = 0; i < SECTORS; i++) {
            const double cosine = cos(2.0 * PI * (i - middle) / SECTORS);
            const double weight = cosine > 0.0 ? cosine * cosine : 0.0;
            sum += weight * area[i];
            heights += weight * height[i];
        }
        if (sum > best) {
            best = sum;
            angle = 2.0 * PI * (middle + 0.5) / SECTORS;
            slope = sum > 0.0 ? fmin(fmax(heights / sum, -STEEPEST_RAD), STEEPEST_RAD) : 0.0;
        }
    }
    const stp_dvec3 level =
        stp_dvec3_add(stp_dvec3_scale(a, cos(angle)), stp_dvec3_scale(b, sin(angle)));
    return stp_dvec3_add(stp_dvec3_scale(level, cos(slope)), stp_dvec3_scale(up, sin(slope)));
}

/* Guesses the up axis of a station that does not tell it: z if z is the height; else against y, if
 * rays go along z as in a depth camera's own axes, where y points down; else by the box's shape. */
static stp_dvec3 guess_up(const stp_space *s, bool heights, stp_dvec3 mean, stp_station_word word)
{
    if (heights)
        return (stp_dvec3){0.0, 0.0, 1.0};
    if (word != STP_STATION_TOLD && mean.z > 0.8)
        return (stp_dvec3){0.0, -1.0, 0.0};
    if (word == STP_STATION_GUESSED) /* as OpenGL has it, or a lidar */
        return mean.z < -0.8 ? (stp_dvec3){0.0, 1.0, 0.0} : (stp_dvec3){0.0, 0.0, 1.0};
    return stp_dbox_up(&s->box);
}

static stp_status view_from_station(stp_first_camera *out, const stp_cloud *cloud,
                                    const stp_prep_source *source, uint16_t station, stp_error *err)
{
    stp_status status = STP_OK;
    stp_space space = {0};
    stp_dvec3 *rays = NULL;
    uint32_t count = 0;
    stp_station_word word = STP_STATION_TOLD;
    const stp_dvec3 eye = source->stations[station - 1];
    const stp_dvec3 earth = stp_dbox_earth_up(&cloud->box);
    stp_dvec3 up =
        source->station_ups ? source->station_ups[station - 1] : (stp_dvec3){0.0, 0.0, 0.0};
    for (size_t f = 0; f < source->file_count; f++)
        if (station - 1u - source->files[f].station_begin < source->files[f].station_count)
            word = source->files[f].station_word;
    STP_TRY(stp_space_create(&space, cloud, station, NULL, err));
    STP_TRY(rays_of(&rays, &count, cloud, station, NULL, eye, err));
    if (count == 0)
        goto done;
    const stp_dvec3 mean = mean_of(rays, count);
    const bool narrow = is_narrow(rays, count, mean);
    if (stp_dvec3_length(up) == 0.0)
        up = earth;
    if (stp_dvec3_length(up) > 0.0)
        up = stp_dvec3_normalize(up);
    else
        up = narrow ? guess_up(&space, source->heights, mean, word) : (stp_dvec3){0.0, 0.0, 1.0};
    stp_first_camera camera = {
        .why = STP_FIRST_SCANNER, .eye = eye, .aspect = 1.0, .fovy_deg = AROUND_FOVY_DEG};
    stp_dvec3 forward = narrow ? mean : largest_surface(&space, eye, up);
    camera.up = up_across(forward, up);
    camera.model_up = word == STP_STATION_GUESSED ? up : earth;
    if (narrow)
        STP_TRY(take_in(&camera, &forward, rays, count, err));
    camera.look =
        stp_dvec3_add(eye, stp_dvec3_scale(forward, distance_along(&space, eye, forward)));
    *out = camera;
done:
    free(rays);
    stp_space_clear(&space);
    return status;
}

/* Finds the first station that still has a point; 0 if there is none. */
static stp_status first_station(const stp_cloud *cloud, uint32_t station_count, uint16_t *out,
                                stp_error *err)
{
    stp_status status = STP_OK;
    const stp_rank_part own = stp_cloud_own(cloud);
    uint64_t *counts = NULL; /* of points by station: at most 65,535 */
    *out = 0;
    STP_TRY(stp_alloc(&counts, station_count, sizeof *counts, "stations", err));
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i)) {
        const uint16_t station = cloud->points[i].station;
        if (station > 0 && station <= station_count)
            counts[station - 1]++;
    }
    STP_TRY(stp_cloud_sum(cloud, counts, station_count, err));
    for (uint32_t i = station_count; i-- > 0;)
        *out = counts[i] > 0 ? (uint16_t)(i + 1) : *out;
done:
    free(counts);
    return status;
}

/* What is up if the file or its coordinates say it, else zero. */
static stp_dvec3 told_up(const stp_cloud *cloud, const stp_prep_source *source)
{
    const stp_dvec3 earth = stp_dbox_earth_up(&cloud->box);
    if (stp_dvec3_length(earth) > 0.0)
        return earth;
    return stp_dbox_is_map(&cloud->box) ? (stp_dvec3){0.0, 0.0, 1.0} : stp_prep_told_up(source);
}

/* What is up, where the format says nothing; zero: the box tells it. */
static stp_status up_of(stp_dvec3 *out, const stp_cloud *cloud, const stp_space *s,
                        const stp_interior *interior, const stp_prep_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    bool down = false;
    *out = stp_dbox_earth_up(&cloud->box);
    if (stp_dvec3_length(told_up(cloud, source)) > 0.0 || stp_dbox_is_map(&s->box))
        return STP_OK;
    if (!interior->found && stp_dbox_up(&s->box).z > 0.0)
        STP_TRY(stp_faces_along_z(&down, cloud, err));
    if (down) {
        *out = (stp_dvec3){0.0, -1.0, 0.0};
    } else if (interior->found) {
        const double y = source->y_likely_down ? -1.0 : 1.0;
        *out = (stp_dvec3){0.0, interior->up_axis == 1 ? y : 0.0, interior->up_axis == 2};
    } else if (stp_dbox_up(&s->box).z == 0.0) {
        STP_TRY(stp_up_is_against_y(&down, cloud, s, err));
        const bool z = stp_up_is_z(s);
        down = down || source->y_likely_down;
        *out = (stp_dvec3){0.0, down && !z ? -1.0 : 0.0, z};
    }
done:
    return status;
}

static double diagonal(const stp_dbox *box)
{
    return stp_dvec3_length(stp_dvec3_sub(box->max, box->min));
}

/* Shows the box of the main part as the whole model would be shown. */
static stp_first_camera view_of_main(const stp_dbox *box, stp_dvec3 model_up,
                                     const stp_prep_source *source)
{
    stp_dvec3 up = model_up;
    if (stp_dvec3_length(up) == 0.0)
        up = stp_prep_told_up(source);
    if (stp_dvec3_length(up) == 0.0)
        up = stp_dbox_is_map(box) ? (stp_dvec3){0.0, 0.0, 1.0} : stp_dbox_up(box);
    const stp_dvec3 look = stp_dbox_middle(box);
    const double radius = 0.5 * MAIN_SLACK * diagonal(box);
    const stp_dvec3 away = stp_dvec3_scale(stp_dvec3_normalize(stp_whole_direction_over(up)),
                                           radius / sin(0.5 * MAIN_FOVY_DEG * DEGREES));
    return (stp_first_camera){.eye = stp_dvec3_add(look, away),
                              .look = look,
                              .up = up,
                              .fovy_deg = MAIN_FOVY_DEG,
                              .aspect = 1.0};
}

/* Shows a flat thing from its broad side, a little from the right and from above, as large as the
 * picture allows. */
static stp_status view_of_side(stp_first_camera *out, const stp_cloud *cloud,
                               const stp_space *space, const stp_broad_side *side, stp_error *err)
{
    stp_status status = STP_OK;
    stp_dvec3 *rays = NULL;
    uint32_t count = 0;
    const stp_dvec3 middle = stp_dbox_middle(&space->box);
    const stp_dvec3 right = stp_dvec3_normalize(stp_dvec3_cross(side->up, side->normal));
    const stp_dvec3 away = stp_dvec3_normalize(
        stp_dvec3_add(side->normal, stp_dvec3_add(stp_dvec3_scale(right, SIDE_RIGHT),
                                                  stp_dvec3_scale(side->up, SIDE_ABOVE))));
    const double radius = 0.5 * diagonal(&space->box);
    stp_first_camera camera = {
        .up = side->up,
        .eye = stp_dvec3_add(middle,
                             stp_dvec3_scale(away, radius / sin(0.5 * MAIN_FOVY_DEG * DEGREES)))};
    stp_dvec3 forward = stp_dvec3_scale(away, -1.0);
    STP_TRY(rays_of(&rays, &count, cloud, 0, &space->box, camera.eye, err));
    STP_TRY(take_in(&camera, &forward, rays, count, err));
    camera.fovy_deg = 2.0 * atan(MAIN_SLACK * tan(0.5 * camera.fovy_deg * DEGREES)) / DEGREES;
    camera.look = stp_dvec3_add(
        camera.eye, stp_dvec3_scale(forward, distance_along(space, camera.eye, forward)));
    *out = camera;
done:
    free(rays);
    return status;
}

/* The free space of all points or, if parts stand out, of the one that has the most. *why: what it
 * is. */
static stp_status find_main(stp_space *out, stp_first_why *why, const stp_cloud *cloud,
                            stp_error *err)
{
    stp_status status = STP_OK;
    stp_space next = {0};
    stp_main_part part = {.share = 1.0};
    *why = STP_FIRST_WHOLE;
    STP_TRY(stp_space_create(out, cloud, 0, NULL, err));
    part.box = out->box;
    if (stp_main_part_stands_out(&part, &cloud->box) ||
        (out->lacks_noise && diagonal(&cloud->box) > NOISE_TIMES * diagonal(&out->all)))
        *why = STP_FIRST_MAIN;
    for (int i = 0; i < MAIN_STEPS; i++) {
        STP_TRY(stp_main_part_find(&part, out, err));
        if (!stp_main_part_is_small(&part, &cloud->box))
            break;
        STP_TRY(stp_space_create(&next, cloud, 0, &part.box, err));
        part.box = next.box; /* finer than voxels */
        if (!stp_main_part_stands_out(&part, &cloud->box))
            break;
        stp_space_clear(out);
        *out = next;
        next = (stp_space){0};
        if (*why != STP_FIRST_PART)
            *why = part.share < STP_MAIN_NEARLY_ALL ? STP_FIRST_PART : STP_FIRST_MAIN;
    }
done:
    stp_space_clear(&next);
    return status;
}

stp_status stp_first_view_of_points(stp_first_camera *out, const stp_cloud *cloud,
                                    const stp_prep_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    stp_space space = {0};
    if (out->why != STP_FIRST_WHOLE || !(stp_dbox_side(&cloud->box) < EXTENT_MOST))
        return STP_OK;
    uint16_t station = 0;
    if (source->stations && source->station_count > 0)
        STP_TRY(first_station(cloud, source->station_count, &station, err));
    if (station > 0)
        return view_from_station(out, cloud, source, station, err);
    stp_first_why why;
    STP_TRY(find_main(&space, &why, cloud, err));
    stp_interior interior;
    STP_TRY(stp_interior_find(&interior, cloud, &space, err));
    stp_broad_side side;
    const stp_dvec3 told = told_up(cloud, source);
    stp_dvec3 up;
    interior.found = interior.found && stp_dvec3_length(stp_dbox_earth_up(&cloud->box)) == 0.0;
    STP_TRY(up_of(&up, cloud, &space, &interior, source, err));
    const bool down = up.y < 0.0 && stp_dbox_up(&space.box).z > 0.0; /* by normals along z */
    STP_TRY(stp_broad_side_find(&side, cloud, &space.box, down ? up : told, err));
    if (interior.found) {
        *out = stp_interior_camera(&interior, &space);
        if ((told.y < 0.0 || up.y < 0.0) && interior.up_axis == 1)
            out->up = (stp_dvec3){0.0, -1.0, 0.0};
    } else if (side.found) {
        STP_TRY(view_of_side(out, cloud, &space, &side, err));
        up = stp_dvec3_length(told) > 0.0 ? up : side.up;
        why = why == STP_FIRST_WHOLE ? STP_FIRST_SIDE : why;
    } else if (why != STP_FIRST_WHOLE)
        *out = view_of_main(&space.box, up, source);
    out->why = interior.found ? STP_FIRST_INTERIOR : why;
    out->model_up = up;
done:
    stp_space_clear(&space);
    return status;
}

void stp_first_view_of_heights(stp_first_camera *out, const stp_dbox *all, double low, double high,
                               double share, const stp_prep_source *source)
{
    const stp_dvec3 none = {0.0, 0.0, 0.0};
    stp_main_part part = {
        .box = *all, .points = share * (double)source->point_count, .share = share};
    part.box.min.z = low;
    part.box.max.z = high;
    if (!(stp_dbox_side(all) < EXTENT_MOST) || !stp_main_part_stands_out(&part, all))
        return;
    *out = view_of_main(&part.box, none, source);
    out->why = share < STP_MAIN_NEARLY_ALL ? STP_FIRST_PART : STP_FIRST_MAIN;
}

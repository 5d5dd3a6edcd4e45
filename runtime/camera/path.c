/* Makes paths and answers questions about them: keyframes around a time, turntables, frames. */
#include "runtime/camera/path.h"

#include "base/vec.h"

#include "base/memory.h"
#include "runtime/camera/path_curve.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846
#define DEGREES (PI / 180.0)
#define ELEVATION_LIMIT_DEG 89.0
/* The part of a frame by which rounding may shorten a film. */
#define FRAME_SLACK 1e-6
/* Between keyframes a camera may swing out; within this limit its view stays valid. */
#define REACH_LIMIT 1e16
/* A share of the coordinates. If the eye is nearer to the point it looks at, rounding turns its
 * direction. */
#define NEAREST 1e-12
#define TIME_LIMIT_S 1e9
#define TIME_STEP_S 1e-6

struct stp_path {
    stp_keyframe *keys; /* a loop has the first once more at the end */
    stp_curve_knot *knots;
    size_t count; /* of keys and knots; 0: a turntable */
    bool loop;
    stp_turntable turntable;
    stp_camera start; /* of a turntable */
};

/* Checks a camera by stp_view_create, with some ball and size. */
static stp_status check_camera(const stp_camera *camera, const char *name, stp_error *err)
{
    stp_view view;
    stp_error reason = {0};
    const double reach = fmax(stp_dvec3_reach(camera->eye), stp_dvec3_reach(camera->look));
    const double distance = stp_dvec3_length(stp_dvec3_sub(camera->eye, camera->look));
    if (stp_view_create(&view, camera, &(stp_ball){.radius = 1.0}, 1, 1, &reason) != STP_OK)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "%s: %.400s", name, reason.message);
    if (reach > REACH_LIMIT)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: its eye or look is %g away, and %g is the farthest of a path",
                             name, reach, REACH_LIMIT);
    if (distance < NEAREST * reach)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: its eye is %g from where it looks, too near for coordinates of "
                             "%g: move one of them",
                             name, distance, reach);
    return STP_OK;
}

static stp_status check_keyframe(const stp_path_params *params, size_t i, stp_error *err)
{
    const stp_keyframe *key = &params->keyframes[i];
    char name[64];
    snprintf(name, sizeof name, "keyframe %zu", i + 1);
    if (!(fabs(key->time_s) <= TIME_LIMIT_S))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: its time is not a number of seconds from -%g to %g", name,
                             TIME_LIMIT_S, TIME_LIMIT_S);
    if (i > 0 && !(key->time_s - params->keyframes[i - 1].time_s >= TIME_STEP_S))
        return stp_error_set(
            err, STP_INVALID_ARGUMENT,
            "%s: its time, %.10g s, is not %g s or more after %.10g s, that of the "
            "one before: give times that rise",
            name, key->time_s, TIME_STEP_S, params->keyframes[i - 1].time_s);
    if ((key->camera.height > 0.0) != (params->keyframes[0].camera.height > 0.0))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: perspective and orthographic keyframes do not mix: give all of "
                             "them fovy_deg, or all height",
                             name);
    return check_camera(&key->camera, name, err);
}

static stp_status check_params(const stp_path_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    if (params->count == 0)
        return stp_error_set(err, STP_EMPTY, "a path without keyframes: give one at least");
    if (params->count > STP_PATH_KEYFRAMES_LIMIT)
        return stp_error_set(err, STP_LIMIT, "%zu keyframes are more than %u", params->count,
                             STP_PATH_KEYFRAMES_LIMIT);
    for (size_t i = 0; i < params->count; i++)
        STP_TRY(check_keyframe(params, i, err));
    double span = params->keyframes[params->count - 1].time_s - params->keyframes[0].time_s;
    if (params->loop && params->loop_s != 0.0 &&
        !(params->loop_s - span >= TIME_STEP_S && params->loop_s <= TIME_LIMIT_S))
        status = stp_error_set(err, STP_INVALID_ARGUMENT,
                               "a loop of %.10g s ends before its last keyframe, at %.10g s, or "
                               "is longer than %g s",
                               params->loop_s, span, TIME_LIMIT_S);
done:
    return status;
}

/* Appends the first keyframe at the end of the way back, unless the last keyframe repeats it. */
static void close_loop(stp_path *path, const stp_path_params *params)
{
    stp_keyframe *keys = path->keys;
    size_t last = params->count - 1;
    double span = keys[last].time_s - keys[0].time_s;
    double loop_s = params->loop_s;
    if (loop_s == 0.0 && stp_camera_equal(&keys[0].camera, &keys[last].camera))
        return;
    if (loop_s == 0.0)
        loop_s = span + span / (double)last;
    keys[path->count] = keys[0];
    keys[path->count++].time_s = keys[0].time_s + loop_s;
}

stp_status stp_path_create(stp_path **out, const stp_path_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_path *path = NULL;
    STP_TRY(check_params(params, err));
    STP_TRY(stp_alloc(&path, 1, sizeof *path, "a path", err));
    STP_TRY(stp_alloc(&path->keys, params->count + 1, sizeof *path->keys, "keyframes", err));
    STP_TRY(stp_alloc(&path->knots, params->count + 1, sizeof *path->knots, "keyframes", err));
    memcpy(path->keys, params->keyframes, params->count * sizeof *path->keys);
    path->count = params->count;
    path->loop = params->loop && params->count > 1;
    if (path->loop)
        close_loop(path, params);
    for (size_t i = 0; i < path->count; i++)
        path->knots[i] = stp_curve_knot_from_camera(&path->keys[i].camera, path->keys[i].time_s);
    stp_curve_set_speeds(path->knots, path->count, path->loop);
    *out = path;
    path = NULL;
done:
    stp_path_destroy(&path);
    return status;
}

/* Raises the eye above the point it looks at. */
static void set_elevation(stp_camera *camera, double elevation_deg)
{
    stp_dvec3 up = stp_dvec3_normalize(camera->up);
    stp_dvec3 offset = stp_dvec3_sub(camera->eye, camera->look);
    stp_dvec3 level = stp_dvec3_sub(offset, stp_dvec3_scale(up, stp_dvec3_dot(offset, up)));
    double distance = stp_dvec3_length(offset), angle = elevation_deg * DEGREES;
    level = stp_dvec3_normalize(level);
    offset = stp_dvec3_add(stp_dvec3_scale(level, distance * cos(angle)),
                           stp_dvec3_scale(up, distance * sin(angle)));
    camera->eye = stp_dvec3_add(camera->look, offset);
}

stp_status stp_path_create_turntable(stp_path **out, const stp_turntable *turntable,
                                     const stp_camera *start, stp_error *err)
{
    stp_status status = STP_OK;
    stp_path *path = NULL;
    stp_turntable t = *turntable;
    if (!(t.seconds > 0.0 && isfinite(t.seconds)))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "a turntable of %g seconds: give more than 0", t.seconds);
    if (!isfinite(t.degrees))
        return stp_error_set(err, STP_INVALID_ARGUMENT, "a turntable's degrees are not a number");
    if (t.has_elevation && !(fabs(t.elevation_deg) <= ELEVATION_LIMIT_DEG))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "a turntable's elevation of %g degrees is not within -%g to %g",
                             t.elevation_deg, ELEVATION_LIMIT_DEG, ELEVATION_LIMIT_DEG);
    STP_TRY(check_camera(start, "the turntable's camera", err));
    STP_TRY(stp_alloc(&path, 1, sizeof *path, "a path", err));
    t.degrees = t.degrees != 0.0 ? t.degrees : 360.0;
    path->turntable = t;
    path->start = *start;
    path->loop = fmod(t.degrees, 360.0) == 0.0;
    if (t.has_elevation)
        set_elevation(&path->start, t.elevation_deg);
    *out = path;
done:
    return status;
}

void stp_path_destroy(stp_path **path)
{
    if (*path == NULL)
        return;
    free((*path)->keys);
    free((*path)->knots);
    free(*path);
    *path = NULL;
}

double stp_path_begin_s(const stp_path *path)
{
    return path->count > 0 ? path->keys[0].time_s : 0.0;
}

double stp_path_duration_s(const stp_path *path)
{
    return path->count > 0 ? path->keys[path->count - 1].time_s - path->keys[0].time_s
                           : path->turntable.seconds;
}

static stp_camera turntable_camera(const stp_path *path, double time_s)
{
    const stp_turntable *t = &path->turntable;
    stp_camera camera = path->start;
    double part = time_s / t->seconds;
    part = path->loop ? part - floor(part) : fmin(fmax(part, 0.0), 1.0);
    if (part > 0.0)
        camera.eye =
            stp_dvec3_add(camera.look, stp_dvec3_rotate(stp_dvec3_sub(camera.eye, camera.look),
                                                        stp_dvec3_normalize(camera.up),
                                                        part * t->degrees * DEGREES));
    return camera;
}

/* The last keyframe at or before a time, which is not before keys[0]. */
static size_t find_key(const stp_path *path, double time_s)
{
    size_t low = 0, high = path->count;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (path->keys[middle].time_s <= time_s)
            low = middle;
        else
            high = middle;
    }
    return low;
}

stp_camera stp_path_camera(const stp_path *path, double time_s)
{
    double begin = stp_path_begin_s(path), duration = stp_path_duration_s(path);
    if (path->count == 0)
        return turntable_camera(path, time_s);
    if (path->loop && !(time_s >= begin && time_s < begin + duration))
        time_s -= duration * floor((time_s - begin) / duration);
    if (!(time_s > begin))
        return path->keys[0].camera;
    size_t i = find_key(path, time_s);
    if (i + 1 == path->count || path->keys[i].time_s == time_s)
        return path->keys[i].camera;
    return stp_curve_camera(&path->knots[i], &path->knots[i + 1], time_s);
}

stp_status stp_path_frame_count(const stp_path *path, double rate, uint64_t *count, stp_error *err)
{
    if (!(rate > 0.0 && isfinite(rate)))
        return stp_error_set(err, STP_INVALID_ARGUMENT, "%g frames a second: give a number above 0",
                             rate);
    double frames = stp_path_duration_s(path) * rate;
    if (!(frames < (double)STP_PATH_FRAMES_LIMIT - 1.0))
        return stp_error_set(err, STP_LIMIT, "a film of %.6g frames is too long: the limit is %u",
                             frames, STP_PATH_FRAMES_LIMIT);
    frames = path->loop ? fmax(1.0, floor(frames + 0.5)) : ceil(frames - FRAME_SLACK) + 1.0;
    *count = (uint64_t)frames;
    return STP_OK;
}

stp_camera stp_path_frame(const stp_path *path, double rate, uint64_t count, uint64_t index)
{
    double passed = path->loop ? stp_path_duration_s(path) * ((double)index / (double)count)
                               : (double)index / rate;
    return stp_path_camera(path, stp_path_begin_s(path) + passed);
}

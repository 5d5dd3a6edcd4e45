/* Recorded paths with an even pace. */
#include "tools/view/kept/view_smooth.h"

#include "base/memory.h"
#include "base/vec.h"

#include <math.h>
#include <stdlib.h>

/* Speeds are measured in ticks, of a length that keeps their number and so the time bounded. */
#define TICK_S 0.004
#define TICKS_MOST 200000.0
/* Half the width of the bell. */
#define BELL_S 1.0
/* Between two keyframes of the result. */
#define STEP_S 0.1

static const double pi = 3.14159265358979323846;

/* The way of a path by time: way[i] at i ticks. A length is one where the eye moves by its distance
 * from what it looks at, or turns by a radian. */
typedef struct pace {
    const stp_path *path;
    double begin_s, duration_s;
    size_t ticks; /* way and even have one more */
    double *way, *even;
} pace;

static double way_between(const stp_camera *a, const stp_camera *b)
{
    const stp_dvec3 from = stp_dvec3_sub(a->look, a->eye), to = stp_dvec3_sub(b->look, b->eye);
    const double distance = stp_dvec3_length(from);
    const stp_dvec3 turned = stp_dvec3_sub(stp_dvec3_normalize(to), stp_dvec3_normalize(from));
    const double zoomed = a->height > 0.0
                              ? log(b->height / a->height)
                              : log(tan(b->fovy_deg * pi / 360.0) / tan(a->fovy_deg * pi / 360.0));
    return stp_dvec3_length(stp_dvec3_sub(b->eye, a->eye)) / distance + stp_dvec3_length(turned) +
           fabs(log(stp_dvec3_length(to) / distance)) + fabs(zoomed) +
           stp_dvec3_length(stp_dvec3_sub(stp_dvec3_normalize(b->up), stp_dvec3_normalize(a->up)));
}

static void measure(pace *p)
{
    stp_camera last = stp_path_camera(p->path, p->begin_s);
    p->way[0] = 0.0;
    for (size_t i = 1; i <= p->ticks; i++) {
        const double time_s = p->begin_s + p->duration_s * (double)i / (double)p->ticks;
        const stp_camera camera = stp_path_camera(p->path, time_s);
        p->way[i] = p->way[i - 1] + way_between(&last, &camera);
        last = camera;
    }
}

/* The speed in a tick; beyond the ends the path is mirrored, so that the sum of speeds stays. */
static double speed_at(const pace *p, long tick)
{
    const long ticks = (long)p->ticks;
    while (tick < 0 || tick >= ticks)
        tick = tick < 0 ? -1 - tick : 2 * ticks - 1 - tick;
    return p->way[tick + 1] - p->way[tick];
}

/* Averages the way's speed by a bell. */
static stp_status even_out(pace *p, stp_error *err)
{
    const double tick_s = p->duration_s / (double)p->ticks;
    const int half = (int)ceil(BELL_S / tick_s);
    double *weights = NULL, sum = 0.0;
    stp_status status =
        stp_alloc(&weights, (size_t)(2 * half + 1), sizeof *weights, "keyframes", err);
    if (status != STP_OK)
        return status;
    for (int k = -half; k <= half; k++)
        sum += weights[k + half] = 1.0 + cos(pi * k / (half + 1));
    p->even[0] = 0.0;
    for (long i = 0; i < (long)p->ticks; i++) {
        double speed = 0.0;
        for (int k = -half; k <= half; k++)
            speed += weights[k + half] * speed_at(p, i + k);
        p->even[i + 1] = p->even[i] + speed / sum;
    }
    free(weights);
    return STP_OK;
}

/* The time, as a part of the duration, at which the path has come as far as the even pace comes at
 * `part`. */
static double time_of(const pace *p, double part)
{
    const double at = part * (double)p->ticks;
    const size_t i = (size_t)fmin(at, (double)p->ticks - 1.0);
    const double way = p->even[i] + (at - (double)i) * (p->even[i + 1] - p->even[i]);
    size_t low = 0, high = p->ticks;
    while (high - low > 1) {
        const size_t middle = (low + high) / 2;
        *(p->way[middle] < way ? &low : &high) = middle;
    }
    const double step = p->way[high] - p->way[low];
    const double inside = step > 0.0 ? (way - p->way[low]) / step : 0.0;
    return ((double)low + fmin(fmax(inside, 0.0), 1.0)) / (double)p->ticks;
}

/* Time of the even pace when `time_s` of the eased film have passed: in the first 2 ease_s the pace
 * rises from 0 to 1, t²/(4 ease_s), and in the last it falls. */
static double eased(double time_s, double duration_s, double ease_s)
{
    const double left_s = duration_s + 2.0 * ease_s - time_s;
    if (time_s < 2.0 * ease_s)
        return time_s * time_s / (4.0 * ease_s);
    if (left_s < 2.0 * ease_s)
        return duration_s - left_s * left_s / (4.0 * ease_s);
    return time_s - ease_s;
}

static stp_status resample(const pace *p, stp_keyframe **out, size_t *out_count, stp_error *err)
{
    const double ease_s = fmin(VIEW_SMOOTH_EASE_S, 0.25 * p->duration_s);
    const double length_s = p->duration_s + 2.0 * ease_s;
    const double most = (double)(STP_PATH_KEYFRAMES_LIMIT - 1);
    const size_t steps = (size_t)fmin(ceil(length_s / STEP_S), most);
    stp_status status = stp_alloc(out, steps + 1, sizeof **out, "keyframes", err);
    for (size_t i = 0; status == STP_OK && i <= steps; i++) {
        const double time_s = length_s * (double)i / (double)steps;
        const double part = eased(time_s, p->duration_s, ease_s) / p->duration_s;
        const double at = p->begin_s + p->duration_s * time_of(p, part);
        (*out)[i] = (stp_keyframe){time_s, stp_path_camera(p->path, at)};
    }
    if (status == STP_OK)
        *out_count = steps + 1;
    return status;
}

static stp_status copy_first(stp_keyframe **out, size_t *out_count, const stp_keyframe *frame,
                             stp_error *err)
{
    stp_status status = stp_alloc(out, 1, sizeof **out, "keyframes", err);
    if (status == STP_OK) {
        **out = (stp_keyframe){0.0, frame->camera};
        *out_count = 1;
    }
    return status;
}

stp_status view_smooth(stp_keyframe **out, size_t *out_count, const stp_keyframe *frames,
                       size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_path *path = NULL;
    pace p = {0};
    while (count > 1 && stp_camera_equal(&frames[0].camera, &frames[1].camera)) {
        frames++;
        count--;
    }
    while (count > 1 && stp_camera_equal(&frames[count - 1].camera, &frames[count - 2].camera))
        count--;
    if (count == 1)
        return copy_first(out, out_count, frames, err);
    STP_TRY(stp_path_create(&path, &(stp_path_params){.keyframes = frames, .count = count}, err));
    p = (pace){
        .path = path, .begin_s = stp_path_begin_s(path), .duration_s = stp_path_duration_s(path)};
    p.ticks = (size_t)fmin(ceil(p.duration_s / TICK_S), TICKS_MOST);
    STP_TRY(stp_alloc(&p.way, p.ticks + 1, sizeof *p.way, "keyframes", err));
    STP_TRY(stp_alloc(&p.even, p.ticks + 1, sizeof *p.even, "keyframes", err));
    measure(&p);
    STP_TRY(even_out(&p, err));
    STP_TRY(resample(&p, out, out_count, err));
done:
    free(p.way);
    free(p.even);
    stp_path_destroy(&path);
    return status;
}

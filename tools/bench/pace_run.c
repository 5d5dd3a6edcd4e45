/* Flies once around the model in eight seconds, nearer and farther. */
#include "tools/bench/pace_run.h"

#include "base/clock.h"
#include "base/memory.h"
#include "base/vec.h"
#include "runtime/camera/pace.h"
#include "runtime/cut/model.h"
#include "tools/bench/median.h"

#include <math.h>
#include <stdlib.h>
#include <time.h>

#define SETTLE_S 2.0
#define ROUND_S 8.0
#define FRAMES_LIMIT 100000
#define BARE_FRAMES 5

static stp_status view_at(const pace_run_params *p, double time_s, stp_view *out, stp_error *err)
{
    double turn = 6.283185307 * time_s / ROUND_S;
    stp_ball ball = stp_model_ball(p->model);
    stp_dvec3 up = stp_camera_up(&p->model->info->box), side = {1.0, 0.0, 0.0};
    stp_dvec3 across = stp_dvec3_normalize(stp_dvec3_cross(up, side));
    stp_dvec3 direction =
        stp_dvec3_add(stp_dvec3_scale(side, cos(turn)), stp_dvec3_scale(across, sin(turn)));
    direction = stp_dvec3_add(direction, stp_dvec3_scale(up, 0.4));
    stp_camera c =
        stp_camera_around(&ball, direction, up, STP_CAMERA_FOVY_DEG, p->width, p->height);
    double near = 0.8 + 0.3 * sin(2.0 * turn);
    c.eye = stp_dvec3_add(c.look, stp_dvec3_scale(stp_dvec3_sub(c.eye, c.look), near));
    return stp_view_create(out, &c, &ball, p->width, p->height, err);
}

static void sleep_until(double time_s)
{
    double left = time_s - stp_clock_seconds();
    if (left > 0.0)
        nanosleep(&(struct timespec){(time_t)left, (long)(1e9 * (left - floor(left)))}, NULL);
}

/* Measures the part of a frame's cost that no threshold of the pace reduces. */
static stp_status measure_bare(const pace_run_params *p, double *out, stp_error *err)
{
    double ms[BARE_FRAMES];
    for (int i = 0; i < BARE_FRAMES; i++) {
        stp_draw_params params = {.threshold_px = STP_PACE_THRESHOLD_MOST_PX, .stream = true};
        stp_draw_stats stats;
        stp_view view;
        stp_status status = view_at(p, 0.1 * i, &view, err);
        if (status == STP_OK)
            status = stp_renderer_draw(p->renderer, &view, &params, &stats, err);
        if (status != STP_OK)
            return status;
        ms[i] = stats.frame_ms;
    }
    *out = bench_median(ms, BARE_FRAMES);
    return STP_OK;
}

stp_status pace_run(const pace_run_params *p, pace_run_result *out, stp_error *err)
{
    stp_status status = STP_OK;
    double *ms = NULL, *px = NULL, *scales = NULL;
    size_t count = 0;
    stp_pace pace = {0};
    stp_pace_ask(&pace, p->fps, 1.0);
    STP_TRY(stp_alloc(&ms, FRAMES_LIMIT, sizeof *ms, "times", err));
    STP_TRY(stp_alloc(&px, FRAMES_LIMIT, sizeof *px, "times", err));
    STP_TRY(stp_alloc(&scales, FRAMES_LIMIT, sizeof *scales, "times", err));
    STP_TRY(measure_bare(p, &out->bare_ms, err));
    double begun = stp_clock_seconds(), due = begun, first = begun, now = begun;
    while (now - begun < SETTLE_S + p->seconds && count < FRAMES_LIMIT) {
        stp_draw_params params = {.threshold_px = pace.threshold_px, .stream = true};
        stp_draw_stats stats;
        stp_view view;
        STP_TRY(view_at(p, now - begun, &view, err));
        view = stp_view_scaled(&view, pace.scale);
        STP_TRY(stp_renderer_draw(p->renderer, &view, &params, &stats, err));
        bool measured = now - begun >= SETTLE_S;
        first = measured && count == 0 ? now : first;
        ms[count] = stats.frame_ms;
        px[count] = params.threshold_px;
        scales[count] = pace.scale;
        count += measured;
        stp_pace_follow(&pace, stats.frame_ms, stats.points_drawn);
        due = fmax(due + 1.0 / p->fps, stp_clock_seconds());
        sleep_until(due);
        now = stp_clock_seconds();
    }
    out->fps = (double)count / (now - first);
    out->frame_ms = bench_median(ms, count);
    out->threshold_px = bench_median(px, count);
    out->scale = bench_median(scales, count);
    out->holds = stp_pace_holds(&pace);
done:
    free(ms);
    free(px);
    free(scales);
    return status;
}

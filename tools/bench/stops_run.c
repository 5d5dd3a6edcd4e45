/* Makes six stops on a ring, so near that each needs chunks of its own. */
#include "tools/bench/stops_run.h"

#include "base/clock.h"

#include <math.h>

/* Distances from the model's centre, in its radius: of the eye, and of the point looked at. */
#define EYE_DISTANCE 1.1
#define LOOK_DISTANCE 0.5
#define HEIGHT 0.4

static stp_dvec3 place(const stp_ball *ball, int stop, double distance)
{
    double angle = 2.0 * M_PI * stop / STOPS_RUN_COUNT;
    const stp_dvec3 offset = {cos(angle) * distance * ball->radius,
                              sin(angle) * distance * ball->radius,
                              HEIGHT * distance * ball->radius};
    return stp_dvec3_add(ball->centre, offset);
}

stp_status stops_run(stp_renderer *renderer, const stp_model *model, const int size[2],
                     stops_run_result *out, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_draw_params params = {.threshold_px = 1.0};
    for (int i = 0; i < STOPS_RUN_COUNT; i++) {
        stp_view view;
        stp_draw_stats stats;
        stp_camera camera = stp_camera_default(&model->info->box, &model->ball, size[0], size[1]);
        camera.eye = place(&model->ball, i, EYE_DISTANCE);
        camera.look = place(&model->ball, i, LOOK_DISTANCE);
        camera.up = (stp_dvec3){0.0, 0.0, 1.0};
        STP_TRY(stp_view_create(&view, &camera, &model->ball, size[0], size[1], err));
        double *const times[2] = {&out->cold_ms[i], &out->warm_ms[i]};
        for (int k = 0; k < 2; k++) {
            double begun = stp_clock_seconds();
            STP_TRY(stp_renderer_draw(renderer, &view, &params, &stats, err));
            *times[k] = 1000.0 * (stp_clock_seconds() - begun);
        }
    }
done:
    return status;
}

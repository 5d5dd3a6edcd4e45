/* Balls and cameras for exaggerated heights. */
#include "tools/draw/draw_exaggerate.h"

#include "base/vec.h"

#include <math.h>

void draw_exaggerate_set(stp_draw_params *params, double times, const stp_dbox *box)
{
    params->exaggerate = times == 1.0 ? 0.0 : times;
    params->exaggerate_about = 0.5 * (box->min.z + box->max.z);
}

stp_dbox draw_exaggerate_box(const stp_draw_params *params, const stp_dbox *box)
{
    return (stp_dbox){stp_exaggerated(params, box->min), stp_exaggerated(params, box->max)};
}

stp_ball draw_exaggerate_ball(const stp_draw_params *params, const stp_ball *ball,
                              const stp_dbox *box)
{
    const stp_dbox drawn = draw_exaggerate_box(params, box);
    const stp_ball tight = stp_ball_from_box(&drawn), loose = stp_exaggerated_ball(params, ball);
    if (params->exaggerate == 0.0)
        return *ball;
    return tight.radius < loose.radius ? tight : loose;
}

void draw_exaggerate_camera(const stp_draw_params *params, const stp_draw_params *before,
                            stp_camera *camera)
{
    const stp_dvec3 is = before ? stp_unexaggerated(before, camera->look) : camera->look;
    const double rise = stp_exaggerated(params, is).z - camera->look.z; /* 0 if nothing changed */
    camera->look.z += rise;
    camera->eye.z += rise;
}

/* What lies under a pixel of the view. */
#include "tools/view/view_control.h"

/* Depth to assume where nothing was drawn: the model's centre from outside, what the camera looks
 * at from within. */
static double empty_depth(const view_control *c)
{
    double centre = stp_dvec3_dot(stp_dvec3_sub(c->view.eye, c->ball.centre), c->view.back);
    return centre > c->ball.radius ? centre
                                   : stp_dvec3_length(stp_dvec3_sub(c->camera.eye, c->camera.look));
}

stp_dvec3 view_control_point(const view_control *c, double x, double y, double *depth)
{
    *depth = c->depth(c->context, (int)floor(x), (int)floor(y));
    if (!(*depth > 0.0))
        *depth = empty_depth(c);
    return stp_view_unproject(&c->view, x, y, *depth);
}

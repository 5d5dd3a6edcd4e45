/* Cameras and the views derived from them. */
#include "runtime/camera/camera.h"

#include "base/earth.h"

/* The near plane lies this fraction of the ball's radius in front of the eye: so little that a
 * stray point at 0 0 0 of a survey leaves its rooms visible. Depths are floats of near / depth,
 * whose precision does not depend on it. */
#define NEAR_FRACTION (1e-5 / 1024.0)
/* Greatest distance of an eye: enough for any model that a file holds, from anywhere around it. */
#define REACH_LIMIT 1e17
#define HEIGHT_LIMIT 1e20
#define FOCAL_LIMIT_PX 1e9
#define DEGREES (3.14159265358979323846 / 180.0)

stp_ball stp_ball_from_box(const stp_dbox *box)
{
    stp_dvec3 centre = stp_dvec3_scale(stp_dvec3_add(box->min, box->max), 0.5);
    double radius = 0.5 * stp_dvec3_length(stp_dvec3_sub(box->max, box->min));
    double least = 1e-9 * stp_dvec3_length(centre);
    if (!(radius > least))
        radius = least > 0.0 ? least : 1.0;
    return (stp_ball){centre, radius};
}

void stp_view_set_ball(stp_view *view, const stp_ball *ball)
{
    double distance = stp_dvec3_dot(stp_dvec3_sub(view->eye, ball->centre), view->back);
    view->near_depth = NEAR_FRACTION * ball->radius;
    view->ball_near = fmax(view->near_depth, distance - ball->radius);
    view->ball_far = fmax(2.0 * view->near_depth, distance + ball->radius);
}

stp_status stp_view_create(stp_view *out, const stp_camera *camera, const stp_ball *ball, int width,
                           int height, stp_error *err)
{
    if (!stp_dvec3_finite(camera->eye) || !stp_dvec3_finite(camera->look) ||
        !stp_dvec3_finite(camera->up))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "the camera's eye, look or up is not finite: give three numbers each");
    const double reach = fmax(stp_dvec3_reach(camera->eye), stp_dvec3_reach(camera->look));
    if (reach > REACH_LIMIT)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "the camera's eye or look is %g away, and %g is the farthest", reach,
                             REACH_LIMIT);
    bool orthographic = camera->height > 0.0;
    if (!orthographic && !(camera->fovy_deg > 0.0 && camera->fovy_deg < 180.0))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "the camera's angle of %g degrees is not between 0 and 180",
                             camera->fovy_deg);
    if (width < 1 || height < 1)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "a picture of %d x %d pixels is empty",
                             width, height);
    const double f = orthographic ? height / camera->height
                                  : height / (2.0 * tan(0.5 * camera->fovy_deg * DEGREES));
    if (orthographic ? !(camera->height >= 1.0 / HEIGHT_LIMIT && camera->height <= HEIGHT_LIMIT)
                     : !(f <= FOCAL_LIMIT_PX))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "the camera shows too little or too much: give another %s than %g",
                             orthographic ? "height" : "angle",
                             orthographic ? camera->height : camera->fovy_deg);
    stp_dvec3 back = stp_dvec3_normalize(stp_dvec3_sub(camera->eye, camera->look));
    if (stp_dvec3_length(back) == 0.0)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "the camera's eye is where it looks: move one of them");
    stp_dvec3 right = stp_dvec3_cross(stp_dvec3_normalize(camera->up), back);
    if (stp_dvec3_length(right) < 1e-9)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "the camera's up points along its view: give another --up");
    right = stp_dvec3_normalize(right);
    *out = (stp_view){
        .eye = camera->eye,
        .right = right,
        .up = stp_dvec3_cross(back, right),
        .back = back,
        .f = f,
        .width = width,
        .height = height,
        .orthographic = orthographic,
    };
    stp_view_set_ball(out, ball);
    return STP_OK;
}

stp_dvec3 stp_camera_up(const stp_dbox *box)
{
    return stp_dbox_up(box);
}

stp_camera stp_camera_around(const stp_ball *ball, stp_dvec3 direction, stp_dvec3 up,
                             double fovy_deg, int width, int height)
{
    direction = stp_dvec3_normalize(direction);
    if (fabs(stp_dvec3_dot(direction, up)) > 0.999)
        up = fabs(direction.z) < 0.9 ? (stp_dvec3){0.0, 0.0, 1.0} : (stp_dvec3){0.0, 1.0, 0.0};
    double half = 0.5 * fovy_deg * DEGREES;
    if (width < height)
        half = atan(tan(half) * width / height);
    double distance = ball->radius / sin(half);
    return (stp_camera){
        .eye = stp_dvec3_add(ball->centre, stp_dvec3_scale(direction, distance)),
        .look = ball->centre,
        .up = up,
        .fovy_deg = fovy_deg,
    };
}

stp_camera stp_camera_whole(const stp_ball *ball, stp_dvec3 up, int width, int height)
{
    return stp_camera_around(ball, stp_whole_direction_over(up), up, STP_CAMERA_FOVY_DEG, width,
                             height);
}

stp_camera stp_camera_default(const stp_dbox *box, const stp_ball *ball, int width, int height)
{
    stp_dvec3 up = stp_dbox_is_map(box) ? (stp_dvec3){0.0, 0.0, 1.0} : stp_camera_up(box);
    return stp_camera_whole(ball, up, width, height);
}

stp_camera stp_camera_widened(const stp_camera *camera, double aspect, int width, int height)
{
    stp_camera out = *camera;
    const double narrower = aspect * height / width;
    if (narrower > 1.0) {
        out.height *= narrower;
        out.fovy_deg = 2.0 * atan(tan(0.5 * camera->fovy_deg * DEGREES) * narrower) / DEGREES;
    }
    return out;
}

bool stp_camera_equal(const stp_camera *a, const stp_camera *b)
{
    return stp_dvec3_equal(a->eye, b->eye) && stp_dvec3_equal(a->look, b->look) &&
           stp_dvec3_equal(a->up, b->up) && a->fovy_deg == b->fovy_deg && a->height == b->height;
}

stp_view stp_view_scaled(const stp_view *view, double times)
{
    stp_view scaled = *view;
    scaled.width = (int)fmax(round(times * view->width), 1.0);
    scaled.height = (int)fmax(round(times * view->height), 1.0);
    scaled.f *= times;
    scaled.offset[0] *= times;
    scaled.offset[1] *= times;
    return scaled;
}

stp_view stp_view_part(const stp_view *view, int x, int y, int width, int height)
{
    stp_view part = *view;
    part.width = width;
    part.height = height;
    part.offset[0] = stp_view_axis_x(view) - x - 0.5 * width;
    part.offset[1] = stp_view_axis_y(view) - y - 0.5 * height;
    return part;
}

stp_dvec3 stp_view_project(const stp_view *view, stp_dvec3 position)
{
    stp_dvec3 p = stp_dvec3_sub(position, view->eye);
    double depth = -stp_dvec3_dot(view->back, p);
    double scale = view->orthographic ? view->f : view->f / depth;
    return (stp_dvec3){stp_view_axis_x(view) + scale * stp_dvec3_dot(view->right, p),
                       stp_view_axis_y(view) + scale * stp_dvec3_dot(view->up, p), depth};
}

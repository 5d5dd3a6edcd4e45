/* Turns, shifts and scales a camera. */
#include "runtime/camera/orbit.h"

#define PI 3.14159265358979323846
#define DEGREES (PI / 180.0)

typedef struct axes {
    stp_dvec3 right, up, back;
} axes;

static axes camera_axes(const stp_camera *c)
{
    axes a;
    a.back = stp_dvec3_normalize(stp_dvec3_sub(c->eye, c->look));
    a.right = stp_dvec3_normalize(stp_dvec3_cross(c->up, a.back));
    a.up = stp_dvec3_cross(a.back, a.right);
    return a;
}

static stp_dvec3 add_scaled(stp_dvec3 a, stp_dvec3 b, double s)
{
    return stp_dvec3_add(a, stp_dvec3_scale(b, s));
}

static void rotate_about(stp_camera *c, stp_dvec3 pivot, stp_dvec3 axis, double angle)
{
    c->eye = stp_dvec3_add(pivot, stp_dvec3_rotate(stp_dvec3_sub(c->eye, pivot), axis, angle));
    c->look = stp_dvec3_add(pivot, stp_dvec3_rotate(stp_dvec3_sub(c->look, pivot), axis, angle));
}

stp_dvec3 stp_view_unproject(const stp_view *view, double u, double v, double depth)
{
    double scale = view->orthographic ? 1.0 / view->f : depth / view->f;
    stp_dvec3 p = add_scaled(view->eye, view->right, (u - stp_view_axis_x(view)) * scale);
    p = add_scaled(p, view->up, (v - stp_view_axis_y(view)) * scale);
    return add_scaled(p, view->back, -depth);
}

void stp_camera_turn(stp_camera *camera, stp_dvec3 pivot, double yaw_rad, double pitch_rad)
{
    stp_dvec3 up = stp_dvec3_normalize(camera->up);
    rotate_about(camera, pivot, up, -yaw_rad);
    axes a = camera_axes(camera);
    /* Angle between `back` and the up axis; pitching the eye up lowers it. */
    double from_pole = acos(fmin(fmax(stp_dvec3_dot(a.back, up), -1.0), 1.0));
    double wanted = from_pole - pitch_rad;
    wanted = fmin(fmax(wanted, STP_ORBIT_POLE_RAD), PI - STP_ORBIT_POLE_RAD);
    rotate_about(camera, pivot, a.right, wanted - from_pole);
}

void stp_camera_pan(stp_camera *camera, double depth, double dx, double dy, int height)
{
    axes a = camera_axes(camera);
    double unit = camera->height > 0.0
                      ? camera->height / height
                      : 2.0 * depth * tan(0.5 * camera->fovy_deg * DEGREES) / height;
    stp_dvec3 shift =
        stp_dvec3_add(stp_dvec3_scale(a.right, -dx * unit), stp_dvec3_scale(a.up, -dy * unit));
    camera->eye = stp_dvec3_add(camera->eye, shift);
    camera->look = stp_dvec3_add(camera->look, shift);
}

static void zoom_orthographic(stp_camera *camera, const stp_ball *ball, stp_dvec3 point,
                              double factor)
{
    axes a = camera_axes(camera);
    double height = fmin(fmax(camera->height * factor, STP_ORBIT_NEAREST * ball->radius),
                         STP_ORBIT_FARTHEST * ball->radius);
    stp_dvec3 to_point = stp_dvec3_sub(point, camera->eye);
    to_point = add_scaled(to_point, a.back, -stp_dvec3_dot(to_point, a.back));
    stp_dvec3 shift = stp_dvec3_scale(to_point, 1.0 - height / camera->height);
    camera->eye = stp_dvec3_add(camera->eye, shift);
    camera->look = stp_dvec3_add(camera->look, shift);
    camera->height = height;
}

void stp_camera_zoom(stp_camera *camera, const stp_ball *ball, stp_dvec3 point, double factor)
{
    if (camera->height > 0.0) {
        zoom_orthographic(camera, ball, point, factor);
        return;
    }
    double distance = stp_dvec3_length(stp_dvec3_sub(camera->eye, point));
    double nearest = STP_ORBIT_NEAREST * ball->radius;
    double wanted = fmax(distance * factor, fmin(distance, nearest));
    double from_ball = stp_dvec3_length(stp_dvec3_sub(camera->eye, ball->centre));
    if (!(distance > 0.0) || (factor > 1.0 && from_ball > STP_ORBIT_FARTHEST * ball->radius))
        return;
    double scale = wanted / distance;
    camera->eye = add_scaled(point, stp_dvec3_sub(camera->eye, point), scale);
    camera->look = add_scaled(point, stp_dvec3_sub(camera->look, point), scale);
}

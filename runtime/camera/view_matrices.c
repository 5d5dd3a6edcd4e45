/* Makes views from the matrices of host applications. */
#include "base/vec.h"
#include "runtime/camera/camera.h"

/* Pixels by which a picture's edge may be off. Rounding of matrices in float is far less. */
#define TOLERANCE_PX 0.02
/* Tolerance for the axes of a rotation, times their lengths: more than float's rounding. */
#define TOLERANCE_AXES 1e-5

static bool all_finite(const double m[16])
{
    for (int i = 0; i < 16; i++)
        if (!isfinite(m[i]))
            return false;
    return true;
}

/* Takes eye and axes from model_view; *scale: lengths of the host divided by the model's. */
static stp_status take_model_view(stp_view *view, const double m[16], double *scale, stp_error *err)
{
    stp_dvec3 right = {m[0], m[4], m[8]}, up = {m[1], m[5], m[9]}, back = {m[2], m[6], m[10]};
    double s = stp_dvec3_length(back), most = TOLERANCE_AXES * s * s;
    if (m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0 || m[15] != 1.0)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "model_view's last row is %g %g %g %g, not 0 0 0 1: give the "
                             "projection apart, and matrices columns first",
                             m[3], m[7], m[11], m[15]);
    if (!(s > 0.0) || fabs(stp_dvec3_dot(right, up)) > most ||
        fabs(stp_dvec3_dot(up, back)) > most || fabs(stp_dvec3_dot(back, right)) > most ||
        fabs(stp_dvec3_dot(right, right) - s * s) > 2.0 * most ||
        fabs(stp_dvec3_dot(up, up) - s * s) > 2.0 * most)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "model_view shears, or scales its axes differently: it may turn, "
                             "shift and scale all alike");
    if (stp_dvec3_dot(stp_dvec3_cross(right, up), back) < 0.0)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "model_view mirrors: it may turn, shift and scale all alike");
    view->back = stp_dvec3_normalize(back);
    view->up = stp_dvec3_normalize(stp_dvec3_cross(view->back, right));
    view->right = stp_dvec3_cross(view->up, view->back);
    stp_dvec3 eye = stp_dvec3_scale(view->right, -m[12] / s);
    eye = stp_dvec3_add(eye, stp_dvec3_scale(view->up, -m[13] / s));
    view->eye = stp_dvec3_add(eye, stp_dvec3_scale(view->back, -m[14] / s));
    *scale = s;
    return STP_OK;
}

/* Checks that the projection is perspective or orthographic and nothing else. */
static stp_status check_kind(const double p[16], bool perspective, stp_error *err)
{
    static const int none[2][9] = {{1, 2, 3, 4, 6, 7, 8, 9, 11}, {1, 2, 3, 4, 6, 7, 12, 13, 15}};
    double w = perspective ? -p[11] : p[15];
    for (int i = 0; i < 9; i++)
        if (p[none[perspective][i]] != 0.0)
            return stp_error_set(err, STP_INVALID_ARGUMENT,
                                 "projection is neither perspective nor orthographic: its element "
                                 "%d is %g, not 0",
                                 none[perspective][i], p[none[perspective][i]]);
    if (!(w > 0.0))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "projection looks along +z: give one of OpenGL's, which looks along "
                             "-z");
    if (!(p[0] > 0.0 && p[5] > 0.0) || p[perspective ? 14 : 10] == 0.0)
        return stp_error_set(
            err, STP_INVALID_ARGUMENT,
            "projection mirrors or flattens: x and y grow to the right and up, and "
            "depth tells near from far");
    return STP_OK;
}

/* Takes f and ndc, in lengths of the model, from projection. */
static stp_status take_projection(stp_view *view, const double p[16], double scale, stp_error *err)
{
    bool perspective = p[11] != 0.0;
    stp_status status = check_kind(p, perspective, err);
    if (status != STP_OK)
        return status;
    double w = perspective ? -p[11] : p[15]; /* clip w is: perspective w * depth, orthographic w */
    double half[2] = {0.5 * view->width, 0.5 * view->height};
    const double *middle = perspective ? p + 8 : p + 12;
    double x = half[0] * p[0] / w, y = half[1] * p[5] / w;
    if (fabs(half[0] * middle[0] / w) > TOLERANCE_PX ||
        fabs(half[1] * middle[1] / w) > TOLERANCE_PX)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "projection has its axis %.3g, %.3g pixels off the middle: give a "
                             "centred one, without jitter",
                             half[0] * middle[0] / w, half[1] * middle[1] / w);
    if (fabs(x / y - 1.0) * half[0] > TOLERANCE_PX)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "projection's pixels are not square: it is made for %.6g times as "
                             "wide as high, the viewport is %d x %d",
                             p[5] / p[0], view->width, view->height);
    view->orthographic = !perspective;
    view->f = perspective ? y : y * scale;
    view->ndc[0] = perspective ? -p[10] / w : p[14] / w;
    view->ndc[1] = perspective ? p[14] / (w * scale) : -p[10] * scale / w;
    return STP_OK;
}

stp_status stp_view_from_matrices(stp_view *out, const double model_view[16],
                                  const double projection[16], const stp_ball *ball, int width,
                                  int height, stp_error *err)
{
    stp_status status = STP_OK;
    double scale = 1.0;
    stp_view view = {.width = width, .height = height};
    if (width < 1 || height < 1)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "a picture of %d x %d pixels is empty",
                             width, height);
    if (!all_finite(model_view) || !all_finite(projection))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s has an element that is not finite: give 16 finite numbers",
                             all_finite(model_view) ? "projection" : "model_view");
    STP_TRY(take_model_view(&view, model_view, &scale, err));
    STP_TRY(take_projection(&view, projection, scale, err));
    double distance = stp_dvec3_dot(stp_dvec3_sub(view.eye, ball->centre), view.back);
    double behind = 2.0 * ball->radius - distance;
    if (view.orthographic && behind > 0.0) {
        view.eye = stp_dvec3_add(view.eye, stp_dvec3_scale(view.back, behind));
        view.ndc[0] -= view.ndc[1] * behind;
    }
    stp_view_set_ball(&view, ball);
    *out = view;
done:
    return status;
}

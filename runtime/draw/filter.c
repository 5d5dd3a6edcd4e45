/* Writes clip box, hidden classes, overlay, light, contours and eye-dome lighting to the frame. */
#include "runtime/draw/filter.h"

#include <float.h>
#include <string.h>

/* The light from the eye beside the one that moves with the camera ("Shading" in
 * shaders/README.md). */
#define EYE_LIGHT 0.4f
/* Every fifth contour is wider (shaders/shade/contour.glsl). */
#define CONTOURS_MARKED 5.0

static stp_status check_planes(const stp_draw_params *params, stp_error *err)
{
    if (params->plane_count > STP_PLANES_LIMIT)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "%u planes to clip by: give at most %d",
                             params->plane_count, STP_PLANES_LIMIT);
    for (unsigned i = 0; i < params->plane_count; i++) {
        const stp_plane *p = &params->planes[i];
        const double length = stp_dvec3_length(p->normal);
        if (!(length > 0.0) || !isfinite(length) || !isfinite(p->offset))
            return stp_error_set(err, STP_INVALID_ARGUMENT,
                                 "plane %u with normal %g,%g,%g and offset %g: give a direction, "
                                 "all finite",
                                 i + 1, p->normal.x, p->normal.y, p->normal.z, p->offset);
    }
    return STP_OK;
}

stp_status stp_filter_check(const stp_draw_params *params, stp_error *err)
{
    const stp_dbox *box = &params->clip.box;
    if (params->clip.enabled && stp_dbox_is_empty(box))
        return stp_error_set(
            err, STP_INVALID_ARGUMENT,
            "the clip box from %.9g,%.9g,%.9g to %.9g,%.9g,%.9g is inverted or not "
            "a number: give the least corner first",
            box->min.x, box->min.y, box->min.z, box->max.x, box->max.y, box->max.z);
    stp_status planes = check_planes(params, err);
    if (planes != STP_OK)
        return planes;
    if (!(params->overlay >= 0.0 && params->overlay <= 1.0))
        return stp_error_set(err, STP_INVALID_ARGUMENT, "an overlay of %g is not between 0 and 1",
                             params->overlay);
    if (!(params->edl >= 0.0) || !isfinite(params->edl))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "a strength of %g for eye-dome lighting is negative or not a number",
                             params->edl);
    if (!(params->contour_step >= 0.0) || !isfinite(params->contour_step) ||
        !isfinite(params->contour_base))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "contours every %g from %g: give a positive step, both finite",
                             params->contour_step, params->contour_base);
    if (!(params->exaggerate == 0.0 || (params->exaggerate >= STP_EXAGGERATE_LEAST &&
                                        params->exaggerate <= STP_EXAGGERATE_MOST)) ||
        !isfinite(params->exaggerate_about))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "heights %g times as high about %g: give %g to %g times, and a finite "
                             "height",
                             params->exaggerate, params->exaggerate_about, STP_EXAGGERATE_LEAST,
                             STP_EXAGGERATE_MOST);
    const double *l = params->light;
    if (!isfinite(l[0] * l[0] + l[1] * l[1] + l[2] * l[2]))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "a light from %g,%g,%g: give three finite numbers, not too large",
                             l[0], l[1], l[2]);
    if (!(params->fade >= 0.0 && params->fade < 1.0))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%g of a level change cannot fade: give 0 or more, but less than 1",
                             params->fade);
    return STP_OK;
}

/* The coordinate as a finite float, however far away it is. */
static float clamped(double x)
{
    return (float)stp_max((double)-FLT_MAX, stp_min((double)FLT_MAX, x));
}

static void set_corner(float out[4], stp_dvec3 corner, const stp_dvec3 *eye)
{
    out[0] = clamped(corner.x - eye->x);
    out[1] = clamped(corner.y - eye->y);
    out[2] = clamped(corner.z - eye->z);
    out[3] = 0.0f;
}

static void set_plane(float out[4], const stp_plane *plane, const stp_dvec3 *eye)
{
    const double length = stp_dvec3_length(plane->normal);
    const stp_dvec3 n = stp_dvec3_scale(plane->normal, 1.0 / length);
    out[0] = (float)n.x;
    out[1] = (float)n.y;
    out[2] = (float)n.z;
    out[3] = clamped(stp_dvec3_dot(n, *eye) - plane->offset / length);
}

/* The light that moves with the camera, in eye space. */
static vec3s camera_light(stp_shade shade)
{
    return shade == STP_SHADE_LAMBERT ? (vec3s){{0.0f, 0.0f, 1.0f}}
                                      : glms_vec3_normalize((vec3s){{0.35f, 0.45f, 1.0f}});
}

static double along(const float axis[4], stp_dvec3 v)
{
    return (double)axis[0] * v.x + (double)axis[1] * v.y + (double)axis[2] * v.z;
}

static void set_light(stp_gpu_frame *frame, const stp_draw_params *params)
{
    stp_dvec3 world =
        stp_dvec3_normalize((stp_dvec3){params->light[0], params->light[1], params->light[2]});
    world.z /= (double)frame->centre[2]; /* the light shines on the world as drawn */
    const bool fixed = world.x != 0.0 || world.y != 0.0 || world.z != 0.0;
    const vec3s own = camera_light(params->shade);
    frame->light[0] = fixed ? (float)along(frame->axis_right, world) : own.x;
    frame->light[1] = fixed ? (float)along(frame->axis_up, world) : own.y;
    frame->light[2] = fixed ? (float)along(frame->axis_back, world) : own.z;
    frame->clip_min[3] = fixed ? 0.0f : EYE_LIGHT; /* a light that stands still casts its shade */
}

void stp_filter_place(stp_gpu_frame *frame, const stp_draw_params *params, const stp_dvec3 *eye)
{
    frame->modes[2] = params->clip.enabled;
    if (params->clip.enabled) {
        set_corner(frame->clip_min, params->clip.box.min, eye);
        set_corner(frame->clip_max, params->clip.box.max, eye);
    }
    for (unsigned i = 0; i < params->plane_count; i++)
        set_plane(frame->planes[i], &params->planes[i], eye);
    frame->light[3] = (float)params->plane_count;
    memcpy(frame->hidden, params->hidden_classes, sizeof frame->hidden);
    frame->colour_range[2] = (float)params->overlay;
    frame->colour_range[3] = (float)params->edl;
    set_light(frame, params);
    frame->terms[2] = (float)params->contour_step;
    if (params->contour_step > 0.0)
        frame->terms[3] =
            (float)remainder(eye->z - params->contour_base, CONTOURS_MARKED * params->contour_step);
}

bool stp_filter_hides_classes(const stp_draw_params *params)
{
    for (int i = 0; i < STP_CLASS_WORDS; i++)
        if (params->hidden_classes[i] != 0)
            return true;
    return false;
}

bool stp_filter_has_overlay(const stp_draw_params *params)
{
    return params->overlay > 0.0 && params->shade >= STP_SHADE_LEVEL;
}

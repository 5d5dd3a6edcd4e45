/* Casts rays at the bumpy sphere. */
#include "tools/gen/truth.h"

#include "base/memory.h"

#include <stdlib.h>

typedef struct picture {
    const gen_surface *surface;
    const stp_view *view;
    stp_image *image;
} picture;

stp_camera gen_truth_camera(const gen_surface *surface, const int size[2])
{
    stp_ball ball = {surface->centre, surface->radius};
    return stp_camera_around(&ball, (stp_dvec3){0.0, 0.0, 1.0}, (stp_dvec3){0.0, 1.0, 0.0},
                             STP_CAMERA_FOVY_DEG, size[0], size[1]);
}

/* Returns |p| minus the radius in p's direction: positive outside. */
static double outside(const gen_surface *surface, stp_dvec3 p, gen_hit *hit)
{
    surface->project(surface, p, hit);
    return stp_dvec3_length(p) - stp_dvec3_length(hit->position);
}

/* Finds the first root along the ray inside the surface's ball. `outside` changes by at most twice
 * the distance (its slopes are below sqrt(3)), so half its value is a safe step. A safe step never
 * passes a root. A step that has become tiny is at a root. */
static bool cast(const gen_surface *surface, stp_dvec3 eye, stp_dvec3 direction, gen_hit *hit)
{
    double along = -stp_dvec3_dot(eye, direction);
    double gap = stp_dvec3_dot(eye, eye) - along * along;
    double reach = surface->radius * surface->radius - gap;
    if (reach <= 0.0)
        return false;
    double t = fmax(along - sqrt(reach), 0.0), end = along + sqrt(reach);
    while (t < end) {
        double value = outside(surface, stp_dvec3_add(eye, stp_dvec3_scale(direction, t)), hit);
        if (value < 1e-9)
            return true;
        t += fmax(0.5 * value, 1e-9);
    }
    return false;
}

static stp_status render_row(void *context, size_t row, unsigned worker, stp_error *err)
{
    (void)worker;
    (void)err;
    const picture *p = context;
    const stp_view *v = p->view;
    for (int column = 0; column < v->width; column++) {
        double x = ((double)column + 0.5 - 0.5 * (double)v->width) / v->f;
        double y = (0.5 * (double)v->height - ((double)row + 0.5)) / v->f;
        stp_dvec3 aside = stp_dvec3_add(stp_dvec3_scale(v->right, x), stp_dvec3_scale(v->up, y));
        stp_dvec3 ahead = stp_dvec3_scale(v->back, -1.0), eye = v->eye, direction = ahead;
        if (v->orthographic)
            eye = stp_dvec3_add(eye, aside);
        else
            direction = stp_dvec3_normalize(stp_dvec3_add(ahead, aside));
        gen_hit hit;
        uint8_t *pixel = p->image->rgba + 4 * (row * (size_t)v->width + (size_t)column);
        if (!cast(p->surface, eye, direction, &hit))
            continue;
        double facing = stp_dvec3_dot(stp_dvec3_from_float(hit.normal), v->back);
        double light = 0.05 + 0.85 * fmax(0.0, facing);
        for (int i = 0; i < 3; i++)
            pixel[i] = (uint8_t)((double)hit.colour.raw[i] * light * 255.0 + 0.5);
        pixel[3] = 255;
    }
    return STP_OK;
}

stp_status gen_truth_render(stp_image *image, const gen_surface *surface, const stp_view *view,
                            stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    stp_image result = {.width = view->width, .height = view->height};
    picture p = {surface, view, &result};
    STP_TRY(
        stp_alloc(&result.rgba, (size_t)result.width * (size_t)result.height, 4, "pixels", err));
    STP_TRY(stp_pool_run(pool, (size_t)result.height, render_row, &p, err));
    *image = result;
    result.rgba = NULL;
done:
    free(result.rgba);
    return status;
}

/* Shades on the CPU ("Shading" in shaders/README.md). */
#include "tests/support/reference_parts.h"

#include <math.h>
#include <string.h>

static void shade_phong(const reference_pixel *p, stp_dvec3 n, stp_dvec3 v, double out[3])
{
    stp_dvec3 l = stp_dvec3_normalize((stp_dvec3){0.35, 0.45, 1.0});
    stp_dvec3 h = stp_dvec3_normalize(stp_dvec3_add(l, v));
    double lit = fmax(0.0, stp_dvec3_dot(n, l)), facing = fmax(0.0, stp_dvec3_dot(n, v));
    double light = 0.18 + 0.74 * lit + 0.08 * fmax(0.0, n.z) + 0.4 * facing * (1.0 - lit);
    double gloss = 0.16 * pow(fmax(0.0, stp_dvec3_dot(n, h)), 40.0);
    for (int k = 0; k < 3; k++)
        out[k] = p->rgb[k] * light + gloss;
}

/* The normal at right angles to the tangent that is lit most or faces the eye most. */
static stp_dvec3 tube_normal(stp_dvec3 tangent, reference_shade shade, stp_dvec3 v)
{
    stp_dvec3 towards = v;
    if (shade == REFERENCE_PHONG)
        towards = stp_dvec3_normalize((stp_dvec3){0.35, 0.45, 1.0});
    else if (shade == REFERENCE_LAMBERT)
        towards = (stp_dvec3){0.0, 0.0, 1.0};
    stp_dvec3 n = stp_dvec3_sub(towards, stp_dvec3_scale(tangent, stp_dvec3_dot(towards, tangent)));
    return stp_dvec3_length(n) > 1e-6 ? stp_dvec3_normalize(n) : towards;
}

static void shade_pixel(const stp_view *view, const reference_pixel *p, int i, int j,
                        reference_shade shade, double out[3])
{
    stp_dvec3 v = stp_dvec3_scale(reference_ray(view, i + 0.5, j + 0.5), -1.0);
    bool away = reference_two_sided(p) && stp_dvec3_dot(p->normal, v) < 0.0;
    stp_dvec3 n = stp_dvec3_scale(p->normal, away ? -1.0 : 1.0);
    if (reference_is_tube(p))
        n = tube_normal(p->normal, shade, v);
    if (shade == REFERENCE_PHONG) {
        shade_phong(p, n, v, out);
    } else if (shade == REFERENCE_LAMBERT) {
        for (int k = 0; k < 3; k++)
            out[k] = p->rgb[k] * (0.05 + 0.85 * fmax(0.0, n.z));
    } else if (shade == REFERENCE_UNLIT) {
        memcpy(out, p->rgb, sizeof p->rgb);
    } else if (shade == REFERENCE_NORMAL) {
        out[0] = 0.5 * n.x + 0.5;
        out[1] = 0.5 * n.y + 0.5;
        out[2] = 0.5 * n.z + 0.5;
    } else {
        double range = view->ball_far - view->ball_near;
        out[0] = out[1] = out[2] = 1.0 - (p->z_min - view->ball_near) / range;
    }
    for (int k = 0; k < 3; k++)
        out[k] = fmin(fmax(out[k], 0.0), 1.0);
}

void reference_shade_picture(const reference_pyramid *pyramid, reference_shade shade, double *rgba)
{
    const reference_level *level = &pyramid->levels[0];
    for (int j = 0; j < level->height; j++)
        for (int i = 0; i < level->width; i++) {
            const reference_pixel *p = &level->finished[j * level->width + i];
            double *out = rgba + 4 * (j * level->width + i);
            out[0] = out[1] = out[2] = out[3] = 0.0;
            if (p->tag == 0)
                continue;
            shade_pixel(&pyramid->view, p, i, j, shade, out);
            out[3] = 1.0;
        }
}

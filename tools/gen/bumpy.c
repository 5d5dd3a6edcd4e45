/* A sphere whose radius and colours are sums of sines of the direction: analytic everywhere. */
#include "tools/gen/grid.h"

#include <stddef.h>

typedef struct wave {
    double k[3], phase, amplitude;
} wave;

/* Frequencies grow from 2 to 60 radians per radian. Each slope (amplitude times frequency) stays
 * below 0.12, so that the shape is a star without overhangs. */
static const wave waves[] = {
    {{1.4, 1.1, -0.9}, 0.3, 0.0420},     {{-1.8, 2.1, 1.2}, 1.9, 0.0300},
    {{2.9, 0.7, 3.1}, 4.1, 0.0220},      {{0.8, -4.9, 2.2}, 2.7, 0.0160},
    {{-5.1, 3.3, 4.0}, 0.9, 0.0110},     {{7.3, 5.2, -3.6}, 5.3, 0.0080},
    {{-4.1, 9.7, 6.4}, 3.3, 0.0060},     {{11.8, -6.5, 8.8}, 1.1, 0.0044},
    {{-9.4, -15.2, 10.6}, 2.2, 0.0032},  {{21.0, 9.9, 14.7}, 4.8, 0.0024},
    {{-18.3, 26.1, -16.0}, 0.5, 0.0019}, {{31.7, -29.4, 38.2}, 3.9, 0.0014},
};
enum { WAVE_COUNT = sizeof waves / sizeof *waves };

/* Returns the radius in the direction d and its gradient in d, as if d were free in space. */
static double radius(stp_dvec3 d, stp_dvec3 *gradient)
{
    double sum = 1.0;
    stp_dvec3 slope = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < WAVE_COUNT; i++) {
        const wave *w = &waves[i];
        double angle = w->k[0] * d.x + w->k[1] * d.y + w->k[2] * d.z + w->phase;
        double c = w->amplitude * cos(angle);
        sum += w->amplitude * sin(angle);
        slope = stp_dvec3_add(slope, (stp_dvec3){c * w->k[0], c * w->k[1], c * w->k[2]});
    }
    *gradient = slope;
    return sum;
}

static float tint(stp_dvec3 d, double fx, double fy, double fz, double phase)
{
    double wide = sin(fx * d.x + fy * d.y + fz * d.z + phase);
    double fine = sin(5.3 * (fy * d.x + fz * d.y - fx * d.z) + 2.0 * phase);
    return (float)(0.58 + 0.27 * wide + 0.12 * fine);
}

static void bumpy_project(const gen_surface *surface, stp_dvec3 start, gen_hit *hit)
{
    (void)surface;
    stp_dvec3 d = stp_dvec3_normalize(start), g;
    double r = radius(d, &g);
    hit->position = stp_dvec3_scale(d, r);
    /* The gradient of |p| - radius(p / |p|). Its second part is at right angles to d. */
    stp_dvec3 across = stp_dvec3_sub(g, stp_dvec3_scale(d, stp_dvec3_dot(g, d)));
    stp_dvec3 n = stp_dvec3_normalize(stp_dvec3_sub(d, stp_dvec3_scale(across, 1.0 / r)));
    hit->normal = stp_dvec3_to_float(n);
    hit->colour = (vec3s){
        {tint(d, 2.1, 1.3, -1.7, 0.4), tint(d, -1.5, 2.4, 1.1, 2.0), tint(d, 1.2, -0.8, 2.6, 3.7)}};
    hit->class_id = 0;
}

void gen_bumpy_init(gen_surface *surface)
{
    double reach = 1.0;
    for (size_t i = 0; i < WAVE_COUNT; i++)
        reach += waves[i].amplitude;
    surface->closed = true;
    surface->proxy_triangles = 300000;
    surface->mesh_triangles = 2000000;
    surface->radius = reach;
    surface->mesh = gen_star_mesh;
    surface->project = bumpy_project;
}

/* The statue's wings: three layers of feathers fanned about a pivot above each shoulder, and the
 * gilded halo. */
#include "tools/gen/statue.h"

#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

/* The point where the feathers' quills would meet, and the angle between feathers. */
static const float pivot_x = 0.02f, pivot_y = 1.12f, feather_angle = 0.088f;

/* Distances from the pivot, by angle from straight down: of the leading edge, and of the tips. */
static const statue_knot leading[] = {
    {0.05f, 0.70f}, {0.40f, 0.575f}, {0.75f, 0.485f}, {1.02f, 0.440f}, {1.25f, 0.43f}};
static const statue_knot tips[] = {{0.02f, 1.02f}, {0.16f, 1.17f}, {0.34f, 1.40f},
                                   {0.46f, 1.46f}, {0.60f, 1.36f}, {0.80f, 1.02f},
                                   {1.00f, 0.70f}, {1.16f, 0.50f}, {1.25f, 0.40f}};

typedef struct wing_site {
    gen_dual angle, radius;
    gen_dual away;       /* distance from the wing's middle surface, along z */
    gen_dual start, end; /* radii of the leading edge and of the tips */
} wing_site;

typedef struct layer {
    float reach;     /* part of the way from leading edge to tips */
    float thickness; /* half, at a feather's middle */
    float phase;     /* in feathers */
    float scallop;   /* how far tips stand out */
} layer;

static const layer layers[] = {
    {1.00f, 0.0075f, 0.0f, 0.075f}, {0.60f, 0.0150f, 0.5f, 0.050f}, {0.36f, 0.0220f, 0.0f, 0.036f}};

static wing_site wing_at(const gen_dual3 *p)
{
    wing_site site;
    gen_dual x = gd_shift(gd_abs(p->x), -pivot_x), y = gd_shift(p->y, -pivot_y);
    site.angle = gd_atan2(x, -y);
    site.radius = gd_length2(x, y);
    gen_dual out = gd_abs(p->x);
    /* Swept back from the shoulder, the tips bending forward again. */
    gen_dual middle = gd_shift(gd_square(gd_shift(out, -0.55f)) * 0.42f, -0.345f);
    middle = middle + gd_square(gd_shift(p->y, -0.45f)) * 0.07f - out * 0.03f;
    site.away = p->z - middle;
    site.start = statue_profile(leading, COUNT(leading), site.angle);
    site.end = statue_profile(tips, COUNT(tips), site.angle);
    return site;
}

/* Phase with one feather per pi. */
static gen_dual feather_phase(const wing_site *site, float shift)
{
    return gd_shift(site->angle * (1.0f / feather_angle), shift) * 3.14159265f;
}

/* Barbs: fine oblique grooves away from the shaft, which stands out as a thin rib. */
static gen_dual barbs(const wing_site *site, gen_dual phase)
{
    gen_dual across = gd_cos(phase); /* 0 at the shaft, 1 in the crease */
    gen_dual shaft = gd_smoothstep(0.10f, 0.02f, gd_abs(across));
    gen_dual run = site->radius * 400.0f + gd_abs(across) * 16.0f;
    return shaft * 0.0022f + gd_sin(run) * 0.0004f;
}

static gen_dual layer_distance(const wing_site *site, const layer *l)
{
    gen_dual phase = feather_phase(site, l->phase);
    gen_dual round = statue_pleat(phase, 0.16f);
    gen_dual end = site->start + (site->end - site->start) * l->reach;
    end = end - gd_shift(-round, 1.0f) * l->scallop;
    gen_dual half = gd_shift(round * (0.45f * l->thickness), 0.55f * l->thickness);
    half = half + barbs(site, phase);
    gen_dual sheet = gd_abs(site->away) * 0.94f - half;
    gen_dual outline = gd_max(site->radius - end, site->start - site->radius) * 0.62f;
    outline = gd_max(outline, gd_shift(site->angle, -1.20f) * 0.4f);
    return gd_smooth_max(sheet, outline, 0.010f);
}

static gen_dual wings_distance(const gen_dual3 *p)
{
    wing_site site = wing_at(p);
    if (fabsf(site.away[0]) > 0.16f)
        return gd_shift(gd_abs(site.away) * 0.8f, -0.06f);
    /* The arm along the leading edge, thick at the shoulder, with small scale-like feathers. */
    gen_dual along = gd_smoothstep(0.0f, 1.2f, site.angle);
    gen_dual scale_row = gd_shift(site.radius, 0.0f) * 46.0f;
    gen_dual scales = statue_pleat(scale_row + gd_abs(gd_sin(site.angle * 34.0f)) * 1.2f, 0.25f);
    gen_dual thick = gd_shift(along * -0.020f, 0.042f) + scales * 0.0030f;
    gen_dual arm = gd_length2(gd_shift(site.radius - site.start, -0.022f) * 0.75f, site.away);
    gen_dual ends = gd_shift(gd_abs(gd_shift(site.angle, -0.62f)), -0.50f) * 0.45f;
    gen_dual f = gd_smooth_max(arm - thick, ends, 0.05f);
    for (int i = 0; i < COUNT(layers); i++)
        f = gd_smooth_min(f, layer_distance(&site, &layers[i]), 0.004f);
    gen_dual inner = (gd_constant(0.035f) - site.angle) * 0.5f;
    f = gd_smooth_max(f, inner, 0.01f);
    /* The joint with the back. */
    gen_dual3 half = {gd_abs(p->x), p->y, p->z};
    gen_dual joint = statue_limb(&half, (vec3s){{0.095f, 0.415f, -0.185f}},
                                 (vec3s){{0.125f, 0.435f, -0.270f}}, 0.046f, 0.036f);
    return gd_smooth_min(f, joint, 0.03f) * 0.9f;
}

/* Bands across the wing, from the arm outwards. */
static vec3s wings_colour(vec3s q)
{
    static const vec3s cream = {{0.93f, 0.88f, 0.77f}}, slate = {{0.20f, 0.31f, 0.40f}};
    static const vec3s rose = {{0.75f, 0.42f, 0.32f}}, ochre = {{0.80f, 0.58f, 0.28f}};
    gen_dual3 p = gd_variable(q.x, q.y, q.z);
    wing_site site = wing_at(&p);
    float along = (site.radius[0] - site.start[0]) / (site.end[0] - site.start[0]);
    int top = along < layers[2].reach ? 2 : along < layers[1].reach ? 1 : 0;
    const layer *l = &layers[top];
    gen_dual phase = feather_phase(&site, l->phase);
    float round = statue_pleat(phase, 0.16f)[0];
    /* The same scalloped ends as the relief, to change colour where the layer does. */
    float scallop = (1.0f - round) * l->scallop / (site.end[0] - site.start[0]);
    if (top > 0 && along > l->reach - scallop) {
        l = &layers[--top];
        phase = feather_phase(&site, l->phase);
        round = statue_pleat(phase, 0.16f)[0];
    }
    float tip = along / l->reach;
    vec3s colour;
    if (top == 2)
        colour = statue_mix(ochre, statue_madder, gd_smoothstep(0.62f, 0.95f, gd_constant(tip))[0]);
    else if (top == 1)
        colour = statue_mix(rose, cream, gd_smoothstep(0.66f, 0.80f, gd_constant(tip))[0]);
    else
        colour = statue_mix(cream, slate, gd_smoothstep(0.70f, 0.90f, gd_constant(tip))[0]);
    colour = statue_shade(colour, 0.78f + 0.24f * round);
    float shaft = gd_smoothstep(0.10f, 0.04f, gd_abs(gd_cos(phase)))[0];
    return statue_mix(colour, statue_shade(colour, 0.8f), shaft);
}

const statue_part statue_wings = {.name = "wings",
                                  .distance = wings_distance,
                                  .colour = wings_colour,
                                  .min = {{-0.86f, -0.44f, -0.50f}},
                                  .max = {{0.86f, 1.06f, 0.02f}},
                                  .blend = 0.008f};

static const vec3s halo_centre = {{0.0f, 0.790f, -0.205f}};

static gen_dual halo_distance(const gen_dual3 *p)
{
    gen_dual x = gd_shift(p->x, -halo_centre.x), y = gd_shift(p->y, -halo_centre.y);
    gen_dual z = gd_shift(p->z, -halo_centre.z);
    gen_dual radius = gd_length2(x, y), angle = gd_atan2(x, y);
    gen_dual rays = statue_pleat(angle * 18.0f, 0.2f);
    /* Rays grow from the rim inwards; towards the rim of beads they flatten. */
    gen_dual fade =
        gd_mul(gd_smoothstep(0.10f, 0.15f, radius), gd_smoothstep(0.212f, 0.19f, radius));
    gen_dual half = gd_shift(gd_mul(rays, fade) * 0.0035f, 0.0050f);
    gen_dual disc = gd_smooth_max(gd_abs(z) - half, gd_shift(radius, -0.225f), 0.006f);
    gen_dual rim = gd_shift(gd_length2(gd_shift(radius, -0.222f), z), -0.0095f);
    gen_dual inner =
        gd_shift(gd_length2(gd_shift(radius, -0.196f), gd_shift(gd_abs(z), -0.004f)), -0.004f);
    gen_dual beads = gd_cos(angle * 60.0f) * 0.0018f;
    gen_dual f = gd_smooth_min(gd_min(disc, inner), rim - beads, 0.005f) * 0.8f;
    /* A boss holds the halo to the hood. */
    gen_dual boss = statue_limb(p, halo_centre, (vec3s){{0.0f, 0.76f, -0.13f}}, 0.030f, 0.042f);
    return gd_smooth_min(f, boss, 0.012f);
}

static vec3s halo_colour(vec3s p)
{
    static const vec3s pale = {{0.93f, 0.79f, 0.47f}};
    float x = p.x - halo_centre.x, y = p.y - halo_centre.y;
    float ray = fabsf(sinf(18.0f * atan2f(x, y))), radius = sqrtf(x * x + y * y);
    if (radius > 0.2115f)
        return statue_gold;
    return statue_mix(statue_shade(statue_gold, 0.85f), pale, radius > 0.19f ? 0.2f : ray);
}

const statue_part statue_halo = {.name = "halo",
                                 .distance = halo_distance,
                                 .colour = halo_colour,
                                 .min = {{-0.27f, 0.52f, -0.27f}},
                                 .max = {{0.27f, 1.06f, -0.05f}},
                                 .blend = 0.010f};

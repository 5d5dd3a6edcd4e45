/* The statue's cloak: an open thin sheet, teal outside, madder inside, with an embossed border. */
#include "tools/gen/statue.h"

#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

static const float half_thickness = 0.0065f;
static const float border_width = 0.046f;

static const statue_knot cloak_x[] = {{-0.76f, 0.470f}, {-0.50f, 0.390f}, {-0.15f, 0.318f},
                                      {0.15f, 0.296f},  {0.36f, 0.282f},  {0.48f, 0.246f},
                                      {0.55f, 0.178f},  {0.60f, 0.122f},  {0.66f, 0.104f}};
static const statue_knot cloak_z[] = {{-0.76f, 0.430f}, {-0.50f, 0.350f}, {-0.15f, 0.280f},
                                      {0.15f, 0.232f},  {0.36f, 0.205f},  {0.48f, 0.178f},
                                      {0.55f, 0.140f},  {0.60f, 0.108f},  {0.66f, 0.098f}};
/* Half the angle of the opening in front, by height. */
static const statue_knot opening[] = {{-0.76f, 1.02f}, {-0.30f, 1.16f}, {0.05f, 1.46f},
                                      {0.24f, 1.62f},  {0.40f, 1.32f},  {0.50f, 0.95f},
                                      {0.575f, 0.72f}, {0.66f, 0.80f}};

/* The loss of distance across the edge of the opening where it climbs over the shoulder. */
static const statue_knot steepness[] = {
    {0.24f, 1.0f}, {0.42f, 0.85f}, {0.50f, 0.62f}, {0.575f, 0.62f}, {0.66f, 0.85f}};

typedef struct cloak_site {
    gen_dual angle, away; /* away: from the middle of the sheet, outwards */
    gen_dual edge;        /* distance inwards from the front edges and the hem */
    gen_dual hem;         /* height above the hem */
} cloak_site;

static gen_dual cloak_folds(gen_dual angle, gen_dual y)
{
    gen_dual low = gd_smoothstep(0.58f, -0.72f, y);
    gen_dual sway = gd_sin(angle * 2.0f - y * 2.2f) * 0.6f +
                    gd_sin(gd_shift(angle * 4.0f + y * 3.1f, 1.0f)) * 0.25f;
    gen_dual broad = statue_pleat(gd_shift(angle * 5.0f + sway, 0.2f), 0.32f);
    gen_dual narrow = gd_sin(angle * 17.0f + sway * 2.0f) * 0.5f;
    gen_dual fine = gd_mul(gd_smoothstep(0.58f, 0.30f, y), gd_smoothstep(-0.55f, 0.1f, y));
    gen_dual swag = statue_pleat(y * 16.0f + gd_cos(angle) * 2.4f, 0.35f);
    /* Across the shoulders the cloth hangs in bows between its two sides. */
    gen_dual bows = gd_mul(gd_smoothstep(0.54f, 0.40f, y), gd_smoothstep(0.08f, 0.36f, y));
    return gd_mul(low, broad * 0.088f) + gd_mul(fine, narrow * 0.010f) +
           gd_mul(bows, swag) * 0.010f;
}

static cloak_site cloak_at(const gen_dual3 *p)
{
    cloak_site site;
    gen_dual shifted = gd_shift(p->z, 0.012f);
    site.angle = gd_atan2(p->x, shifted);
    gen_dual distance = gd_length2(p->x, shifted);
    gen_dual x = statue_profile(cloak_x, COUNT(cloak_x), p->y);
    gen_dual z = statue_profile(cloak_z, COUNT(cloak_z), p->y);
    gen_dual s = gd_div(gd_sin(site.angle), x), c = gd_div(gd_cos(site.angle), z);
    gen_dual radius = gd_div(gd_constant(1.0f), gd_length2(s, c));
    radius = radius + cloak_folds(site.angle, p->y);
    site.away = (distance - radius) * 0.72f;
    gen_dual limit = statue_profile(opening, COUNT(opening), p->y);
    gen_dual front = gd_mul(gd_abs(site.angle) - limit, distance);
    front = gd_mul(front, statue_profile(steepness, COUNT(steepness), p->y));
    /* The hem dips behind and lifts a little in waves. */
    gen_dual level =
        gd_cos(site.angle) * 0.045f + gd_sin(gd_shift(site.angle * 5.0f, 0.5f)) * 0.012f;
    site.hem = gd_shift(p->y - level, 0.665f);
    site.edge = gd_smooth_min(front, site.hem, 0.02f);
    return site;
}

/* Height of the border's ornament, 0..1: a cord on each side of a running wave. */
static gen_dual border_relief(const cloak_site *site, gen_dual y)
{
    gen_dual across = gd_shift(site->edge * (1.0f / border_width), -0.5f) * 2.0f;
    gen_dual cords = gd_smoothstep(0.24f, 0.10f, gd_abs(gd_shift(gd_abs(across), -0.72f)));
    /* Along the hem the angle runs, along the front edges the height does. */
    gen_dual run = site->angle * 24.0f + y * 62.0f;
    gen_dual wave = across - gd_sin(run) * 0.30f;
    return gd_max(cords, gd_smoothstep(0.26f, 0.10f, gd_abs(wave)));
}

static gen_dual cloak_distance(const gen_dual3 *p)
{
    cloak_site site = cloak_at(p);
    gen_dual thickness = gd_constant(half_thickness);
    if (site.away[0] > 0.0f && site.edge[0] < border_width)
        thickness = thickness + border_relief(&site, p->y) * 0.0028f;
    gen_dual sheet = gd_abs(site.away) - thickness;
    gen_dual cut = gd_smooth_max(-site.edge, gd_shift(p->y, -0.625f), 0.01f);
    return gd_smooth_max(sheet, cut * 0.9f, 0.009f);
}

static vec3s cloak_colour(vec3s q)
{
    gen_dual3 p = gd_variable(q.x, q.y, q.z);
    cloak_site site = cloak_at(&p);
    if (site.away[0] < -0.3f * half_thickness) {
        float weave = sinf(q.y * 700.0f) * sinf(site.angle[0] * 230.0f);
        return statue_shade(statue_madder, 1.02f + 0.05f * weave);
    }
    if (site.edge[0] < border_width) {
        float relief = border_relief(&site, p.y)[0];
        return statue_mix(statue_shade(statue_madder, 0.8f), statue_gold, 0.15f + 0.85f * relief);
    }
    float fold = fminf(cloak_folds(site.angle, p.y)[0] / 0.05f, 1.0f);
    vec3s colour = statue_mix(statue_shade(statue_teal, 0.72f), statue_teal, fold);
    /* Sewn stars, a hexagonal scatter over the cloth. */
    float u = site.angle[0] * 9.0f, v = q.y * 17.0f;
    u += 0.5f * (float)((int)floorf(v + 100.0f) & 1);
    float du = (u - floorf(u) - 0.5f) * 0.72f, dv = v - floorf(v) - 0.5f;
    float ray = cosf(4.0f * atan2f(dv, du));
    float star = sqrtf(du * du + dv * dv) - 0.075f * (1.0f + 0.45f * ray);
    if (star < 0.0f && floorf(v) < 7.0f)
        colour = statue_gold;
    return statue_shade(colour, 1.0f + 0.05f * statue_mottle(q, 19.0f));
}

const statue_part statue_cloak = {.name = "cloak",
                                  .distance = cloak_distance,
                                  .colour = cloak_colour,
                                  .min = {{-0.62f, -0.76f, -0.60f}},
                                  .max = {{0.62f, 0.68f, 0.36f}},
                                  .blend = 0.006f};

/* The statue's cloth: pleated robe, sash, and the open cloak, a thin sheet with a lining. */
#include "tools/gen/statue.h"

#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

/* Half axes of the robe's cross-section by height. */
static const statue_knot robe_x[] = {{-0.80f, 0.335f}, {-0.60f, 0.290f}, {-0.30f, 0.235f},
                                     {0.00f, 0.190f},  {0.14f, 0.158f},  {0.20f, 0.150f},
                                     {0.28f, 0.168f},  {0.42f, 0.188f},  {0.49f, 0.168f},
                                     {0.545f, 0.088f}, {0.58f, 0.060f}};
static const statue_knot robe_z[] = {{-0.80f, 0.300f}, {-0.60f, 0.262f}, {-0.30f, 0.208f},
                                     {0.00f, 0.162f},  {0.14f, 0.134f},  {0.20f, 0.128f},
                                     {0.28f, 0.146f},  {0.42f, 0.152f},  {0.49f, 0.122f},
                                     {0.545f, 0.076f}, {0.58f, 0.060f}};

/* Position of the body's axis: the weight is on the figure's left leg. */
static const statue_knot axis_x[] = {
    {-0.80f, 0.000f}, {-0.40f, 0.018f}, {0.05f, 0.028f}, {0.30f, 0.004f}, {0.62f, 0.000f}};

typedef struct polar {
    gen_dual distance, angle; /* from the axis; 0 is the front, positive to +x */
} polar;

static polar around(const gen_dual3 *p)
{
    gen_dual x = p->x - statue_profile(axis_x, COUNT(axis_x), p->y);
    return (polar){gd_length2(x, p->z), gd_atan2(x, p->z)};
}

/* Distance along the radius of an ellipse at an angle. */
static gen_dual ellipse_radius(gen_dual angle, gen_dual x, gen_dual z)
{
    gen_dual s = gd_div(gd_sin(angle), x), c = gd_div(gd_cos(angle), z);
    return gd_div(gd_constant(1.0f), gd_length2(s, c));
}

/* Folds of the skirt: broad ones that gather upwards, narrower ones between them near the hem. */
static gen_dual robe_folds(gen_dual angle, gen_dual y)
{
    gen_dual sway = gd_sin(angle * 2.0f + y * 2.6f) * 0.55f +
                    gd_sin(gd_shift(angle * 3.0f - y * 1.9f, 0.8f)) * 0.35f;
    gen_dual low = gd_smoothstep(0.16f, -0.78f, y);
    gen_dual broad = statue_pleat(angle * 5.5f + sway + gd_constant(0.4f), 0.22f);
    gen_dual narrow = statue_pleat(gd_shift(angle * 11.0f + sway * 1.6f, 1.1f), 0.30f);
    gen_dual uneven = gd_shift(gd_sin(gd_shift(angle * 3.0f + y * 1.3f, 2.0f)) * 0.35f, 0.65f);
    gen_dual depth = gd_mul(low, uneven);
    gen_dual skirt = gd_mul(depth, broad * 0.062f + narrow * 0.020f);
    /* Above the sash: fine gathers that fade to the shoulders. */
    gen_dual chest = gd_mul(gd_smoothstep(0.21f, 0.25f, y), gd_smoothstep(0.50f, 0.26f, y));
    gen_dual gathers = statue_pleat(angle * 15.0f + gd_sin(angle * 4.0f) * 0.8f, 0.35f);
    gen_dual waist = gd_mul(gd_smoothstep(0.02f, 0.12f, y), gd_smoothstep(0.20f, 0.16f, y));
    return skirt + gd_mul(chest + waist * 0.7f, gathers) * 0.009f;
}

/* The embroidery of hem and neckline: lozenges between two cords; in 0..1. */
static gen_dual robe_hem(gen_dual angle, gen_dual y)
{
    gen_dual up = y[0] > 0.0f ? gd_shift(y, -0.528f) * 78.0f : gd_shift(y, 0.690f) * 34.0f;
    gen_dual cords = gd_smoothstep(0.32f, 0.18f, gd_abs(gd_shift(gd_abs(up), -1.3f)));
    gen_dual run = gd_abs(gd_sin(angle * (y[0] > 0.0f ? 12.0f : 22.0f)));
    gen_dual lozenge = gd_smoothstep(0.92f, 0.62f, run + gd_abs(up));
    return gd_max(cords, lozenge);
}

static gen_dual robe_distance(const gen_dual3 *p)
{
    polar c = around(p);
    gen_dual x = statue_profile(robe_x, COUNT(robe_x), p->y);
    gen_dual z = statue_profile(robe_z, COUNT(robe_z), p->y);
    gen_dual radius = ellipse_radius(c.angle, x, z) + robe_folds(c.angle, p->y);
    if (p->y[0] < -0.60f || p->y[0] > 0.48f)
        radius = radius + robe_hem(c.angle, p->y) * 0.0035f;
    gen_dual side = (c.distance - radius) * 0.75f;
    gen_dual body = gd_smooth_max(side, gd_shift(p->y, -0.572f), 0.012f);
    body = gd_smooth_max(body, gd_shift(-p->y, -0.79f), 0.012f);
    /* The toes. */
    gen_dual left =
        statue_ellipsoid(p, (vec3s){{0.10f, -0.765f, 0.350f}}, (vec3s){{0.040f, 0.030f, 0.075f}});
    gen_dual right =
        statue_ellipsoid(p, (vec3s){{-0.07f, -0.765f, 0.340f}}, (vec3s){{0.040f, 0.030f, 0.070f}});
    return gd_smooth_min(body, gd_min(left, right), 0.008f);
}

static vec3s robe_colour(vec3s q)
{
    static const vec3s shadow = {{0.62f, 0.50f, 0.40f}}, leather = {{0.34f, 0.20f, 0.13f}};
    gen_dual3 p = gd_variable(q.x, q.y, q.z);
    polar c = around(&p);
    float fold = robe_folds(c.angle, p.y)[0];
    gen_dual skin = ellipse_radius(c.angle, statue_profile(robe_x, COUNT(robe_x), p.y),
                                   statue_profile(robe_z, COUNT(robe_z), p.y));
    if (q.y < -0.70f && c.distance[0] > skin[0] + 0.075f)
        return leather;
    /* Dye collects in the creases. */
    float deep = 1.0f - fminf(fold / 0.03f, 1.0f);
    vec3s colour = statue_mix(statue_ivory, shadow, q.y < 0.1f ? 0.28f * deep : 0.1f * deep);
    if (q.y < -0.634f || q.y > 0.5035f) {
        float thread = robe_hem(c.angle, p.y)[0];
        vec3s cloth =
            q.y > -0.746f && q.y < 0.5525f ? statue_madder : statue_shade(statue_madder, 0.75f);
        colour =
            statue_mix(cloth, statue_gold, gd_smoothstep(0.35f, 0.65f, gd_constant(thread))[0]);
    }
    return statue_shade(colour, 1.0f + 0.03f * statue_mottle(q, 23.0f));
}

const statue_part statue_robe = {.name = "robe",
                                 .distance = robe_distance,
                                 .colour = robe_colour,
                                 .min = {{-0.46f, -0.85f, -0.44f}},
                                 .max = {{0.46f, 0.68f, 0.46f}},
                                 .blend = 0.010f};

/* A braided cord around the waist and its two hanging ends. */
static gen_dual sash_distance(const gen_dual3 *p)
{
    polar c = around(p);
    gen_dual x = statue_profile(robe_x, COUNT(robe_x), p->y);
    gen_dual z = statue_profile(robe_z, COUNT(robe_z), p->y);
    gen_dual out = c.distance - gd_shift(ellipse_radius(c.angle, x, z), 0.010f);
    gen_dual height = gd_shift(p->y, -0.195f) + gd_cos(c.angle) * 0.012f;
    gen_dual turn = gd_atan2(height, out);
    gen_dual braid = gd_sin(c.angle * 30.0f + turn * 2.0f) * 0.0035f;
    gen_dual cord = gd_length2(out, height * 0.8f) - gd_shift(braid, 0.020f);
    float sway = 0.028f;
    for (int side = 0; side < 2; side++) {
        vec3s top = {{side ? 0.045f : 0.005f, 0.185f, 0.150f}};
        vec3s end = {
            {side ? 0.085f + sway : -0.010f, side ? -0.22f : -0.16f, side ? 0.226f : 0.222f}};
        gen_dual twist = gd_sin(p->y * 190.0f + gd_sin(p->x * 40.0f)) * 0.0022f;
        gen_dual hang = statue_limb(p, top, end, 0.011f, 0.011f) - twist;
        gen_dual knob = statue_ellipsoid(p, end, (vec3s){{0.019f, 0.034f, 0.019f}});
        cord = gd_smooth_min(cord, gd_smooth_min(hang, knob, 0.012f), 0.012f);
    }
    return cord * 0.8f;
}

static vec3s sash_colour(vec3s p)
{
    gen_dual3 q = gd_variable(p.x, p.y, p.z);
    float strand = 0.5f + 0.5f * sinf(around(&q).angle[0] * 30.0f + p.y * 190.0f);
    return statue_mix(statue_madder, statue_gold, p.y > 0.13f ? strand : 0.35f + 0.65f * strand);
}

const statue_part statue_sash = {.name = "sash",
                                 .distance = sash_distance,
                                 .colour = sash_colour,
                                 .min = {{-0.28f, -0.32f, -0.26f}},
                                 .max = {{0.28f, 0.29f, 0.34f}},
                                 .blend = 0.006f};

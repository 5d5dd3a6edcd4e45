/* The statue's arms and what they hold: wide sleeves, hands, the hammered orb. */
#include "tools/gen/statue.h"

static const vec3s orb_centre = {{0.0f, 0.335f, 0.262f}};
static const float orb_radius = 0.074f;

/* Arms are mirror images, so everything here is for the side of positive x. */
static gen_dual3 mirrored(const gen_dual3 *p)
{
    return (gen_dual3){gd_abs(p->x), p->y, p->z};
}

static const vec3s shoulder = {{0.138f, 0.438f, 0.005f}};
static const vec3s elbow = {{0.228f, 0.215f, 0.055f}};
static const vec3s wrist = {{0.105f, 0.268f, 0.222f}};

/* Coordinates along the forearm, 0 at the elbow and 1 at the sleeve's mouth, and across it. */
typedef struct forearm_site {
    gen_dual along, side, up, across;
} forearm_site;

static forearm_site forearm_at(const gen_dual3 *p)
{
    /* An orthonormal frame: the arm, level across it, and up. */
    float ax = wrist.x - elbow.x, ay = wrist.y - elbow.y, az = wrist.z - elbow.z;
    float length = sqrtf(ax * ax + ay * ay + az * az), flat = sqrtf(ax * ax + az * az);
    ax /= length;
    ay /= length;
    az /= length;
    float sx = az * length / flat, sz = -ax * length / flat;
    float ux = -ay * sz, uy = ax * sz - az * sx, uz = ay * sx;
    if (uy < 0.0f) {
        ux = -ux;
        uy = -uy;
        uz = -uz;
    }
    gen_dual3 d = {gd_shift(p->x, -elbow.x), gd_shift(p->y, -elbow.y), gd_shift(p->z, -elbow.z)};
    forearm_site site;
    site.along = (d.x * ax + d.y * ay + d.z * az) * (1.0f / length);
    site.side = d.x * sx + d.z * sz;
    site.up = d.x * ux + d.y * uy + d.z * uz;
    site.across = gd_length2(site.side, site.up);
    return site;
}

/* The sleeve's mouth hangs: a tear-shaped tube, thin at its edge. */
static gen_dual sleeve_mouth(const forearm_site *site)
{
    gen_dual t = gd_clamp(site->along, -0.4f, 1.05f);
    gen_dual wide = gd_shift(gd_square(gd_clamp(t, 0.0f, 1.05f)) * 0.030f, 0.052f);
    gen_dual drop = gd_smoothstep(0.1f, 1.0f, t) * 0.085f;
    /* Below the arm the tube is drawn out downwards. */
    gen_dual low = gd_smoothstep(0.03f, -0.03f, site->up);
    gen_dual up = gd_div(site->up, gd_shift(gd_mul(low, drop) * 13.0f, 1.0f));
    gen_dual angle = gd_atan2(site->side, site->up);
    gen_dual fold = gd_sin(site->along * 15.0f + gd_cos(angle) * 3.2f) * 0.0050f;
    fold = fold + statue_pleat(gd_shift(angle * 4.0f, 0.6f), 0.3f) * 0.006f;
    return gd_length2(site->side, up) - wide - fold;
}

static gen_dual sleeves_distance(const gen_dual3 *p)
{
    gen_dual3 q = mirrored(p);
    forearm_site site = forearm_at(&q);
    gen_dual tube = sleeve_mouth(&site);
    /* Hollow from the mouth inwards, so that the cloth has a thickness there. */
    gen_dual hollow = gd_max(tube + gd_constant(0.0085f), gd_shift(-site.along, 0.45f) * 0.2f);
    gen_dual ends = gd_shift(gd_abs(gd_shift(site.along, -0.40f)) * 0.2f, -0.122f);
    gen_dual fore = gd_smooth_max(gd_smooth_max(tube, ends, 0.010f), -hollow, 0.007f);
    /* Folds wind about the arm and crowd towards the elbow. */
    gen_dual below = gd_shift(-q.y, 0.46f);
    gen_dual run = below * 48.0f + gd_square(below) * 110.0f - q.x * 34.0f +
                   gd_sin(q.z * 30.0f + q.y * 14.0f) * 0.9f;
    gen_dual upper = statue_limb(&q, shoulder, elbow, 0.060f, 0.058f);
    upper = upper - statue_pleat(run, 0.5f) * 0.0075f;
    gen_dual f = gd_smooth_min(upper, fore, 0.045f);
    /* The arm inside the sleeve. */
    gen_dual arm = statue_limb(&q, elbow, wrist, 0.035f, 0.024f);
    f = gd_smooth_min(f * 0.62f, arm, 0.004f);
    /* Cloth fills the pocket between sleeve, sash and robe. */
    gen_dual fill = statue_limb(&q, (vec3s){{0.140f, 0.235f, 0.020f}},
                                (vec3s){{0.145f, 0.205f, 0.030f}}, 0.016f, 0.016f);
    return gd_smooth_min(f, fill, 0.008f);
}

static vec3s sleeves_colour(vec3s p)
{
    static const vec3s skin = {{0.86f, 0.66f, 0.53f}};
    gen_dual3 v = gd_variable(p.x, p.y, p.z), q = mirrored(&v);
    forearm_site site = forearm_at(&q);
    if (statue_limb(&q, elbow, wrist, 0.035f, 0.024f)[0] < 0.003f && site.along[0] > 0.4f)
        return skin;
    bool inside = sleeve_mouth(&site)[0] < -0.005f && site.along[0] > 0.44f;
    if (inside)
        return statue_shade(statue_madder, 0.9f);
    if (site.along[0] > 0.86f)
        return site.along[0] > 0.90f && site.along[0] < 0.965f ? statue_shade(statue_madder, 0.95f)
                                                               : statue_gold;
    return statue_shade(statue_ivory, 0.97f + 0.03f * statue_mottle(p, 23.0f));
}

const statue_part statue_sleeves = {.name = "sleeves",
                                    .distance = sleeves_distance,
                                    .colour = sleeves_colour,
                                    .min = {{-0.36f, 0.02f, -0.11f}},
                                    .max = {{0.36f, 0.60f, 0.35f}},
                                    .blend = 0.016f};

/* A sphere with a hammered skin and a raised band with a cross-band over it. */
static gen_dual orb_distance(const gen_dual3 *p)
{
    gen_dual x = gd_shift(p->x, -orb_centre.x), y = gd_shift(p->y, -orb_centre.y);
    gen_dual z = gd_shift(p->z, -orb_centre.z);
    gen_dual radius = gd_length3((gen_dual3){x, y, z});
    gen_dual hammer = gd_sin(x * 150.0f + gd_sin(y * 90.0f)) +
                      gd_sin(y * 165.0f + gd_sin(z * 80.0f)) +
                      gd_sin(z * 140.0f + gd_sin(x * 110.0f));
    gen_dual belt = gd_smoothstep(0.0115f, 0.0085f, gd_abs(y * 0.94f + x * 0.34f));
    gen_dual arch = gd_smoothstep(0.0115f, 0.0085f, gd_abs(x * 0.94f - y * 0.34f));
    gen_dual above = gd_smoothstep(-0.01f, 0.0f, y * 0.94f + x * 0.34f);
    gen_dual band = gd_max(belt, gd_mul(arch, above));
    gen_dual skin = gd_mul(hammer, gd_shift(-band, 1.0f)) * 0.00045f + band * 0.0036f;
    return gd_shift(radius - skin, -orb_radius) * 0.85f;
}

static vec3s orb_colour(vec3s p)
{
    static const vec3s lapis = {{0.12f, 0.22f, 0.52f}}, fleck = {{0.74f, 0.64f, 0.38f}};
    float x = p.x - orb_centre.x, y = p.y - orb_centre.y;
    bool band = fabsf(y * 0.94f + x * 0.34f) < 0.011f ||
                (fabsf(x * 0.94f - y * 0.34f) < 0.011f && y * 0.94f + x * 0.34f > 0.0f);
    if (band)
        return statue_gold;
    float cloud = statue_mottle(p, 95.0f);
    return cloud > 0.62f ? fleck : statue_shade(lapis, 1.0f + 0.25f * cloud);
}

const statue_part statue_orb = {.name = "orb",
                                .distance = orb_distance,
                                .colour = orb_colour,
                                .min = {{-0.10f, 0.23f, 0.16f}},
                                .max = {{0.10f, 0.44f, 0.37f}},
                                .blend = 0.002f};

/* A place on the orb by longitude (from the front) and latitude, at a height over its skin. */
static vec3s on_orb(float longitude, float latitude, float height)
{
    float r = orb_radius + height;
    return (vec3s){{orb_centre.x + r * cosf(latitude) * sinf(longitude),
                    orb_centre.y + r * sinf(latitude),
                    orb_centre.z + r * cosf(latitude) * cosf(longitude)}};
}

/* Four fingers around the orb from below, the thumb at its side. */
static const float fingers[5][2][3] = {
    /* knuckle and tip: longitude, latitude, radius */
    {{1.15f, -0.62f, 0.0118f}, {0.50f, -0.16f, 0.0082f}},
    {{1.05f, -0.88f, 0.0120f}, {0.33f, -0.44f, 0.0084f}},
    {{0.95f, -1.12f, 0.0116f}, {0.24f, -0.74f, 0.0080f}},
    {{0.80f, -1.34f, 0.0104f}, {0.16f, -1.02f, 0.0072f}},
    {{1.75f, -0.10f, 0.0135f}, {1.25f, 0.42f, 0.0095f}},
};

static gen_dual hands_distance(const gen_dual3 *p)
{
    gen_dual3 q = mirrored(p);
    vec3s palm = on_orb(1.55f, -0.72f, 0.016f);
    gen_dual f = statue_limb(&q, wrist, palm, 0.022f, 0.026f);
    f = gd_smooth_min(f, statue_limb(&q, palm, on_orb(1.0f, -1.0f, 0.011f), 0.024f, 0.016f),
                      0.014f);
    for (int i = 0; i < 5; i++) {
        const float *k = fingers[i][0], *t = fingers[i][1];
        vec3s knuckle = on_orb(k[0], k[1], k[2] * 0.85f);
        vec3s middle = on_orb(0.5f * (k[0] + t[0]), 0.5f * (k[1] + t[1]), 0.5f * (k[2] + t[2]));
        vec3s tip = on_orb(t[0], t[1], t[2] * 0.6f);
        gen_dual first = statue_limb(&q, knuckle, middle, k[2], 0.5f * (k[2] + t[2]));
        gen_dual last = statue_limb(&q, middle, tip, 0.5f * (k[2] + t[2]), t[2]);
        gen_dual finger = gd_smooth_min(first, last, 0.004f);
        if (i == 4)
            finger = gd_smooth_min(finger, statue_limb(&q, palm, knuckle, 0.018f, k[2]), 0.010f);
        f = gd_smooth_min(f, finger, i == 4 ? 0.012f : 0.005f);
    }
    return f * 0.95f;
}

static vec3s hands_colour(vec3s p)
{
    static const vec3s skin = {{0.86f, 0.66f, 0.53f}};
    return statue_shade(skin, 1.0f + 0.03f * statue_mottle(p, 60.0f));
}

const statue_part statue_hands = {.name = "hands",
                                  .distance = hands_distance,
                                  .colour = hands_colour,
                                  .min = {{-0.18f, 0.18f, 0.12f}},
                                  .max = {{0.18f, 0.44f, 0.39f}},
                                  .blend = 0.0055f};

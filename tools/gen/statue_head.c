/* The statue's head: a calm face with closed eyes, hair at the temples, inside the cloak's hood. */
#include "tools/gen/statue.h"

static const float raise = 0.018f;

/* Transforms into the head's own frame: inclined forward and a little to its left. */
static gen_dual3 head_frame(const gen_dual3 *p)
{
    const float ct = 0.9925f, st = 0.1222f; /* 7 degrees forward */
    const float cs = 0.9962f, ss = 0.0872f; /* 5 degrees to the side */
    gen_dual x = p->x, y = gd_shift(p->y, -0.62f - raise), z = p->z;
    gen_dual x1 = x * cs + y * ss, y1 = y * cs - x * ss;
    return (gen_dual3){x1, gd_shift(y1 * ct + z * st, 0.62f), z * ct - y1 * st};
}

static gen_dual blob(const gen_dual3 *p, float x, float y, float z, float rx, float ry, float rz)
{
    return statue_ellipsoid(p, (vec3s){{x, y, z}}, (vec3s){{rx, ry, rz}});
}

/* The eyes: sockets, lids over the balls, and the seam of the closed lids. */
static gen_dual with_eyes(gen_dual f, const gen_dual3 *p)
{
    gen_dual3 half = {gd_abs(p->x), p->y, p->z};
    gen_dual socket = blob(&half, 0.034f, 0.742f, 0.108f, 0.030f, 0.021f, 0.026f);
    f = gd_smooth_max(f, -socket, 0.024f);
    gen_dual lid = blob(&half, 0.034f, 0.737f, 0.0735f, 0.0215f, 0.0165f, 0.0165f);
    f = gd_smooth_min(f, lid, 0.006f);
    gen_dual bow = gd_square(gd_shift(half.x, -0.034f)) * 13.0f;
    gen_dual seam = gd_length2(gd_shift(half.y - bow, -0.7285f), gd_shift(half.z, -0.089f) * 0.55f);
    gen_dual width = gd_smoothstep(0.022f, 0.014f, gd_abs(gd_shift(half.x, -0.034f)));
    return f + gd_mul(gd_smoothstep(0.0055f, 0.0f, seam), width) * 0.0028f;
}

/* Maps both sides of the face onto one, without a crease in the middle. */
static gen_dual3 half_face(const gen_dual3 *p)
{
    return (gen_dual3){gd_sqrt(gd_shift(gd_square(p->x), 1.6e-5f)), p->y, p->z};
}

static gen_dual face(const gen_dual3 *p)
{
    gen_dual f = blob(p, 0.0f, 0.752f, -0.004f, 0.083f, 0.098f, 0.094f);
    f = gd_smooth_min(f, blob(p, 0.0f, 0.688f, 0.026f, 0.056f, 0.068f, 0.062f), 0.06f);
    gen_dual3 half = half_face(p);
    /* Brow, cheeks. */
    f = gd_smooth_min(f,
                      statue_limb(&half, (vec3s){{0.016f, 0.759f, 0.080f}},
                                  (vec3s){{0.049f, 0.757f, 0.063f}}, 0.0105f, 0.0055f),
                      0.022f);
    f = gd_smooth_min(f, blob(&half, 0.040f, 0.704f, 0.052f, 0.028f, 0.027f, 0.026f), 0.035f);
    f = with_eyes(f, p);
    /* Nose: bridge, tip and wings. */
    gen_dual nose = statue_limb(p, (vec3s){{0.0f, 0.758f, 0.086f}}, (vec3s){{0.0f, 0.706f, 0.108f}},
                                0.0072f, 0.0098f);
    nose = gd_smooth_min(nose, blob(&half, 0.0125f, 0.7015f, 0.096f, 0.0088f, 0.0075f, 0.0105f),
                         0.010f);
    f = gd_smooth_min(f, nose, 0.013f);
    /* Mouth and chin. */
    gen_dual mouth = blob(p, 0.0f, 0.664f, 0.070f, 0.034f, 0.026f, 0.022f);
    f = gd_smooth_min(f, mouth, 0.022f);
    gen_dual dip = gd_square(p->x) * 7.0f;
    gen_dual upper =
        statue_ellipsoid(&(gen_dual3){p->x, p->y - dip * 0.45f, p->z},
                         (vec3s){{0.0f, 0.6700f, 0.0880f}}, (vec3s){{0.0240f, 0.0058f, 0.0085f}});
    gen_dual lower =
        statue_ellipsoid(&(gen_dual3){p->x, p->y - dip, p->z}, (vec3s){{0.0f, 0.6600f, 0.0865f}},
                         (vec3s){{0.0190f, 0.0068f, 0.0085f}});
    f = gd_smooth_min(f, upper, 0.006f);
    f = gd_smooth_min(f, lower, 0.005f);
    gen_dual seam = gd_abs(gd_shift(p->y - gd_square(p->x) * 3.2f, -0.6652f));
    gen_dual width = gd_smoothstep(0.024f, 0.014f, gd_abs(p->x));
    f = f + gd_mul(gd_smoothstep(0.0032f, 0.0f, seam), width) * 0.0018f;
    f = gd_smooth_min(f, blob(p, 0.0f, 0.630f, 0.064f, 0.021f, 0.017f, 0.019f), 0.022f);
    return f;
}

static gen_dual hair(const gen_dual3 *p)
{
    gen_dual cap = blob(p, 0.0f, 0.742f, -0.022f, 0.097f, 0.121f, 0.117f);
    /* The face is cut free: the hair parts in the middle and falls beside the cheeks. */
    gen_dual parting = gd_sqrt(gd_shift(gd_square(p->x), 4e-5f)) * 0.42f;
    gen_dual window =
        statue_ellipsoid(&(gen_dual3){p->x, p->y + parting, p->z}, (vec3s){{0.0f, 0.697f, 0.105f}},
                         (vec3s){{0.086f, 0.110f, 0.100f}});
    /* Strands run beside the face, as its outline does, in slow waves. */
    gen_dual sway = gd_sin(p->y * 55.0f + p->x * 20.0f) * 0.5f;
    gen_dual wide = statue_pleat(gd_shift(window * 105.0f + sway, 0.9f), 0.25f) * 0.0055f;
    gen_dual fine = gd_sin(window * 620.0f + sway * 5.0f) * 0.0008f;
    return gd_smooth_max(cap - wide - fine, -window, 0.008f);
}

static gen_dual head_distance(const gen_dual3 *p)
{
    gen_dual3 q = head_frame(p);
    gen_dual f = gd_smooth_min(face(&q), hair(&q), 0.004f);
    gen_dual neck = statue_limb(p, (vec3s){{0.0f, 0.50f, -0.012f}}, (vec3s){{0.0f, 0.68f, 0.003f}},
                                0.050f, 0.041f);
    return gd_smooth_min(f, neck, 0.03f) * 0.9f;
}

static vec3s head_colour(vec3s p)
{
    static const vec3s skin = {{0.86f, 0.66f, 0.53f}}, blush = {{0.83f, 0.49f, 0.40f}};
    static const vec3s lips = {{0.72f, 0.40f, 0.35f}}, brown = {{0.36f, 0.21f, 0.12f}};
    gen_dual3 v = gd_variable(p.x, p.y, p.z), q = head_frame(&v);
    float x = fabsf(q.x[0]), y = q.y[0], z = q.z[0];
    if (hair(&q)[0] < face(&q)[0] && y > 0.6f)
        return statue_shade(brown, 1.0f + 0.12f * statue_mottle(p, 90.0f));
    float cheek = expf(-((x - 0.048f) * (x - 0.048f) + (y - 0.698f) * (y - 0.698f)) / 0.0005f);
    vec3s colour = statue_mix(skin, blush, z > 0.0f ? 0.55f * cheek : 0.0f);
    float mouth =
        (x / 0.0235f) * (x / 0.0235f) + ((y - 0.6655f) / 0.0115f) * ((y - 0.6655f) / 0.0115f);
    if (z > 0.06f)
        colour = statue_mix(lips, colour, gd_smoothstep(0.55f, 1.05f, gd_constant(mouth))[0]);
    float seam = fabsf(y - 3.2f * x * x - 0.6652f);
    if (x < 0.021f && z > 0.06f && seam < 0.0013f)
        colour = statue_shade(lips, 0.55f);
    /* Lashes along the seam, brows above. */
    float lash = fabsf(y - 0.7285f - 13.0f * (x - 0.034f) * (x - 0.034f));
    float taper = 1.0f - (x - 0.034f) * (x - 0.034f) / (0.0195f * 0.0195f);
    if (taper > 0.0f && lash < 0.0027f * sqrtf(taper) && z > 0.05f)
        colour = statue_shade(brown, 0.7f);
    float arch = fabsf(y - 0.7675f + 9.0f * (x - 0.038f) * (x - 0.038f));
    taper = 1.0f - (x - 0.037f) * (x - 0.037f) / (0.023f * 0.023f);
    if (taper > 0.0f && arch < 0.0034f * sqrtf(taper) && z > 0.04f)
        colour = statue_mix(colour, brown, 0.75f);
    return colour;
}

const statue_part statue_head = {.name = "head",
                                 .distance = head_distance,
                                 .colour = head_colour,
                                 .min = {{-0.15f, 0.42f, -0.17f}},
                                 .max = {{0.15f, 0.94f, 0.19f}},
                                 .blend = 0.006f};

/* A shell with a pointed crown, open in front; its rim is gilded. */
typedef struct hood_site {
    gen_dual away, rim; /* rim: distance back from the opening's edge */
} hood_site;

static hood_site hood_at(const gen_dual3 *p)
{
    gen_dual3 q = head_frame(p);
    gen_dual crown = blob(&q, 0.0f, 0.745f, -0.022f, 0.121f, 0.148f, 0.134f);
    gen_dual nape = blob(&q, 0.0f, 0.620f, -0.030f, 0.118f, 0.115f, 0.112f);
    gen_dual shell = gd_smooth_min(crown, nape, 0.07f);
    gen_dual peak = statue_limb(&q, (vec3s){{0.0f, 0.820f, -0.050f}},
                                (vec3s){{0.0f, 0.893f, -0.062f}}, 0.060f, 0.014f);
    shell = gd_smooth_min(shell, peak, 0.06f);
    /* Folds run back from the face and gather at the nape. */
    gen_dual run = gd_atan2(q.x, gd_shift(q.y, -0.62f));
    gen_dual folds = statue_pleat(run * 8.0f + q.z * 9.0f, 0.35f) * 0.006f;
    gen_dual back = gd_smoothstep(0.05f, -0.05f, q.z);
    shell = shell - gd_mul(folds, back);
    gen_dual lean = gd_square(gd_shift(q.y, -0.73f)) * 1.4f;
    gen_dual rim = gd_shift(-(q.z + lean), 0.062f);
    return (hood_site){shell, rim};
}

static gen_dual hood_distance(const gen_dual3 *p)
{
    hood_site site = hood_at(p);
    gen_dual rolled = gd_smoothstep(0.026f, 0.0f, site.rim);
    gen_dual half = gd_shift(rolled * 0.0035f, 0.0070f);
    gen_dual sheet = gd_abs(site.away) - half;
    gen_dual f = gd_smooth_max(sheet, -site.rim * 0.8f, 0.010f);
    return gd_smooth_max(f, gd_shift(-p->y, 0.560f), 0.02f) * 0.9f;
}

static vec3s hood_colour(vec3s p)
{
    gen_dual3 v = gd_variable(p.x, p.y, p.z);
    hood_site site = hood_at(&v);
    if (site.rim[0] < 0.026f)
        return statue_gold;
    if (site.away[0] < 0.0f)
        return statue_madder;
    return statue_shade(statue_teal, 0.95f + 0.05f * statue_mottle(p, 31.0f));
}

const statue_part statue_hood = {.name = "hood",
                                 .distance = hood_distance,
                                 .colour = hood_colour,
                                 .min = {{-0.19f, 0.51f, -0.22f}},
                                 .max = {{0.19f, 1.00f, 0.16f}},
                                 .blend = 0.008f};

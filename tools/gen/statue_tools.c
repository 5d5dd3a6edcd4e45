/* The tools from which the statue's parts are built. */
#include "tools/gen/statue.h"

const vec3s statue_gold = {{0.83f, 0.64f, 0.30f}};
const vec3s statue_madder = {{0.62f, 0.23f, 0.17f}};
const vec3s statue_teal = {{0.10f, 0.33f, 0.38f}};
const vec3s statue_ivory = {{0.90f, 0.85f, 0.74f}};

/* The slope at a knot: that of the parabola through it and its neighbours; level at the ends. */
static float knot_slope(const statue_knot *knots, int count, int i)
{
    if (i == 0 || i == count - 1)
        return 0.0f;
    float before = knots[i].at - knots[i - 1].at, after = knots[i + 1].at - knots[i].at;
    float slope_before = (knots[i].value - knots[i - 1].value) / before;
    float slope_after = (knots[i + 1].value - knots[i].value) / after;
    return (slope_before * after + slope_after * before) / (before + after);
}

gen_dual statue_profile(const statue_knot *knots, int count, gen_dual at)
{
    if (at[0] <= knots[0].at)
        return gd_constant(knots[0].value);
    if (at[0] >= knots[count - 1].at)
        return gd_constant(knots[count - 1].value);
    int i = 0;
    while (at[0] > knots[i + 1].at)
        i++;
    float width = knots[i + 1].at - knots[i].at, t = (at[0] - knots[i].at) / width;
    float p = knots[i].value, q = knots[i + 1].value;
    float m = knot_slope(knots, count, i) * width, n = knot_slope(knots, count, i + 1) * width;
    float a = 2.0f * p - 2.0f * q + m + n, b = -3.0f * p + 3.0f * q - 2.0f * m - n;
    float value = ((a * t + b) * t + m) * t + p;
    return gd_chain(at, value, ((3.0f * a * t + 2.0f * b) * t + m) / width);
}

gen_dual statue_limb(const gen_dual3 *p, vec3s a, vec3s b, float ra, float rb)
{
    float ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z;
    float inverse = 1.0f / (ux * ux + uy * uy + uz * uz);
    gen_dual3 d = {gd_shift(p->x, -a.x), gd_shift(p->y, -a.y), gd_shift(p->z, -a.z)};
    gen_dual t = (d.x * ux + d.y * uy + d.z * uz) * inverse;
    t = gd_clamp(t, 0.0f, 1.0f);
    gen_dual3 away = {d.x - t * ux, d.y - t * uy, d.z - t * uz};
    return gd_length3(away) - gd_shift(t * (rb - ra), ra);
}

gen_dual statue_ellipsoid(const gen_dual3 *p, vec3s centre, vec3s radii)
{
    gen_dual3 unit = {gd_shift(p->x, -centre.x) * (1.0f / radii.x),
                      gd_shift(p->y, -centre.y) * (1.0f / radii.y),
                      gd_shift(p->z, -centre.z) * (1.0f / radii.z)};
    gen_dual3 slope = {unit.x * (1.0f / radii.x), unit.y * (1.0f / radii.y),
                       unit.z * (1.0f / radii.z)};
    gen_dual k0 = gd_length3(unit), k1 = gd_length3(slope);
    if (k1[0] < 1e-6f)
        return gd_constant(-fminf(radii.x, fminf(radii.y, radii.z)));
    return gd_div(gd_mul(k0, gd_shift(k0, -1.0f)), k1);
}

gen_dual statue_pleat(gen_dual phase, float sharpness)
{
    float s = sinf(phase[0]), c = cosf(phase[0]), e = sharpness * sharpness;
    float root = sqrtf(s * s + e), full = sqrtf(1.0f + e) - sharpness;
    return gd_chain(phase, (root - sharpness) / full, s * c / (root * full));
}

vec3s statue_mix(vec3s a, vec3s b, float t)
{
    for (int i = 0; i < 3; i++)
        a.raw[i] += (b.raw[i] - a.raw[i]) * t;
    return a;
}

vec3s statue_shade(vec3s colour, float factor)
{
    return (vec3s){{colour.x * factor, colour.y * factor, colour.z * factor}};
}

float statue_mottle(vec3s p, float frequency)
{
    float x = p.x * frequency, y = p.y * frequency, z = p.z * frequency;
    float wide = sinf(x + 1.7f * sinf(y * 0.9f)) * sinf(y * 1.1f + 1.3f * sinf(z));
    float fine = sinf(2.3f * z + 1.9f * sinf(1.7f * x)) * sinf(2.9f * x - 2.1f * y);
    return 0.65f * wide + 0.35f * fine;
}

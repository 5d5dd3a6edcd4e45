/* The statue's round plinth: slabs, mouldings, beads, and an inscription cut into the drum. */
#include "tools/gen/statue.h"

#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

static const float drum_radius = 0.565f;
static const float band_middle = -0.927f, letter_height = 0.084f, letter_width = 0.056f;
static const float stroke = 0.0105f, cut_depth = 0.0085f;

/* One letter per cell. The text closes around the drum. */
static const char inscription[] = "STIPPLE * A SURFACE OUT OF POINTS * ";
enum { CELLS = sizeof inscription - 1 };

/* Strokes on a grid of 4 by 6: pairs of digits, x then y. A blank starts a new stroke. */
typedef struct glyph {
    char letter;
    const char *strokes;
} glyph;

static const glyph glyphs[] = {
    {'A', "002640 1232"},
    {'C', "4536160501103041"},
    {'E', "46060040 0333"},
    {'F', "460600 0333"},
    {'I', "2026"},
    {'L', "060040"},
    {'N', "00064046"},
    {'O', "100105163645413010"},
    {'P', "00063645443303"},
    {'R', "00063645443303 2340"},
    {'S', "011030414233130405163645"},
    {'T', "0646 2620"},
    {'U', "060110304146"},
    {'*', "2433221324"},
};

/* The nearest point of a letter's strokes so far, in grid units. */
typedef struct nearest {
    float x, y, square;
} nearest;

static void try_segment(nearest *best, float u, float v, const char *from, const char *to)
{
    float ax = (float)(from[0] - '0'), ay = (float)(from[1] - '0');
    float dx = (float)(to[0] - '0') - ax, dy = (float)(to[1] - '0') - ay;
    float t = ((u - ax) * dx + (v - ay) * dy) / (dx * dx + dy * dy);
    t = fminf(fmaxf(t, 0.0f), 1.0f);
    float x = ax + t * dx, y = ay + t * dy;
    float square = (u - x) * (u - x) + (v - y) * (v - y);
    if (square < best->square)
        *best = (nearest){x, y, square};
}

static const char *find_strokes(char letter)
{
    for (int i = 0; i < COUNT(glyphs); i++)
        if (glyphs[i].letter == letter)
            return glyphs[i].strokes;
    return "";
}

/* The distance to the nearest stroke of the inscription, along the drum. Far away it is a cell's
 * width. */
static gen_dual letter_distance(gen_dual angle, gen_dual y)
{
    const float cell_angle = 6.28318531f / (float)CELLS;
    const float unit_x = letter_width / 4.0f, unit_y = letter_height / 6.0f;
    float cell = floorf((angle[0] + 3.14159265f) / cell_angle);
    int index = (int)cell % CELLS;
    float middle = (cell + 0.5f) * cell_angle - 3.14159265f;
    /* The name is in front: cell 0 is three and a half letters left of the middle. */
    const char *strokes = find_strokes(inscription[(index + CELLS / 2 + 3) % CELLS]);
    gen_dual along = gd_shift(angle, -middle) * drum_radius;
    float u = along[0] / unit_x + 2.0f, v = (y[0] - band_middle) / unit_y + 3.0f;
    nearest best = {u, v, 1e9f};
    for (const char *s = strokes; s[0] != '\0' && s[2] != '\0'; s += 2) {
        if (s[2] == ' ') {
            s++;
            continue;
        }
        try_segment(&best, u, v, s, s + 2);
    }
    if (best.square > 1e8f)
        return gd_constant(cell_angle * drum_radius);
    gen_dual du = gd_shift(along, -(best.x - 2.0f) * unit_x);
    gen_dual dv = gd_shift(y, -(band_middle + (best.y - 3.0f) * unit_y));
    return gd_length2(du, dv);
}

/* A round slab between two heights with rounded rims. */
static gen_dual slab(gen_dual rho, gen_dual y, float radius, float low, float high, float round)
{
    gen_dual across = gd_shift(rho, -radius);
    gen_dual tall = gd_shift(gd_abs(gd_shift(y, -0.5f * (low + high))), -0.5f * (high - low));
    return gd_smooth_max(across, tall, round);
}

static gen_dual ring(gen_dual rho, gen_dual y, float radius, float height, float thickness)
{
    return gd_shift(gd_length2(gd_shift(rho, -radius), gd_shift(y, -height)), -thickness);
}

static gen_dual plinth_distance(const gen_dual3 *p)
{
    gen_dual rho = gd_length2(p->x, p->z), y = p->y;
    gen_dual angle = gd_atan2(p->x, p->z);
    gen_dual drum = gd_shift(rho, -drum_radius);
    if (fabsf(y[0] - band_middle) < 0.09f && drum[0] > -0.05f) {
        gen_dual cut = gd_smoothstep(stroke, 0.15f * stroke, letter_distance(angle, y));
        drum = drum + cut * cut_depth;
    }
    gen_dual tall = gd_shift(gd_abs(gd_shift(y, 0.935f)), -0.12f);
    gen_dual f = gd_smooth_max(drum, tall, 0.006f);
    f = gd_smooth_min(f, slab(rho, y, 0.602f, -0.832f, -0.785f, 0.022f), 0.004f);
    f = gd_smooth_min(f, slab(rho, y, 0.640f, -1.100f, -1.030f, 0.026f), 0.004f);
    f = gd_smooth_min(f, ring(rho, y, 0.578f, -1.010f, 0.022f), 0.006f);
    /* A row of beads under the upper slab. */
    gen_dual run = gd_abs(gd_sin(angle * 66.0f));
    gen_dual bead = gd_sqrt(gd_shift(run, 0.02f)) * 0.0125f;
    gen_dual beads = gd_length2(gd_shift(rho, -0.572f), gd_shift(y, 0.848f)) - bead;
    return gd_smooth_min(f, beads * 0.7f, 0.003f) * 0.9f;
}

static vec3s plinth_colour(vec3s q)
{
    static const vec3s stone = {{0.66f, 0.58f, 0.48f}}, vein = {{0.45f, 0.36f, 0.30f}};
    static const vec3s dark = {{0.27f, 0.16f, 0.12f}}, band = {{0.80f, 0.73f, 0.61f}};
    float rho = sqrtf(q.x * q.x + q.z * q.z);
    float wave = statue_mottle(q, 6.0f) + 0.5f * statue_mottle(q, 17.0f);
    float line = expf(-60.0f * wave * wave);
    vec3s colour = statue_mix(stone, vein, 0.35f * line);
    bool on_drum = rho > drum_radius - 0.03f && rho < drum_radius + 0.004f;
    if (on_drum && q.y > -0.995f && q.y < -0.875f) {
        gen_dual3 p = gd_variable(q.x, q.y, q.z);
        float away = letter_distance(gd_atan2(p.x, p.z), p.y)[0];
        colour = statue_mix(band, vein, 0.15f * line);
        return statue_mix(dark, colour,
                          gd_smoothstep(0.75f * stroke, 1.0f * stroke, gd_constant(away))[0]);
    }
    if (on_drum && q.y > -1.0f && q.y < -0.865f)
        return statue_madder;
    if (rho > 0.555f && q.y > -0.864f && q.y < -0.833f)
        return statue_gold;
    return colour;
}

const statue_part statue_plinth = {.name = "plinth",
                                   .distance = plinth_distance,
                                   .colour = plinth_colour,
                                   .min = {{-0.67f, -1.13f, -0.67f}},
                                   .max = {{0.67f, -0.75f, 0.67f}},
                                   .blend = 0.010f};

/* A square kilometre of hills: ridged fractal noise, terraced cliffs, a meandering valley; z up. */
#include "base/random.h"
#include "tools/gen/dual.h"
#include "tools/gen/grid.h"

static const float half_side_m = 500.0f;

/* Smooth noise in -1..1 over the unit lattice, twice differentiable. */
static gen_dual noise(uint64_t seed, gen_dual x, gen_dual y)
{
    float fx = floorf(x[0]), fy = floorf(y[0]);
    float u = x[0] - fx, v = y[0] - fy;
    float corner[2][2];
    for (int j = 0; j < 2; j++)
        for (int i = 0; i < 2; i++) {
            uint64_t cell =
                (uint64_t)((int64_t)fx + i + 0x10000) << 20 | (uint64_t)((int64_t)fy + j + 0x10000);
            corner[j][i] = (float)(2.0 * stp_random_unit(seed, cell) - 1.0);
        }
    float wu = u * u * u * (u * (u * 6.0f - 15.0f) + 10.0f);
    float wv = v * v * v * (v * (v * 6.0f - 15.0f) + 10.0f);
    float du = 30.0f * u * u * (u - 1.0f) * (u - 1.0f);
    float dv = 30.0f * v * v * (v - 1.0f) * (v - 1.0f);
    float near = corner[0][0] + (corner[0][1] - corner[0][0]) * wu;
    float far = corner[1][0] + (corner[1][1] - corner[1][0]) * wu;
    float near_slope = (corner[0][1] - corner[0][0]) * du;
    float far_slope = (corner[1][1] - corner[1][0]) * du;
    gen_dual result = x * (near_slope + (far_slope - near_slope) * wv) + y * ((far - near) * dv);
    result[0] = near + (far - near) * wv;
    return result;
}

/* Ridges where the noise changes sign, slightly rounded. Each octave is rougher on high ground, as
 * erosion leaves it. Source: Musgrave's ridged multifractal (Ebert et al., "Texturing and
 * Modeling"). */
static gen_dual ridges(uint64_t seed, gen_dual x, gen_dual y)
{
    gen_dual sum = gd_constant(0.0f), weight = gd_constant(1.0f);
    float amplitude = 0.5f;
    for (uint64_t octave = 0; octave < 7; octave++) {
        gen_dual n = noise(seed + octave, x, y);
        gen_dual fold = gd_sqrt(gd_shift(gd_square(n), 0.004f));
        gen_dual ridge = gd_square(gd_shift(-fold, 1.03f));
        ridge = gd_mul(ridge, weight);
        sum = sum + ridge * amplitude;
        weight = gd_smoothstep(-0.1f, 1.0f, ridge);
        /* Rotates and doubles, so that the octaves' lattices do not line up. */
        gen_dual turned = x * 1.62f - y * 1.18f;
        y = gd_shift(x * 1.18f + y * 1.62f, 17.3f);
        x = gd_shift(turned, 5.1f);
        amplitude *= 0.5f;
    }
    return sum;
}

/* Terraces of the given step where the mask is 1. The risers are the cliffs. */
static gen_dual terrace(gen_dual height, float step, gen_dual mask)
{
    float level = floorf(height[0] / step);
    gen_dual within = gd_shift(height * (1.0f / step), -level);
    gen_dual stepped = gd_shift(gd_smoothstep(0.25f, 0.75f, within), level) * step;
    return gd_mix(height, stepped, mask);
}

static gen_dual height_m(uint64_t seed, gen_dual x, gen_dual y)
{
    gen_dual u = x * (1.0f / 260.0f), v = y * (1.0f / 260.0f);
    gen_dual warp_u = noise(seed + 101, u * 1.3f, v * 1.3f);
    gen_dual warp_v = noise(seed + 102, u * 1.3f, v * 1.3f);
    gen_dual height = ridges(seed + 201, u + warp_u * 0.35f, v + warp_v * 0.35f) * 170.0f;
    gen_dual cliffs = gd_smoothstep(0.0f, 0.35f, noise(seed + 103, u * 0.9f, v * 0.9f));
    height = terrace(height, 28.0f, cliffs * 0.85f);
    /* The valley: a winding line with banks, and a level floor. */
    gen_dual bend = gd_sin(y * (1.0f / 120.0f)) * 90.0f + gd_sin(y * (1.0f / 47.0f)) * 22.0f;
    gen_dual away = gd_abs(x - bend);
    gen_dual land = gd_smoothstep(12.0f, 190.0f, away);
    gen_dual rough = noise(seed + 104, x * 0.11f, y * 0.11f) * 0.6f;
    return gd_mul(height, land) + rough;
}

static vec3s mix_colour(vec3s a, vec3s b, float t)
{
    for (int i = 0; i < 3; i++)
        a.raw[i] += (b.raw[i] - a.raw[i]) * t;
    return a;
}

static vec3s ground_colour(uint64_t seed, float x, float y, gen_dual height, float up)
{
    static const vec3s silt = {{0.62f, 0.57f, 0.46f}}, grass = {{0.36f, 0.45f, 0.20f}};
    static const vec3s meadow = {{0.55f, 0.53f, 0.30f}}, rock = {{0.47f, 0.42f, 0.38f}};
    static const vec3s snow = {{0.93f, 0.95f, 0.97f}};
    gen_dual3 p = gd_variable(x, y, 0.0f);
    float patch = noise(seed + 301, p.x * 0.03f, p.y * 0.03f)[0];
    float grain = noise(seed + 302, p.x * 0.7f, p.y * 0.7f)[0];
    vec3s colour = mix_colour(silt, grass, gd_smoothstep(1.0f, 7.0f, height)[0]);
    colour = mix_colour(colour, meadow, 0.5f + 0.5f * patch);
    gen_dual line = gd_constant(height[0] + 14.0f * patch);
    colour = mix_colour(colour, snow, gd_smoothstep(112.0f, 128.0f, line)[0]);
    colour = mix_colour(rock, colour, gd_smoothstep(0.68f, 0.84f, gd_constant(up))[0]);
    float shade = 1.0f + 0.07f * grain;
    return (vec3s){{colour.x * shade, colour.y * shade, colour.z * shade}};
}

static void terrain_project(const gen_surface *surface, stp_dvec3 start, gen_hit *hit)
{
    uint64_t seed = stp_random_u64(surface->seed, 7);
    gen_dual3 p = gd_variable((float)start.x, (float)start.y, 0.0f);
    gen_dual height = height_m(seed, p.x, p.y);
    float up = 1.0f / sqrtf(1.0f + height[1] * height[1] + height[2] * height[2]);
    hit->position = (stp_dvec3){(double)p.x[0], (double)p.y[0], (double)height[0]};
    hit->normal = (vec3s){{-height[1] * up, -height[2] * up, up}};
    hit->colour = ground_colour(seed, p.x[0], p.y[0], height, up);
    hit->class_id = 0;
}

static stp_dvec3 terrain_map(const gen_surface *surface, double u, double v)
{
    gen_hit hit;
    double side = 2.0 * (double)half_side_m;
    stp_dvec3 flat = {(u - 0.5) * side, (v - 0.5) * side, 0.0};
    terrain_project(surface, flat, &hit);
    return hit.position;
}

static stp_status terrain_mesh(const gen_surface *surface, uint64_t triangle_count, stp_pool *pool,
                               gen_mesh *out, stp_error *err)
{
    (void)pool;
    size_t side = (size_t)ceil(sqrt((double)triangle_count / 2.0));
    gen_grid grid = {.map = terrain_map, .columns = side, .rows = side};
    return gen_grid_mesh(surface, &grid, 1, out, err);
}

void gen_terrain_init(gen_surface *surface)
{
    surface->proxy_triangles = 500000;
    surface->mesh_triangles = 2000000;
    surface->centre = (stp_dvec3){0.0, 0.0, 60.0};
    surface->radius = (double)half_side_m * sqrt(2.1);
    surface->mesh = terrain_mesh;
    surface->project = terrain_project;
}

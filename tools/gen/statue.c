/* The statue: the union of its parts, and the colour of whichever is nearest. */
#include "tools/gen/statue.h"

static const statue_part *const parts[] = {
#define X(name) &statue_##name,
    STATUE_PARTS(X)
#undef X
};
enum { PART_COUNT = sizeof parts / sizeof *parts };

/* The distance of p from a part's box; 0 inside. */
static float box_distance(const statue_part *part, vec3s p)
{
    float square = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        float low = part->min.raw[axis] - p.raw[axis], high = p.raw[axis] - part->max.raw[axis];
        float out = fmaxf(fmaxf(low, high), 0.0f);
        square += out * out;
    }
    return sqrtf(square);
}

gen_dual gen_statue_distance(vec3s p, unsigned *part)
{
    gen_dual3 q = gd_variable(p.x, p.y, p.z);
    gen_dual f = gd_constant(1e3f);
    float nearest = 1e3f;
    for (unsigned i = 0; i < PART_COUNT; i++) {
        float away = box_distance(parts[i], p);
        if (away > 0.0f) {
            if (away + statue_margin < f[0])
                f = gd_constant(away + statue_margin);
            continue;
        }
        gen_dual d = parts[i]->distance(&q);
        if (d[0] < nearest) {
            nearest = d[0];
            if (part != NULL)
                *part = i;
        }
        f = gd_smooth_min(f, d, parts[i]->blend);
    }
    return f;
}

static stp_status statue_mesh(const gen_surface *surface, uint64_t triangle_count, stp_pool *pool,
                              gen_mesh *out, stp_error *err)
{
    (void)surface;
    gen_implicit_box box = {{{-0.92f, -1.15f, -0.69f}}, {{0.92f, 1.10f, 0.69f}}, 1.6f};
    return gen_implicit_mesh(gen_statue_distance, &box,
                             sqrtf(13.0f * 11.0f / (float)triangle_count), pool, out, err);
}

/* Hollow places are darker. Measures how hollow: how much nearer the surface is, a little way out
 * along the normal, than over a plane. */
static float hollow(vec3s p, vec3s normal, float reach)
{
    vec3s out = {{p.x + reach * normal.x, p.y + reach * normal.y, p.z + reach * normal.z}};
    float free = gen_statue_distance(out, NULL)[0] / (0.85f * reach);
    return 1.0f - fminf(fmaxf(free, 0.0f), 1.0f);
}

static void statue_project(const gen_surface *surface, stp_dvec3 start, gen_hit *hit)
{
    (void)surface;
    unsigned part = 0;
    vec3s p = gen_implicit_project(gen_statue_distance, stp_dvec3_to_float(start), 0.02f,
                                   &hit->normal, &part);
    hit->position = stp_dvec3_from_float(p);
    hit->colour =
        statue_shade(parts[part]->colour(p), 1.0f - 0.45f * hollow(p, hit->normal, 0.02f));
    hit->class_id = 0;
}

/* Least number of triangles of the proxy. A coarse proxy bridges narrow gaps. The samples then have
 * holes there, which show once samples are denser than triangles. */
#define PROXY_LEAST 700000u
#define PROXY_MOST 8000000u

void gen_statue_init(gen_surface *surface, uint64_t point_count)
{
    uint64_t proxy = point_count / 2;
    proxy = proxy < PROXY_LEAST ? PROXY_LEAST : proxy;
    surface->closed = true;
    surface->proxy_triangles = proxy < PROXY_MOST ? proxy : PROXY_MOST;
    surface->mesh_triangles = 3000000;
    surface->radius = 1.35;
    surface->mesh = statue_mesh;
    surface->project = statue_project;
}

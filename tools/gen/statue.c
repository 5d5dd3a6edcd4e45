/* The statue: temporary first version. */
#include "tools/gen/implicit.h"

static gen_dual statue(vec3s q)
{
    gen_dual3 p = gd_variable(q.x, q.y, q.z);
    gen_dual rho = gd_length2(p.x, p.z);
    gen_dual angle = gd_atan2(p.x, p.z);
    gen_dual t = gd_smoothstep(-0.8f, 0.6f, p.y);
    gen_dual fold = gd_sin(angle * 9.0f + gd_sin(p.y * 4.0f) * 1.5f);
    fold = gd_sqrt(gd_shift(gd_square(fold), 0.01f)) * 0.05f;
    gen_dual radius = gd_shift(t * -0.28f, 0.40f) + gd_mul(fold, gd_shift(-t, 1.0f));
    gen_dual robe = (rho - radius) * 0.7f;
    robe = gd_smooth_max(robe, gd_shift(p.y, -0.62f), 0.08f);
    robe = gd_smooth_max(robe, gd_shift(-p.y, -0.82f), 0.02f);
    gen_dual3 h = {p.x, gd_shift(p.y, -0.78f) * 0.8f, p.z};
    gen_dual head = gd_shift(gd_length3(h), -0.15f);
    gen_dual f = gd_smooth_min(robe, head, 0.06f);
    gen_dual drum =
        gd_smooth_max(gd_shift(rho, -0.55f), gd_shift(gd_abs(gd_shift(p.y, 0.9f)), -0.1f), 0.03f);
    return gd_smooth_min(f, drum, 0.01f);
}

static stp_status statue_mesh(const gen_surface *surface, uint64_t triangle_count, stp_pool *pool,
                              gen_mesh *out, stp_error *err)
{
    (void)surface;
    gen_implicit_box box = {{{-0.7f, -1.1f, -0.7f}}, {{0.7f, 1.1f, 0.7f}}, 2.0f};
    return gen_implicit_mesh(statue, &box, sqrtf(13.0f * 5.0f / (float)triangle_count), pool, out,
                             err);
}

static void statue_project(const gen_surface *surface, stp_dvec3 start, gen_hit *hit)
{
    (void)surface;
    vec3s p = gen_implicit_project(statue, stp_dvec3_to_float(start), &hit->normal);
    hit->position = stp_dvec3_from_float(p);
    hit->colour = (vec3s){{0.6f, 0.5f + 0.2f * p.y, 0.4f}};
    hit->class_id = 0;
}

void gen_statue_init(gen_surface *surface)
{
    surface->closed = true;
    surface->proxy_triangles = 400000;
    surface->mesh_triangles = 1500000;
    surface->radius = 1.3;
    surface->mesh = statue_mesh;
    surface->project = statue_project;
}

/* The plain shapes: sphere, plane, torus, and the sheet with two near sides. */
#include "tools/gen/grid.h"

#define TWO_PI 6.283185307179586

/* Torus: radius of the ring and of the tube. */
static const double ring_radius = 0.7, tube_radius = 0.3;

/* A soft checker in two hues, so that colour errors show. */
static vec3s checker(double u, double v)
{
    double wave = sin(TWO_PI * u) * sin(TWO_PI * v);
    float t = (float)(0.5 + 0.5 * tanh(4.0 * wave));
    return (vec3s){{0.20f + 0.65f * t, 0.45f + 0.25f * t, 0.60f - 0.35f * t}};
}

static void sphere_project(const gen_surface *surface, stp_dvec3 start, gen_hit *hit)
{
    (void)surface;
    stp_dvec3 n = stp_dvec3_normalize(start);
    hit->position = n;
    hit->normal = stp_dvec3_to_float(n);
    hit->colour = checker(atan2(n.x, n.z) / TWO_PI * 12.0, n.y * 4.0);
    hit->class_id = 0;
}

void gen_sphere_init(gen_surface *surface)
{
    surface->closed = true;
    surface->proxy_triangles = 80000;
    surface->mesh_triangles = 500000;
    surface->radius = 1.0;
    surface->mesh = gen_star_mesh;
    surface->project = sphere_project;
}

static stp_dvec3 plane_map(const gen_surface *surface, double u, double v)
{
    (void)surface;
    return (stp_dvec3){2.0 * u - 1.0, 2.0 * v - 1.0, 0.0};
}

static void plane_project(const gen_surface *surface, stp_dvec3 start, gen_hit *hit)
{
    (void)surface;
    hit->position = (stp_dvec3){start.x, start.y, 0.0};
    hit->normal = (vec3s){{0.0f, 0.0f, 1.0f}};
    hit->colour = checker(start.x * 4.0, start.y * 4.0);
    hit->class_id = 0;
}

static gen_grid square_grid(gen_grid_map *map, uint64_t triangle_count)
{
    size_t side = (size_t)ceil(sqrt((double)triangle_count / 2.0));
    return (gen_grid){.map = map, .columns = side ? side : 1, .rows = side ? side : 1};
}

static stp_status plane_mesh(const gen_surface *surface, uint64_t triangle_count, stp_pool *pool,
                             gen_mesh *out, stp_error *err)
{
    (void)pool;
    gen_grid grid = square_grid(plane_map, triangle_count);
    return gen_grid_mesh(surface, &grid, 1, out, err);
}

void gen_plane_init(gen_surface *surface)
{
    surface->proxy_triangles = 8192;
    surface->mesh_triangles = 20000;
    surface->radius = sqrt(2.0);
    surface->mesh = plane_mesh;
    surface->project = plane_project;
}

static stp_dvec3 torus_map(const gen_surface *surface, double u, double v)
{
    (void)surface;
    double a = TWO_PI * u, b = TWO_PI * v, r = ring_radius + tube_radius * cos(b);
    return (stp_dvec3){r * sin(a), tube_radius * sin(b), r * cos(a)};
}

static void torus_project(const gen_surface *surface, stp_dvec3 start, gen_hit *hit)
{
    (void)surface;
    double around = hypot(start.x, start.z);
    stp_dvec3 core = {start.x / around * ring_radius, 0.0, start.z / around * ring_radius};
    stp_dvec3 n = stp_dvec3_normalize(stp_dvec3_sub(start, core));
    hit->position = stp_dvec3_add(core, stp_dvec3_scale(n, tube_radius));
    hit->normal = stp_dvec3_to_float(n);
    double b = atan2(n.y, (n.x * core.x + n.z * core.z) / ring_radius);
    hit->colour = checker(atan2(start.x, start.z) / TWO_PI * 12.0, b / TWO_PI * 6.0);
    hit->class_id = 0;
}

static stp_status torus_mesh(const gen_surface *surface, uint64_t triangle_count, stp_pool *pool,
                             gen_mesh *out, stp_error *err)
{
    (void)pool;
    size_t rows = (size_t)ceil(sqrt((double)triangle_count * tube_radius / ring_radius / 2.0));
    rows = rows < 8 ? 8 : rows;
    size_t columns = (size_t)ceil((double)rows * ring_radius / tube_radius);
    gen_grid grid = {.map = torus_map, .columns = columns, .rows = rows, .wraps = true};
    return gen_grid_mesh(surface, &grid, 1, out, err);
}

void gen_torus_init(gen_surface *surface)
{
    surface->closed = true;
    surface->proxy_triangles = 100000;
    surface->mesh_triangles = 500000;
    surface->radius = ring_radius + tube_radius;
    surface->mesh = torus_mesh;
    surface->project = torus_project;
}

static stp_dvec3 sheet_front(const gen_surface *surface, double u, double v)
{
    return (stp_dvec3){2.0 * u - 1.0, 2.0 * v - 1.0, 0.5 * surface->separation};
}

static stp_dvec3 sheet_back(const gen_surface *surface, double u, double v)
{
    return (stp_dvec3){1.0 - 2.0 * u, 2.0 * v - 1.0, -0.5 * surface->separation};
}

/* Side A faces +z, is reddish and class 1; side B faces -z, bluish, class 2. */
static void sheet_project(const gen_surface *surface, stp_dvec3 start, gen_hit *hit)
{
    bool front = start.z > 0.0;
    double z = 0.5 * surface->separation;
    float shade = 0.25f * checker(start.x * 4.0, start.y * 4.0).x;
    hit->position = (stp_dvec3){start.x, start.y, front ? z : -z};
    hit->normal = (vec3s){{0.0f, 0.0f, front ? 1.0f : -1.0f}};
    hit->colour = front ? (vec3s){{0.70f + shade, 0.10f + shade, 0.08f}}
                        : (vec3s){{0.08f, 0.15f + shade, 0.70f + shade}};
    hit->class_id = front ? 1 : 2;
}

static stp_status sheet_mesh(const gen_surface *surface, uint64_t triangle_count, stp_pool *pool,
                             gen_mesh *out, stp_error *err)
{
    (void)pool;
    const gen_grid sides[2] = {square_grid(sheet_front, triangle_count / 2),
                               square_grid(sheet_back, triangle_count / 2)};
    return gen_grid_mesh(surface, sides, 2, out, err);
}

void gen_sheet_init(gen_surface *surface, uint64_t point_count)
{
    /* The two sides of 2 x 2 share the points. */
    surface->separation = sqrt(8.0 / (double)(point_count ? point_count : 1));
    surface->has_class = true;
    surface->proxy_triangles = 8192;
    surface->mesh_triangles = 40000;
    surface->radius = sqrt(2.0 + 0.25 * surface->separation * surface->separation);
    surface->mesh = sheet_mesh;
    surface->project = sheet_project;
}

/* Tests the true meshes of the known surfaces (closed, in one piece, of the right volume, near
 * enough to the surface), what scanner stations see, and the exact picture. */
#include "base/random.h"
#include "tests/fixtures/statue_kept.h"
#include "tools/gen/sampler.h"
#include "tools/gen/statue.h"
#include "tools/gen/truth.h"
#include "tools/gen/visibility.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

static stp_pool *pool;

static int set_up(void **state)
{
    (void)state;
    return stp_pool_create(&pool, 0, NULL) == STP_OK ? 0 : -1;
}

static int tear_down(void **state)
{
    (void)state;
    stp_pool_destroy(&pool);
    return 0;
}

static int compare_edges(const void *a, const void *b)
{
    uint64_t p = *(const uint64_t *)a, q = *(const uint64_t *)b;
    return p < q ? -1 : p > q;
}

/* Every directed edge must occur once, and its opposite once: the mesh is closed, manifold along
 * edges, and oriented. */
static void assert_closed(const gen_mesh *mesh)
{
    size_t count = 3 * mesh->triangle_count;
    uint64_t *edges = calloc(count, 2 * sizeof *edges);
    assert_non_null(edges);
    uint64_t *opposite = edges + count;
    for (size_t i = 0; i < count; i++) {
        const uint32_t *t = mesh->triangles[i / 3];
        uint64_t from = t[i % 3], to = t[(i + 1) % 3];
        assert_true(from < mesh->vertex_count && from != to);
        edges[i] = from << 32 | to;
        opposite[i] = to << 32 | from;
    }
    qsort(edges, count, sizeof *edges, compare_edges);
    qsort(opposite, count, sizeof *edges, compare_edges);
    for (size_t i = 1; i < count; i++)
        assert_true(edges[i - 1] < edges[i]);
    assert_memory_equal(edges, opposite, count * sizeof *edges);
    free(edges);
}

static uint32_t find_root(uint32_t *parents, uint32_t i)
{
    while (parents[i] != i) {
        parents[i] = parents[parents[i]];
        i = parents[i];
    }
    return i;
}

static size_t count_pieces(const gen_mesh *mesh)
{
    uint32_t *parents = calloc(mesh->vertex_count, sizeof *parents);
    assert_non_null(parents);
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        parents[i] = i;
    for (size_t i = 0; i < mesh->triangle_count; i++)
        for (int k = 1; k < 3; k++)
            parents[find_root(parents, mesh->triangles[i][k])] =
                find_root(parents, mesh->triangles[i][0]);
    size_t pieces = 0;
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        pieces += parents[i] == i;
    free(parents);
    return pieces;
}

static stp_dvec3 corner(const gen_mesh *mesh, size_t triangle, int k)
{
    return stp_dvec3_from_float(mesh->positions[mesh->triangles[triangle][k]]);
}

/* The volume by Gauss's theorem. */
static double volume(const gen_mesh *mesh)
{
    double sum = 0.0;
    for (size_t i = 0; i < mesh->triangle_count; i++)
        sum += stp_dvec3_dot(corner(mesh, i, 0),
                             stp_dvec3_cross(corner(mesh, i, 1), corner(mesh, i, 2)));
    return sum / 6.0;
}

/* Points minus edges plus faces. */
static long euler(const gen_mesh *mesh)
{
    return (long)mesh->vertex_count - (long)(mesh->triangle_count / 2);
}

static void test_plain_meshes(void **state)
{
    (void)state;
    const double pi = 3.14159265358979323846;
    static const gen_shape shapes[] = {GEN_SPHERE, GEN_TORUS, GEN_BUMPY};
    const double volumes[] = {4.0 / 3.0 * pi, 2.0 * pi * pi * 0.7 * 0.09, 0.0};
    for (int i = 0; i < 3; i++) {
        gen_surface surface;
        gen_mesh mesh = {0};
        gen_surface_init(&surface, shapes[i], 1, 0);
        assert_int_equal(surface.mesh(&surface, 200000, pool, &mesh, NULL), STP_OK);
        assert_true(mesh.triangle_count > 150000 && mesh.triangle_count < 300000);
        assert_closed(&mesh);
        assert_int_equal(count_pieces(&mesh), 1);
        assert_int_equal(euler(&mesh), shapes[i] == GEN_TORUS ? 0 : 2);
        if (volumes[i] > 0.0)
            assert_true(fabs(volume(&mesh) / volumes[i] - 1.0) < 2e-4);
        gen_mesh_clear(&mesh);
    }
}

static float slope(gen_dual f)
{
    return sqrtf(f[1] * f[1] + f[2] * f[2] + f[3] * f[3]);
}

/* The statue's volume, estimated by counting random points inside. */
static double counted_volume(double *standard_error)
{
    enum { COUNT = 1000000 };
    const double size[3] = {1.84, 2.3, 1.4}, low[3] = {-0.92, -1.15, -0.7};
    size_t inside = 0;
    for (uint64_t i = 0; i < COUNT; i++) {
        vec3s p;
        for (uint64_t axis = 0; axis < 3; axis++)
            p.raw[axis] = (float)(low[axis] + size[axis] * stp_random_unit(axis, i));
        inside += gen_statue_distance(p, NULL)[0] < 0.0f;
    }
    double part = (double)inside / COUNT, box = size[0] * size[1] * size[2];
    *standard_error = box * sqrt(part * (1.0 - part) / COUNT);
    return box * part;
}

/* Judges this part of the statue's triangles, and what stations see of the torus. With --every, as
 * in long_gen_mesh, judges all triangles, and what stations see of the statue, too. */
static size_t part = 4;

static void test_statue_mesh(void **state)
{
    (void)state;
    gen_surface surface;
    gen_mesh mesh = {0};
    gen_surface_init(&surface, GEN_STATUE, 1, 0);
    assert_int_equal(surface.mesh(&surface, surface.mesh_triangles / part, pool, &mesh, NULL),
                     STP_OK);
    assert_closed(&mesh);
    assert_int_equal(count_pieces(&mesh), 1);
    double standard_error, counted = counted_volume(&standard_error);
    assert_true(fabs(volume(&mesh) - counted) < 5.0 * standard_error);
    /* Corners must lie on the surface. The centres of triangles may be off by a fiftieth of the
     * spacing of a million samples on average, and 99 % of them by less than a quarter of it. With
     * a part of the triangles they are off by as much more. */
    const double spacing = 3.687e-3 * (double)part;
    double sum = 0.0;
    size_t far = 0;
    for (size_t i = 0; i < mesh.triangle_count; i++) {
        stp_dvec3 middle = stp_dvec3_add(corner(&mesh, i, 0), stp_dvec3_add(corner(&mesh, i, 1), //
                                                                            corner(&mesh, i, 2)));
        gen_dual f =
            gen_statue_distance(stp_dvec3_to_float(stp_dvec3_scale(middle, 1.0 / 3.0)), NULL);
        double away = (double)fabsf(f[0] / slope(f));
        sum += away;
        far += away > 0.25 * spacing;
    }
    assert_true(sum / (double)mesh.triangle_count < spacing / 50.0);
    assert_true(far < mesh.triangle_count / 100);
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        gen_dual f = gen_statue_distance(mesh.positions[i], NULL);
        assert_true(fabsf(f[0] / slope(f)) < 1e-5f);
    }
    gen_mesh_clear(&mesh);
}

/* The signed distance: exact for the torus, and at most twice too large for the statue. */
static double distance(gen_shape shape, stp_dvec3 p)
{
    if (shape == GEN_TORUS)
        return hypot(hypot(p.x, p.z) - 0.7, p.y) - 0.3;
    return (double)gen_statue_distance(stp_dvec3_to_float(p), NULL)[0];
}

/* Whether the segment from a point of the surface to a station goes deeper into the solid than
 * depth. With a negative depth: whether it comes nearer to the solid than -depth. The first 0.02 of
 * the way is ignored. */
static bool is_hidden(gen_shape shape, stp_dvec3 from, stp_dvec3 to, double depth)
{
    stp_dvec3 way = stp_dvec3_sub(to, from);
    double length = stp_dvec3_length(way), t = 0.02;
    while (t < length) {
        stp_dvec3 p = stp_dvec3_add(from, stp_dvec3_scale(way, t / length));
        if (stp_dvec3_length(p) > 1.4 && t > 1.4)
            return false;
        double d = distance(shape, p);
        if (d < -depth)
            return true;
        t += fmax(0.5 * fabs(d + depth), 3e-3);
    }
    return false;
}

/* Whether a station sees a point, with some tolerance in depth. */
static bool sees(gen_shape shape, stp_dvec3 station, const gen_hit *hit, double grazing,
                 double depth)
{
    stp_dvec3 way = stp_dvec3_sub(station, hit->position);
    double facing = stp_dvec3_dot(stp_dvec3_from_float(hit->normal), way);
    return facing > grazing * stp_dvec3_length(way) &&
           !is_hidden(shape, hit->position, station, depth);
}

/* Whether any station sees the point. */
static bool is_seen(gen_shape shape, const gen_sampler *sampler, size_t stations,
                    const gen_hit *hit, double grazing, double depth)
{
    for (size_t i = 0; i < stations; i++)
        if (sees(shape, gen_sampler_stations(sampler)[i], hit, grazing, depth))
            return true;
    return false;
}

/* The station that a point names must see it. If two see it, either may be named. */
static void check_named_stations(gen_shape shape, const stp_dvec3 *stations, size_t station_count,
                                 const stp_point *points, const gen_hit *hits, size_t count)
{
    size_t named[GEN_STATION_LIMIT + 1] = {0}, shared = 0, first = 0;
    for (size_t j = 0; j < count; j++) {
        size_t own = points[j].station;
        assert_in_range(own, 1, station_count);
        assert_true(sees(shape, stations[own - 1], &hits[j], 0.079, 0.003));
        named[own]++;
        for (size_t other = 1; other <= station_count; other++) {
            if (other == own || !sees(shape, stations[other - 1], &hits[j], 0.081, -0.003))
                continue;
            shared++;
            first += own < other;
        }
    }
    for (size_t j = 1; j <= station_count; j++)
        assert_true(named[j] > count / 10);
    assert_true(shared >= 50);
    assert_true(first > shared / 10 && first < shared - shared / 10);
}

static void test_stations_see_what_nothing_hides(void **state)
{
    (void)state;
    enum { COUNT = 1500, STATIONS = 3 };
    static stp_point points[COUNT];
    static gen_hit all[COUNT], seen[COUNT];
    static const gen_shape shapes[] = {GEN_TORUS, GEN_STATUE};
    for (int i = 0; i < (part == 1 ? 2 : 1); i++) {
        gen_surface surface;
        gen_sampler *whole = NULL, *some = NULL;
        statue_kept_init(&surface, shapes[i], COUNT, 0);
        gen_sampler_params params = {
            .surface = &surface, .point_count = COUNT, .random_order = true};
        assert_int_equal(gen_sampler_create(&whole, &params, pool, NULL), STP_OK);
        gen_sampler_fill(whole, 0, COUNT, points, all);
        params.station_count = STATIONS;
        assert_int_equal(gen_sampler_create(&some, &params, pool, NULL), STP_OK);
        gen_sampler_fill(some, 0, COUNT, points, seen);
        /* the scan may contain nothing that is plainly hidden */
        size_t hidden = 0;
        for (size_t j = 0; j < COUNT; j++)
            hidden += !is_seen(shapes[i], some, STATIONS, &seen[j], 0.079, 0.003);
        assert_true(hidden == 0);
        check_named_stations(shapes[i], gen_sampler_stations(some), STATIONS, points, seen, COUNT);
        /* the scan must contain as much of the surface as the test's own rays see, between a strict
         * and a lenient count */
        size_t least = 0, most = 0;
        for (size_t j = 0; j < COUNT; j++) {
            bool plainly = is_seen(shapes[i], some, STATIONS, &all[j], 0.081, -0.003);
            least += plainly;
            most += plainly || is_seen(shapes[i], some, STATIONS, &all[j], 0.079, 0.003);
        }
        double share = pow(gen_sampler_spacing(some) / gen_sampler_spacing(whole), 2.0);
        double error = 4.0 * 0.5 / sqrt(COUNT);
        assert_true(share > (double)least / COUNT - error);
        assert_true(share < (double)most / COUNT + error);
        assert_true(share > 0.3 && share < 0.95);
        gen_sampler_destroy(&whole);
        gen_sampler_destroy(&some);
    }
}

/* The bumpy sphere's radius in a direction. */
static double bumpy_radius(const gen_surface *surface, stp_dvec3 direction)
{
    gen_hit hit;
    surface->project(surface, direction, &hit);
    return stp_dvec3_length(hit.position);
}

static double bumpy_outside(const gen_surface *surface, stp_dvec3 p)
{
    return stp_dvec3_length(p) - bumpy_radius(surface, p);
}

/* The first root along a ray, by small steps and bisection; false if there is none. */
static bool bumpy_root(const gen_surface *surface, stp_dvec3 eye, stp_dvec3 direction,
                       stp_dvec3 *root)
{
    const double step = 2e-4;
    for (double t = 1.0; t < 6.0; t += step) {
        stp_dvec3 p = stp_dvec3_add(eye, stp_dvec3_scale(direction, t));
        if (stp_dvec3_length(p) > surface->radius || bumpy_outside(surface, p) > 0.0)
            continue;
        double low = t - step, high = t;
        for (int i = 0; i < 40; i++) {
            double middle = 0.5 * (low + high);
            p = stp_dvec3_add(eye, stp_dvec3_scale(direction, middle));
            if (bumpy_outside(surface, p) > 0.0)
                low = middle;
            else
                high = middle;
        }
        *root = p;
        return true;
    }
    return false;
}

/* The gradient, by differences. */
static stp_dvec3 bumpy_normal(const gen_surface *surface, stp_dvec3 p)
{
    const double h = 1e-5;
    double g[3];
    for (int axis = 0; axis < 3; axis++) {
        stp_dvec3 step = {axis == 0 ? h : 0.0, axis == 1 ? h : 0.0, axis == 2 ? h : 0.0};
        g[axis] = bumpy_outside(surface, stp_dvec3_add(p, step)) -
                  bumpy_outside(surface, stp_dvec3_sub(p, step));
    }
    return stp_dvec3_normalize((stp_dvec3){g[0], g[1], g[2]});
}

/* Looks from +x, so that the image's axes are simple: right is -z, up is y. Perspective, or
 * orthographic if height (in world units) is positive. */
static void check_truth(double fovy_deg, double height)
{
    const stp_dvec3 eye = {3.5, 0.0, 0.0};
    const stp_camera camera = {
        .eye = eye, .up = {0.0, 1.0, 0.0}, .fovy_deg = fovy_deg, .height = height};
    const stp_ball ball = {{0.0, 0.0, 0.0}, 2.0};
    gen_surface surface;
    stp_image image = {0};
    stp_view view;
    gen_surface_init(&surface, GEN_BUMPY, 1, 0);
    assert_int_equal(stp_view_create(&view, &camera, &ball, 96, 64, NULL), STP_OK);
    assert_int_equal(gen_truth_render(&image, &surface, &view, pool, NULL), STP_OK);
    assert_int_equal(image.width, 96);
    assert_int_equal(image.height, 64);
    size_t hits = 0, misses = 0;
    double half = height > 0.0 ? 0.5 * height : tan(0.5 * fovy_deg * 3.14159265358979 / 180.0);
    for (int y = 1; y < 64; y += 7)
        for (int x = 2; x < 96; x += 9) {
            const uint8_t *pixel = image.rgba + 4 * (y * 96 + x);
            double right = ((x + 0.5) - 48.0) / 32.0 * half, up = (32.0 - (y + 0.5)) / 32.0 * half;
            stp_dvec3 start = eye, direction = {-1.0, up, -right}, p;
            if (height > 0.0) {
                start = (stp_dvec3){eye.x, up, -right};
                direction = (stp_dvec3){-1.0, 0.0, 0.0};
            }
            if (!bumpy_root(&surface, start, stp_dvec3_normalize(direction), &p)) {
                misses++;
                assert_int_equal(pixel[0] | pixel[1] | pixel[2] | pixel[3], 0);
                continue;
            }
            hits++;
            gen_hit hit;
            surface.project(&surface, p, &hit);
            double light = 0.05 + 0.85 * fmax(0.0, bumpy_normal(&surface, p).x);
            assert_int_equal(pixel[3], 255);
            for (int i = 0; i < 3; i++)
                assert_true(fabs((double)hit.colour.raw[i] * light * 255.0 - pixel[i]) < 1.0);
        }
    assert_true(hits > 30 && misses > 10);
    stp_image_destroy(&image);
}

static void test_truth_is_the_surface_seen_along_each_ray(void **state)
{
    (void)state;
    check_truth(40.0, 0.0);
    check_truth(0.0, 2.2);
}

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "--every") == 0)
        part = 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_plain_meshes),
        cmocka_unit_test(test_statue_mesh),
        cmocka_unit_test(test_stations_see_what_nothing_hides),
        cmocka_unit_test(test_truth_is_the_surface_seen_along_each_ray),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

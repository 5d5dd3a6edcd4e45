/* Tests the known surfaces and their sampling: points on the surface, true normals, noise, order,
 * seeds, even density, bounded memory. */
#include "base/memory.h"
#include "base/random.h"
#include "base/sort.h"
#include "tests/fixtures/size.h"
#include "tests/fixtures/statue_kept.h"
#include "tools/gen/curve.h"
#include "tools/gen/sampler.h"
#include "tools/gen/statue.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

typedef struct cloud {
    gen_surface surface;
    gen_sampler *sampler;
    size_t count;
    stp_point *points;
    gen_hit *truth;
} cloud;

static stp_pool *pool;
/* Made once, since it takes seconds. In random order, so that its first points are a fair
 * sample. */
static cloud statue;
enum { STATUE_POINTS = TEST_SIZE(300000, 60000) };

/* Fills in params' surface and point_count. */
static void make_cloud(cloud *c, gen_shape shape, size_t count, gen_sampler_params params)
{
    statue_kept_init(&c->surface, shape, count, params.seed);
    params.surface = &c->surface;
    params.point_count = count;
    assert_int_equal(gen_sampler_create(&c->sampler, &params, pool, NULL), STP_OK);
    c->count = count;
    c->points = calloc(count, sizeof *c->points);
    c->truth = calloc(count, sizeof *c->truth);
    assert_non_null(c->points);
    assert_non_null(c->truth);
    gen_sampler_fill(c->sampler, 0, count, c->points, c->truth);
}

static void end_cloud(cloud *c)
{
    gen_sampler_destroy(&c->sampler);
    free(c->points);
    free(c->truth);
}

static int set_up(void **state)
{
    (void)state;
    if (stp_pool_create(&pool, 0, NULL) != STP_OK)
        return -1;
    make_cloud(&statue, GEN_STATUE, STATUE_POINTS,
               (gen_sampler_params){.seed = 2, .random_order = true});
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    end_cloud(&statue);
    stp_pool_destroy(&pool);
    return 0;
}

/* How far a point is off the surface, by the test's own formula; -1 if there is none. */
static double residual(const gen_surface *surface, stp_dvec3 p)
{
    switch (surface->shape) {
    case GEN_SPHERE:
        return fabs(stp_dvec3_length(p) - 1.0);
    case GEN_PLANE:
        return fabs(p.z) + fmax(fmax(fabs(p.x), fabs(p.y)) - 1.0, 0.0);
    case GEN_TORUS:
        return fabs(hypot(hypot(p.x, p.z) - 0.7, p.y) - 0.3);
    case GEN_SHEET:
        return fabs(fabs(p.z) - 0.5 * surface->separation);
    case GEN_STATUE: {
        gen_dual f = gen_statue_distance(stp_dvec3_to_float(p), NULL);
        double slope = sqrt((double)f[1] * (double)f[1] + (double)f[2] * (double)f[2] +
                            (double)f[3] * (double)f[3]);
        return fabs((double)f[0]) / slope;
    }
    default:
        return -1.0;
    }
}

/* The surface moves within its tangent plane: if the start moves, the nearest point must move at
 * right angles to n. Returns the sine of n's error. */
static double normal_fault(const gen_surface *surface, const gen_hit *hit, double step)
{
    stp_dvec3 n = stp_dvec3_from_float(hit->normal), worst = {0.0, 0.0, 0.0};
    stp_dvec3 axis = fabs(n.x) < 0.6 ? (stp_dvec3){1.0, 0.0, 0.0} : (stp_dvec3){0.0, 1.0, 0.0};
    stp_dvec3 side[2];
    side[0] = stp_dvec3_normalize(stp_dvec3_cross(n, axis));
    side[1] = stp_dvec3_cross(n, side[0]);
    for (int i = 0; i < 2; i++) {
        gen_hit ahead, behind;
        stp_dvec3 move = stp_dvec3_scale(side[i], step);
        surface->project(surface, stp_dvec3_add(hit->position, move), &ahead);
        surface->project(surface, stp_dvec3_sub(hit->position, move), &behind);
        stp_dvec3 along = stp_dvec3_sub(ahead.position, behind.position);
        double fault = stp_dvec3_dot(n, along) / stp_dvec3_length(along);
        worst.x = fmax(worst.x, fabs(fault));
    }
    return worst.x;
}

static void test_points_and_normals_are_true(void **state)
{
    (void)state;
    static double faults[20000];
    for (gen_shape shape = 0; shape < GEN_SHAPE_COUNT; shape++) {
        cloud c = statue;
        if (shape != GEN_STATUE)
            make_cloud(&c, shape, 20000, (gen_sampler_params){.seed = 3});
        c.count = 20000;
        double size = c.surface.radius;
        for (size_t i = 0; i < c.count; i++) {
            const gen_hit *hit = &c.truth[i];
            stp_dvec3 away = stp_dvec3_sub(hit->position, c.surface.centre);
            assert_true(stp_dvec3_length(away) <= size * (1.0 + 1e-6));
            assert_true(fabsf(glms_vec3_norm(hit->normal) - 1.0f) < 1e-5f);
            assert_memory_equal(&c.points[i].position, &hit->position, sizeof hit->position);
            faults[i] = residual(&c.surface, hit->position);
        }
        stp_sort_doubles(faults, c.count);
        /* the statue is computed in floats */
        assert_true(faults[c.count - 1] < (shape == GEN_STATUE ? 1e-5 : 1e-12));
        /* the tree has flat triangles: test_gen_tree judges its normals */
        for (size_t i = 0; i < c.count && c.surface.project != NULL; i++)
            faults[i] = normal_fault(&c.surface, &c.truth[i], 2e-4 * size);
        stp_sort_doubles(faults, c.count);
        assert_true(faults[c.count / 2] < 0.01);
        assert_true(faults[c.count * 98 / 100] < 0.1);
        if (shape != GEN_STATUE)
            end_cloud(&c);
    }
}

static void test_statue_normals_point_out_of_it(void **state)
{
    (void)state;
    size_t wrong = 0;
    for (size_t i = 0; i < statue.count; i++) {
        vec3s p = stp_dvec3_to_float(statue.truth[i].position);
        vec3s step = glms_vec3_scale(statue.truth[i].normal, 5e-4f);
        float outside = gen_statue_distance(glms_vec3_add(p, step), NULL)[0];
        float inside = gen_statue_distance(glms_vec3_sub(p, step), NULL)[0];
        wrong += outside <= 0.0f || inside >= 0.0f;
    }
    assert_true(wrong < statue.count / 1000);
}

static const statue_part *const statue_parts[] = {
#define X(name) &statue_##name,
    STATUE_PARTS(X)
#undef X
};

/* Outside its box a part may be ignored: at the box it must be farther away than any fillet is
 * wide. */
static void test_statue_parts_keep_to_their_boxes(void **state)
{
    (void)state;
    enum { STEPS = TEST_SIZE(160, 40) };
    for (size_t i = 0; i < sizeof statue_parts / sizeof *statue_parts; i++) {
        const statue_part *part = statue_parts[i];
        assert_true(part->blend < statue_margin);
        for (int face = 0; face < 6; face++) {
            int axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
            for (int j = 0; j <= STEPS * STEPS; j++) {
                vec3s p = face % 2 ? part->max : part->min, size;
                size = glms_vec3_sub(part->max, part->min);
                p.raw[u] = part->min.raw[u] + size.raw[u] * (float)(j % STEPS) / (float)STEPS;
                p.raw[v] = part->min.raw[v] + size.raw[v] * (float)(j / STEPS) / (float)STEPS;
                gen_dual3 q = gd_variable(p.x, p.y, p.z);
                assert_true(part->distance(&q)[0] >= statue_margin);
            }
        }
    }
}

static void test_seed_and_pieces(void **state)
{
    (void)state;
    enum { COUNT = 5000 };
    cloud a, b, other;
    gen_sampler_params params = {.seed = 7, .noise_spacings = 0.3};
    make_cloud(&a, GEN_BUMPY, COUNT, params);
    make_cloud(&b, GEN_BUMPY, COUNT, params);
    assert_memory_equal(a.points, b.points, COUNT * sizeof *a.points);
    /* however the points are requested */
    memset(b.points, 0, COUNT * sizeof *b.points);
    for (size_t first = 0; first < COUNT; first += 777) {
        size_t count = COUNT - first < 777 ? COUNT - first : 777;
        gen_sampler_fill(b.sampler, first, count, b.points + first, NULL);
    }
    assert_memory_equal(a.points, b.points, COUNT * sizeof *a.points);
    params.seed = 8;
    make_cloud(&other, GEN_BUMPY, COUNT, params);
    size_t same = 0;
    for (size_t i = 0; i < COUNT; i++)
        same +=
            stp_dvec3_length(stp_dvec3_sub(a.points[i].position, other.points[i].position)) == 0.0;
    assert_int_equal(same, 0);
    end_cloud(&a);
    end_cloud(&b);
    end_cloud(&other);
}

static int compare_points(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(stp_point));
}

static double mean_step(const cloud *c)
{
    double sum = 0.0;
    for (size_t i = 1; i < c->count; i++)
        sum += stp_dvec3_length(stp_dvec3_sub(c->points[i].position, c->points[i - 1].position));
    return sum / (double)(c->count - 1);
}

static void test_order_changes_the_order_only(void **state)
{
    (void)state;
    cloud scan, random;
    gen_sampler_params params = {.seed = 1, .noise_spacings = 0.1};
    make_cloud(&scan, GEN_TORUS, 12345, params);
    params.random_order = true;
    make_cloud(&random, GEN_TORUS, 12345, params);
    double spacing = gen_sampler_spacing(scan.sampler);
    assert_true(mean_step(&scan) < 2.0 * spacing);
    assert_true(mean_step(&random) > 0.7);
    qsort(scan.points, scan.count, sizeof *scan.points, compare_points);
    qsort(random.points, random.count, sizeof *random.points, compare_points);
    assert_memory_equal(scan.points, random.points, scan.count * sizeof *scan.points);
    end_cloud(&scan);
    end_cloud(&random);
}

static void test_permutation_is_a_bijection(void **state)
{
    (void)state;
    static const uint64_t counts[] = {1, 2, 3, 4, 5, 17, 64, 65, 1000, 65536, 65537};
    uint8_t seen[65537];
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        gen_permutation p;
        gen_permutation_init(&p, counts[i], 99);
        memset(seen, 0, sizeof seen);
        for (uint64_t j = 0; j < counts[i]; j++) {
            uint64_t place = gen_permutation_at(&p, j);
            assert_true(place < counts[i]);
            assert_int_equal(seen[place]++, 0);
        }
    }
}

static void test_noise_is_normal_and_as_large_as_asked(void **state)
{
    (void)state;
    enum { COUNT = 100000 };
    cloud c;
    make_cloud(&c, GEN_SPHERE, COUNT, (gen_sampler_params){.noise_spacings = 0.4, .seed = 5});
    double sigma = 0.4 * sqrt(4.0 * 3.14159265358979 / COUNT), sum = 0.0, square = 0.0;
    size_t within = 0;
    for (size_t i = 0; i < COUNT; i++) {
        stp_dvec3 off = stp_dvec3_sub(c.points[i].position, c.truth[i].position);
        double away = stp_dvec3_dot(off, stp_dvec3_from_float(c.truth[i].normal));
        sum += away;
        square += away * away;
        within += fabs(away) < sigma;
        /* along the normal and nowhere else */
        assert_true(stp_dvec3_dot(off, off) - away * away <= 1e-6 * away * away);
    }
    /* within five standard errors */
    assert_true(fabs(sum / COUNT) < 5.0 * sigma / sqrt(COUNT));
    assert_true(fabs(sqrt(square / COUNT) / sigma - 1.0) < 5.0 / sqrt(2.0 * COUNT));
    assert_true(fabs((double)within / COUNT - 0.682689) < 5.0 * 0.4654 / sqrt(COUNT));
    end_cloud(&c);
}

static void test_sheet_has_two_opposed_sides_one_spacing_apart(void **state)
{
    (void)state;
    enum { COUNT = 40000 };
    cloud c;
    make_cloud(&c, GEN_SHEET, COUNT, (gen_sampler_params){0});
    double spacing = sqrt(8.0 / COUNT);
    size_t front = 0;
    for (size_t i = 0; i < COUNT; i++) {
        bool up = c.truth[i].normal.z > 0.0f;
        front += up;
        assert_true(fabs(c.truth[i].position.z - (up ? 0.5 : -0.5) * spacing) < 1e-12);
        assert_true(fabsf(c.truth[i].normal.z) == 1.0f);
        assert_int_equal(c.points[i].class_id, up ? 1 : 2);
        assert_true(up ? c.points[i].rgb[0] > c.points[i].rgb[2]
                       : c.points[i].rgb[0] < c.points[i].rgb[2]);
    }
    assert_true(front >= COUNT / 2 - 1 && front <= COUNT / 2 + 1);
    assert_true(fabs(gen_sampler_spacing(c.sampler) / spacing - 1.0) < 1e-6);
    end_cloud(&c);
}

/* Pearson's statistic over cells of known area, in standard deviations beyond its mean. */
static double chi_square_excess(const size_t *counts, const double *areas, size_t cells)
{
    double total = 0.0, area = 0.0, chi = 0.0;
    for (size_t i = 0; i < cells; i++) {
        total += (double)counts[i];
        area += areas[i];
    }
    for (size_t i = 0; i < cells; i++) {
        double expected = total * areas[i] / area;
        chi += ((double)counts[i] - expected) * ((double)counts[i] - expected) / expected;
    }
    double freedom = (double)cells - 1.0;
    return (chi - freedom) / sqrt(2.0 * freedom);
}

static void test_torus_is_sampled_evenly(void **state)
{
    (void)state;
    enum { AROUND = 60, TUBE = 40, COUNT = 300000 };
    static size_t counts[AROUND * TUBE];
    static double areas[AROUND * TUBE];
    const double two_pi = 6.283185307179586;
    cloud c;
    make_cloud(&c, GEN_TORUS, COUNT, (gen_sampler_params){.seed = 11});
    for (size_t i = 0; i < COUNT; i++) {
        stp_dvec3 p = c.points[i].position;
        double a = atan2(p.x, p.z) / two_pi + 0.5;
        double b = atan2(p.y, hypot(p.x, p.z) - 0.7) / two_pi + 0.5;
        counts[(size_t)fmin(a * AROUND, AROUND - 1) * TUBE + (size_t)fmin(b * TUBE, TUBE - 1)]++;
    }
    for (size_t i = 0; i < AROUND * TUBE; i++) {
        double b0 = two_pi * ((double)(i % TUBE) / TUBE - 0.5), b1 = b0 + two_pi / TUBE;
        areas[i] = 0.7 * (b1 - b0) + 0.3 * (sin(b1) - sin(b0));
    }
    double excess = chi_square_excess(counts, areas, AROUND * TUBE);
    assert_true(excess < 4.0);
    /* evenly spaced, not just random: counts vary far less than those of independent points */
    assert_true(excess < -20.0);
    end_cloud(&c);
}

/* Counts points in cells of space; the cells' shares of the area come from a finer mesh than the
 * sampled one. */
static void test_statue_is_sampled_evenly(void **state)
{
    (void)state;
    enum { SIDE = 24, CELLS = SIDE * SIDE * SIDE, COUNT = STATUE_POINTS };
    static size_t counts[CELLS], kept_counts[CELLS];
    static double areas[CELLS], kept_areas[CELLS];
    const gen_surface *surface = &statue.surface;
    gen_mesh mesh = {0};
    assert_int_equal(surface->mesh(surface, 1000000, pool, &mesh, NULL), STP_OK);
    double reach = surface->radius;
    for (size_t i = 0; i < COUNT + mesh.triangle_count; i++) {
        stp_dvec3 p;
        double area = 0.0;
        if (i < COUNT) {
            p = statue.points[i].position;
        } else {
            stp_dvec3 v[3];
            for (int k = 0; k < 3; k++)
                v[k] = stp_dvec3_from_float(mesh.positions[mesh.triangles[i - COUNT][k]]);
            p = stp_dvec3_scale(stp_dvec3_add(v[0], stp_dvec3_add(v[1], v[2])), 1.0 / 3.0);
            area = 0.5 * stp_dvec3_length(
                             stp_dvec3_cross(stp_dvec3_sub(v[1], v[0]), stp_dvec3_sub(v[2], v[0])));
        }
        size_t x = (size_t)((p.x / reach + 1.0) * 0.5 * SIDE);
        size_t y = (size_t)((p.y / reach + 1.0) * 0.5 * SIDE);
        size_t z = (size_t)((p.z / reach + 1.0) * 0.5 * SIDE);
        size_t cell = (z * SIDE + y) * SIDE + x;
        counts[cell] += i < COUNT;
        areas[cell] += area;
    }
    size_t kept = 0;
    double total = 0.0;
    for (size_t i = 0; i < CELLS; i++)
        total += areas[i];
    for (size_t i = 0; i < CELLS; i++) {
        if (areas[i] * COUNT / total < 20.0)
            continue;
        kept_counts[kept] = counts[i];
        kept_areas[kept++] = areas[i];
    }
    assert_true(kept > 200);
    assert_true(chi_square_excess(kept_counts, kept_areas, kept) < 4.0);
    gen_mesh_clear(&mesh);
}

static long peak_kib(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
}

/* 10^9 points: any of them can be made at once, without memory for the rest. */
static void test_a_billion_points_need_no_memory(void **state)
{
    (void)state;
    static const uint64_t places[] = {0, 499999999, 999999000};
    stp_point points[1000];
    gen_hit truth[1000];
    long before = peak_kib();
    for (int random = 0; random < 2; random++) {
        gen_surface surface;
        gen_sampler *sampler = NULL;
        gen_surface_init(&surface, GEN_SPHERE, 1000000000, 0);
        gen_sampler_params params = {
            .surface = &surface, .point_count = 1000000000, .random_order = random == 1};
        assert_int_equal(gen_sampler_create(&sampler, &params, pool, NULL), STP_OK);
        double spacing = gen_sampler_spacing(sampler);
        for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
            gen_sampler_fill(sampler, places[i], 1000, points, truth);
            size_t jumps = 0;
            for (size_t j = 1; j < 1000; j++) {
                stp_dvec3 step = stp_dvec3_sub(points[j].position, points[j - 1].position);
                double length = stp_dvec3_length(step);
                assert_true(fabs(stp_dvec3_length(points[j].position) - 1.0) < 1e-12);
                assert_true(length > 0.0);
                jumps += length > 8.0 * spacing;
            }
            /* in scan order, jumps occur only between two triangles of the proxy */
            assert_true(random == 1 ? jumps > 900 : jumps < 3);
        }
        gen_sampler_destroy(&sampler);
    }
    assert_true(peak_kib() - before < 64L << 10);
}

static void test_every_count_works(void **state)
{
    (void)state;
    for (gen_shape shape = 0; shape < GEN_SHAPE_COUNT; shape++)
        for (size_t count = shape == GEN_STATUE ? 3 : 1; count < 4; count++) {
            cloud c;
            make_cloud(&c, shape, count, (gen_sampler_params){.random_order = true});
            for (size_t i = 0; i < count; i++)
                assert_true(isfinite(c.points[i].position.x + c.points[i].position.y +
                                     c.points[i].position.z));
            end_cloud(&c);
        }
    gen_surface surface;
    gen_sampler *sampler = NULL;
    stp_error error = {0};
    gen_surface_init(&surface, GEN_PLANE, 0, 0);
    gen_sampler_params none = {.surface = &surface};
    assert_int_equal(gen_sampler_create(&sampler, &none, pool, &error), STP_INVALID_ARGUMENT);
    assert_null(sampler);
    assert_non_null(strstr(error.message, "no points"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_billion_points_need_no_memory),
        cmocka_unit_test(test_points_and_normals_are_true),
        cmocka_unit_test(test_statue_normals_point_out_of_it),
        cmocka_unit_test(test_statue_parts_keep_to_their_boxes),
        cmocka_unit_test(test_seed_and_pieces),
        cmocka_unit_test(test_order_changes_the_order_only),
        cmocka_unit_test(test_permutation_is_a_bijection),
        cmocka_unit_test(test_noise_is_normal_and_as_large_as_asked),
        cmocka_unit_test(test_sheet_has_two_opposed_sides_one_spacing_apart),
        cmocka_unit_test(test_torus_is_sampled_evenly),
        cmocka_unit_test(test_statue_is_sampled_evenly),
        cmocka_unit_test(test_every_count_works),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

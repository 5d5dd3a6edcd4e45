/* Tests the plant of `stipple gen tree`: the requested number of vertices, leaves of four triangles
 * over six vertices, branches whose rings are where the plan says, the same plant for the same
 * seed, and a scan whose points lie on the triangles. */
#include "tests/support/check.h"
#include "tools/gen/sampler.h"
#include "tools/gen/tree.h"

static gen_tree tree;

static int set_up(void **state)
{
    (void)state;
    return gen_tree_grow(&tree, 20000, 5, NULL) == STP_OK ? 0 : -1;
}

static int tear_down(void **state)
{
    (void)state;
    gen_tree_clear(&tree);
    return 0;
}

static stp_dvec3 position(size_t vertex)
{
    return stp_dvec3_from_float(tree.mesh.positions[vertex]);
}

static void test_counts(void **state)
{
    (void)state;
    for (uint64_t count = 2000; count <= 2000000; count *= 10) {
        gen_tree t;
        check_ok(gen_tree_grow(&t, count, 1, err));
        check_near((double)t.mesh.vertex_count, (double)count, 0.04 * (double)count + 200.0);
        assert_true(t.mesh.vertex_count <= count);
        gen_tree_clear(&t);
    }
    gen_tree least, most;
    check_ok(gen_tree_grow(&least, 0, 1, err));
    assert_true(least.mesh.vertex_count < 500 && least.leaf_count == 3);
    check_ok(gen_tree_grow(&most, UINT64_MAX, 1, err));
    assert_true(most.mesh.vertex_count <= GEN_TREE_VERTEX_LIMIT);
    gen_tree_clear(&least);
    gen_tree_clear(&most);
}

static void test_tubes_and_leaves_are_all(void **state)
{
    (void)state;
    size_t vertices = 0, triangles = 0, rings = 0;
    for (size_t i = 0; i < tree.tube_count; i++) {
        const gen_tree_tube *tube = &tree.tubes[i];
        assert_int_equal(tube->first_vertex, vertices);
        assert_int_equal(tube->first_triangle, triangles);
        assert_int_equal(tube->first_ring, rings);
        assert_true(tube->sides >= 3 && tube->sides <= 8);
        vertices += tube->sides * tube->ring_count + 1;
        triangles += tube->sides * (2 * (tube->ring_count - 1) + 1);
        rings += tube->ring_count;
    }
    assert_int_equal(rings, tree.ring_count);
    assert_int_equal(tree.first_leaf_vertex, vertices);
    assert_int_equal(tree.first_leaf_triangle, triangles);
    assert_int_equal(tree.mesh.vertex_count, vertices + 6 * tree.leaf_count);
    assert_int_equal(tree.mesh.triangle_count, triangles + 4 * tree.leaf_count);
}

/* A leaf must use its own six vertices and all of them; both pairs are symmetric about the line
 * between the ends. */
static void test_leaves(void **state)
{
    (void)state;
    for (size_t i = 0; i < tree.leaf_count; i++) {
        const uint32_t first = tree.first_leaf_vertex + (uint32_t)(6 * i);
        unsigned used = 0;
        for (size_t t = 0; t < 4; t++)
            for (int k = 0; k < 3; k++) {
                const uint32_t v = tree.mesh.triangles[tree.first_leaf_triangle + 4 * i + t][k];
                assert_true(v >= first && v < first + 6);
                used |= 1u << (v - first);
            }
        assert_int_equal(used, 63);
        const stp_dvec3 along = stp_dvec3_normalize(stp_dvec3_sub(position(first + 5), //
                                                                  position(first)));
        for (uint32_t pair = 0; pair < 2; pair++) {
            const stp_dvec3 across =
                stp_dvec3_sub(position(first + 1 + 2 * pair), position(first + 2 + 2 * pair));
            check_near(stp_dvec3_dot(along, across), 0.0, 1e-6);
            assert_true(stp_dvec3_length(across) > 0.02 && stp_dvec3_length(across) < 0.1);
        }
    }
}

static void test_rings(void **state)
{
    (void)state;
    for (size_t i = 0; i < tree.tube_count; i++) {
        const gen_tree_tube *tube = &tree.tubes[i];
        for (uint32_t r = 0; r < tube->ring_count; r++) {
            const gen_tree_ring *ring = &tree.rings[tube->first_ring + r];
            stp_dvec3 mean = {0.0, 0.0, 0.0};
            for (uint32_t k = 0; k < tube->sides; k++) {
                const stp_dvec3 p = position(tube->first_vertex + r * tube->sides + k);
                const stp_dvec3 out = stp_dvec3_sub(p, ring->centre);
                check_near(stp_dvec3_length(out), ring->radius, 1e-6);
                check_near(stp_dvec3_dot(out, ring->axis), 0.0, 1e-6);
                mean = stp_dvec3_add(mean, stp_dvec3_scale(p, 1.0 / (double)tube->sides));
            }
            check_near(stp_dvec3_length(stp_dvec3_sub(mean, ring->centre)), 0.0, 1e-6);
            assert_true(r == 0 || ring->radius < ring[-1].radius);
        }
    }
}

/* How often a directed edge occurs in triangles begin .. end - 1. */
static int count_edge(size_t begin, size_t end, uint32_t from, uint32_t to)
{
    int count = 0;
    for (size_t t = begin; t < end; t++)
        for (int k = 0; k < 3; k++)
            count += tree.mesh.triangles[t][k] == from && tree.mesh.triangles[t][(k + 1) % 3] == to;
    return count;
}

/* Each edge must occur once in each direction, except in the open ring at the beginning:
 * topologically a disc. */
static void test_tubes_are_manifold(void **state)
{
    (void)state;
    for (size_t i = 0; i < tree.tube_count; i += 7) {
        const gen_tree_tube *tube = &tree.tubes[i];
        const uint32_t sides = tube->sides;
        const size_t begin = tube->first_triangle;
        const size_t end = begin + sides * (2 * (tube->ring_count - 1) + 1);
        size_t open = 0;
        for (size_t t = begin; t < end; t++)
            for (int k = 0; k < 3; k++) {
                const uint32_t from = tree.mesh.triangles[t][k];
                const uint32_t to = tree.mesh.triangles[t][(k + 1) % 3];
                assert_int_equal(count_edge(begin, end, from, to), 1);
                const int opposite = count_edge(begin, end, to, from);
                open += opposite == 0;
                assert_true(opposite == 1 ||
                            (from < tube->first_vertex + sides && to < tube->first_vertex + sides));
            }
        assert_int_equal(open, sides);
    }
}

static void test_values(void **state)
{
    (void)state;
    gen_surface surface;
    gen_surface_init(&surface, GEN_TREE, 20000, 5);
    for (size_t i = 0; i < tree.mesh.vertex_count; i++) {
        const vec3s colour = tree.mesh.colours[i];
        const stp_dvec3 p = position(i);
        assert_true(stp_dvec3_finite(p));
        assert_true(stp_dvec3_length(stp_dvec3_sub(p, surface.centre)) < surface.radius);
        check_near((double)glms_vec3_norm(tree.mesh.normals[i]), 1.0, 1e-5);
        for (int c = 0; c < 3; c++)
            assert_true(colour.raw[c] >= 0.0f && colour.raw[c] <= 1.0f);
        if (i < tree.first_leaf_vertex)
            assert_true(colour.x > colour.y && colour.y > colour.z);
        else
            assert_true(colour.y > colour.x && colour.y > colour.z);
    }
}

static void test_seed(void **state)
{
    (void)state;
    gen_tree same, other;
    check_ok(gen_tree_grow(&same, 20000, 5, err));
    check_ok(gen_tree_grow(&other, 20000, 6, err));
    const size_t count = tree.mesh.vertex_count, bytes = count * sizeof *tree.mesh.positions;
    assert_int_equal(same.mesh.vertex_count, count);
    assert_int_equal(other.mesh.vertex_count, count);
    assert_memory_equal(same.mesh.positions, tree.mesh.positions, bytes);
    assert_memory_equal(same.mesh.normals, tree.mesh.normals, bytes);
    assert_memory_equal(same.mesh.colours, tree.mesh.colours, bytes);
    assert_memory_not_equal(other.mesh.positions, tree.mesh.positions, bytes);
    gen_tree_clear(&same);
    gen_tree_clear(&other);
}

/* The distance from a triangle's plane if the point lies within the triangle; otherwise
 * INFINITY. */
static double distance(size_t triangle, stp_dvec3 p)
{
    const uint32_t *c = tree.mesh.triangles[triangle];
    const stp_dvec3 a = position(c[0]);
    const stp_dvec3 n =
        stp_dvec3_cross(stp_dvec3_sub(position(c[1]), a), stp_dvec3_sub(position(c[2]), a));
    for (int k = 0; k < 3; k++) {
        const stp_dvec3 from = position(c[k]), to = position(c[(k + 1) % 3]);
        const stp_dvec3 side = stp_dvec3_cross(n, stp_dvec3_normalize(stp_dvec3_sub(to, from)));
        if (stp_dvec3_dot(side, stp_dvec3_sub(p, from)) < -1e-6 * stp_dvec3_length(n))
            return INFINITY;
    }
    return fabs(stp_dvec3_dot(stp_dvec3_normalize(n), stp_dvec3_sub(p, a)));
}

static void test_scan_lies_on_the_mesh(void **state)
{
    (void)state;
    enum { COUNT = 20000 };
    static stp_point points[COUNT];
    gen_surface surface;
    gen_sampler *sampler = NULL;
    stp_pool *pool = NULL;
    size_t green = 0;
    check_ok(stp_pool_create(&pool, 1, err));
    gen_surface_init(&surface, GEN_TREE, COUNT, 5);
    const gen_sampler_params params = {.surface = &surface, .point_count = COUNT};
    check_ok(gen_sampler_create(&sampler, &params, pool, err));
    gen_sampler_fill(sampler, 0, COUNT, points, NULL);
    for (size_t i = 0; i < COUNT; i += 100) {
        double least = INFINITY;
        for (size_t t = 0; t < tree.mesh.triangle_count; t++)
            least = fmin(least, distance(t, points[i].position));
        check_near(least, 0.0, 1e-5);
        check_near((double)glms_vec3_norm(points[i].normal), 1.0, 1e-5);
    }
    for (size_t i = 0; i < COUNT; i++)
        green += points[i].rgb[1] > points[i].rgb[0];
    /* leaves must get their share of the area */
    double area[2] = {0.0, 0.0};
    for (size_t t = 0; t < tree.mesh.triangle_count; t++) {
        const uint32_t *c = tree.mesh.triangles[t];
        area[t >= tree.first_leaf_triangle] +=
            0.5 * stp_dvec3_length(stp_dvec3_cross(stp_dvec3_sub(position(c[1]), position(c[0])),
                                                   stp_dvec3_sub(position(c[2]), position(c[0]))));
    }
    check_near((double)green / COUNT, area[1] / (area[0] + area[1]), 0.01);
    gen_sampler_destroy(&sampler);
    stp_pool_destroy(&pool);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_counts),
        cmocka_unit_test(test_tubes_and_leaves_are_all),
        cmocka_unit_test(test_leaves),
        cmocka_unit_test(test_rings),
        cmocka_unit_test(test_tubes_are_manifold),
        cmocka_unit_test(test_values),
        cmocka_unit_test(test_seed),
        cmocka_unit_test(test_scan_lies_on_the_mesh),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

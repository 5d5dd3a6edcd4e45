/* Tests the neighbour search against brute force, on point sets that are hard for searches. */
#include "base/random.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/cloud/locale.h"
#include "preprocess/cloud/nearest_list.h"
#include "preprocess/cloud/unit.h"
#include "tests/fixtures/cloud_fixture.h"
#include "tests/fixtures/size.h"

/* Whether point i has the lowest source of all points at its position. */
static bool is_first(const stp_cloud *cloud, uint32_t i)
{
    stp_dvec3 p = cloud->points[i].position;
    for (uint32_t j = i; j-- > 0;) {
        stp_dvec3 q = cloud->points[j].position;
        if (p.x != q.x || p.y != q.y || p.z != q.z)
            return true;
        if (cloud->points[j].source < cloud->points[i].source)
            return false;
    }
    return true;
}

/* Neighbours by the definition: other positions by distance, then by source. */
static unsigned brute_force(const stp_cloud *cloud, const uint8_t *first, uint32_t self, unsigned k,
                            uint32_t *out)
{
    double nearest[STP_NEIGHBOURS_LIMIT];
    unsigned count = 0;
    for (uint32_t i = 0; i < cloud->count; i++) {
        stp_dvec3 d = stp_dvec3_sub(cloud->points[i].position, cloud->points[self].position);
        double squared = stp_dvec3_dot(d, d);
        if (!first[i] || squared == 0.0 || (count == k && squared > nearest[k - 1]))
            continue;
        unsigned at = count;
        while (at > 0 && (squared < nearest[at - 1] ||
                          (squared == nearest[at - 1] &&
                           cloud->points[i].source < cloud->points[out[at - 1]].source)))
            at--;
        if (at == k)
            continue;
        count += count < k;
        for (unsigned j = count - 1; j > at; j--) {
            nearest[j] = nearest[j - 1];
            out[j] = out[j - 1];
        }
        nearest[at] = squared;
        out[at] = i;
    }
    return count;
}

/* Compares the list of every stride-th point, in units of unit_cells cells; frees the cloud. */
static void check_units(stp_cloud *cloud, unsigned k, uint32_t stride, uint32_t unit_cells)
{
    stp_error err = {0};
    stp_pool *pool = NULL;
    assert_int_equal(stp_pool_create(&pool, 2, &err), STP_OK);
    assert_int_equal(stp_cloud_sort(cloud, pool, &err), STP_OK);
    uint8_t *first = malloc(cloud->count);
    assert_non_null(first);
    for (uint32_t i = 0; i < cloud->count; i++)
        first[i] = is_first(cloud, i);
    for (uint32_t c = 0; c < cloud->cell_count; c += unit_cells) {
        uint32_t end = cloud->cell_count - c < unit_cells ? cloud->cell_count : c + unit_cells;
        stp_unit unit;
        assert_int_equal(stp_unit_create(&unit, cloud, c, end, k, 1, &err), STP_OK);
        for (uint32_t i = 0; i < unit.ring_end[0]; i += stride) {
            uint32_t expected[STP_NEIGHBOURS_LIMIT];
            unsigned count = brute_force(cloud, first, (uint32_t)unit.places[i], k, expected);
            for (unsigned j = 0; j < k; j++) {
                uint32_t found = unit.neighbours.indices[(size_t)i * k + j];
                assert_int_equal(found == STP_NEIGHBOUR_NONE ? found : unit.places[found],
                                 j < count ? expected[j] : STP_NEIGHBOUR_NONE);
            }
        }
        stp_unit_clear(&unit);
    }
    free(first);
    stp_cloud_clear(cloud);
    stp_pool_destroy(&pool);
}

static void check(stp_cloud *cloud, unsigned k, uint32_t stride)
{
    check_units(cloud, k, stride, 1);
}

/* Two clusters of very different density and a few far points: no halo width is right for all. */
static void uneven_density(void **state)
{
    (void)state;
    stp_cloud cloud = cloud_fixture_make(TEST_SIZE(150000, 70000));
    for (uint32_t i = 0; i < cloud.count; i++) {
        double size = i % 500 == 0 ? 1000.0 : i % TEST_SIZE(3, 30) == 0 ? 1.0 : 0.01;
        cloud.points[i].position =
            (stp_dvec3){size * stp_random_unit(1, i), size * stp_random_unit(2, i),
                        size * stp_random_unit(3, i)};
    }
    check(&cloud, 16, 601);
}

/* A lattice in random source order: dozens of points tie for the k-th place. */
static void lattice_ties(void **state)
{
    (void)state;
    const uint32_t side = TEST_SIZE(42, 16);
    stp_cloud cloud = cloud_fixture_make(side * side * side);
    for (uint32_t i = 0; i < cloud.count; i++) {
        uint32_t j = (uint32_t)((uint64_t)i * 48271u % cloud.count);
        cloud.points[i].position = (stp_dvec3){j % side, j / side % side, j / side / side};
    }
    assert_int_not_equal(cloud.count % 48271u, 0);
    check(&cloud, 16, 331);
}

/* A lattice whose points are a little off their places: floats tell the distances apart, but not in
 * the right order. */
static void lattice_nearly_ties(void **state)
{
    (void)state;
    const uint32_t side = TEST_SIZE(42, 16);
    stp_cloud cloud = cloud_fixture_make(side * side * side);
    for (uint32_t i = 0; i < cloud.count; i++)
        cloud.points[i].position = (stp_dvec3){i % side + 1e-6 * stp_random_unit(1, i),
                                               i / side % side + 1e-6 * stp_random_unit(2, i),
                                               i / side / side + 1e-6 * stp_random_unit(3, i)};
    check(&cloud, 16, 331);
}

/* A flat lattice on the borders of cells, far from the origin. */
static void flat_lattice_far_away(void **state)
{
    (void)state;
    const uint32_t side = TEST_SIZE(400, 300);
    stp_cloud cloud = cloud_fixture_make(side * side);
    for (uint32_t i = 0; i < cloud.count; i++)
        cloud.points[i].position =
            (stp_dvec3){4e6 + 0.001 * (i % side), -5e5 + 0.001 * (i / side), 77.0};
    check(&cloud, 10, 397);
}

static void duplicates(void **state)
{
    (void)state;
    stp_cloud cloud = cloud_fixture_make(TEST_SIZE(120000, 80000));
    for (uint32_t i = 0; i < cloud.count; i++) {
        uint32_t j = (uint32_t)(stp_random_u64(9, i) % TEST_SIZE(7000, 1000));
        cloud.points[i].position = (stp_dvec3){stp_random_unit(1, j), stp_random_unit(2, j), 0.0};
    }
    check(&cloud, 64, 509);
}

static void fewer_points_than_neighbours(void **state)
{
    (void)state;
    for (uint32_t count = 1; count < 20; count++) {
        stp_cloud cloud = cloud_fixture_make(count);
        for (uint32_t i = 0; i < count; i++)
            cloud.points[i].position.x = i / 2;
        check(&cloud, 16, 1);
    }
}

/* All points on a sphere around one point: it has thousands of neighbours at one distance. */
static void thousands_at_one_distance(void **state)
{
    (void)state;
    stp_cloud cloud = cloud_fixture_make(5000);
    for (uint32_t i = 1; i < cloud.count; i++) {
        int axis = (int)(i % 3);
        double v[3] = {0.0, 0.0, 0.0};
        v[axis] = i % 2 ? 1.0 : -1.0;
        cloud.points[i].position = (stp_dvec3){v[0], v[1], v[2]};
        if (i > 6) {
            double a = 2.0 * M_PI * stp_random_unit(4, i);
            cloud.points[i].position = (stp_dvec3){cos(a), sin(a), 0.0};
        }
    }
    check(&cloud, 16, TEST_SIZE(1, 5));
}

/* A cell of two clumps in far corners of a square, whose box holds all that lies between: a halo
 * around the whole box would take in more points than a locale may have. */
static void clumps_in_two_corners(void **state)
{
    (void)state;
    stp_error err = {0};
    stp_pool *pool = NULL;
    const uint32_t clump = 2000, dense = STP_CELL_POINTS + 10000;
    stp_cloud cloud = cloud_fixture_make(2 * (dense + clump));
    for (uint32_t i = 0; i < cloud.count; i++) {
        const double x = stp_random_unit(1, i), y = stp_random_unit(2, i);
        const double far = i % 2 ? 1.1 : 0.0;
        cloud.points[i].position = (stp_dvec3){far + 0.9 * x, far + 0.9 * y, 0.0};
        if (i < 2 * clump)
            cloud.points[i].position = i % 2 ? (stp_dvec3){0.1 * x, 1.9 + 0.1 * y, 0.0}
                                             : (stp_dvec3){1.9 + 0.1 * x, 0.1 * y, 0.0};
    }
    assert_int_equal(stp_pool_create(&pool, 2, &err), STP_OK);
    assert_int_equal(stp_cloud_sort(&cloud, pool, &err), STP_OK);
    uint32_t c = 0;
    while (c < cloud.cell_count && cloud.cells[c].end - cloud.cells[c].begin != 2 * clump)
        c++;
    assert_true(c < cloud.cell_count);
    stp_locale locale;
    assert_int_equal(stp_locale_create(&locale, &cloud, c, c + 1, 16, 2.0, &err), STP_OK);
    assert_true(locale.halos[0] > 0.0);
    assert_in_range(locale.count, 2 * clump, 3 * clump);
    for (uint64_t i = cloud.cells[c].begin; i < cloud.cells[c].end; i++)
        assert_true(stp_locale_holds(&locale, cloud.points[i].position, 0.5 * locale.halos[0]));
    assert_false(stp_locale_holds(&locale, (stp_dvec3){1.0, 1.0, 0.0}, 0.0));
    stp_locale_clear(&locale);
    stp_cloud_clear(&cloud);
    stp_pool_destroy(&pool);
}

/* A pile and one point 10^9 of its sizes away. */
static stp_cloud make_pile(void)
{
    stp_cloud cloud = cloud_fixture_make(6001);
    for (uint32_t i = 1; i < cloud.count; i++)
        cloud.points[i].position =
            (stp_dvec3){stp_random_unit(1, i), stp_random_unit(2, i), stp_random_unit(3, i)};
    cloud.points[0].position = (stp_dvec3){1e9, 1e9, 1e9};
    return cloud;
}

/* Floats that reach the far point, too, would put the pile into one place, and each search would
 * look at all of it. */
static void pile_and_a_far_point(void **state)
{
    (void)state;
    stp_error err = {0};
    stp_pool *pool = NULL;
    stp_locale locale;
    stp_cloud cloud = make_pile();
    assert_int_equal(stp_pool_create(&pool, 2, &err), STP_OK);
    assert_int_equal(stp_cloud_sort(&cloud, pool, &err), STP_OK);
    assert_int_equal(cloud.cell_count, 1);
    assert_int_equal(stp_locale_create(&locale, &cloud, 0, 1, 16, 2.0, &err), STP_OK);
    for (uint32_t i = 0; i < 6000; i += 7) {
        const vec3s point = stp_locale_point(&locale, i);
        uint32_t runs[STP_RUNS_NEAR];
        assert_in_range(stp_run_tree_near(&locale.runs, point.raw, point.raw, 1e-4f, runs), 1, 16);
    }
    stp_locale_clear(&locale);
    stp_cloud_clear(&cloud);
    stp_pool_destroy(&pool);
    cloud = make_pile();
    check(&cloud, 16, 101);
}

/* A lattice of the least steps that doubles have 10^15 away. */
static void far_from_zero(void **state)
{
    (void)state;
    stp_cloud cloud = cloud_fixture_make(20000);
    for (uint32_t i = 0; i < cloud.count; i++)
        cloud.points[i].position = (stp_dvec3){1e15 + 0.125 * floor(40.0 * stp_random_unit(1, i)),
                                               -1e15 + 0.125 * floor(40.0 * stp_random_unit(2, i)),
                                               1e15 + 0.125 * floor(40.0 * stp_random_unit(3, i))};
    check(&cloud, 16, 61);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(uneven_density),
        cmocka_unit_test(lattice_ties),
        cmocka_unit_test(lattice_nearly_ties),
        cmocka_unit_test(flat_lattice_far_away),
        cmocka_unit_test(duplicates),
        cmocka_unit_test(fewer_points_than_neighbours),
        cmocka_unit_test(thousands_at_one_distance),
        cmocka_unit_test(clumps_in_two_corners),
        cmocka_unit_test(pile_and_a_far_point),
        cmocka_unit_test(far_from_zero),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

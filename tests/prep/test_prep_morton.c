/* Tests the parallel sort along the Morton curve: every point once, by code; ties by coordinates,
 * then by source; piles along their own curve. The result must be the same for any number of
 * threads and any order of the input. */
#include "base/random.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/cloud/morton.h"
#include "tests/fixtures/cloud_fixture.h"
#include "tests/fixtures/size.h"

#include <float.h>
#include <string.h>

/* A cube of this side has cells of side 1. */
#define SIDE ((double)(1 << STP_MORTON_BITS))

typedef struct sorted_cloud {
    stp_cloud_point *points;
    stp_dbox box;
} sorted_cloud;

static uint64_t key_at(const sorted_cloud *s, uint32_t i)
{
    const stp_morton_grid grid = stp_morton_grid_of(&s->box);
    return stp_morton_code(&grid, s->points[i].position);
}

static sorted_cloud sort(const stp_cloud *cloud, unsigned threads)
{
    stp_error err = {0};
    stp_pool *pool = NULL;
    stp_dbox box;
    stp_cloud_point *points = calloc((size_t)cloud->count + 1, sizeof *points);
    assert_non_null(points);
    memcpy(points, cloud->points, cloud->count * sizeof *points);
    assert_int_equal(stp_pool_create(&pool, threads, &err), STP_OK);
    assert_int_equal(stp_morton_box(&box, points, cloud->count, NULL, pool, &err), STP_OK);
    assert_int_equal(stp_morton_sort(points, cloud->count, NULL, &box, pool, &err), STP_OK);
    stp_pool_destroy(&pool);
    return (sorted_cloud){points, box};
}

static void clear(sorted_cloud *s)
{
    free(s->points);
    *s = (sorted_cloud){0};
}

/* The code of a cell of the cube by the definition, bit by bit. */
static uint64_t code_of(const uint32_t cell[3])
{
    uint64_t code = 0;
    for (unsigned bit = 0; bit < STP_MORTON_BITS; bit++)
        for (unsigned axis = 0; axis < 3; axis++)
            code |= (uint64_t)(cell[axis] >> bit & 1u) << (3 * bit + axis);
    return code;
}

/* Returns -1, 0 or 1: compares coordinates, x first, then the source. */
static int compare_ties(const stp_cloud_point *a, const stp_cloud_point *b)
{
    const double p[4] = {a->position.x, a->position.y, a->position.z, a->source};
    const double q[4] = {b->position.x, b->position.y, b->position.z, b->source};
    for (int i = 0; i < 4; i++)
        if (p[i] != q[i])
            return p[i] < q[i] ? -1 : 1;
    return 0;
}

/* Every point of the input must be there once, with its own position; codes rise, ties are in
 * order. */
static void assert_sorted(const sorted_cloud *s, const stp_cloud *cloud)
{
    uint8_t *met = calloc((size_t)cloud->count + 1, 1);
    uint32_t *place = calloc((size_t)cloud->count + 1, sizeof *place);
    assert_true(met && place);
    for (uint32_t i = 0; i < cloud->count; i++)
        place[cloud->points[i].source] = i;
    for (uint32_t i = 0; i < cloud->count; i++) {
        const stp_cloud_point *p = &s->points[i];
        assert_true(p->source < cloud->count && !met[p->source]);
        met[p->source] = 1;
        assert_memory_equal(p, &cloud->points[place[p->source]], sizeof *p);
        if (i == 0)
            continue;
        uint64_t before = key_at(s, i - 1), here = key_at(s, i);
        assert_true(before <= here);
        if (before == here)
            assert_int_equal(compare_ties(&s->points[i - 1], p), -1);
    }
    free(place);
    free(met);
}

static void assert_same(const sorted_cloud *a, const sorted_cloud *b, uint32_t count)
{
    assert_memory_equal(a->points, b->points, count * sizeof *a->points);
    assert_memory_equal(&a->box, &b->box, sizeof a->box);
}

/* The order must be right, and the same for any number of threads and any order of the input. */
static void check_cloud(stp_cloud *cloud)
{
    sorted_cloud one = sort(cloud, 1);
    assert_sorted(&one, cloud);
    for (unsigned threads = 2; threads <= TEST_SIZE(8, 3); threads++) {
        sorted_cloud more = sort(cloud, threads);
        assert_same(&one, &more, (uint32_t)cloud->count);
        clear(&more);
    }
    for (uint32_t i = (uint32_t)cloud->count; i-- > 1;) {
        uint32_t j = (uint32_t)(stp_random_unit(9, i) * (i + 1.0));
        stp_cloud_point swapped = cloud->points[i];
        cloud->points[i] = cloud->points[j];
        cloud->points[j] = swapped;
    }
    sorted_cloud shuffled = sort(cloud, 3);
    assert_sorted(&shuffled, cloud);
    assert_same(&one, &shuffled, (uint32_t)cloud->count);
    clear(&shuffled);
    clear(&one);
}

/* Cells of side 1, so that codes are exact. Points lie all over the cube, crowded in a corner
 * (filling many buckets) and on the corners; a third share their place with others. */
static void codes_are_the_definition(void **state)
{
    (void)state;
    enum { COUNT = TEST_SIZE(150000, 80000) };
    stp_cloud cloud = cloud_fixture_make(COUNT);
    for (uint32_t i = 0; i < COUNT; i++) {
        uint32_t k = i < COUNT / 3 ? i * 2 : i;
        double *p[3] = {&cloud.points[i].position.x, &cloud.points[i].position.y,
                        &cloud.points[i].position.z};
        for (uint32_t axis = 0; axis < 3; axis++) {
            double at = floor(stp_random_unit(axis + 1, k) * (k % 3 == 0 ? SIDE + 1.0 : 600.0));
            *p[axis] = i < 8 ? (i >> axis & 1) * SIDE : at;
        }
    }
    sorted_cloud s = sort(&cloud, 2);
    for (uint32_t i = 0; i < COUNT; i++) {
        stp_dvec3 p = s.points[i].position;
        const uint32_t cell[3] = {(uint32_t)fmin(p.x, SIDE - 1.0), (uint32_t)fmin(p.y, SIDE - 1.0),
                                  (uint32_t)fmin(p.z, SIDE - 1.0)};
        assert_int_equal(key_at(&s, i), code_of(cell));
    }
    assert_true(s.box.min.x == 0.0 && s.box.min.y == 0.0 && s.box.min.z == 0.0);
    assert_true(s.box.max.x == SIDE && s.box.max.y == SIDE && s.box.max.z == SIDE);
    clear(&s);
    check_cloud(&cloud);
    stp_cloud_clear(&cloud);
}

/* Ties in one cell, more than a block of them, and a cloud of equal points only. */
static void equal_points_keep_their_sources(void **state)
{
    (void)state;
    enum { COUNT = 70000 };
    stp_cloud cloud = cloud_fixture_make(COUNT);
    check_cloud(&cloud); /* all at the origin */
    for (uint32_t i = 0; i < COUNT; i++)
        cloud.points[i].position.y = i == 0 ? 1e9 : (double)(i % 7) * 1e-9;
    check_cloud(&cloud);
    stp_cloud_clear(&cloud);
}

/* More points with one code than a cell holds, and an outlier: the pile follows a curve of its own,
 * and so does a pile within the pile. There are so many points that parts are split again. */
static void piles_follow_their_own_curve(void **state)
{
    (void)state;
    enum { COUNT = 300000 };
    stp_cloud cloud = cloud_fixture_make(COUNT);
    for (uint32_t i = 0; i < COUNT; i++) {
        double size = i % 4 == 0 ? 1.0 : 1e-9;
        cloud.points[i].position =
            (stp_dvec3){size * stp_random_unit(1, i), size * stp_random_unit(2, i),
                        size * stp_random_unit(3, i)};
    }
    cloud.points[0].position = (stp_dvec3){1e7, 1e7, 1e7};
    sorted_cloud one = sort(&cloud, 1), more = sort(&cloud, 3);
    assert_same(&one, &more, COUNT);
    assert_int_equal(one.points[COUNT - 1].source, 0);
    stp_dbox near = stp_dbox_empty();
    for (uint32_t i = 0; i + 1 < COUNT; i++)
        stp_dbox_add(&near, one.points[i].position);
    const stp_morton_grid outer = stp_morton_grid_of(&one.box);
    assert_int_equal(stp_morton_code(&outer, near.max), 0); /* all but one */
    const stp_morton_grid inner = stp_morton_grid_of(&near);
    for (uint32_t i = 1; i + 1 < COUNT; i++)
        assert_true(stp_morton_code(&inner, one.points[i - 1].position) <=
                    stp_morton_code(&inner, one.points[i].position));
    clear(&more);
    clear(&one);
    stp_cloud_clear(&cloud);
}

static void few_points(void **state)
{
    (void)state;
    for (uint32_t count = 0; count <= 3; count++) {
        stp_cloud cloud = cloud_fixture_make(count);
        for (uint32_t i = 0; i < count; i++)
            cloud.points[i].position = (stp_dvec3){-(double)i, 5.0, 1e6};
        check_cloud(&cloud);
        sorted_cloud s = sort(&cloud, 2);
        for (uint32_t i = 0; i < count; i++) {
            assert_int_equal(s.points[i].source, count - 1 - i);
            assert_true(s.box.min.x == 1.0 - count && s.box.max.x == 0.0);
        }
        clear(&s);
        stp_cloud_clear(&cloud);
    }
}

/* Coordinates only need to be finite: a box wider than a double holds, a box too narrow to divide
 * by, and neighbouring numbers far from the origin. */
static void extreme_coordinates(void **state)
{
    (void)state;
    const double values[][4] = {
        {-DBL_MAX, DBL_MAX, 0.0, 1.0},
        {0.0, DBL_TRUE_MIN, 2.0 * DBL_TRUE_MIN, -DBL_TRUE_MIN},
        {1e300, nextafter(1e300, INFINITY), nextafter(1e300, 0.0), 1e300},
        {-0.0, 0.0, DBL_MIN, -DBL_MIN},
        {DBL_MAX, 0.5 * DBL_MAX, 0.25 * DBL_MAX, 0.0},
    };
    enum { COUNT = 1000 };
    for (size_t set = 0; set < sizeof values / sizeof *values; set++) {
        stp_cloud cloud = cloud_fixture_make(COUNT);
        for (uint32_t i = 0; i < COUNT; i++)
            cloud.points[i].position =
                (stp_dvec3){values[set][i % 4], values[set][i / 4 % 4], values[set][i / 16 % 4]};
        check_cloud(&cloud);
        stp_cloud_clear(&cloud);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(codes_are_the_definition),
        cmocka_unit_test(equal_points_keep_their_sources),
        cmocka_unit_test(piles_follow_their_own_curve),
        cmocka_unit_test(few_points),
        cmocka_unit_test(extreme_coordinates),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

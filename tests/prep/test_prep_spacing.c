/* Tests local spacings: noise, outliers, steps in density, duplicates. */
#include "base/random.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/surface/normals.h"
#include "preprocess/surface/spacing.h"
#include "tests/fixtures/cloud_fixture.h"

#define NEIGHBOURS 16u

/* Finds the spacings by source, before and after smoothing. */
static void find(stp_cloud *cloud, float *before, float *after)
{
    stp_error err = {0};
    stp_pool *pool = NULL;
    stp_unit all;
    stp_normal_errors errors = {{0}};
    assert_int_equal(stp_pool_create(&pool, 2, &err), STP_OK);
    assert_int_equal(stp_cloud_sort(cloud, pool, &err), STP_OK);
    assert_int_equal(stp_unit_create(&all, cloud, 0, cloud->cell_count, NEIGHBOURS, 2, &err), 0);
    for (uint32_t i = 0; before && i < cloud->count; i++)
        before[cloud->points[i].source] = all.cloud.points[i].spacing;
    assert_int_equal(stp_normals_estimate(&all, NULL, &errors, &err), STP_OK);
    for (uint32_t i = 0; i < cloud->count; i++)
        after[cloud->points[i].source] = all.cloud.points[i].spacing;
    stp_unit_clear(&all);
    stp_pool_destroy(&pool);
}

/* The relative deviation; values below 0 are ignored. */
static double scatter(const float *values, uint32_t count, double *mean)
{
    double sum = 0.0, squares = 0.0, weight = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        if (values[i] < 0.0f)
            continue;
        weight += 1.0;
        sum += (double)values[i];
        squares += (double)values[i] * (double)values[i];
    }
    *mean = sum / weight;
    return sqrt(squares / weight - *mean * *mean) / *mean;
}

/* Random points on the unit square: the true spacing is 1 / sqrt(count) everywhere. */
static void noise_is_less(void **state)
{
    (void)state;
    enum { COUNT = 20000 };
    static float before[COUNT], after[COUNT], inner[COUNT];
    stp_cloud cloud = cloud_fixture_make(COUNT);
    for (uint32_t i = 0; i < COUNT; i++)
        cloud.points[i].position = (stp_dvec3){stp_random_unit(1, i), stp_random_unit(2, i), 0.0};
    find(&cloud, before, after);
    for (uint32_t i = 0; i < COUNT; i++) /* spacings really grow at the border */
        if (fabs(stp_random_unit(1, i) - 0.5) > 0.45 || fabs(stp_random_unit(2, i) - 0.5) > 0.45)
            before[i] = inner[i] = -1.0f;
        else
            inner[i] = after[i];
    double mean_before, mean;
    double scatter_before = scatter(before, COUNT, &mean_before);
    assert_true(scatter(inner, COUNT, &mean) < 0.8 * scatter_before);
    assert_true(fabs(mean * sqrt(COUNT) - 1.0) < 0.1);
    stp_cloud_clear(&cloud);
}

/* One point, a pair, and two groups of five beside each other, all far above a unit grid. */
static void outliers_are_small(void **state)
{
    (void)state;
    enum { SIDE = 100, GRID = SIDE * SIDE, FAR = 13 };
    static float before[GRID + FAR], after[GRID + FAR];
    stp_cloud cloud = cloud_fixture_make(GRID + FAR);
    for (uint32_t i = 0; i < GRID; i++)
        cloud.points[i].position = (stp_dvec3){i % SIDE, i / SIDE, 0.0};
    for (uint32_t i = 0; i < FAR; i++) {
        stp_dvec3 p = {20.0, 20.0, 40.0};
        if (i == 1 || i == 2)
            p = (stp_dvec3){80.0 + 0.1 * i, 20.0, 60.0};
        if (i > 2)
            p = (stp_dvec3){i % 2 ? 50.0 : 60.0, 50.0 + 0.1 * i, 100.0 + 0.01 * i * i};
        cloud.points[GRID + i].position = p;
    }
    find(&cloud, before, after);
    for (uint32_t i = GRID; i < GRID + FAR; i++) {
        assert_true(before[i] > 4.0f);
        assert_true(after[i] > 0.0f && after[i] < 3.5f);
    }
    for (uint32_t i = 0; i < GRID; i++)
        assert_true(after[i] > 0.5f && after[i] < 1.7f);
    stp_cloud_clear(&cloud);
}

/* A grid of spacing 1 ends where one of spacing 8 begins: discs of 1.7 spacings must still meet. */
static void density_step_stays_closed(void **state)
{
    (void)state;
    enum { FINE = 60, COARSE = 20, COUNT = FINE * FINE + COARSE * COARSE };
    static float after[COUNT];
    static stp_dvec3 at[COUNT];
    const double step = 8.0;
    stp_cloud cloud = cloud_fixture_make(COUNT);
    for (uint32_t i = 0; i < COUNT; i++) {
        uint32_t j = i - FINE * FINE;
        at[i] = i < FINE * FINE ? (stp_dvec3){-1.0 - i % FINE, 50.0 + i / FINE, 0.0}
                                : (stp_dvec3){step * (0.5 + j % COARSE), step * (j / COARSE), 0.0};
        cloud.points[i].position = at[i];
    }
    find(&cloud, NULL, after);
    for (double x = -5.0; x < 60.0; x += 0.5) {
        for (double y = 60.0; y < 100.0; y += 0.5) {
            bool covered = false;
            for (uint32_t i = 0; i < COUNT && !covered; i++)
                covered = hypot(at[i].x - x, at[i].y - y) < 1.7 * (double)after[i];
            assert_true(covered);
        }
    }
    for (uint32_t i = 0; i < FINE * FINE; i++)
        assert_true(after[i] < 2.0f);
    stp_cloud_clear(&cloud);
}

/* Scan lines: points are ten times as dense along them as across. */
static void scan_lines_keep_their_spacing(void **state)
{
    (void)state;
    enum { ALONG = 400, LINES = 30, COUNT = ALONG * LINES };
    static float before[COUNT], after[COUNT];
    stp_cloud cloud = cloud_fixture_make(COUNT);
    for (uint32_t i = 0; i < COUNT; i++)
        cloud.points[i].position = (stp_dvec3){0.1 * (i % ALONG), i / ALONG, 0.0};
    find(&cloud, before, after);
    for (uint32_t i = 0; i < COUNT; i++)
        if (i % ALONG > 20 && i % ALONG < ALONG - 20)
            assert_true(fabsf(after[i] / before[i] - 1.0f) < 1e-4f);
    stp_cloud_clear(&cloud);
}

/* Every position five times, and clouds too small to have spacings. */
static void duplicates_agree(void **state)
{
    (void)state;
    enum { COUNT = 10000 };
    static float after[COUNT];
    stp_cloud cloud = cloud_fixture_make(COUNT);
    for (uint32_t i = 0; i < COUNT; i++) {
        uint32_t j = i % (COUNT / 5);
        cloud.points[i].position = (stp_dvec3){stp_random_unit(1, j), stp_random_unit(2, j), 0.0};
    }
    find(&cloud, NULL, after);
    for (uint32_t i = COUNT / 5; i < COUNT; i++) {
        assert_true(after[i] > 0.0f);
        assert_true(after[i] == after[i % (COUNT / 5)]);
    }
    stp_cloud_clear(&cloud);
    for (uint32_t count = 1; count < 5; count++) {
        cloud = cloud_fixture_make(count);
        find(&cloud, NULL, after);
        for (uint32_t i = 0; i < count; i++)
            assert_true(after[i] == 0.0f);
        stp_cloud_clear(&cloud);
    }
    cloud = cloud_fixture_make(2);
    cloud.points[1].position.x = 1.0;
    find(&cloud, NULL, after);
    assert_true(after[0] > 0.0f && after[1] == after[0] && isfinite(after[0]));
    stp_cloud_clear(&cloud);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_is_less),
        cmocka_unit_test(outliers_are_small),
        cmocka_unit_test(density_step_stays_closed),
        cmocka_unit_test(scan_lines_keep_their_spacing),
        cmocka_unit_test(duplicates_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

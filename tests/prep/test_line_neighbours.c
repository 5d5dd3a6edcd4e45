/* Tests that points which lie in scan lines get enough neighbours to see other lines, and no others
 * do. */
#include "base/random.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/cloud/scan_lines.h"
#include "preprocess/surface/surface.h"
#include "tests/fixtures/cloud_fixture.h"

#define COUNT 40000u

typedef enum scan_kind { LINES, PLANE, WIRES, ONE_PLACE, KINDS } scan_kind;

/* A wavy sheet, scanned in lines 12 times as far apart as their points, or evenly; wires ten times
 * as far apart. */
static stp_cloud make(scan_kind kind, uint32_t count)
{
    const uint32_t row = 1000;
    stp_cloud cloud = cloud_fixture_make(count);
    for (uint32_t i = 0; i < count && kind != ONE_PLACE; i++) {
        stp_dvec3 p = {0.01 * (i % row), 0.12 * (i / row), 0.0};
        if (kind == PLANE)
            p = (stp_dvec3){10.0 * stp_random_unit(1, i), 4.8 * stp_random_unit(2, i), 0.0};
        else if (kind == WIRES)
            p.y *= 10.0;
        p.z = 0.3 * sin(p.x) + 0.004 * stp_random_unit(3, i);
        cloud.points[i].position = p;
    }
    return cloud;
}

static stp_pool *sort(stp_cloud *cloud)
{
    stp_pool *pool = NULL;
    stp_error err = {0};
    assert_int_equal(stp_pool_create(&pool, 2, &err), STP_OK);
    assert_int_equal(stp_cloud_sort(cloud, pool, &err), STP_OK);
    return pool;
}

static void lines_have_more_neighbours(void **state)
{
    (void)state;
    for (int kind = 0; kind < KINDS; kind++)
        for (uint32_t count = 1; count <= COUNT; count *= 200) {
            stp_cloud cloud = make((scan_kind)kind, count);
            stp_pool *pool = sort(&cloud);
            unsigned k = 0;
            assert_int_equal(stp_scan_lines_choose(&k, 16, &cloud, NULL), STP_OK);
            if (k != (kind == LINES && count == COUNT ? STP_SCAN_LINE_NEIGHBOURS : 16))
                fail_msg("kind %d of %u points has %u neighbours", kind, count, k);
            stp_cloud_clear(&cloud);
            stp_pool_destroy(&pool);
        }
}

/* Normals of the sheet that are within 20 degrees of the true ones, of all. */
static double right_share(unsigned k)
{
    stp_cloud cloud = make(LINES, COUNT);
    stp_pool *pool = sort(&cloud);
    stp_graph *none = NULL;
    uint32_t right = 0;
    const stp_surface_params params = {.k = k};
    assert_int_equal(stp_surface_find(&none, &cloud, &params, NULL, pool, NULL, NULL), STP_OK);
    for (uint32_t i = 0; i < COUNT; i++) {
        const stp_cloud_point *p = &cloud.points[i];
        const double slope = 0.3 * cos(p->position.x);
        const double cosine =
            ((double)p->normal.z - slope * (double)p->normal.x) / sqrt(1.0 + slope * slope);
        right += fabs(cosine) > 0.94;
    }
    stp_cloud_clear(&cloud);
    stp_pool_destroy(&pool);
    return (double)right / COUNT;
}

/* Why: with 16 neighbours, planes turn about their line as noise pleases. */
static void more_neighbours_find_the_surface(void **state)
{
    (void)state;
    const double few = right_share(16), more = right_share(STP_SCAN_LINE_NEIGHBOURS);
    print_message("right normals: %.3f by 16 neighbours, %.3f by 64\n", few, more);
    assert_true(few < 0.7);
    assert_true(more > 0.99);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_have_more_neighbours),
        cmocka_unit_test(more_neighbours_find_the_surface),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

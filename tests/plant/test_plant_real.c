/* Tests a real tree's mesh to lines: how many leaves and branches it has, how many vertices are
 * left, and how it looks. Skips unless STIPPLE_SCANS names a folder of scans: the project may not
 * distribute them. */
#include "tests/fixtures/plant_silhouette.h"
#include "tests/fixtures/scan/scan_fixture.h"

static const char oak[] = "tree/eztree_oak_large.obj";

/* 5,280 square cards; 180 twigs of 4 rings, 50 of 17, 9 branches of 28, and a trunk of 65 whose
 * lowest rings are too thick. */
static void test_oak(void **state)
{
    (void)state;
    char path[4096];
    stp_mesh *mesh = NULL;
    if (!scan_fixture_real(oak, path))
        return;
    check_ok(stp_mesh_load(&mesh, path, err));
    stp_plant plant = plant_convert(mesh, NULL);
    const stp_plant_report *r = &plant.report;
    print_message("%llu vertices (%llu positions) become %llu: %.1f %%\n",
                  (unsigned long long)r->vertices_before, (unsigned long long)r->positions_before,
                  (unsigned long long)r->vertices_after,
                  100.0 * (double)r->vertices_after / (double)r->vertices_before);
    assert_int_equal(r->vertices_before, 30104);
    assert_int_equal(r->positions_before, 27870);
    assert_int_equal(r->ribbons, 5280);
    assert_int_equal(r->ribbon_triangles, 10560);
    assert_int_equal(r->tubes, 180 + 50 + 9 + 1);
    assert_true(r->rings <= 180 * 4 + 50 * 17 + 9 * 28 + 65 && r->rings >= 1870);
    assert_true((double)r->vertices_after <= 0.45 * (double)r->vertices_before);
    const silhouette_sum sum = silhouette_compare(mesh, &plant, 600);
    silhouette_check(&sum, 0.02, 0.02, 0.95);
    stp_plant_clear(&plant);
    stp_mesh_destroy(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_oak)};
    if (!scan_fixture_has_real())
        return 77;
    return cmocka_run_group_tests(tests, NULL, NULL);
}

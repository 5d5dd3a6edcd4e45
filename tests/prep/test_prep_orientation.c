/* Tests which way normals point, against the true surface. */
#include "preprocess/orient/visibility.h"
#include "tests/fixtures/orientation_fixture.h"

#define SAMPLES 300000u

/* If the normals are true, points seen from outside must face the viewer. */
static void seen_points_face_the_viewer(void **state)
{
    (void)state;
    surface_cloud s = surface_scan(GEN_STATUE, SAMPLES, 0.0, 0);
    surface_prepare(&s, 16);
    stp_pool *pool = NULL;
    assert_int_equal(stp_visibility_stride(&s.cloud), 1);
    _Atomic int *votes = calloc(s.cloud.count, sizeof *votes);
    assert_non_null(votes);
    for (uint32_t i = 0; i < s.cloud.count; i++)
        s.cloud.points[i].normal = s.truth[s.cloud.points[i].source].normal;
    assert_int_equal(stp_pool_create(&pool, 0, NULL), STP_OK);
    assert_int_equal(stp_visibility_vote(votes, &s.cloud, pool, NULL), STP_OK);
    uint32_t facing = 0, seen = 0;
    for (uint32_t i = 0; i < s.cloud.count; i++) {
        seen += votes[i] != 0;
        facing += votes[i] > 0;
    }
    print_message("%u of %u points seen, %u of them face the viewer\n", seen, s.cloud.count,
                  facing);
    assert_true(seen > s.cloud.count / 3);
    assert_true(facing >= 0.99 * seen);
    stp_pool_destroy(&pool);
    free((void *)votes);
    surface_clear(&s);
}

static void torus_points_outward(void **state)
{
    (void)state;
    closed_surface(GEN_TORUS, SAMPLES);
}

/* Nothing says which way two sides one spacing apart face, so no normal may be marked as
 * oriented. */
static void sheet_is_unknown(void **state)
{
    (void)state;
    surface_cloud s = surface_scan(GEN_SHEET, SAMPLES, 0.1, 0);
    surface_prepare(&s, 16);
    surface_orient(&s, (stp_orient_params){.mode = STP_ORIENT_AUTO});
    assert_int_equal(s.orientation, STP_ORIENTATION_UNKNOWN);
    for (uint32_t i = 0; i < s.cloud.count; i++)
        assert_true(stp_has_normal(&s.cloud.points[i]) && !surface_is_oriented(&s, i));
    surface_clear(&s);
}

/* The points of such a sheet that a scanner sees must face the scanner. */
static void station_orients_the_sheet(void **state)
{
    (void)state;
    const stp_dvec3 station = {1.0, 2.0, -3.0};
    surface_cloud s = surface_scan(GEN_SHEET, SAMPLES, 0.1, 0);
    surface_keep_facing(&s, station);
    surface_prepare(&s, 16);
    surface_orient(&s, (stp_orient_params){.mode = STP_ORIENT_POSITION, .position = station});
    assert_int_equal(s.orientation, STP_ORIENTATION_POSITION);
    double share = right_share(&s);
    assert_true(share >= 0.999);
    surface_clear(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(seen_points_face_the_viewer),
        cmocka_unit_test(torus_points_outward),
        cmocka_unit_test(sheet_is_unknown),
        cmocka_unit_test(station_orients_the_sheet),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

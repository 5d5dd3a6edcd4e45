/* Tests orientation without given normals at full size: 1 M samples, 99.9 % right, of the statue,
 * and of the statue and the sheet seen from several stations. */
#include "tests/fixtures/orientation_fixture.h"

static void statue_points_outward(void **state)
{
    (void)state;
    closed_surface(GEN_STATUE, 1000000u);
}

static void stations_turn(gen_shape shape, unsigned station_count, double noise)
{
    surface_cloud s = surface_scan(shape, 1000000u, noise, station_count);
    surface_prepare(&s, 16);
    surface_orient(&s, (stp_orient_params){.mode = STP_ORIENT_AUTO, .stations = s.stations});
    assert_int_equal(s.orientation, STP_ORIENTATION_POSITION);
    assert_true(right_share(&s) >= 0.999);
    surface_clear(&s);
}

static void sheet_faces_its_stations(void **state)
{
    (void)state;
    stations_turn(GEN_SHEET, 4, 0.0);
    stations_turn(GEN_SHEET, 4, 0.1);
}

static void statue_faces_its_stations(void **state)
{
    (void)state;
    stations_turn(GEN_STATUE, 6, 0.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(statue_points_outward),
        cmocka_unit_test(sheet_faces_its_stations),
        cmocka_unit_test(statue_faces_its_stations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Tests normals turned to the stations that saw their points, against the true surface. */
#include "tests/fixtures/orientation_fixture.h"

#include "base/random.h"

#define SAMPLES 200000u

static stp_orient_params by_stations(const surface_cloud *s)
{
    return (stp_orient_params){.mode = STP_ORIENT_AUTO, .stations = s->stations};
}

/* A surface scanned from several stations, without its normals. */
static surface_cloud scan(gen_shape shape, double noise, unsigned station_count)
{
    surface_cloud s = surface_scan(shape, SAMPLES, noise, station_count);
    surface_prepare(&s, 16);
    return s;
}

/* The sheet's two sides are one spacing apart, and stations stand on both sides. */
static void sheet_from_three(void **state)
{
    (void)state;
    for (int noisy = 0; noisy < 2; noisy++) {
        surface_cloud s = scan(GEN_SHEET, 0.1 * noisy, 3);
        surface_orient(&s, by_stations(&s));
        assert_int_equal(s.orientation, STP_ORIENTATION_POSITION);
        assert_true(right_share(&s) >= 0.999);
        surface_clear(&s);
    }
}

static void torus_from_four(void **state)
{
    (void)state;
    surface_cloud s = scan(GEN_TORUS, 0.1, 4);
    surface_orient(&s, by_stations(&s));
    assert_int_equal(s.orientation, STP_ORIENTATION_POSITION);
    assert_true(right_share(&s) >= 0.999);
    surface_clear(&s);
}

/* Some points have no known station: their normals must follow the points around them. */
static void some_stations_are_unknown(void **state)
{
    (void)state;
    surface_cloud s = scan(GEN_SHEET, 0.0, 3);
    for (uint32_t i = 0; i < s.cloud.count; i++)
        if (stp_random_unit(5, i) < 0.3)
            s.cloud.points[i].station = 0;
    surface_orient(&s, by_stations(&s));
    assert_int_equal(s.orientation, STP_ORIENTATION_POSITION);
    assert_true(right_share(&s) >= 0.999);
    surface_clear(&s);
}

/* Of the points with x in [low, high), the share that is oriented and points away from the centre
 * `middle` of their sphere. */
static double outward_share(const surface_cloud *s, double low, double high, double middle)
{
    uint32_t count = 0, outward = 0;
    for (uint32_t i = 0; i < s->cloud.count; i++) {
        const stp_cloud_point *p = &s->cloud.points[i];
        if (p->position.x < low || p->position.x >= high)
            continue;
        stp_dvec3 away = {p->position.x - middle, p->position.y, p->position.z};
        count++;
        outward += surface_is_oriented(s, i) &&
                   stp_dvec3_dot(away, stp_dvec3_from_float(stp_cloud_normal(&s->cloud, i))) > 0.0;
    }
    assert_true(count > 0);
    return (double)outward / count;
}

/* A room is seen from inside, and its walls face the inside. A ball beside it has no known station,
 * but is closed, so it faces outwards. */
static void room_and_ball(void **state)
{
    (void)state;
    surface_cloud s = surface_scan(GEN_SPHERE, SAMPLES, 0.1, 0);
    s.stations[0] = (stp_dvec3){-0.5, 0.2, 0.0};
    s.stations[1] = (stp_dvec3){0.6, 0.0, -0.1};
    for (uint32_t i = 0; i < s.cloud.count; i++) {
        stp_cloud_point *p = &s.cloud.points[i];
        p->station = p->position.x < 0.0 ? 1 : 2;
        if (i % 3 == 0) {
            p->position.x += 5.0;
            p->station = 0;
        }
    }
    surface_prepare(&s, 16);
    surface_orient(&s, by_stations(&s));
    assert_int_equal(s.orientation, STP_ORIENTATION_POSITION);
    for (uint32_t i = 0; i < s.cloud.count; i++)
        assert_true(surface_is_oriented(&s, i));
    assert_true(outward_share(&s, -2.0, 2.0, 0.0) <= 0.001);
    assert_true(outward_share(&s, 3.0, 7.0, 5.0) >= 0.999);
    surface_clear(&s);
}

/* An open piece without stations stays unknown, though another piece is fully known. */
static void piece_without_stations_stays_unknown(void **state)
{
    (void)state;
    surface_cloud s = surface_scan(GEN_PLANE, SAMPLES, 0.0, 1);
    s.stations[0].x -= 3.0;
    for (uint32_t i = 0; i < s.cloud.count; i++) {
        stp_cloud_point *p = &s.cloud.points[i];
        p->station = p->position.x < 0.0;
        p->position.x += p->station ? -3.0 : 3.0;
    }
    surface_prepare(&s, 16);
    surface_orient(&s, by_stations(&s));
    assert_int_equal(s.orientation, STP_ORIENTATION_MIXED);
    for (uint32_t i = 0; i < s.cloud.count; i++) {
        const stp_cloud_point *p = &s.cloud.points[i];
        bool oriented = surface_is_oriented(&s, i);
        assert_int_equal(oriented, p->position.x < 0.0);
        assert_true(!oriented || stp_cloud_normal(&s.cloud, i).z > 0.0f);
    }
    surface_clear(&s);
}

/* The mode that is asked for wins over the stations. */
static void modes_win(void **state)
{
    (void)state;
    surface_cloud s = scan(GEN_SHEET, 0.0, 3);
    const stp_dvec3 below = {0.0, 0.0, -10.0};
    stp_orient_params params = by_stations(&s);
    params.mode = STP_ORIENT_PROPAGATE;
    surface_orient(&s, params);
    assert_int_equal(s.orientation,
                     STP_ORIENTATION_PROPAGATED); /* both sides belong to one flat body */
    params.mode = STP_ORIENT_NONE;
    surface_orient(&s, params);
    assert_int_equal(s.orientation, STP_ORIENTATION_UNKNOWN);
    params.mode = STP_ORIENT_POSITION;
    params.position = below;
    surface_orient(&s, params);
    assert_int_equal(s.orientation, STP_ORIENTATION_POSITION);
    uint32_t down = 0;
    for (uint32_t i = 0; i < s.cloud.count; i++)
        down += stp_cloud_normal(&s.cloud, i).z < 0.0f;
    assert_true(down >= 0.999 * (double)s.cloud.count);
    params.mode = STP_ORIENT_AUTO;
    params.from_file = true;
    surface_orient(&s, params);
    assert_int_equal(s.orientation, STP_ORIENTATION_FILE);
    surface_clear(&s);
}

/* Stations at their points, or too far away for a double, must do no harm. */
static void stations_at_odd_places(void **state)
{
    (void)state;
    surface_cloud s = scan(GEN_SPHERE, 0.0, 1);
    for (uint32_t i = 0; i < s.cloud.count; i++)
        s.cloud.points[i].station = (uint16_t)(i % 2 + 1);
    s.stations[0] = s.cloud.points[0].position;
    s.stations[1] = (stp_dvec3){1.7e308, -1.7e308, 1.7e308};
    surface_orient(&s, by_stations(&s));
    for (uint32_t i = 0; i < s.cloud.count; i++) {
        assert_true(surface_is_oriented(&s, i));
        assert_true(fabsf(glms_vec3_norm(s.cloud.points[i].normal) - 1.0f) < 1e-3f);
    }
    surface_clear(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sheet_from_three),
        cmocka_unit_test(torus_from_four),
        cmocka_unit_test(some_stations_are_unknown),
        cmocka_unit_test(room_and_ball),
        cmocka_unit_test(piece_without_stations_stays_unknown),
        cmocka_unit_test(modes_win),
        cmocka_unit_test(stations_at_odd_places),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

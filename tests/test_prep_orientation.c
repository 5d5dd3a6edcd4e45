/* Which way normals point, against the true surface. */
#include "tests/surface_fixture.h"

#include "formats/chunk/sample.h"

#define SAMPLES 300000u

/* Share of points that are known to point outward and do; prints what the others are. */
static double right_share(const surface_cloud *s)
{
    uint32_t right = 0, known = 0;
    for (uint32_t i = 0; i < s->cloud.count; i++) {
        const stp_cloud_point *p = &s->cloud.points[i];
        if (!(p->flags & STP_SAMPLE_ORIENTED))
            continue;
        known++;
        right += glms_vec3_dot(p->normal, s->truth[p->source].normal) > 0.0f;
    }
    double count = s->cloud.count;
    print_message("%.4f %% right, %.4f %% wrong, %.4f %% unknown\n", 100.0 * right / count,
                  100.0 * (known - right) / count, 100.0 * (s->cloud.count - known) / count);
    return right / count;
}

static void closed_surface(gen_shape shape)
{
    surface_cloud s = surface_sample(shape, SAMPLES, 0.1, NULL);
    surface_prepare(&s, 16);
    surface_orient(&s, (stp_orient_params){.mode = STP_ORIENT_AUTO});
    double share = right_share(&s);
    print_message("mean error %.3f degrees\n", surface_mean_error(&s));
    assert_true(share >= 0.999);
    surface_clear(&s);
}

static void statue_points_outward(void **state)
{
    (void)state;
    closed_surface(GEN_STATUE);
}

static void torus_points_outward(void **state)
{
    (void)state;
    closed_surface(GEN_TORUS);
}

/* Nothing says which way two sides one spacing apart face: none is marked. */
static void sheet_is_unknown(void **state)
{
    (void)state;
    surface_cloud s = surface_sample(GEN_SHEET, SAMPLES, 0.1, NULL);
    surface_prepare(&s, 16);
    surface_orient(&s, (stp_orient_params){.mode = STP_ORIENT_AUTO});
    assert_int_equal(s.orientation, STP_ORIENTATION_UNKNOWN);
    for (uint32_t i = 0; i < s.cloud.count; i++)
        assert_int_equal(s.cloud.points[i].flags, STP_SAMPLE_HAS_NORMAL);
    surface_clear(&s);
}

/* What a scanner sees of such a sheet faces it. */
static void station_orients_the_sheet(void **state)
{
    (void)state;
    const stp_dvec3 station = {1.0, 2.0, -3.0};
    surface_cloud s = surface_sample(GEN_SHEET, SAMPLES, 0.1, &station);
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
        cmocka_unit_test(statue_points_outward),
        cmocka_unit_test(torus_points_outward),
        cmocka_unit_test(sheet_is_unknown),
        cmocka_unit_test(station_orients_the_sheet),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

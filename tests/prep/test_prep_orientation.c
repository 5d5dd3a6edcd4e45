/* Tests which way normals point, against the true surface. */
#include "preprocess/orient/visibility.h"
#include "tests/fixtures/first_view_fixture.h"
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
    print_message("%u of %u points seen, %u of them face the viewer\n", seen,
                  (unsigned)s.cloud.count, facing);
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

/* The file tells the signs of normals that it gives, not of those that it leaves out as zeros. */
static void zero_normals_say_nothing(void **state)
{
    (void)state;
    surface_cloud s = surface_scan(GEN_SPHERE, 20000, 0.0, 0);
    for (uint32_t i = 0; i < s.cloud.count; i += 2) {
        s.cloud.points[i].normal = s.truth[i].normal;
        s.cloud.points[i].given = STP_GIVEN_INPUT;
    }
    surface_prepare(&s, 16);
    surface_orient(&s, (stp_orient_params){.from_file = true});
    assert_int_equal(s.orientation, STP_ORIENTATION_FILE);
    for (uint32_t i = 0; i < s.cloud.count; i++) {
        assert_true(stp_has_normal(&s.cloud.points[i]));
        assert_int_equal(surface_is_oriented(&s, i), s.cloud.points[i].source % 2 == 0);
    }
    surface_clear(&s);
}

/* A half sphere of 1000 points, of which a share in tenths has normals: the orientation is the
 * file's if most have. */
static void most_normals_decide(void **state)
{
    (void)state;
    for (unsigned tenths = 0; tenths <= 10; tenths += 2) {
        FILE *file = fopen("normals.xyz", "w");
        assert_non_null(file);
        fprintf(file, "x y z nx ny nz\n");
        for (unsigned i = 0; i < 1000; i++) {
            const double z = stp_random_unit(1, i), a = 2.0 * M_PI * stp_random_unit(2, i);
            const double x = sqrt(1.0 - z * z) * cos(a), y = sqrt(1.0 - z * z) * sin(a);
            const double length = i % 10 < tenths ? 1.0 : 0.0;
            fprintf(file, "%.9g %.9g %.9g %.9g %.9g %.9g\n", x, y, z, length * x, length * y,
                    length * z);
        }
        fclose(file);
        const bool file_decides = first_prep("normals.xyz", 2).orientation == STP_ORIENTATION_FILE;
        assert_int_equal(file_decides, tenths > 5);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(seen_points_face_the_viewer),
        cmocka_unit_test(torus_points_outward),
        cmocka_unit_test(sheet_is_unknown),
        cmocka_unit_test(station_orients_the_sheet),
        cmocka_unit_test(zero_normals_say_nothing),
        cmocka_unit_test(most_normals_decide),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

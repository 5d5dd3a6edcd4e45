/* Tests first views of surveys whose classes say what is noise. */
#include "tests/fixtures/first_view_fixture.h"

#include "tests/fixtures/prep_fixture.h"

#define GROUND 20000u

/* Level ground of 100 x 100, and `count` points of a class up to 150 above and below. */
static stp_first_camera seen(unsigned count, unsigned class_id)
{
    FILE *f = fopen("survey.txt", "w");
    assert_non_null(f);
    fputs("x y z class\n", f);
    for (uint64_t i = 0; i < GROUND + count; i++) {
        const double x = 100.0 * stp_random_unit(3, 3 * i),
                     y = 100.0 * stp_random_unit(3, 3 * i + 1), z = stp_random_unit(3, 3 * i + 2);
        fprintf(f, "%.3f %.3f %.3f %u\n", x, y, i < GROUND ? z : 150.0 * (2.0 * z - 1.0),
                i < GROUND ? 2u : class_id);
    }
    assert_int_equal(fclose(f), 0);
    return first_prep("survey.txt", 2).first;
}

/* Noise among the others widens nothing, and a room keeps its view from inside with noise in its
 * air. */
static void noise_within_changes_nothing(void **state)
{
    (void)state;
    FILE *f = fopen("cloud.txt", "w");
    assert_non_null(f);
    fputs("x y z class\n0 0 0 7\n", f);
    for (uint64_t i = 0; i < GROUND; i++) { /* dense in the middle: its ends are far out */
        double at[3];
        for (uint64_t k = 0; k < 3; k++)
            at[k] = pow(2.0 * stp_random_unit(4, 3 * i + k) - 1.0, 19.0);
        fprintf(f, "%.6f %.6f %.6f 2\n", at[0], at[1], at[2]);
    }
    assert_int_equal(fclose(f), 0);
    assert_int_equal(first_prep("cloud.txt", 2).first.why, STP_FIRST_WHOLE);
    for (unsigned class_id = 2; class_id <= 7; class_id += 5) {
        positions p = {0};
        room_box(&p, (stp_dvec3){0.0, 0.0, 0.0}, (stp_dvec3){6.0, 5.0, 2.6}, 0);
        f = fopen("room.txt", "w");
        assert_non_null(f);
        fputs("x y z class\n", f);
        for (size_t i = 0; i < p.count; i++)
            fprintf(f, "%.4f %.4f %.4f 1\n", p.at[i].x, p.at[i].y, p.at[i].z);
        for (uint64_t i = 0; i < 40; i++)
            fprintf(f, "%.4f %.4f %.4f %u\n", 0.5 + 5.0 * stp_random_unit(9, 3 * i),
                    0.5 + 4.0 * stp_random_unit(9, 3 * i + 1),
                    0.5 + 1.6 * stp_random_unit(9, 3 * i + 2), class_id);
        assert_int_equal(fclose(f), 0);
        free(p.at);
        assert_int_equal(first_prep("room.txt", 2).first.why, STP_FIRST_INTERIOR);
    }
}

/* Up to a tenth of noise does not count; other classes do, and a class that many points have is no
 * noise. */
static void noise_is_not_the_view(void **state)
{
    (void)state;
    static const struct {
        unsigned count, class_id;
        stp_first_why why;
    } cases[] = {{300, 7, STP_FIRST_MAIN},
                 {1500, 18, STP_FIRST_MAIN},
                 {1500, 5, STP_FIRST_WHOLE},
                 {6000, 7, STP_FIRST_WHOLE}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const stp_first_camera first = seen(cases[i].count, cases[i].class_id);
        assert_int_equal(first.why, cases[i].why);
        if (first.why == STP_FIRST_WHOLE)
            continue;
        assert_true(fabs(first.look.x - 50.0) < 3.0 && fabs(first.look.y - 50.0) < 3.0);
        assert_true(fabs(first.look.z) < 2.0);
        const double away = stp_dvec3_length(stp_dvec3_sub(first.eye, first.look));
        assert_true(away > 100.0 && away < 260.0); /* 141 across, 45 degrees */
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(noise_is_not_the_view),
                                       cmocka_unit_test(noise_within_changes_nothing)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

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
    const struct CMUnitTest tests[] = {cmocka_unit_test(noise_is_not_the_view)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

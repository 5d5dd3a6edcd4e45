/* Tests that verify accepts what prep writes: 500 random mixtures of several leaves each, surveys
 * with points far around them, and a million points at a few places. */
#include "tests/fixtures/mixture_fixture.h"
#include "tests/fixtures/size.h"

#include <unistd.h>

#define OUT "long_prep_mixtures.stipple"

enum { MIXTURES = TEST_SIZE(500, 20), SURVEYS = TEST_SIZE(30, 3) };

static void mixtures_are_sound(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= MIXTURES; seed++) {
        if (!mixture_wanted(seed))
            continue;
        mixture m = mixture_make(seed, seed % 10 ? 66000.0 : 1.0, seed % 50 ? 150000.0 : 600000.0);
        mixture_try(&m, OUT);
    }
}

static void surveys_are_sound(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= SURVEYS; seed++) {
        if (!mixture_wanted(seed))
            continue;
        mixture m = mixture_make_survey(seed, 200000, 100);
        mixture_try(&m, OUT);
    }
}

static void numbers_of_any_size_are_sound_or_refused(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 2000; seed++) {
        if (!mixture_wanted(seed))
            continue;
        mixture m = mixture_make_extreme(seed, seed % 2 ? -40.0 : -3.0, seed % 2 ? 15.0 : 35.0);
        m.params.outliers = STP_OUTLIERS_KEEP; /* otherwise all may be dropped */
        mixture_try(&m, OUT);
    }
}

static void a_million_points_at_few_places_are_sound(void **state)
{
    (void)state;
    for (size_t places = 1; places <= 1000; places *= 10) {
        mixture m = {.words = "a million points at few places", .size = 1.0, .seed = places};
        m.cloud = prep_cloud_make(1000000);
        for (size_t i = 0; i < m.cloud.count; i++) {
            const size_t at = i % places;
            m.cloud.points[i].position = (stp_dvec3){
                5e5 + (double)(at % 10), 4e6 + (double)(at / 10 % 10), (double)(at / 100)};
        }
        mixture_try(&m, OUT);
    }
}

static int remove_output(void **state)
{
    (void)state;
    unlink(OUT);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(mixtures_are_sound),
                                       cmocka_unit_test(surveys_are_sound),
                                       cmocka_unit_test(numbers_of_any_size_are_sound_or_refused),
                                       cmocka_unit_test(a_million_points_at_few_places_are_sound)};
    return cmocka_run_group_tests(tests, NULL, remove_output);
}

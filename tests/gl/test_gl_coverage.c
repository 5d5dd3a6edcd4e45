/* Tests holes and outlines at 512 x 512 from 26 directions against the true mesh. At most 0.01 % of
 * the silhouette may be holes, and no hole may exceed one pixel. The tolerance is one pixel plus
 * one projected sample spacing. Pixels covered farther than that from the truth, and true ones
 * farther than that from what is covered, may be 1 % as many as the outlines have pixels.
 * long_gl_coverage.c does the same at 1024 x 1024. */
#include "tests/fixtures/gl_coverage.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/fixtures/size.h"

enum {
    COUNT = TEST_SIZE(200000, 50000),
    SIZE = TEST_SIZE(512, 256), /* same samples per pixel with either */
    TRIANGLES = 300000          /* they lie hundredths of a pixel off the surface */
};

static void bumpy(void **state)
{
    (void)state;
    gl_coverage_judge(
        "bumpy", &(model_recipe){.shape = GEN_BUMPY, .point_count = COUNT, .noise_spacings = 0.1},
        TRIANGLES, SIZE, 1);
}

static void torus(void **state)
{
    (void)state;
    gl_coverage_judge("torus", &(model_recipe){.shape = GEN_TORUS, .point_count = COUNT}, TRIANGLES,
                      SIZE, 1);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bumpy),
        cmocka_unit_test(torus),
    };
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

/* Tests holes and outlines at 1024 x 1024 from 26 directions against the true mesh, as
 * test_gl_coverage.c does at 512 x 512. Adds the statue, whose feathers are less than a pixel
 * apart. */
#include "tests/fixtures/gl_coverage.h"
#include "tests/fixtures/scan/scan_fixture.h"

/* Pixels. The statue's holes are where a surface is seen through a gap of some five pixels between
 * nearer ones. Half of their pixels are open with exact discs (splat), too, which leave three times
 * as many. The other half a sample beside them would cover: pull gives coarse pixels to the nearer
 * surfaces, and where these end, push at level 0 looks no further (shaders/README.md, "Left out").
 */
#define LARGEST_HOLE 8

static void bumpy(void **state)
{
    (void)state;
    gl_coverage_judge(
        "bumpy", &(model_recipe){.shape = GEN_BUMPY, .point_count = 1000000, .noise_spacings = 0.1},
        0, 1024, 1);
}

static void torus(void **state)
{
    (void)state;
    gl_coverage_judge("torus", &(model_recipe){.shape = GEN_TORUS, .point_count = 1000000}, 0, 1024,
                      1);
}

static void statue(void **state)
{
    (void)state;
    const model_recipe recipe = {.shape = GEN_STATUE, .point_count = 1000000, .true_normals = true};
    gl_coverage_judge("statue", &recipe, 8000000, 1024, LARGEST_HOLE);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bumpy),
        cmocka_unit_test(torus),
        cmocka_unit_test(statue),
    };
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

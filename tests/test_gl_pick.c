/* Picking: random picks find the front surface of known models. long_gl_pick.c does ten thousand of
 * each. */
#include "tests/gl_pick.h"
#include "tests/scan_fixture.h"
#include "tests/size.h"

enum { COUNT = TEST_SIZE(200000, 50000), SIZE = TEST_SIZE(512, 256), PICKS = 2000 };

static void statue(void **state)
{
    (void)state;
    pick_tally t = pick_model("statue", &(model_recipe){.shape = GEN_STATUE, .point_count = COUNT},
                              1000000, SIZE, PICKS);
    assert_true(t.right * 1000 >= t.picks * 999);
}

static void sheet(void **state)
{
    (void)state;
    const model_recipe recipe = {
        .shape = GEN_SHEET, .point_count = COUNT / 4, .true_normals = true};
    pick_tally t = pick_model("sheet", &recipe, 0, SIZE, PICKS);
    assert_true(t.right * 1000 >= t.picks * 999);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(statue),
        cmocka_unit_test(sheet),
    };
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

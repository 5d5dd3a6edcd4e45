/* Tests ten thousand random picks on the statue and on the sheet, whose two sides are one spacing
 * apart: 99.9 % of them must find the front surface within one sample's radius. */
#include "tests/fixtures/gl_pick.h"
#include "tests/fixtures/scan/scan_fixture.h"

enum { COUNT = 1000000, SIZE = 1024, PICKS = 10000 };

static void statue(void **state)
{
    (void)state;
    pick_tally t = pick_model("statue", &(model_recipe){.shape = GEN_STATUE, .point_count = COUNT},
                              4000000, SIZE, PICKS, 1);
    assert_true(t.right * 1000 >= t.picks * 999);
}

static void sheet(void **state)
{
    (void)state;
    const model_recipe recipe = {.shape = GEN_SHEET, .point_count = COUNT, .true_normals = true};
    pick_tally t = pick_model("sheet", &recipe, 0, SIZE, PICKS, 1);
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

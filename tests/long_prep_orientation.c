/* The statue's orientation without its normals, at the size: 1 M samples, 99.9 %. */
#include "tests/orientation_fixture.h"

static void statue_points_outward(void **state)
{
    (void)state;
    closed_surface(GEN_STATUE, 1000000u);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(statue_points_outward)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

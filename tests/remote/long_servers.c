/* Tests all commands against bad web servers in all modes. */
#include "tests/fixtures/servers.h"

static void bad_servers_do_no_harm(void **state)
{
    (void)state;
    server_run_modes(0, 1, true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(bad_servers_do_no_harm)};
    return cmocka_run_group_tests(tests, server_set_up, server_tear_down);
}

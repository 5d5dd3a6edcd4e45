/* Tests bad web servers: a sample of the modes that long_servers tries, without windows. */
#include "tests/fixtures/servers.h"

static void bad_servers_do_no_harm(void **state)
{
    (void)state;
    server_run_modes(21, 17, false);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(bad_servers_do_no_harm)};
    return cmocka_run_group_tests(tests, server_set_up, server_tear_down);
}

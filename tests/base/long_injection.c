/* Lets every call of every command fail once: long_injection [COMMAND...], as `long_injection
 * tune`. */
#include "tests/fixtures/injection_commands.h"

int main(int argc, char **argv)
{
    return injection_main(true, argc > 1 ? argv + 1 : NULL);
}

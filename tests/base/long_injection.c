/* Every call of every command fails once. */
#include "tests/fixtures/injection_commands.h"

int main(void)
{
    return injection_main(true);
}

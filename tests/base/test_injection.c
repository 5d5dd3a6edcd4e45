/* Lets calls fail once: a sample of the calls that long_injection tries. */
#include "tests/fixtures/injection_commands.h"

int main(void)
{
    return injection_main(false, NULL);
}

/* Lets every call of every command fail once. */
#include "tests/fixtures/injection_commands.h"

int main(void)
{
    return injection_main(true);
}

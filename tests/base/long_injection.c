/* Lets every call of every command fail once: long_injection [EVERY] [WORD...]. `long_injection 5
 * tune` lets each fifth call of the commands fail that have the word `tune`. */
#include "tests/fixtures/injection_commands.h"

int main(int argc, char **argv)
{
    return injection_main(true, argc > 1 ? argv + 1 : NULL);
}

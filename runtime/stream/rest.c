/* Doubles the rest after each failure. */
#include "runtime/stream/rest.h"

#include "base/clock.h"

#include <math.h>
#include <stdio.h>

#define LEAST_S 1.0
#define MOST_S 8.0

bool stp_rest_lasts(const stp_rest *rest)
{
    return stp_clock_seconds() < rest->until;
}

void stp_rest_begin(stp_rest *rest, const char *message, bool late)
{
    if (stp_rest_lasts(rest) || (late && rest->words[0] != '\0'))
        return;
    snprintf(rest->words, sizeof rest->words, "%.500s", message);
    rest->seconds = rest->seconds > 0.0 ? fmin(2.0 * rest->seconds, MOST_S) : LEAST_S;
    rest->until = stp_clock_seconds() + rest->seconds;
}

/* Helpers for tests of pictures: cmocka's headers, views made by hand, comparison of numbers. */
#ifndef STP_TESTS_SUPPORT_CHECK_H
#define STP_TESTS_SUPPORT_CHECK_H

#include "base/error.h"
#include "base/vec.h"
#include "runtime/camera/camera.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A view from the origin along -z; f in pixels (per unit, if orthographic). */
static inline stp_view check_view(int width, int height, double f, bool orthographic)
{
    return (stp_view){.right = {1.0, 0.0, 0.0},
                      .up = {0.0, 1.0, 0.0},
                      .back = {0.0, 0.0, 1.0},
                      .f = f,
                      .near_depth = 1e-4,
                      .ball_near = 1.0,
                      .ball_far = 3.0,
                      .width = width,
                      .height = height,
                      .orthographic = orthographic};
}

#define check_ok(call)                                                                             \
    do {                                                                                           \
        stp_error check_error = {0};                                                               \
        stp_error *err = &check_error;                                                             \
        if ((call) != STP_OK)                                                                      \
            fail_msg("%s", check_error.message);                                                   \
    } while (0)

#define check_near(value, expected, tolerance)                                                     \
    do {                                                                                           \
        double check_value = (value), check_expected = (expected);                                 \
        if (!(fabs(check_value - check_expected) <= (tolerance)))                                  \
            fail_msg("%s is %.9g, expected %.9g within %g", #value, check_value, check_expected,   \
                     (double)(tolerance));                                                         \
    } while (0)

#endif

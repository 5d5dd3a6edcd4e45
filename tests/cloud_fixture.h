/* Points in memory as the stages of preprocessing take them. */
#ifndef STP_TESTS_CLOUD_FIXTURE_H
#define STP_TESTS_CLOUD_FIXTURE_H

#include "preprocess/cloud.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>

/* count points at the origin, numbered in order; stp_cloud_clear frees. */
static inline stp_cloud cloud_fixture_make(uint32_t count)
{
    stp_cloud cloud = {.count = count, .capacity = count};
    cloud.points = calloc(count ? count : 1, sizeof *cloud.points);
    assert_non_null(cloud.points);
    for (uint32_t i = 0; i < count; i++)
        cloud.points[i].source = i;
    return cloud;
}

#endif

/* Tests which of a chunk's tilted grids a square of few samples belongs to: by chance, a sample may
 * lie on several. It is the one that the samples are nearest to, whichever comes first. */
#include "formats/chunk/codec/square.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

enum { SAMPLES = 2, STEPS = 64 };

/* A grid whose columns are `by` columns off, on planes that lean. */
static stp_raster grid(double by)
{
    return (stp_raster){.axis = 2, .across = {{by, 1.0, 0.0, 0.25}, {0.0, 0.0, 1.0, -0.5}}};
}

static void nearest_grid(void **state)
{
    (void)state;
    stp_patch patch = {.exponent = -6, .counts = {SAMPLES, 1, 1, 1}};
    stp_sample samples[SAMPLES] = {0};
    uint32_t begin[2] = {0, SAMPLES};
    stp_raster rasters[2];
    stp_square square;
    for (unsigned i = 0; i < SAMPLES; i++) { /* columns 9 and 10 of row 12, at heights 8 and 4 */
        const double height = 8.0 - 4.0 * i;
        samples[i].position[0] = (uint16_t)lrint(STEPS * (9.0 + i + 0.25 * height));
        samples[i].position[1] = (uint16_t)lrint(STEPS * (12.0 - 0.5 * height));
        samples[i].position[2] = (uint16_t)lrint(STEPS * height);
    }
    const stp_chunk chunk = {.patch_count = 1,
                             .patches = &patch,
                             .samples = {samples},
                             .level_begin = {begin},
                             .rasters = rasters,
                             .raster_count = 2};
    for (uint32_t right = 0; right < 2; right++) {
        rasters[right] = grid(0.0);
        rasters[1 - right] = grid(0.1);
        assert_true(stp_squares_find(&chunk, &square));
        assert_int_equal(square.raster, right);
        assert_int_equal(square.column, 1);
        assert_int_equal(square.row, 1);
    }
    rasters[0] = rasters[1] = grid(0.2);
    assert_false(stp_squares_find(&chunk, &square));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(nearest_grid)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

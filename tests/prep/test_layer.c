/* Tests the layer of a point against sorted heights. */
#include "base/random.h"
#include "base/sort.h"
#include "preprocess/cloud/nearest_list.h"
#include "preprocess/surface/layer.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#define ROUNDS 2000
#define GAP 0.35f

/* The layer from heights in order: it goes on as long as the next one is within the gap. */
static stp_layer expected(const float *heights, unsigned count)
{
    double sorted[STP_NEIGHBOURS_LIMIT];
    stp_layer layer = {0.0f, 0.0f};
    for (unsigned i = 0; i < count; i++)
        sorted[i] = (double)heights[i];
    stp_sort_doubles(sorted, count);
    for (unsigned i = 0; i < count; i++)
        if ((float)sorted[i] > layer.high && (float)sorted[i] - layer.high <= GAP)
            layer.high = (float)sorted[i];
    for (unsigned i = count; i-- > 0;)
        if ((float)sorted[i] < layer.low && layer.low - (float)sorted[i] <= GAP)
            layer.low = (float)sorted[i];
    return layer;
}

static void layers_are_those_of_sorted_heights(void **state)
{
    (void)state;
    for (uint64_t round = 0; round < ROUNDS; round++) {
        float heights[STP_NEIGHBOURS_LIMIT];
        const unsigned count = (unsigned)(round % (STP_NEIGHBOURS_LIMIT + 1));
        for (unsigned i = 0; i < count; i++)
            heights[i] = (float)((double)count * 0.2 * (stp_random_unit(round, i) - 0.5));
        const stp_layer found = stp_layer_of(heights, count, GAP),
                        wanted = expected(heights, count);
        assert_true(found.low == wanted.low && found.high == wanted.high);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layers_are_those_of_sorted_heights),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

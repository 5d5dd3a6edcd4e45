/* Tests the boxes over runs: searches must miss no point, and say when there are too many runs. */
#include "base/random.h"
#include "preprocess/cloud/run_tree.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#define MOST 5000u

typedef struct points {
    float axes[3][MOST];
    uint32_t count;
    stp_run_tree tree;
} points;

static void plant(points *p, uint32_t count)
{
    const float *const axes[3] = {p->axes[0], p->axes[1], p->axes[2]};
    p->count = count;
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t a = 0; a < 3; a++) /* along a line, with noise: runs lie together */
            p->axes[a][i] = (float)(i + 20.0 * stp_random_unit(a, i)) * (a == 1 ? -0.01f : 0.01f);
    assert_int_equal(stp_run_tree_create(&p->tree, axes, count, NULL), STP_OK);
}

static bool is_near(const points *p, uint32_t i, const float low[3], const float high[3],
                    float reach)
{
    double squared = 0.0;
    for (int a = 0; a < 3; a++) {
        const double at = (double)p->axes[a][i];
        const double off = fmax(0.0, fmax((double)low[a] - at, at - (double)high[a]));
        squared += off * off;
    }
    return squared <= (double)reach * (double)reach;
}

/* Each point that is near must be in a run that was found; runs ascend. */
static void check(const points *p, const float low[3], const float high[3], float reach)
{
    uint32_t runs[STP_RUNS_NEAR];
    unsigned next = 0;
    const unsigned count = stp_run_tree_near(&p->tree, low, high, reach, runs);
    assert_true(count <= STP_RUNS_NEAR);
    for (unsigned r = 0; r < count; r++)
        assert_true(runs[r] < (p->count + STP_RUN_POINTS - 1) / STP_RUN_POINTS &&
                    (r == 0 || runs[r] > runs[r - 1]));
    for (uint32_t i = 0; i < p->count; i++) {
        if (!is_near(p, i, low, high, reach))
            continue;
        while (next < count && runs[next] < i / STP_RUN_POINTS)
            next++;
        assert_true(next < count && runs[next] == i / STP_RUN_POINTS);
    }
}

static void nothing_is_missed(void **state)
{
    (void)state;
    static points p;
    const uint32_t counts[] = {1, 7, 8, 9, 64, 65, 513, MOST};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
        plant(&p, counts[c]);
        for (uint32_t i = 0; i < p.count; i += 1 + p.count / 300) {
            float low[3], high[3];
            for (int a = 0; a < 3; a++) {
                low[a] = p.axes[a][i];
                high[a] = low[a] + (i % 3 == 0 ? 0.3f : 0.0f);
            }
            check(&p, low, high, 0.0f);
            check(&p, low, high, 0.4f);
        }
        stp_run_tree_clear(&p.tree);
    }
}

static void too_many_runs_are_told(void **state)
{
    (void)state;
    static points p;
    const float low[3] = {0.0f, 0.0f, 0.0f};
    uint32_t runs[STP_RUNS_NEAR + 1] = {0};
    plant(&p, STP_RUNS_NEAR * STP_RUN_POINTS);
    assert_int_equal(stp_run_tree_near(&p.tree, low, low, 1e6f, runs), STP_RUNS_NEAR);
    stp_run_tree_clear(&p.tree);
    plant(&p, STP_RUNS_NEAR * STP_RUN_POINTS + 1);
    assert_int_equal(stp_run_tree_near(&p.tree, low, low, 1e6f, runs), STP_RUNS_NEAR + 1);
    assert_int_equal(runs[STP_RUNS_NEAR], 0); /* nothing is written there */
    stp_run_tree_clear(&p.tree);
}

static void no_points(void **state)
{
    (void)state;
    static points p;
    uint32_t runs[STP_RUNS_NEAR];
    const float low[3] = {0.0f, 0.0f, 0.0f};
    plant(&p, 0);
    assert_int_equal(stp_run_tree_near(&p.tree, low, low, 1e6f, runs), 0);
    stp_run_tree_clear(&p.tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_is_missed),
        cmocka_unit_test(too_many_runs_are_told),
        cmocka_unit_test(no_points),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

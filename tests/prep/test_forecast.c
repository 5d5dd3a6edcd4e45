/* Tests the model of time: alone nothing is sent, shared work falls with ranks and threads, and
 * what every rank does stays. */
#include "preprocess/prep_forecast.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#define POINTS UINT64_C(1000000000)
#define NETWORK 1.25e9

static stp_prep_forecast forecast(unsigned ranks, unsigned threads)
{
    return stp_prep_forecast_make(POINTS, ranks, threads, NETWORK);
}

static void expect_near(double a, double b)
{
    assert_true(a - b < 1e-9 * b && b - a < 1e-9 * b);
}

static void test_alone(void **state)
{
    const stp_prep_forecast f = forecast(1, 2), more = forecast(1, 4);
    (void)state;
    assert_true(f.sent_s == 0.0 && f.sent_bytes == 0.0);
    assert_true(more.shared_s < f.shared_s && more.shared_s > 0.5 * f.shared_s);
    assert_true(more.lone_s < f.lone_s && more.lone_s > 0.5 * f.lone_s);
    expect_near(stp_prep_forecast_seconds(&f), f.lone_s + f.shared_s + f.written_s);
}

/* Each of N - 1 other ranks gets the same bytes; rank 0 gets (N - 1) / N of the file; as many of
 * the points, of 56 bytes, move to the rank that sorts them. */
static void test_ranks(void **state)
{
    const stp_prep_forecast alone = forecast(1, 2);
    (void)state;
    for (unsigned ranks = 2; ranks <= 1024; ranks *= 2) {
        const stp_prep_forecast f = forecast(ranks, 2), half = forecast(ranks / 2, 2);
        expect_near(f.shared_s * ranks, alone.shared_s);
        expect_near(f.lone_s, alone.lone_s);
        assert_true(f.sent_s > half.sent_s && f.written_s > half.written_s);
        assert_true(f.sent_bytes > half.sent_bytes);
        const double file = NETWORK * (f.written_s - alone.written_s) * ranks / (ranks - 1);
        const double moved = 56.0 * (double)POINTS * (ranks - 1) / ranks;
        const double given = f.sent_bytes - moved * (ranks + 1) - file * (ranks - 1) / ranks;
        const double each = given / (ranks - 1) * (double)(31 - __builtin_clz(ranks));
        const double sent = each + moved + moved / ranks;
        expect_near(sent / NETWORK, f.sent_s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_alone), cmocka_unit_test(test_ranks)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

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
    expect_near(more.lone_s, f.lone_s); /* on one thread */
    expect_near(stp_prep_forecast_seconds(&f), f.lone_s + f.shared_s + f.written_s);
}

/* Points, of 56 bytes, move to the rank that sorts them; each of N - 1 other ranks gets 7 bytes a
 * point; what lies along borders grows with the root of the points. */
static void test_ranks(void **state)
{
    const stp_prep_forecast alone = forecast(1, 2);
    (void)state;
    for (unsigned ranks = 2; ranks <= 1024; ranks *= 2) {
        const stp_prep_forecast f = forecast(ranks, 2);
        const stp_prep_forecast large = stp_prep_forecast_make(4 * POINTS, ranks, 2, NETWORK);
        expect_near(f.shared_s * ranks, alone.shared_s);
        expect_near(f.lone_s, alone.lone_s);
        expect_near(f.written_s * (ranks < 16 ? ranks : 16), alone.written_s);
        const double moved = 56.0 * (double)POINTS * (ranks - 1) / ranks;
        const double given = 7.0 * (double)POINTS;
        const double border = (4.0 * f.sent_bytes - large.sent_bytes) / 2.0; /* of all ranks */
        assert_true(border > 0.0);
        expect_near(moved + given * (ranks - 1) + border, f.sent_bytes);
        const double steps = 31 - __builtin_clz(ranks);
        expect_near((moved / ranks + given * steps + border / ranks) / NETWORK, f.sent_s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_alone), cmocka_unit_test(test_ranks)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Tests the threshold for a frame rate, against known costs: stp_pace reaches the rate within two
 * seconds, does not swing, ignores spikes, follows a step, and says if the rate cannot be held. */
#include "runtime/camera/pace.h"
#include "tests/support/check.h"

#include <math.h>

/* A frame costs fixed_ms + points_ms / threshold^power. */
typedef struct cost {
    double fixed_ms, points_ms, power;
} cost;

static double frame_ms(const cost *c, double threshold_px)
{
    return c->fixed_ms + c->points_ms * pow(threshold_px, -c->power);
}

static void holds(void **state)
{
    (void)state;
    static const cost costs[] = {{10, 50, 1}, {10, 500, 1},  {40, 60, 2}, {60, 300, 2},
                                 {1, 700, 2}, {70, 20, 0.5}, {0, 100, 2}};
    static const double rates[] = {12, 30, 60};
    for (size_t i = 0; i < sizeof costs / sizeof *costs; i++)
        for (size_t k = 0; k < 3; k++) {
            if (frame_ms(&costs[i], 64) > 0.85 * 1e3 / rates[k])
                continue;
            stp_pace p = stp_pace_begin(rates[k], 1.0);
            double passed_ms = 0.0, last = 0.0;
            int turns = 0, direction = 0;
            for (int frame = 0; passed_ms < 6e3; frame++) {
                double ms = frame_ms(&costs[i], p.threshold_px);
                passed_ms += fmax(ms, 1e3 / rates[k]);
                if (passed_ms > 2e3)
                    assert_true(ms < 1.15 * 1e3 / rates[k] &&
                                (ms > 0.75 * 1e3 / rates[k] || p.threshold_px <= 1.0));
                int now = p.threshold_px > last ? 1 : p.threshold_px < last ? -1 : 0;
                turns += direction * now < 0;
                direction = now != 0 ? now : direction;
                last = p.threshold_px;
                stp_pace_follow(&p, ms);
                assert_true(stp_pace_holds(&p));
            }
            assert_true(turns <= 2); /* up from the first threshold, and back at most once */
        }
}

static void spikes(void **state)
{
    (void)state;
    const cost c = {20, 100, 1.5};
    stp_pace p = stp_pace_begin(20, 1.0);
    for (int frame = 0; frame < 100; frame++)
        stp_pace_follow(&p, frame_ms(&c, p.threshold_px));
    double settled = p.threshold_px;
    for (int frame = 0; frame < 40; frame++)
        stp_pace_follow(&p, frame_ms(&c, p.threshold_px) * (frame % 8 == 0 ? 5.0 : 1.0));
    assert_true(fabs(p.threshold_px / settled - 1.0) < 0.03);
}

static void limits(void **state)
{
    (void)state;
    const cost slow = {200, 100, 2}, quick = {1, 2, 2};
    stp_pace p = stp_pace_begin(20, 0.5);
    for (int frame = 0; frame < 60; frame++)
        stp_pace_follow(&p, frame_ms(&slow, p.threshold_px));
    assert_false(stp_pace_holds(&p));
    assert_true(p.threshold_px >= STP_PACE_THRESHOLD_MOST_PX);
    for (int frame = 0; frame < 60; frame++)
        stp_pace_follow(&p, frame_ms(&quick, p.threshold_px));
    assert_true(stp_pace_holds(&p));
    assert_true(p.threshold_px <= 0.5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(holds),
        cmocka_unit_test(spikes),
        cmocka_unit_test(limits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

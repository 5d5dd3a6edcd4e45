/* The threshold and the resolution for a frame rate, on simulated machines whose costs are known.
 */
#include "runtime/camera/pace.h"
#include "tests/support/check.h"

#include <math.h>

#define FULL_SAMPLES 1e6

/* The time of a frame: a part that nothing changes, pixels at full resolution, and samples at a
 * threshold of 1 px. Samples fall with the threshold to the given power. */
typedef struct machine {
    double fixed_ms, pixels_ms, samples_ms, power;
    double noise; /* each frame's time is off by up to this share */
    uint32_t random;
} machine;

static double sample_share(const machine *m, double threshold_px, double scale)
{
    return scale * scale * pow(threshold_px, -m->power);
}

static double frame_ms(const machine *m, double threshold_px, double scale)
{
    return m->fixed_ms + m->pixels_ms * scale * scale +
           m->samples_ms * sample_share(m, threshold_px, scale);
}

/* Draws a frame; its time. */
static double draw(machine *m, stp_pace *p)
{
    m->random = m->random * 1664525u + 1013904223u;
    double ms = frame_ms(m, p->threshold_px, p->scale) *
                (1.0 + m->noise * ((double)m->random / 2147483648.0 - 1.0));
    stp_pace_follow(p, ms, (uint64_t)(FULL_SAMPLES * sample_share(m, p->threshold_px, p->scale)));
    return ms;
}

static void draw_many(machine *m, stp_pace *p, int frames)
{
    while (frames-- > 0)
        draw(m, p);
}

static stp_pace pace_for(double fps, double asked_px)
{
    stp_pace p = {0};
    stp_pace_ask(&p, fps, asked_px);
    return p;
}

/* Whatever the cost, the rate is there after two seconds and neither threshold nor scale swings. */
static void samples_and_mixtures(void **state)
{
    (void)state;
    static const machine machines[] = {{0, 10, 50, 1, 0, 0},   {0, 10, 500, 1, 0, 0},
                                       {0, 40, 60, 2, 0, 0},   {0, 60, 300, 2, 0, 0},
                                       {0, 1, 700, 2, 0, 0},   {0, 0, 100, 2, 0, 0},
                                       {0, 70, 20, 0.5, 0, 0}, {2, 90, 90, 1.5, 0, 0}};
    static const double rates[] = {12, 30, 60};
    for (size_t i = 0; i < sizeof machines / sizeof *machines; i++)
        for (size_t k = 0; k < 3; k++) {
            machine m = machines[i];
            const double period_ms = 1e3 / rates[k];
            stp_pace p = pace_for(rates[k], 1.0);
            double passed_ms = 0.0, scale = 0.0, threshold = 0.0;
            if (frame_ms(&m, STP_PACE_THRESHOLD_MOST_PX, 0.25) > 0.85 * period_ms)
                continue;
            while (passed_ms < 6e3) {
                double ms = draw(&m, &p);
                if (passed_ms > 3e3) {
                    assert_true(ms < 1.15 * period_ms);
                    assert_true(p.scale == scale && fabs(p.threshold_px / threshold - 1.0) < 0.15);
                    assert_true(stp_pace_holds(&p));
                }
                scale = p.scale;
                threshold = p.threshold_px;
                passed_ms += fmax(ms, period_ms);
            }
            /* where samples alone cost, all pixels are drawn */
            if (m.pixels_ms <= 10 && frame_ms(&m, 3.0, 1.0) < 0.9 * period_ms)
                assert_true(p.scale == 1.0);
        }
}

/* A coarser threshold saves nothing: it stays, and the picture gets smaller. */
static void pixels_alone(void **state)
{
    (void)state;
    machine m = {.pixels_ms = 100, .samples_ms = 4, .power = 2, .noise = 0.15};
    stp_pace p = pace_for(30, 1.0);
    int coarse = 0;
    for (int frame = 0; frame < 200; frame++) {
        draw(&m, &p);
        coarse += p.threshold_px > 1.05;
        assert_true(p.threshold_px <= 2.0);
        assert_true(frame < 6 || p.scale < 1.0);
    }
    assert_true(coarse <= 3); /* as long as it takes to see that it does not help */
    assert_true(p.scale == 0.5);
    assert_true(stp_pace_holds(&p));
}

/* Half pixels, half samples: the threshold takes what it can, fewer pixels the rest. */
static void both(void **state)
{
    (void)state;
    machine m = {.pixels_ms = 60, .samples_ms = 60, .power = 2};
    stp_pace p = pace_for(11, 1.0); /* 82 ms: 60 + 60 / 1.66^2 */
    draw_many(&m, &p, 100);
    assert_true(p.scale == 1.0 && p.threshold_px > 1.5 && p.threshold_px < 1.8);
    stp_pace_ask(&p, 30, 1.0);
    draw_many(&m, &p, 100);
    assert_true(p.scale == 0.5 && p.threshold_px < 2.5 && stp_pace_holds(&p));
    stp_pace_ask(&p, 30, 6.0); /* asked for: coarser than the limit */
    draw_many(&m, &p, 100);
    assert_true(p.threshold_px == 6.0);
}

/* With noise of 20 %, 300 frames seldom change the threshold, and the resolution next to never. */
static void noise(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 19 * 53; i++) {
        machine m = {.pixels_ms = 50,
                     .samples_ms = 90,
                     .power = 1.5,
                     .noise = 0.2,
                     .random = 7919 * (i / 53)};
        stp_pace p = pace_for(8.0 + i % 53, 0.8);
        int steps = 0, moves = 0;
        draw_many(&m, &p, 60);
        for (int frame = 0; frame < 300; frame++) {
            const stp_pace last = p;
            draw(&m, &p);
            steps += p.scale != last.scale;
            moves += fabs(log(p.threshold_px / last.threshold_px)) > 0.1;
        }
        assert_true(steps <= 2);
        assert_true(moves <= 15);
    }
}

static void spikes(void **state)
{
    (void)state;
    machine m = {.pixels_ms = 20, .samples_ms = 100, .power = 1.5};
    stp_pace p = pace_for(20, 1.0);
    draw_many(&m, &p, 100);
    double settled = p.threshold_px;
    for (int frame = 0; frame < 40; frame++) {
        machine hiccup = m;
        hiccup.pixels_ms *= frame % 8 == 0 ? 12.0 : 1.0;
        draw(&hiccup, &p);
    }
    assert_true(fabs(p.threshold_px / settled - 1.0) < 0.03 && p.scale == 1.0);
}

/* A machine that is busy for a while: small pictures, then full ones, each change made once. */
static void faster_again(void **state)
{
    (void)state;
    machine busy = {.pixels_ms = 150, .samples_ms = 50, .power = 2, .noise = 0.1};
    machine idle = {.pixels_ms = 12, .samples_ms = 4, .power = 2, .noise = 0.1};
    stp_pace p = pace_for(24, 0.5);
    draw_many(&busy, &p, 100);
    double scale = p.scale;
    assert_true(scale <= 0.5 && stp_pace_holds(&p));
    for (int frame = 0; frame < 100; frame++) {
        draw(&idle, &p);
        assert_true(p.scale >= scale);
        scale = p.scale;
    }
    assert_true(p.scale == 1.0 && p.threshold_px <= 0.55);
}

/* What nothing saves is said, and neither threshold nor resolution is given away for it. */
static void limits(void **state)
{
    (void)state;
    machine stuck = {.fixed_ms = 200, .pixels_ms = 4, .samples_ms = 4, .power = 2};
    stp_pace p = pace_for(20, 0.5);
    draw_many(&stuck, &p, 60);
    assert_false(stp_pace_holds(&p));
    assert_true(p.scale == 1.0 && p.threshold_px == 0.5);
    machine slow = {.pixels_ms = 204, .samples_ms = 4, .power = 2}; /* another view */
    draw_many(&slow, &p, 100);
    assert_true(stp_pace_holds(&p) && p.scale <= 0.5);
    machine huge = {.pixels_ms = 2000, .samples_ms = 2000, .power = 2};
    p = pace_for(60, 1.0);
    draw_many(&huge, &p, 100);
    assert_false(stp_pace_holds(&p));
    assert_true(p.scale == 0.25 && p.threshold_px <= STP_PACE_THRESHOLD_MOST_PX);
    machine fast = {.pixels_ms = 1, .samples_ms = 1, .power = 2};
    draw_many(&fast, &p, 100);
    assert_true(stp_pace_holds(&p) && p.scale == 1.0 && p.threshold_px == 1.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_and_mixtures),
        cmocka_unit_test(pixels_alone),
        cmocka_unit_test(both),
        cmocka_unit_test(noise),
        cmocka_unit_test(spikes),
        cmocka_unit_test(faster_again),
        cmocka_unit_test(limits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

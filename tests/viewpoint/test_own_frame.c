/* Tests which points have the coordinates of a sensor at the origin. */
#include "tests/support/check.h"

#include "preprocess/viewpoint/own_frame.h"

#include <math.h>
#include <stdlib.h>

enum { COLUMNS = 160, ROWS = 120, COUNT = COLUMNS * ROWS };

static double noise(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state / 4294967296.0 - 0.5;
}

static stp_own_frame frame_of(const stp_dvec3 *positions)
{
    stp_own_frame frame = STP_OWN_FRAME_TURNING;
    assert_int_equal(stp_own_frame_find(&frame, positions, COUNT, NULL), STP_OK);
    return frame;
}

/* A floor, a wall and a post, as floats. */
static void fill_camera(stp_dvec3 *out)
{
    uint32_t seed = 1;
    for (int i = 0; i < COUNT; i++) {
        const double u = (i % COLUMNS - 80) / 130.0, v = (i / COLUMNS - 60) / 130.0;
        double z = fmin(3.5 - u, v > 0.0 ? 1.2 / v : 9.0);
        z = (fabs(u) < 0.1 ? 2.0 : z) + 0.01 * noise(&seed);
        out[i] = (stp_dvec3){(double)(float)(u * z), (double)(float)(v * z), (double)(float)z};
    }
}

static void cameras(void **state)
{
    (void)state;
    static stp_dvec3 p[COUNT];
    fill_camera(p);
    assert_int_equal(frame_of(p), STP_OWN_FRAME_CAMERA);
    for (int i = 0; i < COUNT; i++)
        p[i] = (stp_dvec3){p[i].x, -p[i].y, -p[i].z};
    assert_int_equal(frame_of(p), STP_OWN_FRAME_CAMERA);
    for (int i = 0; i < COUNT; i++)
        p[i] = (stp_dvec3){-p[i].z, -p[i].x, p[i].y};
    assert_int_equal(frame_of(p), STP_OWN_FRAME_CAMERA);
    for (int i = 0; i < COUNT; i++) /* in a world */
        p[i] = (stp_dvec3){p[i].x + 0.5, p[i].y - 0.25, p[i].z};
    assert_int_equal(frame_of(p), STP_OWN_FRAME_NONE);
}

/* Above the origin; with whole heights, x/z and y/z are few, too. */
static void terrains(void **state)
{
    (void)state;
    static stp_dvec3 p[COUNT];
    for (int whole = 0; whole < 2; whole++) {
        for (int i = 0; i < COUNT; i++) {
            const double x = i % COLUMNS - 80, y = i / COLUMNS - 60, z = 100.0 + 3.0 * sin(x / 9.0);
            p[i] = (stp_dvec3){x, y, whole ? floor(z) : z};
        }
        assert_int_equal(frame_of(p), STP_OWN_FRAME_NONE);
    }
}

/* Sixteen rings on the ground and on walls around. */
static void turning(void **state)
{
    (void)state;
    static stp_dvec3 p[COUNT];
    for (int statue = 0; statue < 2; statue++) { /* which is as far on all sides */
        for (int i = 0; i < COUNT; i++) {
            const double angle = 2.0 * 3.14159265 * (i / 16) / (COUNT / 16);
            const double slope = tan((2.0 * (i % 16) - 15.0) * 3.14159265 / 180.0);
            double r = fmin(30.0 / fabs(cos(angle)), 12.0 / fabs(sin(angle)));
            r = slope < 0.0 ? fmin(r, -1.0 / slope) : r;
            r = statue ? 1.0 + 0.3 * sin(7.0 * angle) : r;
            p[i] = (stp_dvec3){r * cos(angle), r * sin(angle), r * slope};
        }
        assert_int_equal(frame_of(p), statue ? STP_OWN_FRAME_NONE : STP_OWN_FRAME_TURNING);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cameras),
        cmocka_unit_test(terrains),
        cmocka_unit_test(turning),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

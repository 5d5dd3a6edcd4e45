/* Tests turning, shifting and scaling a camera: the point that is held stays where it is in the
 * picture. */
#include "runtime/camera/orbit.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#define WIDTH 640
#define HEIGHT 480
#define PIXELS 1e-6

/* Georeferenced, so that coordinates are large and lengths small. */
static const stp_ball ball = {{456000.0, 5428000.0, 300.0}, 25.0};

static stp_camera camera_of(bool orthographic)
{
    stp_camera c = stp_camera_around(&ball, (stp_dvec3){0.3, -1.0, 0.7}, (stp_dvec3){0.0, 0.0, 1.0},
                                     40.0, WIDTH, HEIGHT);
    c.height = orthographic ? 60.0 : 0.0;
    return c;
}

static stp_view view_of(const stp_camera *camera)
{
    stp_view view;
    stp_error err = {0};
    assert_int_equal(stp_view_create(&view, camera, &ball, WIDTH, HEIGHT, &err), STP_OK);
    return view;
}

static double distance(stp_dvec3 a, stp_dvec3 b)
{
    return stp_dvec3_length(stp_dvec3_sub(a, b));
}

static void expect_at(const stp_camera *camera, stp_dvec3 point, double u, double v, double within)
{
    stp_view view = view_of(camera);
    stp_dvec3 w = stp_view_project(&view, point);
    assert_true(fabs(w.x - u) <= within && fabs(w.y - v) <= within);
    assert_true(w.z > 0.0);
}

static void unproject_inverts_project(void **state)
{
    (void)state;
    for (int orthographic = 0; orthographic < 2; orthographic++) {
        stp_camera c = camera_of(orthographic != 0);
        stp_view view = view_of(&c);
        for (int i = 0; i < 100; i++) {
            double u = 6.5 * i, v = 480.0 - 4.5 * i, depth = 1.0 + 2.0 * i;
            stp_dvec3 w = stp_view_project(&view, stp_view_unproject(&view, u, v, depth));
            assert_true(fabs(w.x - u) < PIXELS && fabs(w.y - v) < PIXELS);
            assert_true(fabs(w.z - depth) < 1e-7);
        }
    }
}

static void turn_holds_the_pivot(void **state)
{
    (void)state;
    for (int orthographic = 0; orthographic < 2; orthographic++) {
        stp_camera c = camera_of(orthographic != 0);
        stp_view view = view_of(&c);
        stp_dvec3 pivot = stp_view_unproject(&view, 200.0, 300.0, 50.0);
        double far_away = distance(c.eye, pivot), length = distance(c.eye, c.look);
        for (int i = 0; i < 200; i++) {
            stp_camera_turn(&c, pivot, 0.1, 0.013 * (i % 7 - 3));
            view = view_of(&c); /* never degenerate */
            assert_true(fabs(distance(c.eye, pivot) - far_away) < 1e-6);
            assert_true(fabs(distance(c.eye, c.look) - length) < 1e-6);
            assert_true(stp_dvec3_dot(view.up, c.up) > 0.0);
        }
    }
}

/* The point that the camera turns about stays in the picture's middle. A point on its near side
 * moves with the hand. */
static void turn_follows_the_hand(void **state)
{
    (void)state;
    stp_camera c = camera_of(false);
    stp_view view = view_of(&c);
    stp_dvec3 near_side = stp_view_unproject(&view, 320.0, 240.0, 40.0);
    stp_camera right = c, down = c;
    stp_camera_turn(&right, ball.centre, 0.05, 0.0);
    expect_at(&right, ball.centre, 320.0, 240.0, PIXELS);
    view = view_of(&right);
    assert_true(stp_view_project(&view, near_side).x > 321.0);
    stp_camera_turn(&down, ball.centre, 0.0, 0.05);
    expect_at(&down, ball.centre, 320.0, 240.0, PIXELS);
    view = view_of(&down);
    assert_true(stp_view_project(&view, near_side).y < 239.0);
    stp_camera_turn(&down, ball.centre, 0.0, -0.05);
    assert_true(distance(down.eye, c.eye) < 1e-6);
}

static void turn_stops_at_the_poles(void **state)
{
    (void)state;
    for (int sign = -1; sign <= 1; sign += 2) {
        stp_camera c = camera_of(false);
        for (int i = 0; i < 100; i++)
            stp_camera_turn(&c, ball.centre, 0.3, sign * 0.2);
        stp_view view = view_of(&c);
        double angle = acos(stp_dvec3_dot(view.back, c.up) * sign);
        assert_true(fabs(angle - STP_ORBIT_POLE_RAD) < 1e-6);
    }
}

static void pan_moves_by_pixels(void **state)
{
    (void)state;
    for (int orthographic = 0; orthographic < 2; orthographic++) {
        stp_camera c = camera_of(orthographic != 0);
        stp_view view = view_of(&c);
        stp_dvec3 point = stp_view_unproject(&view, 100.0, 50.0, 33.0);
        stp_dvec3 back = view.back;
        stp_camera_pan(&c, 33.0, 211.0, -37.5, HEIGHT);
        expect_at(&c, point, 311.0, 12.5, PIXELS);
        view = view_of(&c);
        assert_true(distance(view.back, back) < 1e-9);
    }
}

static void zoom_holds_the_point(void **state)
{
    (void)state;
    for (int orthographic = 0; orthographic < 2; orthographic++) {
        stp_camera c = camera_of(orthographic != 0);
        stp_view view = view_of(&c);
        stp_dvec3 point = stp_view_unproject(&view, 600.0, 30.0, 47.0);
        stp_dvec3 other = stp_view_unproject(&view, 500.0, 30.0, 47.0);
        double before = distance(c.eye, point), height = c.height;
        for (int i = 0; i < 12; i++)
            stp_camera_zoom(&c, &ball, point, 0.85);
        expect_at(&c, point, 600.0, 30.0, 1e-4);
        view = view_of(&c);
        double scale = pow(0.85, 12.0);
        double apart = 600.0 - stp_view_project(&view, other).x;
        assert_true(fabs(apart * scale - 100.0) < 1e-3);
        if (orthographic)
            assert_true(fabs(c.height - height * scale) < 1e-9);
        else
            assert_true(fabs(distance(c.eye, point) - before * scale) < 1e-6);
    }
}

static void zoom_has_limits(void **state)
{
    (void)state;
    for (int orthographic = 0; orthographic < 2; orthographic++) {
        stp_camera c = camera_of(orthographic != 0);
        stp_view view = view_of(&c);
        stp_dvec3 point = stp_view_unproject(&view, 320.0, 240.0, 40.0);
        for (int i = 0; i < 500; i++)
            stp_camera_zoom(&c, &ball, point, 0.5);
        double least = STP_ORBIT_NEAREST * ball.radius;
        view = view_of(&c);
        double reached = orthographic ? c.height : distance(c.eye, point);
        assert_true(reached > 0.5 * least && reached < 2.0 * least);
        for (int i = 0; i < 500; i++)
            stp_camera_zoom(&c, &ball, point, 2.0);
        view = view_of(&c);
        reached = orthographic ? c.height : distance(c.eye, ball.centre);
        assert_true(reached > 0.5 * STP_ORBIT_FARTHEST * ball.radius);
        assert_true(reached < 4.0 * STP_ORBIT_FARTHEST * ball.radius);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(unproject_inverts_project), cmocka_unit_test(turn_holds_the_pivot),
        cmocka_unit_test(turn_follows_the_hand),     cmocka_unit_test(turn_stops_at_the_poles),
        cmocka_unit_test(pan_moves_by_pixels),       cmocka_unit_test(zoom_holds_the_point),
        cmocka_unit_test(zoom_has_limits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

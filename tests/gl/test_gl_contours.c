/* Tests contours on a unit sphere against the circles of equal z that rays find on it: a pixel of a
 * line lies near a circle, and a circle is drawn where it faces the eye. A level plane at a
 * contour's own height has none, and pictures without contours do not change. */
#include "tests/fixtures/gl_model.h"

enum { SIZE = 300, PIXELS = SIZE * SIZE };

/* Half of the widest line and its soft edge, in pixels, and what a circle may be off. */
#define WIDEST (0.5 * 2.2 + 0.5)
#define OFF 1.0

static int open_model(void **state)
{
    return gl_model_enter(state, &(model_recipe){.shape = GEN_SPHERE, .point_count = 120000});
}

static stp_view view_of(const gl_fixture *f, bool orthographic)
{
    stp_view view;
    const stp_camera camera = stp_camera_around(&f->model->ball, (stp_dvec3){0.5, -0.8, 0.6},
                                                (stp_dvec3){0.0, 0.0, 1.0}, 40.0, SIZE, SIZE);
    check_ok(stp_view_create(&view, &camera, &f->model->ball, SIZE, SIZE, err));
    view.orthographic = orthographic;
    if (orthographic)
        view.f = 0.45 * SIZE / f->model->ball.radius;
    return view;
}

/* The sphere's z where the ray through window coordinates meets it. *facing: the cosine there. NaN:
 * it misses. */
static double sphere_z(const stp_view *view, double u, double v, double *facing)
{
    const double x = (u - 0.5 * SIZE) / view->f, y = (v - 0.5 * SIZE) / view->f;
    const stp_dvec3 across =
        stp_dvec3_add(stp_dvec3_scale(view->right, x), stp_dvec3_scale(view->up, y));
    const stp_dvec3 ahead = stp_dvec3_scale(view->back, -1.0);
    const stp_dvec3 from = view->orthographic ? stp_dvec3_add(view->eye, across) : view->eye;
    const stp_dvec3 way =
        view->orthographic ? ahead : stp_dvec3_normalize(stp_dvec3_add(across, ahead));
    const double b = stp_dvec3_dot(from, way), c = stp_dvec3_dot(from, from) - 1.0;
    if (b * b - c < 0.0)
        return NAN;
    const stp_dvec3 hit = stp_dvec3_add(from, stp_dvec3_scale(way, -b - sqrt(b * b - c)));
    *facing = -stp_dvec3_dot(hit, way);
    return hit.z;
}

/* How far a pixel is from the nearest circle, in pixels, by the slope of z there; INFINITY beyond
 * the outline. */
static double pixels_off(const stp_view *view, int i, double step, double base, double *facing)
{
    const double u = i % SIZE + 0.5, v = i / SIZE + 0.5;
    double unused;
    const double z = sphere_z(view, u, v, facing), right = sphere_z(view, u + 0.5, v, &unused),
                 left = sphere_z(view, u - 0.5, v, &unused),
                 above = sphere_z(view, u, v + 0.5, &unused),
                 below = sphere_z(view, u, v - 0.5, &unused);
    const double slope = hypot(right - left, above - below);
    if (isnan(z) || isnan(slope))
        return INFINITY;
    return fabs(remainder(z - base, step)) / slope;
}

static void circles(void **state)
{
    gl_fixture *f = *state;
    static uint8_t plain[4 * PIXELS], lined[4 * PIXELS];
    for (int variant = 0; variant < 6; variant++) {
        const stp_view view = view_of(f, variant % 2);
        const double step = 0.2, base = variant < 2 ? 0.0 : 12345.67;
        stp_draw_params params = {.shade = STP_SHADE_UNLIT,
                                  .colour = STP_COLOUR_NONE,
                                  .threshold_px = variant < 4 ? 1.0 : 0.0,
                                  .every_sample = variant >= 4,
                                  .lod = variant < 4 ? STP_LOD_AUTO : STP_LOD_COMPUTE};
        gl_fixture_draw(f, &view, &params, NULL, plain);
        params.contour_step = step;
        params.contour_base = base;
        gl_fixture_draw(f, &view, &params, NULL, lined);
        size_t dark = 0, far = 0, on = 0, missing = 0;
        for (int i = 0; i < PIXELS; i++) {
            double facing = 0.0;
            const double off = pixels_off(&view, i, step, base, &facing);
            const int drawn = plain[4 * i] - lined[4 * i];
            assert_int_equal(plain[4 * i + 3], lined[4 * i + 3]);
            assert_true(drawn >= 0);
            if (isinf(off) || facing < 0.35)
                continue; /* near the outline lines are closer together than they are wide */
            dark += drawn > 40;
            far += drawn > 40 && off > WIDEST + OFF;
            on += off < 0.25;
            missing += off < 0.25 && drawn < 40;
        }
        print_message("variant %d: %zu pixels of lines, %zu too far; %zu on circles, %zu missing\n",
                      variant, dark, far, on, missing);
        assert_true(dark > 1500 && on > 400);
        assert_true(far <= dark / 100);
        assert_true(missing <= on / 20);
    }
}

static void no_lines_on_a_level_plane(void **state)
{
    (void)state;
    static uint8_t plain[4 * PIXELS], lined[4 * PIXELS];
    gl_fixture f = {0};
    model_fixture_build("plane.stipple", &(model_recipe){.shape = GEN_PLANE, .point_count = 10000});
    gl_fixture_open(&f, "plane.stipple", NULL);
    const stp_view view = view_of(&f, false);
    stp_draw_params params = {.shade = STP_SHADE_UNLIT};
    gl_fixture_draw(&f, &view, &params, NULL, plain);
    params.contour_step = 0.1;
    gl_fixture_draw(&f, &view, &params, NULL, lined);
    assert_memory_equal(plain, lined, sizeof plain);
    gl_fixture_close(&f);
}

static void wrong_steps(void **state)
{
    gl_fixture *f = *state;
    static const double wrong[][2] = {{-1.0, 0.0}, {NAN, 0.0}, {INFINITY, 0.0}, {1.0, NAN}};
    const stp_view view = view_of(f, false);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        stp_error error = {0};
        const stp_draw_params params = {.contour_step = wrong[i][0], .contour_base = wrong[i][1]};
        assert_int_equal(stp_renderer_draw(f->renderer, &view, &params, NULL, &error),
                         STP_INVALID_ARGUMENT);
        assert_non_null(strstr(error.message, "contours"));
    }
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {cmocka_unit_test(circles),
                                       cmocka_unit_test(no_lines_on_a_level_plane),
                                       cmocka_unit_test(wrong_steps)};
    int failed = cmocka_run_group_tests(tests, open_model, gl_model_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

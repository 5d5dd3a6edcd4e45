/* Tests what is laid over a picture: eye-dome lighting against the formula of shaders/README.md,
 * the colours of confidence against the pixels that they describe, and overlays against the two
 * pictures that they mix. */
#include "tests/fixtures/gl_model.h"
#include "tests/support/views.h"

enum { WIDTH = 241, HEIGHT = 180, PIXELS = WIDTH * HEIGHT };

static int open_model(void **state)
{
    return gl_model_enter(state, &(model_recipe){.shape = GEN_STATUE, .point_count = 60000});
}

static stp_view view_of(const gl_fixture *f, bool orthographic)
{
    stp_view view = views_get(22, &f->model->ball, NULL, 0, WIDTH, HEIGHT);
    view.orthographic = orthographic;
    if (orthographic)
        view.f = 0.45 * HEIGHT / f->model->ball.radius;
    return view;
}

/* How far, in pixels of depth, the neighbour at (x + dx, y + dy) lies in front of pixel (x, y). */
static double in_front(const stp_view *view, const float *depth, int x, int y, int dx, int dy)
{
    double own = (double)depth[y * WIDTH + x];
    x = x + dx < 0 ? 0 : x + dx >= WIDTH ? WIDTH - 1 : x + dx;
    y = y + dy < 0 ? 0 : y + dy >= HEIGHT ? HEIGHT - 1 : y + dy;
    double other = (double)depth[y * WIDTH + x];
    if (own <= 0.0 || other <= 0.0)
        return 0.0;
    return fmax(0.0, view->f * (view->orthographic ? own - other : log(own / other)));
}

static void eye_dome(void **state)
{
    gl_fixture *f = *state;
    static uint8_t plain[4 * PIXELS], lit[4 * PIXELS];
    static float depth[PIXELS];
    for (int variant = 0; variant < 6; variant++) {
        stp_view view = view_of(f, variant % 2);
        stp_draw_params params = {.reconstruct = (stp_reconstruct)(variant / 2),
                                  .shade = variant < 4 ? STP_SHADE_LAMBERT : STP_SHADE_CHUNK};
        const double strength = variant == 3 ? 4.0 : 1.0;
        size_t darker = 0;
        gl_fixture_draw(f, &view, &params, NULL, plain);
        params.edl = strength;
        gl_fixture_draw(f, &view, &params, NULL, lit);
        glGetTextureImage(stp_renderer_inspect(f->renderer).pyramid->picture_depth, 0, GL_RED,
                          GL_FLOAT, sizeof depth, depth);
        for (int i = 0; i < PIXELS; i++) {
            double sum = 0.0;
            for (int k = 0; k < 9; k++)
                sum += in_front(&view, depth, i % WIDTH, i / WIDTH, k % 3 - 1, k / 3 - 1);
            double share = exp(-strength * 0.15 * sum / 8.0);
            darker += share < 0.5 && plain[4 * i + 3] != 0;
            assert_int_equal(lit[4 * i + 3], plain[4 * i + 3]);
            for (int c = 0; c < 3; c++)
                check_near(lit[4 * i + c], share * plain[4 * i + c], 1.01);
        }
        assert_true(darker > 20);
    }
}

/* Green if the finished pixel was measured; from yellow to red if it was interpolated. */
static void confidence(void **state)
{
    gl_fixture *f = *state;
    static uint8_t rgba[4 * PIXELS];
    size_t measured = 0, interpolated = 0;
    stp_view view = view_of(f, false);
    view.f *= 3.0;
    const stp_draw_params params = {.shade = STP_SHADE_CONFIDENCE, .keep_pixels = true};
    gl_fixture_draw(f, &view, &params, NULL, rgba);
    reference_pixel *pixels = gl_fixture_pixels(f, true), *pulled = gl_fixture_pixels(f, false);
    for (int i = 0; i < PIXELS; i++) {
        const uint8_t *p = rgba + 4 * i;
        int source = pixels[i].tag == 0 ? 0 : (pixels[i].tag - 1) >> 4;
        assert_int_equal(p[3] != 0, pixels[i].tag != 0);
        if (pixels[i].tag == 0)
            continue;
        measured += source == 0;
        interpolated += source > 0;
        if (source == 0) /* a sample fell here and is shown */
            assert_true(pulled[i].tag != 0 && pulled[i].z_min == pixels[i].z_min);
        else /* no sample fell here, or one that is hidden */
            assert_true(pulled[i].tag == 0 || pulled[i].z_min > pixels[i].z_min);
        check_near(p[0], source == 0 ? 0.2 * 255.0 : 255.0, 1.0);
        check_near(p[1], 255.0 * (source == 0 ? 0.75 : fmax(0.0, 1.0 - (source - 1) / 5.0)), 1.0);
        check_near(p[2], 255.0 * (source == 0 ? 0.3 : 0.1), 1.0);
    }
    assert_true(measured > 1000 && interpolated > 1000);
    free(pixels);
    free(pulled);
}

/* A weak overlay is nearly phong; a stronger one moves steadily away from it. */
static void overlays(void **state)
{
    gl_fixture *f = *state;
    static uint8_t plain[4 * PIXELS], rgba[4 * PIXELS];
    stp_view view = view_of(f, false);
    gl_fixture_draw(f, &view, &(stp_draw_params){.shade = STP_SHADE_PHONG}, NULL, plain);
    for (int shade = STP_SHADE_LEVEL; shade <= STP_SHADE_LAST; shade++) {
        static const double amounts[4] = {1e-6, 0.3, 0.6, 1.0};
        double last = 0.0;
        for (int k = 0; k < 4; k++) {
            stp_draw_params params = {.shade = (stp_shade)shade, .overlay = amounts[k]};
            double sum = 0.0;
            gl_fixture_draw(f, &view, &params, NULL, rgba);
            for (int i = 0; i < 4 * PIXELS; i++)
                sum += abs(rgba[i] - plain[i]);
            if (k == 0)
                assert_true(sum <= PIXELS / 100);
            else
                assert_true(sum > 1.3 * last && sum > PIXELS);
            last = sum;
        }
    }
}

/* A light that stands still lights a normal alike from wherever it is seen. */
static void fixed_light(void **state)
{
    gl_fixture *f = *state;
    static uint8_t plain[4 * PIXELS], lit[4 * PIXELS];
    static float normals[3 * PIXELS];
    stp_error err = {0};
    const stp_view first = view_of(f, false);
    const stp_dvec3 towards =
        stp_dvec3_add(stp_dvec3_scale(first.back, 3.0), stp_dvec3_scale(first.right, 2.0));
    const double light[3] = {towards.x, towards.y, towards.z}, length = stp_dvec3_length(towards);
    for (int variant = 0; variant < 3; variant++) {
        stp_view view = views_get(variant == 2   ? 5
                                  : variant == 1 ? 21
                                                 : 22,
                                  &f->model->ball, NULL, 0, WIDTH, HEIGHT);
        stp_draw_params params = {.shade = STP_SHADE_UNLIT, .keep_pixels = true};
        size_t bright = 0;
        gl_fixture_draw(f, &view, &params, NULL, plain);
        params.shade = STP_SHADE_LAMBERT;
        memcpy(params.light, light, sizeof light);
        gl_fixture_draw(f, &view, &params, NULL, lit);
        if (stp_renderer_read_normals(f->renderer, normals, &err) != STP_OK)
            fail_msg("%s", err.message);
        for (int i = 0; i < PIXELS; i++) {
            const float *n = normals + (size_t)3 * (size_t)i;
            const double facing =
                ((double)n[0] * light[0] + (double)n[1] * light[1] + (double)n[2] * light[2]) /
                length;
            const double share = 0.05 + 0.85 * fmax(0.0, facing);
            if (plain[4 * i + 3] == 0)
                continue;
            bright += share > 0.7;
            for (int c = 0; c < 3; c++)
                check_near(lit[4 * i + c], share * plain[4 * i + c], 1.6);
        }
        assert_true(variant == 2 || bright > 200);
    }
}

/* Whatever the light that moves with the camera leaves in the dark, as the ceiling and one wall of
 * a room, is lit from the eye, the more the more it faces it. */
static void light_from_the_eye(void **state)
{
    gl_fixture *f = *state;
    static uint8_t plain[4 * PIXELS], lit[4 * PIXELS];
    static float normals[3 * PIXELS];
    stp_error err = {0};
    const stp_view view = view_of(f, true);
    const stp_dvec3 light = stp_dvec3_normalize(
        stp_dvec3_add(view.back, stp_dvec3_add(stp_dvec3_scale(view.right, 0.35),
                                               stp_dvec3_scale(view.up, 0.45))));
    size_t dark = 0;
    gl_fixture_draw(f, &view, &(stp_draw_params){.shade = STP_SHADE_UNLIT}, NULL, plain);
    gl_fixture_draw(f, &view, &(stp_draw_params){.keep_pixels = true}, NULL, lit);
    if (stp_renderer_read_normals(f->renderer, normals, &err) != STP_OK)
        fail_msg("%s", err.message);
    for (int i = 0; i < PIXELS; i++) {
        const float *p = normals + (size_t)3 * (size_t)i;
        const stp_dvec3 n = {(double)p[0], (double)p[1], (double)p[2]};
        const double facing = stp_dvec3_dot(n, view.back);
        if (plain[4 * i + 3] == 0 || facing < 0.2 || stp_dvec3_dot(n, light) > 0.0)
            continue;
        dark++;
        for (int c = 0; c < 3; c++)
            assert_true(lit[4 * i + c] >= (0.18 + 0.4 * facing) * plain[4 * i + c] - 1.6);
    }
    assert_true(dark > 100);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(eye_dome),           cmocka_unit_test(confidence),
        cmocka_unit_test(overlays),           cmocka_unit_test(fixed_light),
        cmocka_unit_test(light_from_the_eye),
    };
    int failed = cmocka_run_group_tests(tests, open_model, gl_model_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

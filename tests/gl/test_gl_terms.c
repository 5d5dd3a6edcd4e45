/* Tests the terms of the error rule: each alone makes levels finer. The colour term counts only if
 * colours are shown. On a painted wall, which has no other error, it earns its points. */
#include "tests/fixtures/gl_model.h"

enum { SIZE = 256 };

static stp_view look_at(const gl_fixture *f, double x, double y, double z)
{
    stp_view view;
    stp_camera camera = stp_camera_around(&f->model->ball, (stp_dvec3){x, y, z},
                                          (stp_dvec3){0.0, 1.0, 0.0}, 45.0, SIZE, SIZE);
    check_ok(stp_view_create(&view, &camera, &f->model->ball, SIZE, SIZE, err));
    return view;
}

/* The number of samples drawn, all within the threshold. */
static uint64_t points_of(const gl_fixture *f, const stp_view *view, stp_draw_params params,
                          uint32_t terms)
{
    stp_cut_measure measure;
    params.terms = terms;
    check_ok(stp_renderer_draw(f->renderer, view, &params, NULL, err));
    stp_renderer_measure(f->renderer, &measure);
    assert_true(measure.max_error_px <= params.threshold_px);
    return measure.points;
}

static void terms_only_refine(void **state)
{
    const gl_fixture *f = *state;
    static const double thresholds[] = {0.5, 1.0, 2.0, 8.0};
    static const uint32_t alone[] = {STP_TERM_RADIUS, STP_TERM_COLOUR, STP_TERM_SILHOUETTE};
    const uint32_t all = STP_TERM_RADIUS | STP_TERM_COLOUR | STP_TERM_SILHOUETTE;
    bool finer[3] = {false, false, false};
    for (int v = 0; v < 4; v++)
        for (size_t t = 0; t < sizeof thresholds / sizeof *thresholds; t++) {
            const stp_draw_params params = {.threshold_px = thresholds[t], .radius_cap_px = 3.0};
            stp_view view = look_at(f, v - 1.5, 1.0, 0.7 * v);
            uint64_t none = points_of(f, &view, params, STP_TERM_NONE);
            uint64_t most = points_of(f, &view, params, all);
            for (int k = 0; k < 3; k++) {
                uint64_t points = points_of(f, &view, params, alone[k]);
                assert_true(points >= none && points <= most);
                finer[k] |= points > none;
            }
            assert_int_equal(points_of(f, &view, params, 0),
                             points_of(f, &view, params, STP_TERMS_DEFAULT));
        }
    assert_true(finer[0] && finer[1] && finer[2]);
}

static void colours_count_where_they_are_shown(void **state)
{
    const gl_fixture *f = *state;
    const stp_view view = look_at(f, 0.3, 0.2, 1.0);
    const stp_draw_params shown = {.threshold_px = 1.0};
    const stp_draw_params levels = {.threshold_px = 1.0, .shade = STP_SHADE_LEVEL};
    const stp_draw_params hidden[] = {
        {.threshold_px = 1.0, .colour = STP_COLOUR_NONE},
        {.threshold_px = 1.0, .shade = STP_SHADE_DEPTH},
        {.threshold_px = 1.0, .shade = STP_SHADE_NORMAL, .overlay = 0.5}}; /* has none */
    uint64_t none = points_of(f, &view, shown, STP_TERM_NONE);
    assert_true(points_of(f, &view, shown, STP_TERM_COLOUR) > none);
    assert_int_equal(points_of(f, &view, levels, STP_TERM_COLOUR),
                     points_of(f, &view, shown, STP_TERM_COLOUR));
    for (size_t i = 0; i < sizeof hidden / sizeof *hidden; i++)
        assert_int_equal(points_of(f, &view, hidden[i], STP_TERM_COLOUR), none);
}

/* In dB, over the pixels that both pictures cover. */
static double psnr(const uint8_t *a, const uint8_t *b)
{
    double squares = 0.0, count = 0.0;
    for (size_t i = 0; i < (size_t)SIZE * SIZE; i++)
        for (int c = 0; c < 3 && a[4 * i + 3] != 0 && b[4 * i + 3] != 0; c++) {
            double apart = (a[4 * i + (size_t)c] - b[4 * i + (size_t)c]) / 255.0;
            squares += apart * apart;
            count += 1.0;
        }
    assert_true(count > 0.0);
    return -10.0 * log10(squares / count);
}

/* Compares with the picture of every sample. The other picture uses the surface's error alone and
 * has at least as many points. */
static void a_painted_wall_gains(void **state)
{
    (void)state;
    static uint8_t every[4 * SIZE * SIZE], seen[4 * SIZE * SIZE], blind[4 * SIZE * SIZE];
    gl_fixture wall;
    model_fixture_build("wall.stipple", &(model_recipe){.shape = GEN_PLANE, .point_count = 200000});
    gl_fixture_open(&wall, "wall.stipple", NULL);
    const stp_view view = look_at(&wall, 0.2, 0.3, 1.0);
    stp_draw_params params = {.threshold_px = 1.0, .terms = STP_TERM_COLOUR};
    gl_fixture_draw(&wall, &view, &(stp_draw_params){.lod = STP_LOD_FULL}, NULL, every);
    uint64_t points = points_of(&wall, &view, params, STP_TERM_COLOUR), others = 0;
    gl_fixture_draw(&wall, &view, &params, NULL, seen);
    params.terms = STP_TERM_NONE;
    for (params.threshold_px = 4.0; others < points && params.threshold_px > 1e-3;
         params.threshold_px *= 0.9)
        others = points_of(&wall, &view, params, STP_TERM_NONE);
    params.threshold_px /= 0.9;
    gl_fixture_draw(&wall, &view, &params, NULL, blind);
    double gain = psnr(seen, every) - psnr(blind, every);
    print_message("a painted wall: %.2f dB with %llu points, %.2f dB with %llu (%.3f px)\n",
                  psnr(seen, every), (unsigned long long)points, psnr(blind, every),
                  (unsigned long long)others, params.threshold_px);
    assert_true(others >= points);
    assert_true(gain >= 1.0);
    gl_fixture_close(&wall);
}

static int enter(void **state)
{
    return gl_model_enter(state, &(model_recipe){.shape = GEN_BUMPY, .point_count = 100000});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(terms_only_refine),
        cmocka_unit_test(colours_count_where_they_are_shown),
        cmocka_unit_test(a_painted_wall_gains),
    };
    stp_gl_context *context = gl_fixture_context();
    int failed = cmocka_run_group_tests(tests, enter, gl_model_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

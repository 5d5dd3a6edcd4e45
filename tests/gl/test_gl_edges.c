/* Tests smooth edges: the pass must equal the CPU reference. Outlines must be at least 3 dB nearer
 * to a picture of four times as many pixels each way. Depths and picks must stay the same, and
 * nothing of the last frame may remain. While streaming, only a view at rest has them. */
#include "tests/fixtures/gl_model.h"
#include "tests/support/triangles.h"
#include "tests/support/views.h"
#include "tools/draw/draw_fine.h"

enum { WIDTH = 301, HEIGHT = 240, PIXELS = WIDTH * HEIGHT };

static int open_model(void **state)
{
    return gl_model_enter(state, &(model_recipe){.shape = GEN_STATUE, .point_count = 60000});
}

/* A surface without details smaller than a pixel. */
static void open_bumpy(gl_fixture *f)
{
    model_fixture_build("bumpy.stipple", &(model_recipe){.shape = GEN_BUMPY, .point_count = 60000});
    gl_fixture_open(f, "bumpy.stipple", NULL);
}

static stp_view view_of(const gl_fixture *f, int direction, bool orthographic)
{
    stp_view view = views_get(direction, &f->model->ball, NULL, 0, WIDTH, HEIGHT);
    view.orthographic = orthographic;
    if (orthographic)
        view.f = 0.45 * HEIGHT / f->model->ball.radius;
    return view;
}

static int draw(gl_fixture *f, const stp_view *view, const stp_draw_params *params, uint8_t *rgba,
                float *depth)
{
    stp_draw_stats stats;
    check_ok(stp_renderer_draw(f->renderer, view, params, &stats, err));
    check_ok(stp_renderer_read(f->renderer, rgba, err));
    check_ok(stp_renderer_read_depth(f->renderer, depth, err));
    return stats.pyramid_levels;
}

/* Counts the pixels of the smooth picture that differ from the reference's smoothing of the rough
 * one. */
static size_t count_wrong(const gl_fixture *f, const stp_view *view, const uint8_t *rough,
                          const float *depth, const uint8_t *smooth, bool pushed, int levels)
{
    static double expected[4 * PIXELS];
    reference_pixel *level_0 = gl_fixture_level(f, 0, false);
    reference_pixel *level_1 = pushed && levels > 0 ? gl_fixture_level(f, 1, levels > 1) : NULL;
    size_t wrong = 0;
    reference_edges(&(reference_rough){*view, rough, depth, level_0, level_1}, expected);
    for (int i = 0; i < PIXELS; i++) {
        bool good = true;
        for (int c = 0; c < 4; c++)
            good &= fabs(smooth[4 * i + c] - expected[4 * i + c]) <= 1.5;
        wrong += !good;
    }
    free(level_0);
    free(level_1);
    return wrong;
}

static void follow_the_reference(void **state)
{
    gl_fixture *f = *state;
    static uint8_t rough[4 * PIXELS], smooth[4 * PIXELS];
    static float depth[PIXELS], smooth_depth[PIXELS];
    static const stp_reconstruct modes[] = {STP_RECONSTRUCT_GAUSS, STP_RECONSTRUCT_BOX,
                                            STP_RECONSTRUCT_TEMPLATE5, STP_RECONSTRUCT_SPLAT};
    for (int variant = 0; variant < 8; variant++) {
        stp_view view = view_of(f, 3 * variant, variant % 2);
        stp_draw_params params = {.reconstruct = modes[variant / 2],
                                  .edl = variant == 2 ? 1.0 : 0.0};
        size_t parts = 0;
        draw(f, &view, &params, rough, depth);
        params.smooth_edges = true;
        int levels = draw(f, &view, &params, smooth, smooth_depth);
        assert_memory_equal(depth, smooth_depth, sizeof depth);
        for (int i = 0; i < PIXELS; i++)
            parts += smooth[4 * i + 3] > 0 && smooth[4 * i + 3] < 255;
        size_t wrong = count_wrong(f, &view, rough, depth, smooth, variant < 4, levels);
        print_message("variant %d: %zu pixels in part, %zu wrong\n", variant, parts, wrong);
        assert_true(parts > 200);
        assert_true(wrong <= parts / 200);
    }
}

/* For each pixel, the part that the true surface covers, 0..255. Returns how many pixels are
 * covered in part. */
static size_t true_parts(const triangles_mesh *mesh, const stp_view *view, double *part)
{
    enum { TIMES = 4 };
    stp_view finer = stp_view_scaled(view, TIMES);
    triangles_picture picture = {0};
    size_t count = 0;
    check_ok(triangles_draw(&picture, mesh, &finer, err));
    for (int i = 0; i < PIXELS; i++) {
        int covered = 0;
        for (int k = 0; k < TIMES * TIMES; k++) {
            int y = TIMES * (i / WIDTH) + k / TIMES, x = TIMES * (i % WIDTH) + k % TIMES;
            covered += picture.pixels[y * finer.width + x].layers > 0;
        }
        part[i] = 255.0 * covered / (TIMES * TIMES);
        count += covered > 0 && covered < TIMES * TIMES;
    }
    triangles_destroy(&picture);
    return count;
}

/* Sums squared differences of alpha, over the pixels that the surface covers in part. */
static double outline_error(const uint8_t *rgba, const double *part)
{
    double sum = 0.0;
    for (int i = 0; i < PIXELS; i++)
        if (part[i] > 0.0 && part[i] < 255.0)
            sum += (rgba[4 * i + 3] - part[i]) * (rgba[4 * i + 3] - part[i]);
    return sum;
}

static void near_the_true_outline(void **state)
{
    gl_fixture bumpy, *f = &bumpy;
    static uint8_t rough[4 * PIXELS], smooth[4 * PIXELS];
    static double part[PIXELS];
    static float depth[PIXELS];
    triangles_mesh mesh = model_fixture_mesh(GEN_BUMPY, 60000, 300000);
    (void)state;
    open_bumpy(f);
    for (int direction = 0; direction < 20; direction += 6) {
        stp_view view = view_of(f, direction, direction == 6);
        stp_draw_params params = {.every_sample = direction == 12};
        assert_true(true_parts(&mesh, &view, part) > 300);
        draw(f, &view, &params, rough, depth);
        params.smooth_edges = true;
        draw(f, &view, &params, smooth, depth);
        double gain_db = 10.0 * log10(outline_error(rough, part) / outline_error(smooth, part));
        print_message("direction %d: outlines %.1f dB nearer\n", direction, gain_db);
        assert_true(gain_db >= 3.0);
    }
    model_fixture_mesh_clear(&mesh);
    gl_fixture_close(f);
}

/* Inside the surface, a finer picture (draw_fine) must differ little from a plain one. */
static void finer_pictures(void **state)
{
    gl_fixture bumpy, *f = &bumpy;
    static uint8_t fine[4 * PIXELS], rough[4 * PIXELS];
    static float depth[PIXELS];
    (void)state;
    open_bumpy(f);
    stp_view view = view_of(f, 5, false);
    stp_draw_params params = {.every_sample = true, .shade = STP_SHADE_LAMBERT};
    stp_draw_stats stats;
    draw(f, &view, &params, rough, depth);
    size_t whole = 0, parts = 0;
    double difference = 0.0;
    check_ok(draw_fine(f->renderer, &view, &params, 3, fine, &stats, err));
    assert_true(stats.cut_complete && stats.every_sample);
    for (int i = 0; i < PIXELS; i++) {
        parts += fine[4 * i + 3] > 0 && fine[4 * i + 3] < 255;
        if (fine[4 * i + 3] < 255)
            continue;
        whole++;
        difference += abs(fine[4 * i] - rough[4 * i]);
    }
    assert_true(parts > 200);
    assert_true(whole > 5000 && difference / (double)whole < 3.0);
    gl_fixture_close(f);
}

static void picks_stay(void **state)
{
    gl_fixture *f = *state;
    stp_view view = view_of(f, 5, false);
    stp_pick picks[2][64];
    for (int smooth = 0; smooth < 2; smooth++) {
        stp_draw_params params = {.smooth_edges = smooth};
        check_ok(stp_renderer_draw(f->renderer, &view, &params, NULL, err));
        for (int i = 0; i < 64; i++)
            check_ok(stp_renderer_pick(f->renderer, 37 * i % WIDTH, 53 * i % HEIGHT,
                                       &picks[smooth][i], err));
    }
    for (int i = 0; i < 64; i++) {
        assert_int_equal(picks[0][i].hit, picks[1][i].hit);
        assert_true(stp_dvec3_equal(picks[0][i].position, picks[1][i].position));
    }
}

/* A view drawn again after another view must give the same picture. */
static void nothing_stays(void **state)
{
    gl_fixture *f = *state;
    static uint8_t before[4 * PIXELS], after[4 * PIXELS];
    static float depth[PIXELS];
    stp_view view = view_of(f, 5, false), other = view_of(f, 17, false);
    stp_draw_params params = {.smooth_edges = true};
    other.f *= 2.0;
    draw(f, &view, &params, before, depth);
    draw(f, &other, &params, after, depth);
    draw(f, &view, &params, after, depth);
    assert_memory_equal(before, after, sizeof before);
}

/* Streams until the view rests. */
static void rest(gl_fixture *f, const stp_view *view, const stp_draw_params *params, uint8_t *rgba)
{
    stp_draw_stats stats = {.more = true};
    for (int i = 0; i < 10000 && (stats.more || stats.chunks_loading > 0); i++)
        check_ok(stp_renderer_draw(f->renderer, view, params, &stats, err));
    assert_true(stats.cut_complete && !stats.more);
    check_ok(stp_renderer_read(f->renderer, rgba, err));
}

/* While streaming, a view at rest has smooth edges, and a moving one has none. */
static void only_at_rest(void **state)
{
    gl_fixture *f = *state;
    static uint8_t rough[4 * PIXELS], smooth[4 * PIXELS], streamed[4 * PIXELS];
    static float depth[PIXELS];
    const stp_view view = view_of(f, 5, false), other = view_of(f, 17, false);
    for (int lod = STP_LOD_GEOMETRY; lod <= STP_LOD_COMPUTE; lod++) {
        stp_draw_params params = {.lod = (stp_lod)lod};
        draw(f, &view, &params, rough, depth);
        params.smooth_edges = true;
        draw(f, &view, &params, smooth, depth);
        params.stream = true;
        rest(f, &view, &params, streamed);
        assert_memory_equal(streamed, smooth, sizeof smooth);
        rest(f, &other, &params, streamed);
        check_ok(stp_renderer_draw(f->renderer, &view, &params, NULL, err));
        check_ok(stp_renderer_read(f->renderer, streamed, err));
        assert_memory_equal(streamed, rough, sizeof rough);
        rest(f, &view, &params, streamed);
        assert_memory_equal(streamed, smooth, sizeof smooth);
    }
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(follow_the_reference), cmocka_unit_test(near_the_true_outline),
        cmocka_unit_test(finer_pictures),       cmocka_unit_test(picks_stay),
        cmocka_unit_test(nothing_stays),        cmocka_unit_test(only_at_rest),
    };
    int failed = cmocka_run_group_tests(tests, open_model, gl_model_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

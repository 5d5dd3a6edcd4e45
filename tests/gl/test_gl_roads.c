/* Tests that every road, rasterised or by compute shaders, draws the same picture of every sample,
 * byte for byte: which sample wins a pixel, pull and push, shading, marks, smoothing. At the chosen
 * sizes blocks, cells and levels end within pixels of each other. Each renderer also continues in
 * textures that the other road used before. The amount of memory must not matter either, though it
 * splits a picture into passes and moves chunks, and though most pixels may have several samples at
 * one depth. Shaders that choose levels must also draw the same number of samples. */
#include "tests/fixtures/gl_model.h"

#include "runtime/draw/road.h"

typedef struct scene {
    const char *name;
    int width, height;
    stp_draw_params params;
} scene;

/* Far views leave most of the picture empty; near views have ellipses of many levels. */
static const scene scenes[] = {
    {.name = "gauss", .width = 301, .height = 199},
    {.name = "box", .width = 97, .height = 401, .params = {.reconstruct = STP_RECONSTRUCT_BOX}},
    {.name = "edges", .width = 256, .height = 128, .params = {.smooth_edges = true}},
    {.name = "eye-dome", .width = 130, .height = 250, .params = {.edl = 1.0}},
    {.name = "normals", .width = 33, .height = 65, .params = {.shade = STP_SHADE_NORMAL}},
    {.name = "sources", .width = 17, .height = 9, .params = {.shade = STP_SHADE_CONFIDENCE}},
    {.name = "kept", .width = 300, .height = 200, .params = {.keep_pixels = true}},
    {.name = "marked", .width = 300, .height = 200, .params = {.stream = true, .fade = 0.5}},
    {.name = "a pixel", .width = 1, .height = 1},
    {.name = "a row", .width = 200, .height = 1},
    {.name = "five rows", .width = 333, .height = 5},
};

static const double away[] = {1.0, 0.3, 4.0};
enum { AWAY = 3, TURNS = 3 };

static stp_view view_of(const gl_fixture *f, const scene *s, int turn, double times)
{
    static const stp_dvec3 from[TURNS] = {{0.4, 0.3, 1.0}, {-1.0, 0.2, 0.1}, {0.3, 1.0, -0.5}};
    stp_camera camera = stp_camera_around(&f->model->ball, from[turn], (stp_dvec3){0.0, 0.0, 1.0},
                                          45.0, s->width, s->height);
    stp_view view;
    camera.eye =
        stp_dvec3_add(camera.look, stp_dvec3_scale(stp_dvec3_sub(camera.eye, camera.look), times));
    check_ok(stp_view_create(&view, &camera, &f->model->ball, s->width, s->height, err));
    return view;
}

static size_t covered(const uint8_t *rgba, size_t pixels)
{
    size_t count = 0;
    for (size_t i = 0; i < pixels; i++)
        count += rgba[4 * i + 3] != 0;
    return count;
}

/* Draws; a streaming picture is drawn until nothing more comes and nothing fades. Returns the
 * number of samples drawn. */
static uint64_t draw(gl_fixture *f, const stp_view *view, const stp_draw_params *params,
                     uint8_t *out)
{
    stp_draw_stats stats;
    int frames = 0;
    do {
        check_ok(stp_renderer_draw(f->renderer, view, params, &stats, err));
        assert_true(frames++ < 1000);
    } while (params->stream && (!stats.cut_complete || stats.fading));
    check_ok(stp_renderer_read(f->renderer, out, err));
    return stats.points_drawn;
}

static void compare(const scene *s, const uint8_t *a, const uint8_t *b, size_t pixels)
{
    for (size_t i = 0; i < 4 * pixels; i++)
        if (a[i] != b[i])
            fail_msg("%s: pixel %zu of %zu, channel %zu: %d, the other way %d", s->name, i / 4,
                     pixels, i % 4, a[i], b[i]);
}

static void same_bytes(void **state)
{
    gl_fixture *rasterised = *state, computed;
    size_t drawn = 0;
    gl_fixture_open(&computed, "model.stipple", NULL);
    for (size_t i = 0; i < sizeof scenes / sizeof scenes[0]; i++) {
        const scene *s = &scenes[i];
        size_t pixels = (size_t)s->width * (size_t)s->height;
        uint8_t *pictures[2] = {calloc(pixels, 4), calloc(pixels, 4)};
        assert_true(pictures[0] != NULL && pictures[1] != NULL);
        for (int k = 0; k < AWAY * TURNS; k++) {
            stp_view view = view_of(rasterised, s, k % TURNS, away[k / TURNS]);
            stp_draw_params params = s->params;
            params.every_sample = true;
            params.lod = k % 2 ? STP_LOD_CPU : STP_LOD_GEOMETRY;
            uint64_t emitted = draw(rasterised, &view, &params, pictures[0]);
            params.lod = STP_LOD_COMPUTE;
            uint64_t placed = draw(&computed, &view, &params, pictures[1]);
            assert_true(k % 2 || emitted == placed); /* the CPU counts what it lists */
            compare(s, pictures[0], pictures[1], pixels);
            draw(rasterised, &view, &params, pictures[1]); /* after rasterised passes */
            compare(s, pictures[0], pictures[1], pixels);
            drawn += covered(pictures[0], pixels);
        }
        free(pictures[0]);
        free(pictures[1]);
    }
    assert_true(drawn > 500000);
    gl_fixture_close(&computed);
}

/* Patches that are drawn as one sample, or as level 2, are listed apart from those whose levels a
 * shader chooses. With a software driver, the pass that finds depths keeps where all these samples
 * lie, for the pass that names samples. */
static void levels_chosen(void **state)
{
    static const double thresholds[] = {1.0, 3.0, 6.0};
    const scene s = {.name = "levels", .width = 300, .height = 200};
    const size_t pixels = (size_t)s.width * (size_t)s.height;
    gl_fixture *rasterised = *state, computed;
    uint8_t *pictures[2];
    unsigned all = 0;
    if (!stp_road_is_software()) {
        print_message("only software drivers keep places, and choose the same levels exactly\n");
        skip();
    }
    for (int i = 0; i < 2; i++)
        pictures[i] = calloc(pixels, 4);
    assert_true(pictures[0] != NULL && pictures[1] != NULL);
    gl_fixture_open(&computed, "model.stipple", NULL);
    for (int k = 0; k < 9; k++) {
        stp_view view = view_of(rasterised, &s, k % TURNS, 0.6);
        stp_draw_params params = {.threshold_px = thresholds[k / TURNS],
                                  .radius_cap_px = 1000.0,
                                  .reconstruct = STP_RECONSTRUCT_POINTS,
                                  .lod = STP_LOD_GEOMETRY};
        uint64_t emitted = draw(rasterised, &view, &params, pictures[0]);
        params.lod = STP_LOD_COMPUTE;
        assert_int_equal(draw(&computed, &view, &params, pictures[1]), emitted);
        compare(&s, pictures[0], pictures[1], pixels);
        const stp_inspection look = stp_renderer_inspect(computed.renderer);
        const size_t draws = look.cut->draw_count;
        const size_t patches = look.sight->lists[STP_SIGHT_PATCHES].begin[draws];
        const size_t vertices = look.sight->lists[STP_SIGHT_VERTICES].begin[draws];
        const size_t quarters = look.sight->lists[STP_SIGHT_QUARTERS].begin[draws];
        all += patches > 100 && vertices > 100 && quarters > 100;
    }
    assert_true(all >= 3);
    gl_fixture_close(&computed);
    free(pictures[0]);
    free(pictures[1]);
}

/* A plane seen head-on, with some ten samples per pixel: most pixels are decided by ties. */
static void any_memory(void **state)
{
    (void)state;
    static const uint64_t budgets[] = {UINT64_C(3) << 19, UINT64_C(3) << 20, UINT64_C(11) << 20};
    const scene s = {.name = "passes", .width = 150, .height = 150};
    const size_t pixels = (size_t)s.width * (size_t)s.height;
    uint8_t *pictures[2] = {calloc(pixels, 4), calloc(pixels, 4)};
    gl_fixture roomy;
    unsigned passes = 0;
    model_fixture_build("plane.stipple",
                        &(model_recipe){.shape = GEN_PLANE, .point_count = 300000});
    gl_fixture_open(&roomy, "plane.stipple", NULL);
    for (size_t b = 0; b < sizeof budgets / sizeof *budgets; b++) {
        gl_fixture little = {.model = roomy.model};
        check_ok(stp_renderer_create(&little.renderer,
                                     &(stp_renderer_params){.model = roomy.model,
                                                            .thread_count = 2,
                                                            .gpu_memory_bytes = budgets[b]},
                                     err));
        for (int k = 0; k < 6; k++) { /* the oblique views between move chunks */
            const stp_dvec3 from = {0.0, k % 3 == 1 ? 1.0 : 0.0, 1.0};
            stp_camera camera = stp_camera_around(
                &roomy.model->ball, from, (stp_dvec3){1.0, 0.0, 0.0}, 45.0, s.width, s.height);
            stp_view view;
            stp_draw_stats stats = {0};
            stp_draw_params params = {.lod = k < 3 ? STP_LOD_COMPUTE : STP_LOD_GEOMETRY,
                                      .every_sample = k % 3 != 1,
                                      .reconstruct =
                                          b == 0 ? STP_RECONSTRUCT_POINTS : STP_RECONSTRUCT_GAUSS};
            check_ok(stp_view_create(&view, &camera, &roomy.model->ball, s.width, s.height, err));
            draw(&roomy, &view, &params, pictures[0]);
            check_ok(stp_renderer_draw(little.renderer, &view, &params, &stats, err));
            check_ok(stp_renderer_read(little.renderer, pictures[1], err));
            passes = stats.passes > passes ? stats.passes : passes;
            compare(&s, pictures[0], pictures[1], pixels);
            assert_true(covered(pictures[0], pixels) > pixels / 20);
        }
        stp_renderer_destroy(&little.renderer);
    }
    assert_true(passes > 2);
    gl_fixture_close(&roomy);
    free(pictures[0]);
    free(pictures[1]);
}

static int enter(void **state)
{
    return gl_model_enter(state, &(model_recipe){.shape = GEN_STATUE, .point_count = 60000});
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(same_bytes),
                                       cmocka_unit_test(levels_chosen),
                                       cmocka_unit_test(any_memory)};
    stp_gl_context *context = gl_fixture_context();
    int failed = cmocka_run_group_tests(tests, enter, gl_model_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

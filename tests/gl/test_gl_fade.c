/* Tests that changes of level fade. A camera moves slowly at a coarse threshold; the test looks at
 * pixels whose level changes. They change more from frame to frame than if every sample is drawn.
 * With fading, this excess is at most three quarters of the excess without. If no level changes,
 * nothing fades. A picture at rest soon equals, byte for byte, the picture without fading. */
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/support/views.h"

enum { SIZE = 256, PIXELS = SIZE * SIZE, FRAMES = 48, LEVEL_CHANGE = 20, COARSE = 8 };

static const double kept = 0.75;
/* The cap on radii that lets levels change at this threshold; the renderer multiplies it by the
 * threshold's square. */
static const double cap_px = 6.0 / (COARSE * COARSE);

typedef struct rider {
    gl_fixture fixture;
    stp_draw_params params;
    uint8_t now[4 * PIXELS], before[4 * PIXELS];
} rider;

static stp_view view_at(const stp_ball *ball, int frame)
{
    stp_view view = views_get(3, ball, NULL, 0, SIZE, SIZE);
    stp_dvec3 from = stp_dvec3_sub(view.eye, ball->centre);
    view.eye = stp_dvec3_add(ball->centre, stp_dvec3_scale(from, 1.2 * pow(0.997, frame)));
    return view;
}

/* Draws until everything that the view needs is there. Returns the number of frames. */
static int draw(rider *r, const stp_view *view)
{
    stp_draw_stats stats = {0};
    int frames = 0;
    memcpy(r->before, r->now, sizeof r->now);
    for (; !stats.cut_complete; frames++)
        check_ok(stp_renderer_draw(r->fixture.renderer, view, &r->params, &stats, err));
    check_ok(stp_renderer_read(r->fixture.renderer, r->now, err));
    return frames;
}

static int change_of(const rider *r, size_t pixel)
{
    int greatest = 0;
    for (size_t c = 0; c < 3; c++) {
        int change = abs(r->now[4 * pixel + c] - r->before[4 * pixel + c]);
        greatest = change > greatest ? change : greatest;
    }
    return greatest;
}

/* Whether the pixel is covered now and in the last frame. */
static bool stays(const rider *r, size_t pixel)
{
    return r->now[4 * pixel + 3] != 0 && r->before[4 * pixel + 3] != 0;
}

static void open_rider(rider *r, stp_draw_params params)
{
    gl_fixture_open(&r->fixture, "fade.stipple", NULL);
    r->params = params;
}

static void dolly(void **state)
{
    (void)state;
    static rider levels, riders[3]; /* every sample; threshold; threshold, faded */
    double change[3] = {0.0};
    size_t pixels = 0;
    open_rider(&levels, (stp_draw_params){.threshold_px = COARSE,
                                          .radius_cap_px = cap_px,
                                          .stream = true,
                                          .shade = STP_SHADE_LEVEL});
    open_rider(&riders[0], (stp_draw_params){.lod = STP_LOD_FULL});
    open_rider(&riders[1],
               (stp_draw_params){.threshold_px = COARSE, .radius_cap_px = cap_px, .stream = true});
    open_rider(&riders[2],
               (stp_draw_params){
                   .threshold_px = COARSE, .radius_cap_px = cap_px, .stream = true, .fade = kept});
    /* The first flight reads the blocks. The second one is measured: each view takes one frame, for
     * a difference fades by frames. */
    for (int i = 0; i < 2 * FRAMES; i++) {
        stp_view view = view_at(&levels.fixture.model->ball, i % FRAMES);
        int frames = draw(&levels, &view);
        for (int k = 0; k < 3; k++)
            frames += draw(&riders[k], &view);
        assert_true(i < FRAMES || frames == 4);
        for (size_t p = 0; i > FRAMES && p < PIXELS; p++) {
            if (change_of(&levels, p) < LEVEL_CHANGE || !stays(&riders[0], p) ||
                !stays(&riders[1], p))
                continue;
            pixels++;
            for (int k = 0; k < 3; k++)
                change[k] += change_of(&riders[k], p);
        }
    }
    double n = (double)pixels;
    printf("%zu level changes: every sample %.2f, threshold %.2f, faded %.2f of 255\n", pixels,
           change[0] / n, change[1] / n, change[2] / n);
    assert_true(pixels > 10000);
    /* Every sample changes too, since the camera moves. What levels add to that must fade. */
    assert_true(change[2] - change[0] < 0.75 * (change[1] - change[0]));
    gl_fixture_close(&levels.fixture);
    for (int k = 0; k < 3; k++)
        gl_fixture_close(&riders[k].fixture);
}

static void rest(void **state)
{
    (void)state;
    static rider plain, fades;
    stp_draw_stats stats = {.fading = true};
    int frames = 0;
    open_rider(&plain, (stp_draw_params){.threshold_px = COARSE, .radius_cap_px = cap_px});
    open_rider(&fades,
               (stp_draw_params){
                   .threshold_px = COARSE, .radius_cap_px = cap_px, .stream = true, .fade = kept});
    for (int i = 0; i < FRAMES; i += 4) {
        stp_view view = view_at(&plain.fixture.model->ball, i);
        draw(&fades, &view);
    }
    stp_view view = view_at(&plain.fixture.model->ball, FRAMES - 4);
    draw(&plain, &view);
    assert_memory_not_equal(plain.now, fades.now, sizeof plain.now);
    while (stats.fading) {
        check_ok(stp_renderer_draw(fades.fixture.renderer, &view, &fades.params, &stats, err));
        /* A block that was asked for ahead may still come; fading begins anew then. */
        frames = stats.chunks_loading > 0 ? 0 : frames + 1;
        assert_true(frames < 40);
    }
    check_ok(stp_renderer_read(fades.fixture.renderer, fades.now, err));
    assert_memory_equal(plain.now, fades.now, sizeof plain.now);
    assert_true(frames > 4);
    gl_fixture_close(&plain.fixture);
    gl_fixture_close(&fades.fixture);
}

/* If every sample is drawn, no level ever changes, so fading has no effect. */
static void same_level(void **state)
{
    (void)state;
    static rider plain, fades;
    open_rider(&plain, (stp_draw_params){.lod = STP_LOD_FULL});
    open_rider(&fades, (stp_draw_params){.lod = STP_LOD_FULL, .stream = true, .fade = kept});
    stp_view view = view_at(&plain.fixture.model->ball, 0);
    draw(&fades, &view);
    for (int i = 0; i < 30; i++) /* arriving chunks fade in */
        draw(&fades, &view);
    for (int i = 1; i < 6; i++) {
        view = view_at(&plain.fixture.model->ball, i);
        draw(&plain, &view);
        draw(&fades, &view);
        assert_memory_equal(plain.now, fades.now, sizeof plain.now);
    }
    gl_fixture_close(&plain.fixture);
    gl_fixture_close(&fades.fixture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(dolly),
        cmocka_unit_test(rest),
        cmocka_unit_test(same_level),
    };
    stp_gl_context *context = gl_fixture_context();
    model_fixture_build(
        "fade.stipple",
        &(model_recipe){.shape = GEN_BUMPY, .point_count = 300000, .noise_spacings = 0.3});
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stp_gl_context_destroy(&context);
    return failed;
}

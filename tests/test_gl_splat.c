/* Splats drawn in several passes, for want of memory, are those drawn at once: all fronts are found
 * before any splat is added. Waiting and streaming, to within a step of 8 bits, since floats are
 * added in another order. */
#include "tests/gl_fixture.h"
#include "tests/model_fixture.h"
#include "tests/scan_fixture.h"
#include "tests/support/views.h"

enum { SIZE = 200, VIEWS = 6, FRAMES_LIMIT = 2000 };

#define LITTLE_BYTES (UINT64_C(7) << 20)

static uint8_t expected[4 * SIZE * SIZE], found[4 * SIZE * SIZE];

static void check_same(stp_renderer *renderer, const char *how, int view)
{
    size_t covered = 0;
    check_ok(stp_renderer_read(renderer, found, err));
    for (size_t i = 0; i < sizeof found; i++) {
        covered += i % 4 == 3 && expected[i] > 0;
        if (abs(found[i] - expected[i]) > 1)
            fail_msg("%s, view %d: component %zu is %d, at once %d", how, view, i, found[i],
                     expected[i]);
    }
    assert_true(covered > SIZE * SIZE / 20);
}

static void passes_are_the_whole(void **state)
{
    (void)state;
    gl_fixture roomy;
    stp_renderer *little = NULL;
    unsigned in_passes = 0;
    model_fixture_build("splat.stipple",
                        &(model_recipe){.shape = GEN_STATUE, .point_count = 300000});
    gl_fixture_open(&roomy, "splat.stipple", NULL);
    check_ok(stp_renderer_create(
        &little, &(stp_renderer_params){.model = roomy.model, .gpu_memory_bytes = LITTLE_BYTES},
        err));
    for (int i = 0; i < VIEWS; i++) {
        stp_draw_stats stats = {0};
        stp_view view = views_get(4 * i, &roomy.model->ball, NULL, 0, SIZE, SIZE);
        stp_draw_params params = {
            .reconstruct = STP_RECONSTRUCT_SPLAT, .lod = (stp_lod)(i % 3), .threshold_px = 0.2};
        check_ok(stp_renderer_draw(roomy.renderer, &view, &params, &stats, err));
        assert_int_equal(stats.passes, 1);
        check_ok(stp_renderer_read(roomy.renderer, expected, err));
        check_ok(stp_renderer_draw(little, &view, &params, &stats, err));
        in_passes += stats.passes > 1;
        check_same(little, "waiting", i);
        params.stream = true;
        stats.cut_complete = false;
        for (int frame = 0; !stats.cut_complete; frame++) {
            assert_true(frame < FRAMES_LIMIT);
            check_ok(stp_renderer_draw(little, &view, &params, &stats, err));
            usleep(1000);
        }
        check_same(little, "streaming", i);
    }
    assert_true(in_passes > 0);
    stp_renderer_destroy(&little);
    gl_fixture_close(&roomy);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {cmocka_unit_test(passes_are_the_whole)};
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

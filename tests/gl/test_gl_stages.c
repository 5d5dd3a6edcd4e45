/* Tests the times of a frame's stages: a timed frame names the stages that it has and no others,
 * and they take no longer than the frame. An untimed frame names none. Both draw the same picture.
 */
#include "runtime/draw/road.h"
#include "tests/fixtures/gl_model.h"
#include "tests/support/views.h"

#include <string.h>

enum { SIZE = 160, BYTES = 4 * SIZE * SIZE };
enum {
    CHOOSE = 1 << STP_STAGE_CHOOSE,
    PROJECT = 1 << STP_STAGE_PROJECT,
    RESOLVE = 1 << STP_STAGE_RESOLVE,
    BLEND = 1 << STP_STAGE_BLEND,
    PULL = 1 << STP_STAGE_PULL,
    PUSH = 1 << STP_STAGE_PUSH,
    FINISH = 1 << STP_STAGE_FINISH,
    EFFECTS = 1 << STP_STAGE_EFFECTS,
    ALWAYS = PROJECT | RESOLVE | FINISH
};

/* The GPU's clock differs from the CPU's; this difference is allowed. */
#define CLOCK_SLACK 0.02
#define CLOCK_SLACK_MS 0.1

static const struct {
    stp_draw_params params;
    int stages;
} frames[] = {
    {{.lod = STP_LOD_FULL}, ALWAYS | CHOOSE | PULL | PUSH},
    {{.lod = STP_LOD_CPU}, ALWAYS | PULL | PUSH},
    {{.lod = STP_LOD_GEOMETRY}, ALWAYS | PULL | PUSH},
    {{.lod = STP_LOD_COMPUTE}, ALWAYS | CHOOSE | PULL | PUSH},
    {{.lod = STP_LOD_COMPUTE, .edl = 1.0}, ALWAYS | CHOOSE | PULL | PUSH | EFFECTS},
    {{.lod = STP_LOD_GEOMETRY, .smooth_edges = true}, ALWAYS | PULL | PUSH | EFFECTS},
    {{.lod = STP_LOD_GEOMETRY, .keep_pixels = true}, ALWAYS | PULL | PUSH | EFFECTS},
    {{.lod = STP_LOD_COMPUTE, .reconstruct = STP_RECONSTRUCT_SPLAT}, ALWAYS | CHOOSE | BLEND},
    {{.lod = STP_LOD_FULL, .reconstruct = STP_RECONSTRUCT_SPLAT}, ALWAYS | CHOOSE | BLEND},
    {{.lod = STP_LOD_CPU, .reconstruct = STP_RECONSTRUCT_POINTS}, ALWAYS},
};

static int open_model(void **state)
{
    return gl_model_enter(state, &(model_recipe){.shape = GEN_BUMPY, .point_count = 3000});
}

static void draw(gl_fixture *f, const stp_view *view, stp_draw_params params, bool timed,
                 stp_draw_stats *stats, uint8_t *rgba)
{
    params.timed = timed;
    gl_fixture_draw(f, view, &params, stats, rgba);
}

static void stages_are_those_of_the_frame(void **state)
{
    gl_fixture *f = *state;
    static uint8_t timed[BYTES], plain[BYTES];
    stp_view view = views_get(3, &f->model->ball, NULL, 0, SIZE, SIZE);
    for (size_t i = 0; i < sizeof frames / sizeof *frames; i++) {
        stp_draw_stats stats;
        double all = 0.0;
        int expected = frames[i].stages;
        if (frames[i].params.lod == STP_LOD_FULL && !stp_road_is_software())
            expected &= ~CHOOSE; /* only a software driver draws all samples by compute shaders */
        draw(f, &view, frames[i].params, false, &stats, plain);
        for (int k = 0; k < STP_STAGE_COUNT; k++)
            assert_true(stats.gpu_ms[k] == 0.0);
        draw(f, &view, frames[i].params, true, &stats, timed);
        assert_memory_equal(timed, plain, sizeof timed);
        for (int k = 0; k < STP_STAGE_COUNT; k++) {
            bool there = (expected >> k & 1) != 0;
            if (there != (stats.gpu_ms[k] > 0.0))
                fail_msg("frame %zu, %s: %g ms", i, stp_stage_name((stp_stage)k), stats.gpu_ms[k]);
            all += stats.gpu_ms[k];
        }
        assert_true(all <= stats.frame_ms * (1.0 + CLOCK_SLACK) + CLOCK_SLACK_MS);
    }
}

static void names_are_words(void **state)
{
    (void)state;
    for (int i = 0; i < STP_STAGE_COUNT; i++) {
        const char *name = stp_stage_name((stp_stage)i);
        assert_true(strlen(name) > 0 && strspn(name, "abcdefghijklmnopqrstuvwxyz") == strlen(name));
        for (int k = 0; k < i; k++)
            assert_string_not_equal(name, stp_stage_name((stp_stage)k));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stages_are_those_of_the_frame),
        cmocka_unit_test(names_are_words),
    };
    stp_gl_context *context = gl_fixture_context();
    int failed = cmocka_run_group_tests(tests, open_model, gl_model_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

/* Tests that the geometry shader and the CPU choose the same level of each quarter of every patch:
 * in 26 directions and ten close views, at five thresholds, with all terms of the rule, and with a
 * near and a far cap on radii in turn. If they differ, a threshold, cap or cone that is 1e-5 off
 * must explain it; such ties are counted. */
#include "tests/fixtures/gl_levels.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/fixtures/size.h"
#include "tests/support/views.h"

#define TIE 1e-5f

enum {
    COUNT = TEST_SIZE(200000, 50000),
    SIZE = TEST_SIZE(512, 256) /* same samples per pixel with either */
};

typedef struct choices {
    size_t patches, skipped, mixed, ties, levels[STP_LEVEL_COUNT]; /* levels: by quarter */
    size_t asked, quarters; /* patches that ask for level 2, and those of which the brief tells */
} choices;

/* A sine that may round to 1 or not. */
#define SINE_TIE 0.9999995f

/* Whether the CPU chooses the GPU's level if a threshold, the cap or the cone of normals is
 * slightly different. The cone decides whether an outline may be there: near 90 degrees a sine
 * hardly changes with its angle, so there both answers are right. sine: sin(alpha) by the CPU. */
static bool is_tie(const stp_inspection *look, const stp_gpu_chunk *chunk,
                   const stp_mirror_patch *patch, float sine, int quarter, int gpu)
{
    for (int k = 0; k < (sine >= SINE_TIE ? 8 : 6); k++) {
        const float factor = 1.0f + (k % 2 == 0 ? TIE : -TIE);
        stp_gpu_frame frame = *look->frame;
        stp_mirror_patch near = *patch;
        for (int i = 0; i < 2 && k < 2; i++)
            frame.quality[i] *= factor;
        if (k == 2 || k == 3)
            near.cone_cos *= factor;
        for (int i = 0; i < 3 && (k == 4 || k == 5); i++) /* near the ray the sine has few digits */
            near.cone_axis[i] *= factor;
        if (k == 6)
            frame.terms[1] = 1.0f; /* no outline */
        if (k == 7)
            near.cone_cos = -1.0f; /* an outline */
        if (stp_levels_choose(&frame, chunk, &near).of[quarter] == gpu)
            return true;
    }
    return false;
}

/* Patches looked at side by side say, to the last bit, what each says alone. */
static void check_side_by_side(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                               const stp_resident *resident, choices *told)
{
    const uint32_t patches = resident->placement.patches.count;
    for (uint32_t first = 0; first < patches; first += STP_LOOKS_LIMIT) {
        const uint32_t count =
            patches - first < STP_LOOKS_LIMIT ? patches - first : STP_LOOKS_LIMIT;
        stp_looks looks;
        stp_patches_look(&looks, frame, frame, chunk, &resident->mirror.briefs[first], count);
        for (uint32_t i = 0; i < count; i++) {
            const stp_mirror_patch *patch = &resident->mirror.patches[first + i];
            const stp_patch_brief *brief = &resident->mirror.briefs[first + i];
            const stp_rule_bound bound = stp_patch_bound(brief, chunk);
            const stp_rule_sight alone = stp_rule_look(frame, &bound);
            const stp_rule_sight beside = stp_looks_sight(&looks, frame, i);
            float eye[3];
            assert_memory_equal(&alone, &beside, sizeof alone);
            assert_int_equal(looks.visible[i], stp_rule_visible(frame, &bound, eye));
            assert_int_equal(brief->has_spots, patch->spots != 0);
            assert_int_equal(brief->finest, patch->finest);
            const int asked = stp_level_asked(frame, chunk, patch, 0);
            assert_true(!looks.quarters[i] || asked >= 2);
            told->asked += asked == 2;
            told->quarters += asked == 2 && looks.quarters[i];
            for (int l = 0; l < STP_LEVEL_COUNT; l++)
                assert_true(!brief->vertex_greatest || patch->radius[l] <= brief->vertex_radius);
            assert_int_equal(looks.vertex[i], asked == STP_LEVEL_COUNT - 1);
            for (int k = 0; k < 3 && looks.visible[i]; k++)
                assert_true(looks.eye[k][i] == eye[k]);
            if (looks.visible[i]) {
                const stp_window_disc disc =
                    stp_ball_window_disc(frame, eye, bound.radius * stp_frame_stretch(frame));
                const stp_window_disc found = {{looks.window[0][i], looks.window[1][i]},
                                               looks.reach_px[i]};
                assert_memory_equal(&found, &disc, sizeof disc);
            }
        }
    }
}

static void compare_block(const gl_levels *levels, size_t draw, int view, choices *sum)
{
    stp_gpu_chunk chunk;
    const stp_resident *resident = gl_fixture_resident(&levels->fixture, draw, &chunk);
    stp_inspection look = stp_renderer_inspect(levels->fixture.renderer);
    uint32_t count = look.looked.scene->blocks[resident->block].patch_count;
    check_side_by_side(look.frame, &chunk, resident, sum);
    for (uint32_t p = 0; p < count; p++) {
        const stp_mirror_patch *patch = &resident->mirror.patches[p];
        stp_levels gpu = gl_levels_drawn(levels, resident, p);
        stp_levels cpu;
        memset(&cpu, STP_LEVEL_SKIP, sizeof cpu);
        sum->patches++;
        if (stp_patch_in_sight(look.sight, &look.looked, &look.cut->draws[draw],
                               resident->mirror.briefs, p))
            cpu = stp_levels_choose(look.frame, &chunk, patch);
        else
            sum->skipped++;
        bool mixed = false;
        for (int q = 0; q < STP_PATCH_QUARTERS; q++) {
            if (cpu.of[q] != STP_LEVEL_SKIP)
                sum->levels[cpu.of[q]]++;
            mixed |= cpu.of[q] != STP_LEVEL_SKIP && cpu.of[q] != cpu.of[0];
            if (gpu.of[q] == cpu.of[q])
                continue;
            const stp_rule_bound bound = stp_patch_bound(&resident->mirror.briefs[p], &chunk);
            const float sine = stp_rule_look(look.frame, &bound).sin_alpha;
            /* if one of them drew the patch vertex, the other quarters say nothing more */
            if (!is_tie(&look, &chunk, patch, sine, q, gpu.of[q]) &&
                !(gpu.of[0] != cpu.of[0] && (gpu.of[0] == 3 || cpu.of[0] == 3)))
                fail_msg("view %d, threshold %g: block %u patch %u quarter %d is drawn at level "
                         "%d, the CPU says %d (%.9g px; sine %.9g)",
                         view, (double)look.frame->quality[0], resident->block, p, q, gpu.of[q],
                         cpu.of[q],
                         (double)stp_level_error_px(look.frame, &chunk, patch, gpu.of[q], q),
                         (double)sine);
            sum->ties++;
        }
        sum->mixed += mixed;
    }
}

static void judge_model(const char *name, const model_recipe *recipe, bool orthographic)
{
    static const double thresholds[] = {0.5, 1.0, 2.0, 4.0, 8.0};
    gl_levels levels = {0};
    promise_disc *leaves = NULL;
    size_t leaf_count = 0;
    choices sum = {0};
    model_fixture_build("level.stipple", recipe);
    gl_levels_open(&levels, "level.stipple");
    const stp_model *model = levels.fixture.model;
    check_ok(promise_load_leaves(model->file, &leaves, &leaf_count, err));
    for (int v = 0; v < VIEWS_COUNT; v++) {
        stp_view view = views_get(v, &model->ball, leaves, leaf_count, SIZE, SIZE);
        view.orthographic = orthographic;
        if (orthographic)
            view.f = (v % 3 + 1) * 0.4 * SIZE / model->ball.radius;
        for (size_t t = 0; t < sizeof thresholds / sizeof *thresholds; t++) {
            stp_draw_params params = {.threshold_px = thresholds[t],
                                      /* 1000: large enough that level 3 occurs too */
                                      .radius_cap_px = v % 2 == 0 ? 1000.0 : 3.0,
                                      .terms =
                                          STP_TERM_RADIUS | STP_TERM_COLOUR | STP_TERM_SILHOUETTE,
                                      .reconstruct = STP_RECONSTRUCT_POINTS};
            gl_levels_draw(&levels, &view, &params);
            stp_inspection look = stp_renderer_inspect(levels.fixture.renderer);
            for (size_t i = 0; i < look.cut->draw_count; i++)
                compare_block(&levels, i, v, &sum);
        }
    }
    print_message("%s: %zu patches (%zu skipped, %zu of several levels); %zu, %zu, %zu quarters of "
                  "levels 0 to 2 and %zu of level 3; %zu ties; %zu of %zu by briefs\n",
                  name, sum.patches, sum.skipped, sum.mixed, sum.levels[0], sum.levels[1],
                  sum.levels[2], sum.levels[3], sum.ties, sum.quarters, sum.asked);
    for (int level = 0; level < STP_LEVEL_COUNT; level++)
        assert_true(sum.levels[level] > 100);
    assert_true(sum.mixed > 100);
    assert_true(sum.quarters > 0.9 * (double)sum.asked);
    assert_true(sum.skipped > 100);
    free(leaves);
    gl_levels_close(&levels);
}

static void bumpy(void **state)
{
    (void)state;
    judge_model("bumpy",
                &(model_recipe){.shape = GEN_BUMPY, .point_count = COUNT, .noise_spacings = 0.1},
                false);
}

static void statue_orthographic(void **state)
{
    (void)state;
    judge_model("statue, orthographic", &(model_recipe){.shape = GEN_STATUE, .point_count = COUNT},
                true);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bumpy),
        cmocka_unit_test(statue_orthographic),
    };
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

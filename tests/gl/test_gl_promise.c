/* Tests the error promise with the real renderer. The test notes which level of each patch the
 * geometry shader drew, in 36 views at 1, 2 and 4 pixels. The centre and rim points of every drawn
 * disc, and the points nearest to them on all level-0 discs, must project within the threshold of
 * each other.
 *
 * The test judges every other drawn disc; with the argument --every, as in long_gl_promise,
 * all of them. */
#include "tests/fixtures/gl_levels.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/fixtures/size.h"
#include "tests/support/promise.h"
#include "tests/support/views.h"

enum {
    COUNT = TEST_SIZE(200000, 50000),
    SIZE = TEST_SIZE(512, 256), /* same samples per pixel with either */
    THRESHOLDS = 3,
    SHOTS = VIEWS_COUNT * THRESHOLDS
};
static const double thresholds[THRESHOLDS] = {1.0, 2.0, 4.0};

typedef struct judged_model {
    gl_levels levels;
    promise_disc *leaves;
    size_t leaf_count;
    promise_index *index;
    stp_view views[VIEWS_COUNT];
    size_t *first_patch;        /* by chunk, chunk_count + 1 */
    stp_levels (*drawn)[SHOTS]; /* by patch */
    promise_tally tallies[THRESHOLDS];
    size_t coarse; /* drawn discs other than a leaf's level 0 */
} judged_model;

static unsigned part = 2; /* judges one of so many discs */

static void note_shot(judged_model *m, int view, int threshold)
{
    stp_draw_params params = {.threshold_px = thresholds[threshold],
                              .reconstruct = STP_RECONSTRUCT_POINTS};
    gl_levels_draw(&m->levels, &m->views[view], &params);
    stp_inspection look = stp_renderer_inspect(m->levels.fixture.renderer);
    for (size_t i = 0; i < look.cut->draw_count; i++) {
        stp_gpu_chunk chunk;
        const stp_resident *resident = gl_fixture_resident(&m->levels.fixture, i, &chunk);
        const stp_block *block = &look.looked.scene->blocks[resident->block];
        size_t first = m->first_patch[chunk.id] + block->first_patch;
        for (uint32_t p = 0; p < block->patch_count; p++)
            m->drawn[first + p][view * THRESHOLDS + threshold] =
                gl_levels_drawn(&m->levels, resident, p);
    }
}

static void judge_level(judged_model *m, const stp_chunk_entry *entry, const stp_chunk *chunk,
                        uint32_t patch, int level, unsigned quarter)
{
    const stp_levels *drawn = m->drawn[m->first_patch[chunk->id] + patch];
    const uint8_t *counts = chunk->patches[patch].counts;
    const stp_sample *samples = chunk->samples[level] + chunk->level_begin[level][patch];
    bool any = false;
    for (int s = 0; s < SHOTS; s++)
        any |= drawn[s].of[quarter] == level;
    unsigned end = !any ? 0 : stp_quarter_begin(counts, level, quarter + 1);
    for (unsigned i = stp_quarter_begin(counts, level, quarter); i < end; i++) {
        if ((i + patch) % part != 0)
            continue;
        promise_disc disc = promise_disc_from_sample(entry, &chunk->patches[patch], &samples[i]);
        promise_pairs pairs;
        promise_trace(m->index, &disc, entry->origin, &pairs);
        for (int s = 0; s < SHOTS; s++) {
            promise_tally *tally = &m->tallies[s % THRESHOLDS];
            size_t before = tally->broken;
            if (drawn[s].of[quarter] != level)
                continue;
            m->coarse += level > 0 || entry->child_count > 0;
            promise_add(tally, &pairs, &m->views[s / THRESHOLDS], thresholds[s % THRESHOLDS]);
            if (tally->broken > before && tally->broken < 20)
                print_message("view %d, threshold %g: chunk %u patch %u level %d breaks it\n",
                              s / THRESHOLDS, thresholds[s % THRESHOLDS], chunk->id, patch, level);
        }
    }
}

static void judge_discs(judged_model *m)
{
    const stp_model *model = m->levels.fixture.model;
    for (uint32_t id = 0; id < model->info->chunk_count; id++) {
        stp_chunk *chunk = NULL;
        check_ok(stp_chunk_file_read(model->file, id, 0, &chunk, err));
        for (uint32_t p = 0; p < chunk->patch_count; p++)
            for (int level = 0; level < STP_LEVEL_COUNT; level++)
                for (unsigned q = 0; q < chunk->patches[p].counts[2]; q++)
                    judge_level(m, &model->entries[id], chunk, p, level, q);
        stp_chunk_destroy(&chunk);
    }
}

static void prepare(judged_model *m, const char *path)
{
    gl_levels_open(&m->levels, path);
    const stp_model *model = m->levels.fixture.model;
    check_ok(promise_load_leaves(model->file, &m->leaves, &m->leaf_count, err));
    check_ok(promise_index_create(&m->index, m->leaves, m->leaf_count, err));
    m->first_patch = calloc(model->info->chunk_count + 1, sizeof *m->first_patch);
    assert_non_null(m->first_patch);
    for (uint32_t id = 0; id < model->info->chunk_count; id++)
        m->first_patch[id + 1] = m->first_patch[id] + model->entries[id].patch_count;
    size_t patches = m->first_patch[model->info->chunk_count];
    m->drawn = malloc(patches * sizeof *m->drawn);
    assert_non_null(m->drawn);
    memset(m->drawn, STP_LEVEL_SKIP, patches * sizeof *m->drawn);
    for (int v = 0; v < VIEWS_COUNT; v++)
        m->views[v] = views_get(v, &model->ball, m->leaves, m->leaf_count, SIZE, SIZE);
}

static void judge_model(const char *name, const model_recipe *recipe)
{
    judged_model m = {0};
    model_fixture_build("promise.stipple", recipe);
    prepare(&m, "promise.stipple");
    for (int v = 0; v < VIEWS_COUNT; v++)
        for (int t = 0; t < THRESHOLDS; t++)
            note_shot(&m, v, t);
    judge_discs(&m);
    size_t broken = 0;
    for (int t = 0; t < THRESHOLDS; t++) {
        const promise_tally *tally = &m.tallies[t];
        print_message("%s, %g px: %zu discs drawn, %zu points, %zu broken, greatest %.4f px, 99.9 "
                      "%% below %.3f px\n",
                      name, thresholds[t], tally->discs, tally->points, tally->broken,
                      tally->max_px, thresholds[t] * promise_quantile(tally, 0.999));
        assert_true(tally->points > 100000);
        broken += tally->broken;
    }
    assert_true(m.coarse > 10000);
    assert_int_equal(broken, 0);
    promise_index_destroy(&m.index);
    free(m.leaves);
    free(m.first_patch);
    free(m.drawn);
    gl_levels_close(&m.levels);
}

static void bumpy(void **state)
{
    (void)state;
    judge_model("bumpy",
                &(model_recipe){.shape = GEN_BUMPY, .point_count = COUNT, .noise_spacings = 0.1});
}

static void statue(void **state)
{
    (void)state;
    judge_model("statue", &(model_recipe){.shape = GEN_STATUE, .point_count = COUNT / 2});
}

static void terrain(void **state)
{
    (void)state;
    judge_model("terrain", &(model_recipe){.shape = GEN_TERRAIN, .point_count = COUNT / 2});
}

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "--every") == 0)
        part = 1;
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bumpy),
        cmocka_unit_test(statue),
        cmocka_unit_test(terrain),
    };
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

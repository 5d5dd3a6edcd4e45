/* Tests the error promise of a prepared model, by the rule alone. If level_rule.glsl accepts a
 * level of a patch, take the centre and rim points of its discs and the points nearest to them on
 * the level-0 discs: each pair must project within the threshold of each other. */
#include "runtime/cut/level_rule.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/support/promise.h"
#include "tests/support/views.h"

enum { THRESHOLDS = 3 };
static const double thresholds[THRESHOLDS] = {1.0, 2.0, 4.0};

typedef struct judged_model {
    stp_chunk_file *file;
    stp_ball ball;
    promise_disc *leaves;
    size_t leaf_count;
    promise_index *index;
    stp_view views[VIEWS_COUNT];
    promise_tally tallies[VIEWS_COUNT][THRESHOLDS];
    promise_tally careless; /* every patch vertex, without the rule; view 0, 1 pixel */
} judged_model;

/* The coarsest level that the rule accepts for a quarter, or STP_LEVEL_COUNT. Level 3, the patch
 * vertex, is returned for quarter 0 only. */
static int coarsest(const stp_chunk_entry *entry, const stp_patch *patch, unsigned quarter,
                    const stp_view *view, double threshold)
{
    stp_dvec3 local = {ldexp((double)patch->origin[0] + patch->bound_centre[0], patch->exponent),
                       ldexp((double)patch->origin[1] + patch->bound_centre[1], patch->exponent),
                       ldexp((double)patch->origin[2] + patch->bound_centre[2], patch->exponent)};
    stp_dvec3 centre = stp_dvec3_sub(stp_dvec3_add(entry->origin, local), view->eye);
    double radius = stp_radius_decode(patch->bound_radius, patch->exponent);
    double range = stp_dvec3_length(centre);
    stp_dvec3 axis = stp_dvec3_from_float(stp_normal_decode(patch->cone_axis));
    double cone = stp_cone_angle_decode(patch->cone_angle);
    float scale =
        stp_rule_scale((float)-stp_dvec3_dot(view->back, centre), (float)range, (float)radius,
                       (float)view->f, (float)view->near_depth, view->orthographic);
    if (scale < 0.0f)
        return STP_LEVEL_COUNT;
    float sin_alpha =
        stp_rule_sin_alpha((float)(stp_dvec3_dot(centre, axis) / range),
                           (float)cos(fmin(cone, M_PI)), (float)fmin(1.0, radius / range));
    int finest = entry->child_count > 0 ? 0 : 1; /* level 0 of a leaf is the original itself */
    for (int level = STP_LEVEL_COUNT - 1; level >= finest; level--) {
        double error = stp_error_decode(stp_quarter_error(patch, level, quarter), patch->exponent);
        double tangential =
            stp_error_decode(stp_quarter_tangential_error(patch, level, quarter), patch->exponent);
        if (stp_rule_error(scale, sin_alpha, (float)error, (float)tangential) <= (float)threshold)
            return level < 3 || quarter == 0 ? level : STP_LEVEL_COUNT;
    }
    return STP_LEVEL_COUNT;
}

/* Prints where the promise is broken, for the first few places. */
static void explain(const judged_model *m, const promise_pairs *pairs, int view, double threshold,
                    uint32_t chunk, uint32_t patch, int level)
{
    static int said;
    for (int i = 0; i < PROMISE_POINTS; i++) {
        double px = promise_displacement_px(&m->views[view], pairs->drawn[i], pairs->nearest[i]);
        if (px <= threshold || said >= 8)
            continue;
        said++;
        print_message("view %d, threshold %g: chunk %u patch %u level %d point %d is %.4f px off\n",
                      view, threshold, chunk, patch, level, i, px);
    }
}

static void judge_level(judged_model *m, const stp_chunk_entry *entry, const stp_chunk *chunk,
                        uint32_t patch, int level, unsigned quarter,
                        uint8_t chosen[VIEWS_COUNT][THRESHOLDS])
{
    const uint8_t *counts = chunk->patches[patch].counts;
    const stp_sample *samples = chunk->samples[level] + chunk->level_begin[level][patch];
    unsigned end = stp_quarter_begin(counts, level, quarter + 1);
    for (unsigned i = stp_quarter_begin(counts, level, quarter); i < end; i++) {
        promise_disc disc = promise_disc_from_sample(entry, &chunk->patches[patch], &samples[i]);
        promise_pairs pairs;
        promise_trace(m->index, &disc, m->ball.centre, &pairs);
        if (level == STP_LEVEL_COUNT - 1)
            promise_add(&m->careless, &pairs, &m->views[0], 1.0);
        for (int v = 0; v < VIEWS_COUNT; v++)
            for (int t = 0; t < THRESHOLDS; t++) {
                if (chosen[v][t] != level)
                    continue;
                size_t before = m->tallies[v][t].broken;
                promise_add(&m->tallies[v][t], &pairs, &m->views[v], thresholds[t]);
                if (m->tallies[v][t].broken > before)
                    explain(m, &pairs, v, thresholds[t], chunk->id, patch, level);
            }
    }
}

static void judge_quarter(judged_model *m, const stp_chunk_entry *entry, const stp_chunk *chunk,
                          uint32_t patch, unsigned quarter)
{
    uint8_t chosen[VIEWS_COUNT][THRESHOLDS];
    unsigned any = quarter == 0 ? 1u << 3 : 0;
    for (int v = 0; v < VIEWS_COUNT; v++)
        for (int t = 0; t < THRESHOLDS; t++) {
            chosen[v][t] = (uint8_t)coarsest(entry, &chunk->patches[patch], quarter, &m->views[v],
                                             thresholds[t]);
            any |= 1u << chosen[v][t];
        }
    for (int level = 0; level < STP_LEVEL_COUNT; level++)
        if (any & 1u << level)
            judge_level(m, entry, chunk, patch, level, quarter, chosen);
}

static void judge_chunk(judged_model *m, uint32_t id)
{
    stp_chunk_entry entry;
    stp_chunk *chunk = NULL;
    check_ok(stp_chunk_file_entry(m->file, id, &entry, err));
    check_ok(stp_chunk_file_read(m->file, id, 0, &chunk, err));
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (unsigned q = 0; q < chunk->patches[p].counts[2]; q++)
            judge_quarter(m, &entry, chunk, p, q);
    stp_chunk_destroy(&chunk);
}

/* Judges all patches of all chunks, in any cut or none. */
static void judge_model(const char *path, const char *name)
{
    static judged_model m;
    m = (judged_model){0};
    check_ok(stp_chunk_file_open(&m.file, path, err));
    const stp_chunk_file_info *info = stp_chunk_file_get_info(m.file);
    stp_dvec3 size = stp_dvec3_sub(info->box.max, info->box.min);
    m.ball = (stp_ball){stp_dvec3_scale(stp_dvec3_add(info->box.min, info->box.max), 0.5),
                        0.5 * stp_dvec3_length(size)};
    check_ok(promise_load_leaves(m.file, &m.leaves, &m.leaf_count, err));
    assert_int_equal(m.leaf_count, info->point_count);
    check_ok(promise_index_create(&m.index, m.leaves, m.leaf_count, err));
    for (int v = 0; v < VIEWS_COUNT; v++)
        m.views[v] = views_get(v, &m.ball, m.leaves, m.leaf_count, 512, 512);
    for (uint32_t id = 0; id < info->chunk_count; id++)
        judge_chunk(&m, id);
    size_t broken = 0;
    for (int t = 0; t < THRESHOLDS; t++) {
        promise_tally sum = {0};
        for (int v = 0; v < VIEWS_COUNT; v++) {
            const promise_tally *tally = &m.tallies[v][t];
            sum.points += tally->points;
            sum.broken += tally->broken;
            sum.max_px = fmax(sum.max_px, tally->max_px);
            for (size_t k = 0; k < sizeof sum.histogram / sizeof *sum.histogram; k++)
                sum.histogram[k] += tally->histogram[k];
        }
        print_message("%s, %g px: %zu points, %zu broken, greatest %.4f px, half below %.3f px, "
                      "99.9 %% below %.3f px\n",
                      name, thresholds[t], sum.points, sum.broken, sum.max_px,
                      thresholds[t] * promise_quantile(&sum, 0.5),
                      thresholds[t] * promise_quantile(&sum, 0.999));
        assert_true(sum.points > 1000);
        broken += sum.broken;
    }
    assert_int_equal(broken, 0);
    assert_true(m.careless.broken > 0); /* otherwise the test could not see a broken promise */
    promise_index_destroy(&m.index);
    free(m.leaves);
    stp_chunk_file_close(&m.file);
}

static void bumpy_with_noise(void **state)
{
    (void)state;
    model_fixture_build(
        "bumpy.stipple",
        &(model_recipe){.shape = GEN_BUMPY, .point_count = 100000, .noise_spacings = 0.1});
    judge_model("bumpy.stipple", "bumpy");
}

static void statue(void **state)
{
    (void)state;
    model_fixture_build("statue.stipple",
                        &(model_recipe){.shape = GEN_STATUE, .point_count = 60000});
    judge_model("statue.stipple", "statue");
}

/* Two surfaces one spacing apart: nothing may be drawn between them. */
static void sheet(void **state)
{
    (void)state;
    model_fixture_build(
        "sheet.stipple",
        &(model_recipe){.shape = GEN_SHEET, .point_count = 30000, .true_normals = true});
    judge_model("sheet.stipple", "sheet");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bumpy_with_noise),
        cmocka_unit_test(statue),
        cmocka_unit_test(sheet),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

/* Tests that of each block only the levels are on the GPU that its patches ask for, and that no
 * picture shows it: a renderer that moves draws the bytes of one that has whole blocks, and no
 * patch in sight lacks a level. */
#include "base/random.h"
#include "runtime/stream/cache/patch_levels.h"
#include "tests/fixtures/gl_model.h"
#include "tests/fixtures/size.h"

enum { SIZE = 256, PIXELS = SIZE * SIZE, STEPS = 12 };

/* From so many radians around, so many times as near. */
static stp_view view_from(const stp_model *model, double t, double near)
{
    stp_camera camera = stp_camera_around(&model->ball, (stp_dvec3){sin(t), 0.3, cos(t)},
                                          (stp_dvec3){0.0, 1.0, 0.0}, 45.0, SIZE, SIZE);
    stp_view view;
    const stp_dvec3 away = stp_dvec3_sub(camera.eye, camera.look);
    camera.look = stp_dvec3_add(
        camera.look, stp_dvec3_scale(stp_dvec3_normalize(away), (1.0 - near) * model->ball.radius));
    camera.eye = stp_dvec3_add(camera.look, stp_dvec3_scale(away, near));
    check_ok(stp_view_create(&view, &camera, &model->ball, SIZE, SIZE, err));
    return view;
}

/* Comes nearer, by so much that some patches need finer levels at each step, and turns. */
static stp_view view_at(const stp_model *model, int step)
{
    return view_from(model, 0.15 * step, pow(0.85, step));
}

/* What is resident of the blocks drawn. */
typedef struct held {
    size_t samples, all;           /* all: of the blocks' resident levels */
    size_t lacking;                /* patches in sight that lack a level */
    const stp_patch_brief *briefs; /* patch 0 of the Object Texture: they lie by number */
} held;

static held look_at_drawn(const gl_fixture *f)
{
    held sum = {0};
    stp_inspection look = stp_renderer_inspect(f->renderer);
    for (size_t i = 0; i < look.cut->draw_count; i++) {
        stp_gpu_chunk chunk;
        const stp_draw *draw = &look.cut->draws[i];
        const stp_resident *r = gl_fixture_resident(f, i, &chunk);
        const stp_patch_brief *first = r->mirror.briefs - r->placement.patches.begin;
        assert_true(sum.briefs == NULL || sum.briefs == first);
        sum.briefs = first;
        for (int l = r->finest; l < STP_LEVEL_COUNT; l++)
            sum.all += look.looked.scene->blocks[r->block].sample_count[l];
        for (uint32_t p = 0; p < r->placement.patches.count; p++) {
            const stp_mirror_patch *patch = &r->mirror.patches[p];
            for (int l = patch->finest; l < STP_LEVEL_COUNT; l++)
                sum.samples += patch->count[l];
            if (stp_patch_in_sight(look.sight, &look.looked, draw, r->mirror.briefs, p))
                sum.lacking +=
                    stp_level_asked(look.frame, &chunk, patch, draw->finest) < patch->finest;
        }
    }
    return sum;
}

static const stp_draw_params every = {.threshold_px = 1.0, .every_sample = true};

/* Draws a step, and compares it with what is drawn of whole blocks, which every sample needs. */
static held compare(const gl_fixture *f, int step, const stp_draw_params *params)
{
    static uint8_t found[4 * PIXELS], expected[4 * PIXELS];
    const stp_view view = view_at(f->model, step);
    gl_fixture whole;
    gl_fixture_open(&whole, "model.stipple", NULL);
    gl_fixture_draw(&whole, &view, &every, NULL, expected);
    gl_fixture_draw(&whole, &view, params, NULL, expected);
    const held all = look_at_drawn(&whole);
    assert_int_equal(all.samples, all.all);
    gl_fixture_close(&whole);
    gl_fixture_draw(f, &view, params, NULL, found);
    assert_memory_equal(found, expected, sizeof found);
    const held h = look_at_drawn(f);
    assert_int_equal(h.lacking, 0);
    return h;
}

static void pictures_are_those_of_whole_blocks(void **state)
{
    const gl_fixture *f = *state;
    const stp_draw_params params = {.threshold_px = 1.0};
    held sum = {0};
    for (int step = 0; step < STEPS; step++) {
        const held h = compare(f, step, &params);
        sum.samples += h.samples;
        sum.all += h.all;
    }
    print_message("%zu of %zu samples are resident\n", sum.samples, sum.all);
    assert_true(12 * sum.samples < 7 * sum.all);
    compare(f, STEPS - 1, &every);
    compare(f, STEPS / 2, &params);
}

/* For its first picture a renderer keeps what the picture shows: the levels that patches in sight
 * ask for, nothing finer of others, and only the vertices of those that are not visible. Roots are
 * whole. */
static void first_picture_has_what_it_shows(void **state)
{
    static const stp_draw_params params = {.threshold_px = 1.0};
    gl_fixture f;
    size_t vertices = 0;
    gl_fixture_open(&f, "model.stipple", NULL);
    compare(&f, STEPS / 2, &params);
    const stp_inspection look = stp_renderer_inspect(f.renderer);
    for (size_t i = 0; i < look.cut->draw_count; i++) {
        stp_gpu_chunk chunk;
        const stp_resident *r = gl_fixture_resident(&f, i, &chunk);
        for (uint32_t p = 0; p < r->placement.patches.count; p++) {
            const stp_mirror_patch *patch = &r->mirror.patches[p];
            const int asked = stp_level_asked(look.frame, &chunk, patch, r->finest);
            const stp_draw *draw = &look.cut->draws[i];
            if (stp_scene_is_root(look.looked.scene, r->block))
                continue;
            if (stp_patch_in_sight(look.sight, &look.looked, draw, r->mirror.briefs, p))
                assert_int_equal(patch->finest, asked);
            else if (stp_patch_visible(look.frame, &chunk, patch))
                assert_true(patch->finest >= asked);
            else
                assert_int_equal(patch->finest, STP_LEVEL_COUNT - 1);
            vertices += patch->finest == STP_LEVEL_COUNT - 1;
        }
    }
    assert_true(vertices > 100);
    for (int step = STEPS / 2; step < STEPS; step += 2)
        compare(&f, step, &params);
    gl_fixture_close(&f);
    (void)state;
}

/* Where a block's samples are; zero if it is not resident. */
static stp_range texels_of(const stp_block_cache *cache, uint32_t block)
{
    if (stp_block_cache_finest(cache, block) == STP_NOT_RESIDENT)
        return (stp_range){0};
    return stp_block_cache_get(cache, stp_block_cache_slot(cache, block))->placement.texels;
}

/* How many of the drawn blocks were loaded again, with more samples, for the second of two views, a
 * tenth nearer. */
static size_t loaded_again(bool views_follow, size_t *drawn)
{
    static const stp_draw_params params = {.threshold_px = 1.0};
    static uint8_t picture[4 * PIXELS];
    gl_fixture f;
    size_t again = 0;
    gl_fixture_open(&f, "model.stipple", NULL);
    stp_renderer_destroy(&f.renderer);
    check_ok(stp_renderer_create(
        &f.renderer, &(stp_renderer_params){.model = f.model, .views_follow = views_follow}, err));
    stp_view view = view_at(f.model, STEPS / 2);
    gl_fixture_draw(&f, &view, &params, NULL, picture);
    const stp_inspection look = stp_renderer_inspect(f.renderer);
    uint32_t *texels = malloc(look.looked.scene->block_count * sizeof *texels);
    assert_non_null(texels);
    for (uint32_t b = 0; b < look.looked.scene->block_count; b++)
        texels[b] = texels_of(look.cache, b).count;
    view.eye = stp_dvec3_sub(view.eye, stp_dvec3_scale(view.back, 0.1 * f.model->ball.radius));
    gl_fixture_draw(&f, &view, &params, NULL, picture);
    *drawn = look.cut->draw_count;
    for (size_t i = 0; i < look.cut->draw_count; i++) {
        const uint32_t block = look.cut->draws[i].block;
        again += texels[block] > 0 && texels[block] != texels_of(look.cache, block).count;
    }
    free(texels);
    gl_fixture_close(&f);
    return again;
}

/* A renderer that knows that views follow one another keeps from the first picture on what the next
 * one may show. Else most blocks are loaded again for the second one. */
static void little_is_loaded_again_if_views_follow(void **state)
{
    size_t drawn = 0;
    const size_t again = loaded_again(false, &drawn), follow = loaded_again(true, &drawn);
    print_message("of %zu blocks %zu are loaded again; if views follow, %zu\n", drawn, again,
                  follow);
    assert_true(2 * again > drawn && 4 * follow < again);
    (void)state;
}

/* Turns around the model with so much GPU memory; *used and *pinned are of the last picture. Each
 * picture must be that of a renderer with room. Returns in how many passes they were drawn at most.
 */
static uint32_t turn(uint64_t gpu_bytes, stp_cut_measure *cut, uint64_t *used, uint64_t *pinned)
{
    static const stp_draw_params params = {.threshold_px = 1.0};
    static uint8_t found[4 * PIXELS], expected[4 * PIXELS];
    gl_fixture f, roomy;
    uint32_t passes = 0;
    gl_fixture_open(&f, "model.stipple", NULL);
    gl_fixture_open(&roomy, "model.stipple", NULL);
    stp_renderer_destroy(&f.renderer);
    check_ok(stp_renderer_create(&f.renderer,
                                 &(stp_renderer_params){.model = f.model,
                                                        .gpu_memory_bytes = gpu_bytes,
                                                        .views_follow = true},
                                 err));
    for (int step = 0; step < STEPS; step++) {
        stp_draw_stats stats;
        const stp_view view = view_from(f.model, 0.3 * step, 1.0);
        gl_fixture_draw(&f, &view, &params, &stats, found);
        gl_fixture_draw(&roomy, &view, &params, NULL, expected);
        assert_memory_equal(found, expected, sizeof found);
        passes = stats.passes > passes ? stats.passes : passes;
    }
    stp_renderer_measure(f.renderer, cut);
    *used = stp_renderer_memory(f.renderer).gpu_used;
    *pinned = stp_renderer_gpu_pinned(f.renderer);
    gl_fixture_close(&f);
    gl_fixture_close(&roomy);
    return passes;
}

/* Levels for nearer views are cache: where memory is short, blocks give them back, and pictures
 * that do without them still take one pass. */
static void levels_are_given_back(void **state)
{
    stp_cut_measure roomy, tight;
    uint64_t used[2], pinned[2];
    (void)state;
    assert_int_equal(turn(UINT64_C(1) << 30, &roomy, &used[0], &pinned[0]), 1);
    assert_int_equal(turn(UINT64_C(2520) << 10, &tight, &used[1], &pinned[1]), 1);
    print_message("%.1f bytes a sample, with room %.1f; %.1f are pinned\n",
                  (double)used[1] / (double)tight.points, (double)used[0] / (double)roomy.points,
                  (double)pinned[1] / (double)tight.points);
    assert_int_equal(tight.points, roomy.points);
    assert_true(10 * used[1] < 9 * used[0]);
    assert_true(pinned[1] <= used[1] && 10 * pinned[1] > 9 * pinned[0]);
}

/* Comes nearer without waiting: what is missing is drawn from coarser levels, the same by each
 * road. */
static void roads_draw_what_is_there(void **state)
{
    static const stp_lod lods[] = {STP_LOD_CPU, STP_LOD_GEOMETRY, STP_LOD_COMPUTE};
    static uint8_t pictures[3][4 * PIXELS];
    for (int i = 0; i < 3; i++) {
        gl_fixture f;
        stp_draw_stats stats;
        stp_draw_params params = {.threshold_px = 1.0, .lod = lods[i]};
        gl_fixture_open(&f, "model.stipple", NULL);
        stp_view view = view_at(f.model, 0);
        gl_fixture_draw(&f, &view, &params, NULL, pictures[i]);
        params.stream = true;
        view = view_at(f.model, STEPS - 1);
        gl_fixture_draw(&f, &view, &params, &stats, pictures[i]);
        assert_false(stats.cut_complete);
        assert_true(look_at_drawn(&f).lacking > 100);
        assert_memory_equal(pictures[i], pictures[0], sizeof pictures[i]);
        gl_fixture_close(&f);
    }
    (void)state;
}

/* What is kept of a chunk is what it was. */
static void keeps_samples(void **state)
{
    const gl_fixture *f = *state;
    stp_chunk *whole = NULL, *kept = NULL;
    const uint32_t id = f->model->info->chunk_count - 1;
    uint8_t finest[65536];
    check_ok(stp_chunk_file_read(f->model->file, id, 0, &whole, err));
    check_ok(stp_chunk_file_read(f->model->file, id, 0, &kept, err));
    for (uint32_t p = 0; p < whole->patch_count; p++)
        finest[p] = (uint8_t)(stp_random_u64(3, p) % STP_LEVEL_COUNT);
    stp_patch_levels_keep(kept, finest);
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        for (uint32_t p = 0; p < whole->patch_count; p++) {
            const uint32_t *from = whole->level_begin[l] + p, *to = kept->level_begin[l] + p;
            const uint32_t count = l >= finest[p] ? from[1] - from[0] : 0;
            assert_int_equal(to[1] - to[0], count);
            assert_memory_equal(kept->samples[l] + to[0], whole->samples[l] + from[0],
                                count * sizeof(stp_sample));
        }
    stp_chunk_destroy(&whole);
    stp_chunk_destroy(&kept);
}

static int enter(void **state)
{
    return gl_model_enter(
        state, &(model_recipe){.shape = GEN_STATUE, .point_count = TEST_SIZE(400000, 200000)});
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_are_those_of_whole_blocks),
        cmocka_unit_test(first_picture_has_what_it_shows),
        cmocka_unit_test(little_is_loaded_again_if_views_follow),
        cmocka_unit_test(levels_are_given_back),
        cmocka_unit_test(roads_draw_what_is_there),
        cmocka_unit_test(keeps_samples),
    };
    int failed = cmocka_run_group_tests(tests, enter, gl_model_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

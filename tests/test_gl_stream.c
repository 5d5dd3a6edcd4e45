/* A flight while chunks stream: at every frame each part of the surface is drawn exactly once,
 * memory stays within what was given, nothing that was covered is uncovered while the camera rests,
 * and every stop ends at the bytes of a picture that waited. */
#include "tests/gl_fixture.h"
#include "tests/model_fixture.h"
#include "tests/size.h"
#include "tests/support/views.h"

#include <unistd.h>

enum { SIZE = 256, PIXELS = SIZE * SIZE, FRAMES_LIMIT = 20000, STOPS = 5, STEPS = 6 };

static const char path[] = "stream.stipple";

typedef struct flight {
    stp_model *model;
    stp_renderer *streaming, *waiting;
    stp_renderer_params params;
} flight;

static void take_off(flight *f, uint64_t gpu_bytes, uint64_t cpu_bytes)
{
    f->params = (stp_renderer_params){.model = f->model,
                                      .gpu_memory_bytes = gpu_bytes,
                                      .cpu_memory_bytes = cpu_bytes,
                                      .thread_count = 2};
    check_ok(stp_renderer_create(&f->streaming, &f->params, err));
    check_ok(stp_renderer_create(&f->waiting, &(stp_renderer_params){.model = f->model}, err));
}

static void land(flight *f)
{
    stp_renderer_destroy(&f->streaming);
    stp_renderer_destroy(&f->waiting);
}

/* ---- the cut ---- */

/* By chunk: 0 no part of the cut; 1 passed; 2 drawn. children: by chunk, which of its own skip. */
typedef struct members {
    uint8_t *part;
    uint64_t *children;
} members;

static members list_members(const stp_model *model, const stp_cut *cut)
{
    uint32_t count = model->info->chunk_count;
    members m = {calloc(count, sizeof *m.part), calloc(count, sizeof *m.children)};
    assert_non_null(m.part);
    assert_non_null(m.children);
    for (size_t i = 0; i < cut->passed_count; i++) {
        m.part[cut->passed[i]] = 1;
        m.children[cut->passed[i]] = UINT64_MAX;
    }
    for (size_t i = 0; i < cut->draw_count; i++) {
        assert_int_equal(m.part[cut->draws[i].chunk], 0);
        m.part[cut->draws[i].chunk] = 2;
        m.children[cut->draws[i].chunk] = cut->draws[i].drawn_children;
    }
    return m;
}

static void free_members(members *m)
{
    free(m->part);
    free(m->children);
}

/* How often a cut draws the surface that a leaf stands for. */
static unsigned times_drawn(const stp_model *model, const members *m, uint32_t leaf)
{
    unsigned times = m->part[leaf] == 2;
    uint32_t child = leaf, chunk = model->entries[leaf].parent;
    for (; chunk != STP_CHUNK_NONE; child = chunk, chunk = model->entries[chunk].parent) {
        uint32_t k = child - model->entries[chunk].first_child;
        times += m->part[chunk] == 2 && !(m->children[chunk] >> k & 1);
    }
    return times;
}

/* What the whole cut draws is drawn now too, once; nothing is drawn twice. */
static void check_cut(const flight *f, uint32_t passes)
{
    stp_inspection now = stp_renderer_inspect(f->streaming);
    stp_inspection whole = stp_renderer_inspect(f->waiting);
    members part = list_members(f->model, now.cut), all = list_members(f->model, whole.cut);
    for (uint32_t id = 0; id < f->model->info->chunk_count; id++) {
        if (f->model->entries[id].child_count > 0)
            continue;
        unsigned times = times_drawn(f->model, &part, id);
        assert_true(times <= 1);
        assert_true(times >= times_drawn(f->model, &all, id));
    }
    for (size_t i = 0; passes == 1 && i < now.cut->draw_count; i++) {
        const stp_draw *draw = &now.cut->draws[i];
        assert_true(stp_chunk_cache_finest(now.cache, draw->chunk) <= draw->finest);
    }
    free_members(&part);
    free_members(&all);
}

static void check_memory(const flight *f)
{
    stp_memory_use use = stp_renderer_memory(f->streaming);
    assert_true(use.gpu_used <= use.gpu_allotted);
    assert_true(use.gpu_allotted <= f->params.gpu_memory_bytes);
    assert_true(use.cpu_allotted <= f->params.cpu_memory_bytes);
}

/* ---- pictures ---- */

static size_t count_covered(const uint8_t *rgba)
{
    size_t count = 0;
    for (size_t i = 0; i < PIXELS; i++)
        count += rgba[4 * i + 3] != 0;
    return count;
}

static void draw(stp_renderer *r, const stp_view *view, const stp_draw_params *params,
                 uint8_t *rgba, stp_draw_stats *stats)
{
    check_ok(stp_renderer_draw(r, view, params, stats, err));
    check_ok(stp_renderer_read(r, rgba, err));
}

/* Frames at one view until nothing changes; the bytes must be those of the picture that waited. */
static void stop(flight *f, const stp_view *view, const stp_draw_params *params,
                 const stp_draw_params *waiting, bool every)
{
    static uint8_t found[4 * PIXELS], expected[4 * PIXELS];
    stp_draw_stats stats = {0}, whole;
    draw(f->waiting, view, waiting, expected, &whole);
    size_t covered = count_covered(expected);
    for (int frame = 0; !(every ? stats.every_sample : stats.cut_complete); frame++) {
        assert_true(frame < FRAMES_LIMIT);
        draw(f->streaming, view, params, found, &stats);
        check_memory(f);
        assert_int_equal(stats.load_ms, 0.0);
        size_t now = count_covered(found);
        assert_true(20 * now >= 19 * covered && 19 * now <= 20 * covered);
        if (stats.chunks_loading > 0)
            usleep(1000);
    }
    assert_memory_equal(found, expected, sizeof found);
    draw(f->streaming, view, params, found, &stats); /* and stays */
    assert_memory_equal(found, expected, sizeof found);
}

static stp_view view_at(const flight *f, double t)
{
    stp_camera camera = stp_camera_around(&f->model->ball, (stp_dvec3){sin(t), 0.3, cos(t)},
                                          (stp_dvec3){0.0, 1.0, 0.0}, 45.0, SIZE, SIZE);
    stp_view view;
    camera.eye = stp_dvec3_add(camera.look, stp_dvec3_scale(stp_dvec3_sub(camera.eye, camera.look),
                                                            0.55 + 0.4 * cos(1.7 * t)));
    check_ok(stp_view_create(&view, &camera, &f->model->ball, SIZE, SIZE, err));
    return view;
}

static void fly(flight *f, const stp_draw_params *params, const stp_draw_params *waiting)
{
    static uint8_t rgba[4 * PIXELS];
    stp_draw_stats stats;
    double t = 0.0;
    for (int i = 0; i < STOPS; i++) {
        for (int k = 0; k < STEPS; k++, t += 0.07) {
            stp_view view = view_at(f, t);
            check_ok(stp_renderer_draw(f->waiting, &view, waiting, NULL, err));
            draw(f->streaming, &view, params, rgba, &stats);
            check_cut(f, stats.passes);
            check_memory(f);
        }
        t += 0.9; /* a jump */
        stp_view view = view_at(f, t);
        stop(f, &view, params, waiting, false);
    }
}

/* Budgets from roomy to less than one cut, which then comes in passes. */
static void flights(void **state)
{
    static const uint64_t budgets[][2] = {{256, 256}, {24, 24}, {10, 16}};
    flight f = {.model = *state};
    for (size_t i = 0; i < sizeof budgets / sizeof *budgets; i++) {
        stp_draw_params params = {.threshold_px = 0.5, .stream = true};
        stp_draw_params waiting = {.threshold_px = 0.5};
        take_off(&f, budgets[i][0] << 20, budgets[i][1] << 20);
        fly(&f, &params, &waiting);
        land(&f);
    }
}

/* A picture at rest goes on to every sample, and says so. */
static void refined(void **state)
{
    flight f = {.model = *state};
    stp_draw_params params = {.threshold_px = 2.0, .stream = true, .refine = true};
    stp_draw_params waiting = {.lod = STP_LOD_FULL};
    take_off(&f, 10 << 20, 16 << 20);
    stp_view view = view_at(&f, 1.0);
    stop(&f, &view, &params, &waiting, true);
    view = view_at(&f, 1.1);
    stp_draw_stats stats;
    check_ok(stp_renderer_draw(f.streaming, &view, &params, &stats, err));
    assert_false(stats.every_sample);
    land(&f);
}

/* Several models in one scene: the picture of both is, pixel by pixel, one of the two, and hiding
 * one leaves the other's bytes. */
static void scenes(void **state)
{
    static uint8_t one[4 * PIXELS], both[4 * PIXELS];
    stp_model *other = NULL;
    flight f = {.model = *state};
    stp_draw_params params = {.threshold_px = 1.0};
    model_fixture_build("other.stipple", &(model_recipe){.shape = GEN_TORUS, .point_count = 60000});
    check_ok(stp_model_open(&other, "other.stipple", err));
    take_off(&f, 256 << 20, 256 << 20);
    stp_view view = view_at(&f, 0.5);
    draw(f.waiting, &view, &params, one, NULL);
    const stp_model *models[] = {f.model, other};
    check_ok(stp_renderer_set_models(f.waiting, models, 2, err));
    params.hidden_models = 2;
    draw(f.waiting, &view, &params, both, NULL);
    assert_memory_equal(one, both, sizeof one);
    params.hidden_models = 0;
    draw(f.waiting, &view, &params, both, NULL);
    assert_true(count_covered(both) >= count_covered(one));
    assert_memory_not_equal(one, both, sizeof one);
    check_ok(stp_renderer_set_models(f.waiting, models, 1, err));
    draw(f.waiting, &view, &params, both, NULL);
    assert_memory_equal(one, both, sizeof one);
    assert_int_equal(stp_renderer_set_models(f.waiting, models, 0, NULL), STP_INVALID_ARGUMENT);
    draw(f.waiting, &view, &params, both, NULL);
    assert_memory_equal(one, both, sizeof one);
    land(&f);
    stp_model_close(&other);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    stp_model *model = NULL;
    model_fixture_build(
        path, &(model_recipe){.shape = GEN_BUMPY, .point_count = TEST_SIZE(900000, 250000)});
    check_ok(stp_model_open(&model, path, err));
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate(flights, model),
        cmocka_unit_test_prestate(refined, model),
        cmocka_unit_test_prestate(scenes, model),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stp_model_close(&model);
    stp_gl_context_destroy(&context);
    return failed;
}

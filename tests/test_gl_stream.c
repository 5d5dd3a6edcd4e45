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
    struct layer *layers; /* by chunk */
    size_t parted; /* leaf patches that a patch above stood for while their chunk was drawn */
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

/* A chunk's patches as the file has them: what looking at them reads, which of the parent's patches
 * stands for each, and the points under them as bounds of their own. */
typedef struct layer {
    stp_patch_brief *briefs;
    uint32_t *above;
    stp_rule_bound *points; /* of a leaf */
    uint32_t *first_point;
} layer;

static stp_rule_bound bound_of_point(const stp_sample *sample, const stp_patch *patch)
{
    stp_dvec3 p = stp_sample_position(sample, patch);
    vec3s n = stp_normal_decode(sample->normal);
    return (stp_rule_bound){.centre = {(float)p.x, (float)p.y, (float)p.z},
                            .cone_axis = {n.x, n.y, n.z},
                            .cone_cos = 1.0f,
                            .two_sided = (patch->flags & STP_PATCH_TWO_SIDED) != 0};
}

static void load_points(const stp_chunk *chunk, layer *out)
{
    const uint32_t *begin = chunk->level_begin[0];
    out->points = calloc(begin[chunk->patch_count], sizeof *out->points);
    out->first_point = calloc(chunk->patch_count + 1, sizeof *out->first_point);
    assert_true(out->points != NULL && out->first_point != NULL);
    memcpy(out->first_point, begin, (chunk->patch_count + 1) * sizeof *begin);
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (uint32_t i = begin[p]; i < begin[p + 1]; i++)
            out->points[i] = bound_of_point(&chunk->samples[0][i], &chunk->patches[p]);
}

static void load_layer(const stp_model *model, uint32_t id, layer *out)
{
    stp_chunk *chunk = NULL;
    check_ok(stp_chunk_file_read(model->file, id, 0, &chunk, err));
    stp_gpu_patch *patches = calloc(chunk->patch_count, sizeof *patches);
    *out = (layer){.briefs = calloc(chunk->patch_count, sizeof *out->briefs),
                   .above = calloc(chunk->patch_count, sizeof *out->above)};
    assert_true(patches != NULL && out->briefs != NULL && out->above != NULL);
    stp_gpu_patches_fill(patches, chunk, &(stp_placement){0}, 0);
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        out->briefs[p] = stp_patch_brief_of(&patches[p], &chunk->patches[p]);
    if (model->entries[id].child_count == 0)
        load_points(chunk, out);
    free(patches);
    stp_chunk_destroy(&chunk);
}

/* By chunk. */
static layer *load_layers(const stp_model *model)
{
    layer *layers = calloc(model->info->chunk_count, sizeof *layers);
    assert_non_null(layers);
    for (uint32_t id = 0; id < model->info->chunk_count; id++)
        load_layer(model, id, &layers[id]);
    for (uint32_t id = 0; id < model->info->chunk_count; id++) {
        const stp_chunk_entry *e = &model->entries[id];
        assert_int_equal(e->flags & STP_CHUNK_LINKED, e->child_count > 0 ? STP_CHUNK_LINKED : 0);
        for (uint32_t p = 0; e->child_count > 0 && p < e->patch_count; p++) {
            const stp_patch_brief *brief = &layers[id].briefs[p];
            uint32_t *above = layers[e->first_child + brief->child].above;
            for (unsigned i = 0; i < brief->below_count; i++)
                above[brief->first_below + i] = p;
        }
    }
    return layers;
}

static void free_layers(const stp_model *model, layer *layers)
{
    for (uint32_t id = 0; id < model->info->chunk_count; id++) {
        free(layers[id].briefs);
        free(layers[id].above);
        free(layers[id].points);
        free(layers[id].first_point);
    }
    free(layers);
}

/* The draw of each chunk, NULL for none; free with free(). */
static const stp_draw **list_draws(const stp_model *model, const stp_cut *cut)
{
    const stp_draw **draws = calloc(model->info->chunk_count, sizeof *draws);
    assert_non_null(draws);
    for (size_t i = 0; i < cut->draw_count; i++) {
        assert_null(draws[cut->draws[i].chunk]);
        draws[cut->draws[i].chunk] = &cut->draws[i];
    }
    return draws;
}

/* How often the surface of a leaf's patch is drawn: by itself, and by patches that stand for it. */
static unsigned times_drawn(const flight *f, const stp_draw *const *draws, uint32_t chunk,
                            uint32_t patch, unsigned *above)
{
    stp_inspection look = stp_renderer_inspect(f->streaming);
    unsigned times = 0;
    *above = 0;
    for (bool leaf = true; chunk != STP_CHUNK_NONE; leaf = false) {
        const layer *l = &f->layers[chunk];
        bool drawn = draws[chunk] != NULL &&
                     stp_patch_in_sight(look.sight, &look.looked, draws[chunk], l->briefs, patch);
        times += drawn;
        *above += drawn && !leaf;
        patch = l->above[patch];
        chunk = f->model->entries[chunk].parent;
    }
    return times;
}

/* Whether some point of a leaf's patch is in the picture and turned to the eye. */
static bool is_visible(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk, const layer *l,
                       uint32_t patch)
{
    float eye[3];
    for (uint32_t i = l->first_point[patch]; i < l->first_point[patch + 1]; i++) {
        stp_rule_bound bound = l->points[i];
        for (int axis = 0; axis < 3; axis++)
            bound.centre[axis] += chunk->offset[axis];
        if (stp_rule_visible(frame, &bound, eye))
            return true;
    }
    return false;
}

/* What of a leaf is in sight is drawn once, and nothing twice. */
static void check_leaf(flight *f, const stp_draw *const *draws, uint32_t id)
{
    const stp_chunk_entry *e = &f->model->entries[id];
    stp_inspection look = stp_renderer_inspect(f->streaming);
    stp_gpu_chunk chunk = stp_gpu_chunk_from_draw(e, &(stp_draw){.chunk = id}, look.eye);
    for (uint32_t p = 0; p < e->patch_count; p++) {
        unsigned above;
        unsigned times = times_drawn(f, draws, id, p, &above);
        assert_true(times == 1 ||
                    (times == 0 && !is_visible(look.frame, &chunk, &f->layers[id], p)));
        f->parted += above > 0 && draws[id] != NULL;
    }
}

static void check_cut(flight *f, uint32_t passes)
{
    stp_inspection now = stp_renderer_inspect(f->streaming);
    const stp_draw **draws = list_draws(f->model, now.cut);
    for (uint32_t id = 0; id < f->model->info->chunk_count; id++)
        if (f->model->entries[id].child_count == 0)
            check_leaf(f, draws, id);
    for (size_t i = 0; passes == 1 && i < now.cut->draw_count; i++)
        assert_true(stp_chunk_cache_finest(now.cache, now.cut->draws[i].chunk) <=
                    now.cut->draws[i].finest);
    free(draws);
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
    flight f = {.model = *state, .layers = load_layers(*state)};
    for (size_t i = 0; i < sizeof budgets / sizeof *budgets; i++) {
        stp_draw_params params = {.threshold_px = TEST_SIZE(0.5, 2.0),
                                  .radius_cap_px = TEST_SIZE(0.0, 100.0), /* 0: the usual */
                                  .stream = true};
        stp_draw_params waiting = params;
        waiting.stream = false;
        take_off(&f, budgets[i][0] << 20, budgets[i][1] << 20);
        fly(&f, &params, &waiting);
        land(&f);
    }
    free_layers(f.model, f.layers);
    assert_true(f.model->info->depth >= TEST_SIZE(3, 2));
    print_message("%zu times a leaf's patch was left to one above it\n", f.parted);
    assert_true(f.parted > 1000);
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
        path, &(model_recipe){.shape = GEN_BUMPY, .point_count = TEST_SIZE(3000000, 250000)});
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

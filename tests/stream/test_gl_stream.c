/* Tests a flight while chunks stream. At every frame each part of the surface is drawn exactly
 * once, and memory stays within its budgets. While the camera rests, covered pixels stay covered.
 * Every stop ends with the same bytes as a picture that waited. What is coarse comes first. */
#include "formats/chunk/convert.h"
#include "formats/chunk/repair/repair.h"
#include "preprocess/tree/rebuild.h"
#include "runtime/cut/need.h"
#include "runtime/stream/gather.h"
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/fixtures/model_layers.h"
#include "tests/fixtures/size.h"
#include "tests/support/views.h"

#include <fcntl.h>
#include <stdatomic.h>
#include <unistd.h>

enum { SIZE = 256, PIXELS = SIZE * SIZE, FRAMES_LIMIT = 20000, STOPS = 5, STEPS = 6 };
/* Level-0 samples of a block, at least: prepared models have mostly one patch above a block. In
 * blocks of several, a block is drawn while some of its patches are left to the patches above. */
#define BLOCK_SAMPLES 3000

static const char path[] = "stream.stipple";

typedef struct flight {
    stp_model *model;
    model_layer *layers;  /* by chunk */
    size_t parted;        /* leaf patches drawn by a patch above while their block was drawn */
    size_t parted_passes; /* frames in passes where that may be so */
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

/* Lists the draw of each block, NULL for none; free it with free(). */
static const stp_draw **list_draws(const stp_model *model, const stp_cut *cut)
{
    const stp_draw **draws = calloc(model->first_block[model->info->chunk_count], sizeof *draws);
    assert_non_null(draws);
    for (size_t i = 0; i < cut->draw_count; i++) {
        assert_null(draws[cut->draws[i].block]);
        draws[cut->draws[i].block] = &cut->draws[i];
    }
    return draws;
}

/* The block of a chunk's patch. */
static uint32_t block_of(const stp_model *model, uint32_t chunk, uint32_t patch)
{
    uint32_t block = model->first_block[chunk];
    while (patch - model->blocks[block].first_patch >= model->blocks[block].patch_count)
        block++;
    return block;
}

/* How often the surface of a leaf's patch is drawn, by itself and by patches that stand for it.
 * *above counts the latter. */
static unsigned times_drawn(const flight *f, const stp_draw *const *draws, uint32_t chunk,
                            uint32_t patch, unsigned *above)
{
    stp_inspection look = stp_renderer_inspect(f->streaming);
    unsigned times = 0;
    *above = 0;
    for (bool leaf = true; chunk != STP_CHUNK_NONE; leaf = false) {
        const model_layer *l = &f->layers[chunk];
        uint32_t block = block_of(f->model, chunk, patch);
        uint32_t first = f->model->blocks[block].first_patch;
        bool drawn =
            draws[block] != NULL && stp_patch_in_sight(look.sight, &look.looked, draws[block],
                                                       l->briefs + first, patch - first);
        times += drawn;
        *above += drawn && !leaf;
        patch = l->above[patch];
        chunk = f->model->entries[chunk].parent;
    }
    return times;
}

/* Whether some point of a leaf's patch is in the picture and faces the eye. */
static bool is_visible(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk, const model_layer *l,
                       uint32_t patch)
{
    float eye[3];
    for (uint32_t i = l->first_point[patch]; i < l->first_point[patch + 1]; i++) {
        stp_patch_brief point = {.bound = l->points[i]};
        stp_rule_bound bound = stp_patch_bound(&point, chunk);
        if (stp_rule_visible(frame, &bound, eye))
            return true;
    }
    return false;
}

/* Each patch of a leaf must be drawn at most once, and exactly once if it is visible. */
static void check_leaf(flight *f, const stp_draw *const *draws, uint32_t id)
{
    const stp_chunk_entry *e = &f->model->entries[id];
    stp_inspection look = stp_renderer_inspect(f->streaming);
    stp_gpu_chunk chunk = stp_gpu_chunk_from_draw(
        look.looked.scene, &(stp_draw){.block = f->model->first_block[id]}, look.eye);
    for (uint32_t p = 0; p < e->patch_count; p++) {
        unsigned above;
        unsigned times = times_drawn(f, draws, id, p, &above);
        assert_true(times == 1 ||
                    (times == 0 && !is_visible(look.frame, &chunk, &f->layers[id], p)));
        f->parted += above > 0 && draws[block_of(f->model, id, p)] != NULL;
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
        assert_true(stp_block_cache_finest(now.cache, now.cut->draws[i].block) <=
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

/* Draws frames of one view until nothing changes; the bytes must be those of the picture that
 * waited. */
static void stop(flight *f, const stp_view *view, const stp_draw_params *params,
                 const stp_draw_params *waiting, bool every)
{
    static uint8_t found[4 * PIXELS], expected[4 * PIXELS];
    stp_draw_stats stats = {0}, whole;
    draw(f->waiting, view, waiting, expected, &whole);
    size_t covered = count_covered(expected);
    /* the first frame may keep a chunk a little longer */
    for (int frame = 0;
         frame < 2 || stats.exposes || !(every ? stats.every_sample : stats.cut_complete);
         frame++) {
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
    f->parted_passes += stats.passes > 1 && stp_renderer_inspect(f->streaming).cut->link_count > 0;
    draw(f->streaming, view, params, found, &stats); /* it stays */
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

/* Flies over one model with several budgets: from roomy to less than one cut, which then comes in
 * passes. first: the first of the budgets to fly with. */
enum { BUDGETS = 3 };

static void fly_budgets(flight *f, size_t first)
{
    static const uint64_t budgets[BUDGETS][2] = {{256, 256}, {24, 24}, {TEST_SIZE(10, 6), 16}};
    f->layers = model_layers_load(f->model);
    for (size_t i = first; i < BUDGETS; i++) {
        stp_draw_params params = {.threshold_px = TEST_SIZE(0.5, 2.0),
                                  .radius_cap_px = TEST_SIZE(0.0, 100.0), /* 0: the usual */
                                  .stream = true};
        stp_draw_params waiting = params;
        waiting.stream = false;
        take_off(f, budgets[i][0] << 20, budgets[i][1] << 20);
        fly(f, &params, &waiting);
        land(f);
    }
    model_layers_free(f->model, f->layers);
    print_message("%zu times a leaf's patch was left to one above it; %zu such cuts in passes\n",
                  f->parted, f->parted_passes);
}

static void flights(void **state)
{
    flight f = {.model = *state};
    assert_true(f.model->info->depth >= TEST_SIZE(3, 2));
    for (uint32_t id = 0; id < f.model->info->chunk_count; id++)
        assert_int_equal((f.model->entries[id].flags & STP_CHUNK_LINKED) != 0,
                         f.model->entries[id].child_count > 0);
    fly_budgets(&f, 0);
    assert_true(f.parted > TEST_SIZE(1000, 10));
}

/* Rebuilds an inner chunk and those above it: these chunks are then not linked, but others are. */
static void rebuild_one(const stp_model *model, uint32_t id, const char *output)
{
    static const uint8_t garbage[16] = {0x5a, 0xa5, 0x5a, 0xa5, 0x5a, 0xa5, 0x5a, 0xa5};
    stp_pool *pool = NULL;
    stp_repair_result result;
    char command[300];
    snprintf(command, sizeof command, "cp '%s' damaged.stipple", path);
    assert_int_equal(system(command), 0);
    int file = open("damaged.stipple", O_WRONLY);
    assert_int_equal(pwrite(file, garbage, sizeof garbage, (off_t)model->entries[id].offset + 64),
                     sizeof garbage);
    close(file);
    check_ok(stp_pool_create(&pool, 2, err));
    const stp_repair_params params = {
        .output = output, .force = true, .build_parent = stp_rebuild_parent, .pool = pool};
    check_ok(stp_chunk_file_repair("damaged.stipple", &params, &result, err));
    stp_pool_destroy(&pool);
}

/* Flies over a file with some chunks that are not linked. */
static void repaired(void **state)
{
    flight f = {0};
    uint32_t linked = 0, unlinked = 0;
    const stp_model *sound = *state;
    rebuild_one(sound, TEST_SIZE(1, 0), "repaired.stipple");
    check_ok(stp_model_open(&f.model, "repaired.stipple", err));
    for (uint32_t id = 0; id < f.model->info->chunk_count; id++) {
        linked += (f.model->entries[id].flags & STP_CHUNK_LINKED) != 0;
        unlinked += f.model->entries[id].child_count > 0 &&
                    !(f.model->entries[id].flags & STP_CHUNK_LINKED);
    }
    assert_int_equal(unlinked, TEST_SIZE(2, 1));
    assert_in_range(linked, TEST_SIZE(1, 0), f.model->info->chunk_count);
    fly_budgets(&f, BUDGETS - 1);
    assert_in_range(f.parted_passes, TEST_SIZE(1, 0), SIZE_MAX); /* small models fit */
    stp_model_close(&f.model);
}

/* A picture at rest must go on to every sample and say so. */
static void refine(flight f, uint64_t gpu_bytes)
{
    stp_draw_params params = {.threshold_px = 2.0, .stream = true, .refine = true};
    stp_draw_params waiting = {.lod = STP_LOD_FULL};
    take_off(&f, gpu_bytes, 16 << 20);
    stp_view view = view_at(&f, 1.0);
    stop(&f, &view, &params, &waiting, true);
    view = view_at(&f, 1.1);
    stp_draw_stats stats;
    check_ok(stp_renderer_draw(f.streaming, &view, &params, &stats, err));
    assert_false(stats.every_sample);
    land(&f);
}

static void refined(void **state)
{
    refine((flight){.model = *state}, 10 << 20); /* in passes */
    refine((flight){.model = *state}, 256 << 20);
}

/* Two models in one scene: each pixel of their picture must equal the pixel of one of the models.
 * If one model is hidden, the other's bytes remain. */
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

/* ---- order ---- */

/* The linker puts these before the functions that read blocks and tell the time (CMakeLists.txt):
 * if there is a model here, its leaves cannot be read. The clock goes ahead by leaps. */
static _Atomic(const stp_model *) leaves_fail;
static _Atomic double leaps_s;

uint64_t __real_stp_gather_read(stp_chunk_file *file, stp_gather_item *items, size_t count,
                                uint8_t *buffer);
uint64_t __wrap_stp_gather_read(stp_chunk_file *file, stp_gather_item *items, size_t count,
                                uint8_t *buffer);
double __real_stp_clock_seconds(void);
double __wrap_stp_clock_seconds(void);

uint64_t __wrap_stp_gather_read(stp_chunk_file *file, stp_gather_item *items, size_t count,
                                uint8_t *buffer)
{
    const stp_model *model = leaves_fail;
    uint64_t bytes = 0;
    if (model == NULL)
        return __real_stp_gather_read(file, items, count, buffer);
    for (size_t i = 0; i < count; i++) {
        if (model->entries[items[i].block->chunk].child_count > 0) {
            bytes += __real_stp_gather_read(file, &items[i], 1, buffer);
            continue;
        }
        items[i].got = items[i].begin;
        items[i].status = stp_error_set(&items[i].error, STP_IO, "a leaf that the test keeps back");
    }
    return bytes;
}

double __wrap_stp_clock_seconds(void)
{
    return __real_stp_clock_seconds() + leaps_s;
}

/* Counts the patches drawn that are left to blocks below; *coarse counts those whose level
 * STP_NEED_MEANWHILE is not there. */
static size_t count_left(const flight *f, size_t *coarse)
{
    const stp_inspection look = stp_renderer_inspect(f->streaming);
    size_t count = 0;
    *coarse = 0;
    for (size_t i = 0; i < look.cut->draw_count; i++) {
        const stp_draw *draw = &look.cut->draws[i];
        const stp_resident *r =
            stp_block_cache_get(look.cache, stp_block_cache_slot(look.cache, draw->block));
        const stp_gpu_chunk chunk = stp_gpu_chunk_from_draw(look.looked.scene, draw, look.eye);
        for (uint32_t p = 0; p < r->placement.patches.count; p++) {
            const stp_rule_bound bound = stp_patch_bound(&r->mirror.briefs[p], &chunk);
            const stp_rule_sight sight = stp_rule_look(look.frame, &bound);
            if (r->mirror.briefs[p].block == STP_BLOCK_NONE ||
                stp_levels_do(look.frame, &sight, &r->mirror.patches[p], 0) ||
                !stp_patch_in_sight(look.sight, &look.looked, draw, r->mirror.briefs, p))
                continue;
            count++;
            *coarse += r->mirror.patches[p].finest > STP_NEED_MEANWHILE;
        }
    }
    return count;
}

static bool lacks_leaves_alone(const flight *f)
{
    const stp_cut *cut = stp_renderer_inspect(f->streaming).cut;
    bool alone = true;
    for (size_t i = 0; i < cut->miss_count; i++)
        alone &= f->model->entries[f->model->blocks[cut->misses[i].block].chunk].child_count == 0;
    return alone;
}

/* While leaves do not come, all of the picture gets finer: no inner patch waits with its headers
 * alone. Once leaves come, the picture is that of a renderer that waited. */
static void coarse_comes_first(void **state)
{
    flight f = {0};
    const stp_draw_params params = {.threshold_px = 0.1, .stream = true},
                          waiting = {.threshold_px = 0.1};
    (void)state;
    check_ok(stp_model_open(&f.model, "small_blocks.stipple", err));
    if (f.model->info->depth < 3) { /* under the thread sanitizer */
        stp_model_close(&f.model);
        skip();
    }
    take_off(&f, 256 << 20, 256 << 20);
    const stp_view view = view_at(&f, 0.0);
    leaves_fail = f.model;
    for (int frame = 0; frame == 0 || !lacks_leaves_alone(&f); frame++) {
        assert_true(frame < FRAMES_LIMIT);
        check_ok(stp_renderer_draw(f.streaming, &view, &params, NULL, err));
        leaps_s = leaps_s + 0.1;
        usleep(1000);
    }
    size_t coarse, left = count_left(&f, &coarse);
    print_message("%zu patches are left to leaves\n", left);
    assert_true(left > 100);
    assert_int_equal(coarse, 0);
    leaves_fail = NULL;
    leaps_s = leaps_s + 100.0;
    stop(&f, &view, &params, &waiting, false);
    land(&f);
    stp_model_close(&f.model);
}

/* For a first picture that waits, patches of inner chunks that are left to blocks below keep their
 * vertices alone. */
static void left_patches_are_vertices(void **state)
{
    flight f = {.model = *state};
    size_t vertices = 0, finer = 0;
    if (f.model->info->depth < 3) /* under the thread sanitizer */
        skip();
    take_off(&f, 256 << 20, 256 << 20);
    const stp_view view = view_at(&f, 0.0);
    check_ok(
        stp_renderer_draw(f.waiting, &view, &(stp_draw_params){.threshold_px = 0.3}, NULL, err));
    const stp_inspection look = stp_renderer_inspect(f.waiting);
    for (size_t i = 0; i < look.cut->draw_count; i++) {
        const stp_draw *draw = &look.cut->draws[i];
        const stp_resident *r =
            stp_block_cache_get(look.cache, stp_block_cache_slot(look.cache, draw->block));
        const stp_gpu_chunk chunk = stp_gpu_chunk_from_draw(look.looked.scene, draw, look.eye);
        for (uint32_t p = 0; p < r->placement.patches.count; p++) {
            const stp_mirror_patch *patch = &r->mirror.patches[p];
            if (r->finest == 0 && !stp_scene_is_root(look.looked.scene, r->block) &&
                r->mirror.briefs[p].block != STP_BLOCK_NONE &&
                stp_patch_visible(look.frame, &chunk, patch) &&
                !stp_patch_in_sight(look.sight, &look.looked, draw, r->mirror.briefs, p))
                *(patch->finest == 3 ? &vertices : &finer) += 1;
        }
    }
    print_message("%zu left patches are vertices, %zu are finer\n", vertices, finer);
    assert_true(vertices > 0);
    assert_int_equal(finer, 0);
    land(&f);
}

/* Prepares the model, and cuts it into larger blocks. */
static void build_model(void)
{
    stp_chunk_file *file = NULL;
    model_fixture_build(
        "small_blocks.stipple",
        &(model_recipe){.shape = GEN_BUMPY, .point_count = TEST_SIZE(3000000, 250000)});
    check_ok(stp_chunk_file_open(&file, "small_blocks.stipple", err));
    const stp_convert_params params = {
        .codec = STP_CODEC_DRACO, .format = 2, .block_samples = BLOCK_SAMPLES, .force = true};
    check_ok(stp_chunk_file_convert(file, path, &params, err));
    stp_chunk_file_close(&file);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    stp_model *model = NULL;
    build_model();
    check_ok(stp_model_open(&model, path, err));
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate(flights, model),
        cmocka_unit_test_prestate(repaired, model),
        cmocka_unit_test_prestate(refined, model),
        cmocka_unit_test_prestate(scenes, model),
        cmocka_unit_test(coarse_comes_first),
        cmocka_unit_test_prestate(left_patches_are_vertices, model),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stp_model_close(&model);
    stp_gl_context_destroy(&context);
    return failed;
}

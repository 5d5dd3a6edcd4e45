/* Tests streaming when something goes wrong: damaged chunks, a failing server, no memory to decode,
 * sizes and settings that change at each frame. Each must come to an end, with the picture of a
 * renderer that waited. */
#include "runtime/stream/gather.h"
#include "tests/fixtures/chunk_fixture.h"
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/support/fault_server.h"

#include <fcntl.h>
#include <stdatomic.h>
#include <unistd.h>

enum { SIZE = 160, PIXELS = SIZE * SIZE, FRAMES_LIMIT = 20000, DAMAGE_BYTES = 64 };

static const char path[] = "faults.stipple";

static stp_view look(const stp_model *model, double t, double nearer, int width, int height)
{
    stp_view view;
    stp_camera camera = stp_camera_around(&model->ball, (stp_dvec3){sin(t), 0.3, cos(t)},
                                          (stp_dvec3){0.0, 1.0, 0.0}, 45.0, width, height);
    stp_dvec3 away = stp_dvec3_sub(camera.eye, camera.look);
    camera.eye = stp_dvec3_add(camera.look, stp_dvec3_scale(away, nearer));
    check_ok(stp_view_create(&view, &camera, &model->ball, width, height, err));
    return view;
}

static stp_renderer *renderer_of(const stp_model *model)
{
    stp_renderer *r = NULL;
    check_ok(
        stp_renderer_create(&r, &(stp_renderer_params){.model = model, .thread_count = 2}, err));
    return r;
}

static void read_picture(stp_renderer *r, uint8_t *rgba)
{
    check_ok(stp_renderer_read(r, rgba, err));
}

/* Draws frames of one view until no more comes. */
static stp_draw_stats rest(stp_renderer *r, const stp_view *view, const stp_draw_params *params)
{
    stp_draw_stats stats = {0};
    for (int frame = 0, still = 0; still < 3; frame++) {
        assert_true(frame < FRAMES_LIMIT);
        check_ok(stp_renderer_draw(r, view, params, &stats, err));
        still = stats.chunks_loading == 0 ? still + 1 : 0;
        if (stats.chunks_loading > 0)
            usleep(1000);
    }
    return stats;
}

/* A streaming renderer must come to rest at the picture of one that waits. */
static void check_rest(stp_renderer *streaming, const stp_model *model, const stp_view *view,
                       const stp_draw_params *params, stp_draw_stats *stats)
{
    static uint8_t found[4 * PIXELS], expected[4 * PIXELS];
    stp_renderer *waiting = renderer_of(model);
    stp_draw_params waits = *params;
    waits.stream = false;
    *stats = rest(streaming, view, params);
    read_picture(streaming, found);
    check_ok(stp_renderer_draw(waiting, view, &waits, NULL, err));
    read_picture(waiting, expected);
    assert_memory_equal(found, expected, sizeof found);
    stp_renderer_destroy(&waiting);
}

/* ---- damage ---- */

/* Swaps some bytes near the end of a chunk's first segment with `bytes`. */
static void swap_bytes(const stp_chunk_entry *e, uint8_t bytes[DAMAGE_BYTES])
{
    uint8_t before[DAMAGE_BYTES];
    int file = open(path, O_RDWR);
    off_t at = (off_t)e->offset + e->segment_end[0] - DAMAGE_BYTES - 1; /* of the last block */
    assert_true(file >= 0);
    assert_int_equal(pread(file, before, DAMAGE_BYTES, at), DAMAGE_BYTES);
    assert_int_equal(pwrite(file, bytes, DAMAGE_BYTES, at), DAMAGE_BYTES);
    memcpy(bytes, before, DAMAGE_BYTES);
    close(file);
}

/* A damaged chunk must be read once or twice, not for ever. Then its parent stands for it, and a
 * picture at rest goes on to every other sample. */
static void damage_is_met_once(void **state)
{
    const stp_model *model = *state;
    uint8_t bytes[DAMAGE_BYTES] = {0xa5};
    stp_draw_params params = {.threshold_px = 0.2, .stream = true};
    stp_draw_stats stats;
    uint32_t leaf = model->info->chunk_count - 1;
    stp_view view = look(model, 0.3, 1.0, SIZE, SIZE);
    swap_bytes(&model->entries[leaf], bytes);
    stp_renderer *r = renderer_of(model);
    params.cull = STP_CULL_NONE;
    params.every_sample = true;
    check_rest(r, model, &view, &params, &stats);
    assert_int_equal(stats.chunks_missing, 1);
    assert_false(stats.cut_complete);
    assert_non_null(strstr(stp_renderer_damage(r), "checksum"));
    assert_string_equal(stp_renderer_trouble(r), "");
    assert_true(stp_renderer_bytes_read(r) <= 2 * model->info->file_bytes);
    params = (stp_draw_params){.threshold_px = 2.0, .stream = true, .refine = true};
    stats = rest(r, &view, &params);
    assert_true(stats.passes >= 1);
    assert_true(stp_renderer_bytes_read(r) <= 3 * model->info->file_bytes);
    stp_renderer_destroy(&r);
    swap_bytes(&model->entries[leaf], bytes);
}

/* ---- a server ---- */

typedef struct remote {
    fault_server server;
    stp_model *model;
    stp_renderer *renderer;
} remote;

static void connect_to(remote *x, unsigned stall_ms)
{
    size_t size = 0;
    uint8_t *bytes = fixture_read_file(path, &size);
    assert_true(fault_server_create(&x->server, bytes, size));
    free(bytes);
    const stp_byte_source_params params = {.stall_ms = stall_ms, .tries = 1};
    check_ok(stp_model_open_at(&x->model, x->server.address, &params, err));
    x->renderer = renderer_of(x->model);
}

static void disconnect(remote *x)
{
    stp_renderer_destroy(&x->renderer);
    stp_model_close(&x->model);
    fault_server_destroy(&x->server);
}

static void order(remote *x, fault_kind kind)
{
    fault_server_order(&x->server, &(fault_orders){.kind = kind, .count = UINT32_MAX, .code = 503});
}

/* While the server fails, frames must go on, and no chunk may count as damaged; later all chunks
 * come. */
static void outages_pass(void **state)
{
    static const fault_kind kinds[] = {FAULT_STATUS, FAULT_WHOLE};
    const stp_model *model = *state;
    stp_draw_params params = {.threshold_px = 0.2, .stream = true};
    stp_view view = look(model, 0.3, 0.6, SIZE, SIZE);
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        stp_draw_stats stats = {0};
        remote x;
        connect_to(&x, 2000);
        order(&x, kinds[i]);
        for (int frame = 0; stp_renderer_trouble(x.renderer)[0] == '\0'; frame++) {
            assert_true(frame < FRAMES_LIMIT);
            check_ok(stp_renderer_draw(x.renderer, &view, &params, &stats, err));
            usleep(1000);
        }
        assert_false(stats.cut_complete);
        assert_string_equal(stp_renderer_damage(x.renderer), "");
        order(&x, FAULT_NONE);
        for (int frame = 0; !stats.cut_complete; frame++) {
            assert_true(frame < FRAMES_LIMIT);
            check_ok(stp_renderer_draw(x.renderer, &view, &params, &stats, err));
            usleep(1000);
        }
        assert_string_equal(stp_renderer_trouble(x.renderer), "");
        check_rest(x.renderer, model, &view, &params, &stats);
        disconnect(&x);
    }
}

/* The linker puts this before the clock (CMakeLists.txt): it goes ahead by leaps. */
static _Atomic double leaps_s;

double __real_stp_clock_seconds(void);
double __wrap_stp_clock_seconds(void);

double __wrap_stp_clock_seconds(void)
{
    return __real_stp_clock_seconds() + leaps_s;
}

/* One frame of a view at rest, and a while of which nothing is read. */
static void rest_a_frame(stp_renderer *r, const stp_view *view, stp_draw_stats *stats)
{
    const stp_draw_params params = {.threshold_px = 0.2, .stream = true};
    check_ok(stp_renderer_draw(r, view, &params, stats, err));
    if (stats->chunks_loading > 0)
        usleep(1000);
    else
        leaps_s = leaps_s + 0.1;
}

/* However long the server was away, and though the camera rests, its return is noticed soon. */
static void a_return_is_noticed_soon(void **state)
{
    stp_view view = look(*state, 0.3, 0.6, SIZE, SIZE);
    stp_draw_stats stats = {0};
    remote x;
    connect_to(&x, 2000);
    order(&x, FAULT_STATUS);
    for (const double until_s = leaps_s + 35.0; leaps_s < until_s;)
        rest_a_frame(x.renderer, &view, &stats);
    assert_true(stp_renderer_trouble(x.renderer)[0] != '\0');
    order(&x, FAULT_NONE);
    const double back_s = leaps_s;
    while (!stats.cut_complete)
        rest_a_frame(x.renderer, &view, &stats);
    assert_true(leaps_s - back_s < 10.0);
    assert_string_equal(stp_renderer_trouble(x.renderer), "");
    disconnect(&x);
}

/* Each second request fails: as long as chunks are missing, the host learns that there is more to
 * draw. */
static void a_server_fails_in_part(void **state)
{
    stp_view view = look(*state, 0.3, 0.6, SIZE, SIZE);
    stp_draw_stats stats = {0};
    remote x;
    connect_to(&x, 2000);
    fault_server_order(
        &x.server,
        &(fault_orders){.kind = FAULT_STATUS, .count = UINT32_MAX, .every = 2, .code = 503});
    for (int frame = 0; !stats.cut_complete; frame++) {
        assert_true(frame < FRAMES_LIMIT);
        rest_a_frame(x.renderer, &view, &stats);
        assert_true(stats.cut_complete || stats.more || stats.chunks_loading > 0 ||
                    stp_renderer_trouble(x.renderer)[0] != '\0');
    }
    disconnect(&x);
}

/* Reads what is left of a group. Returns whether all of it is there. */
static bool read_rest(const remote *x, stp_gather_item *items, size_t count)
{
    bool there = true;
    stp_gather_read(x->model->file, items, count);
    for (size_t i = 0; i < count; i++) {
        there &= items[i].status == STP_OK;
        items[i].out += items[i].got - items[i].begin;
        items[i].begin = items[i].got;
        items[i].status = STP_OK;
    }
    return there;
}

/* A group of blocks takes several requests, of which each second fails: each attempt gets farther
 * than the one before, and nothing is asked for that is of no use. */
static void a_group_gets_farther(void **state)
{
    enum { BLOCKS = 2 };
    (void)state;
    remote x;
    connect_to(&x, 2000);
    for (uint32_t b = 0; b + BLOCKS <= x.model->first_block[x.model->info->chunk_count]; b++) {
        stp_gather_item items[BLOCKS] = {0};
        uint8_t *memory[BLOCKS];
        for (size_t i = 0; i < BLOCKS; i++) {
            items[i].block = &x.model->blocks[b + i];
            items[i].end = stp_block_payload_bytes(items[i].block, 0);
            items[i].out = memory[i] = malloc(items[i].end);
            assert_non_null(memory[i]);
        }
        order(&x, FAULT_STATUS);
        assert_false(read_rest(&x, items, BLOCKS));
        assert_true(fault_server_requests(&x.server) <= BLOCKS);
        fault_server_order(
            &x.server,
            &(fault_orders){.kind = FAULT_STATUS, .count = UINT32_MAX, .every = 2, .code = 503});
        for (int attempt = 0; !read_rest(&x, items, BLOCKS); attempt++)
            assert_true(attempt < BLOCKS * STP_SEGMENT_COUNT);
        for (size_t i = 0; i < BLOCKS; i++)
            free(memory[i]);
    }
    disconnect(&x);
}

/* A picture that waits fails with a sentence, as often as the server does, and not once more. */
static void waiting_fails_and_goes_on(void **state)
{
    static uint8_t found[4 * PIXELS], expected[4 * PIXELS];
    const stp_model *model = *state;
    stp_draw_params params = {.threshold_px = 0.2};
    stp_view view = look(model, 0.3, 0.6, SIZE, SIZE);
    stp_error error = {0};
    remote x;
    connect_to(&x, 2000);
    order(&x, FAULT_STATUS);
    assert_int_equal(stp_renderer_draw(x.renderer, &view, &params, NULL, &error), STP_IO);
    assert_non_null(strstr(error.message, "503"));
    order(&x, FAULT_NONE);
    check_ok(stp_renderer_draw(x.renderer, &view, &params, NULL, err));
    read_picture(x.renderer, found);
    stp_renderer *local = renderer_of(model);
    check_ok(stp_renderer_draw(local, &view, &params, NULL, err));
    read_picture(local, expected);
    assert_memory_equal(found, expected, sizeof found);
    stp_renderer_destroy(&local);
    disconnect(&x);
}

/* If a server is silent for minutes, neither new models nor the program's end may wait for it. */
static void silence_holds_nothing_up(void **state)
{
    const stp_model *const models[] = {*state};
    stp_draw_params params = {.threshold_px = 0.2, .stream = true};
    stp_view view = look(models[0], 0.3, 0.6, SIZE, SIZE);
    stp_draw_stats stats;
    for (int again = 0; again < 2; again++) {
        remote x;
        connect_to(&x, 600000);
        order(&x, FAULT_STALL);
        check_ok(stp_renderer_draw(x.renderer, &view, &params, &stats, err));
        assert_true(stats.chunks_loading > 0);
        if (again == 1) {
            check_ok(stp_renderer_set_models(x.renderer, models, 1, err));
            check_rest(x.renderer, models[0], &view, &params, &stats);
            assert_true(stats.cut_complete);
        }
        disconnect(&x);
    }
}

/* ---- no memory ---- */

/* The linker puts these functions before those that read and decode blocks (CMakeLists.txt). A read
 * may be slow, so that a picture asks for the next block before it has this one. A decoder may run
 * out of memory, also after a while. */
#define SLOW_READ_US 20000
#define SLOW_FAILURE_US 200000
static atomic_bool reads_are_slow, next_decode_fails;

uint64_t __real_stp_gather_read(stp_chunk_file *file, stp_gather_item *items, size_t count);
uint64_t __wrap_stp_gather_read(stp_chunk_file *file, stp_gather_item *items, size_t count);
stp_status __real_stp_block_decode(stp_chunk_file *file, const stp_block *block, int finest,
                                   const uint8_t *payload, stp_chunk_scratch *scratch,
                                   stp_chunk **out, stp_error *err);
stp_status __wrap_stp_block_decode(stp_chunk_file *file, const stp_block *block, int finest,
                                   const uint8_t *payload, stp_chunk_scratch *scratch,
                                   stp_chunk **out, stp_error *err);

uint64_t __wrap_stp_gather_read(stp_chunk_file *file, stp_gather_item *items, size_t count)
{
    if (reads_are_slow)
        usleep(SLOW_READ_US);
    return __real_stp_gather_read(file, items, count);
}

stp_status __wrap_stp_block_decode(stp_chunk_file *file, const stp_block *block, int finest,
                                   const uint8_t *payload, stp_chunk_scratch *scratch,
                                   stp_chunk **out, stp_error *err)
{
    if (!atomic_exchange(&next_decode_fails, false))
        return __real_stp_block_decode(file, block, finest, payload, scratch, out, err);
    usleep(SLOW_FAILURE_US);
    return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory to decode chunk %u", block->chunk);
}

/* A waiting picture must fail with a message if one of its chunks fails. The chunk may be one that
 * the picture no longer wants, or one that a streaming picture began to read. The next picture must
 * be complete. */
static void no_memory_ends_a_waiting_picture(void **state)
{
    static uint8_t found[4 * PIXELS], expected[4 * PIXELS];
    stp_draw_params params = {.threshold_px = 0.2};
    stp_view view = look(*state, 0.3, 0.6, SIZE, SIZE);
    stp_renderer *local = renderer_of(*state);
    check_ok(stp_renderer_draw(local, &view, &params, NULL, err));
    read_picture(local, expected);
    stp_renderer_destroy(&local);
    for (int streamed = 0; streamed < 2; streamed++) {
        stp_renderer *r = renderer_of(*state);
        stp_error error = {0};
        reads_are_slow = next_decode_fails = true;
        params.stream = true;
        if (streamed)
            check_ok(stp_renderer_draw(r, &view, &params, NULL, err));
        params.stream = false;
        assert_int_equal(stp_renderer_draw(r, &view, &params, NULL, &error), STP_OUT_OF_MEMORY);
        assert_non_null(strstr(error.message, "no memory to decode chunk"));
        assert_string_equal(stp_renderer_damage(r), "");
        reads_are_slow = false;
        check_ok(stp_renderer_draw(r, &view, &params, NULL, err));
        read_picture(r, found);
        assert_memory_equal(found, expected, sizeof found);
        stp_renderer_destroy(&r);
    }
}

/* A failure in a streaming picture must not fail the waiting picture after it. */
static void no_memory_before_is_old_news(void **state)
{
    stp_draw_params params = {.threshold_px = 0.2, .stream = true};
    stp_view view = look(*state, 0.3, 0.6, SIZE, SIZE);
    stp_renderer *r = renderer_of(*state);
    stp_draw_stats stats;
    next_decode_fails = true;
    for (int frame = 0; next_decode_fails; frame++) {
        assert_true(frame < FRAMES_LIMIT);
        check_ok(stp_renderer_draw(r, &view, &params, NULL, err));
        usleep(1000);
    }
    params.stream = false;
    check_ok(stp_renderer_draw(r, &view, &params, &stats, err));
    assert_true(stats.cut_complete);
    params.stream = true;
    check_rest(r, *state, &view, &params, &stats);
    stp_renderer_destroy(&r);
}

/* ---- a scene ---- */

/* If none of the models can be read any more, drawing says so until there are other models. */
static void no_model_is_left(void **state)
{
    const stp_model *const models[] = {*state};
    stp_draw_params params = {.threshold_px = 1.0};
    stp_view view = look(models[0], 0.3, 0.6, SIZE, SIZE);
    stp_renderer *r = renderer_of(models[0]);
    stp_draw_stats stats;
    stp_pick pick;
    uint8_t bytes[DAMAGE_BYTES] = {0xa5};
    check_ok(stp_renderer_draw(r, &view, &params, NULL, err));
    swap_bytes(&models[0]->entries[0], bytes);
    assert_int_equal(stp_renderer_set_models(r, models, 1, NULL), STP_IO);
    assert_int_equal(stp_renderer_set_models(r, models, 1, NULL), STP_CORRUPT);
    assert_int_equal(stp_renderer_draw(r, &view, &params, NULL, NULL), STP_IO);
    check_ok(stp_renderer_pick(r, SIZE / 2, SIZE / 2, &pick, err));
    assert_false(pick.hit);
    assert_false(stp_renderer_has_news(r));
    assert_int_equal(stp_renderer_memory(r).gpu_used, 0);
    assert_string_equal(stp_renderer_damage(r), "");
    swap_bytes(&models[0]->entries[0], bytes);
    check_ok(stp_renderer_set_models(r, models, 1, err));
    params.stream = true;
    check_rest(r, models[0], &view, &params, &stats);
    stp_renderer_destroy(&r);
}

/* A scene that holds one model as often as it can must draw the picture of one. */
static void one_model_many_times(void **state)
{
    const stp_model *models[32];
    stp_draw_params params = {.threshold_px = 1.0, .stream = true};
    stp_view view = look(*state, 0.3, 1.0, SIZE, SIZE);
    stp_renderer *r = renderer_of(*state);
    stp_draw_stats stats;
    for (int i = 0; i < 32; i++)
        models[i] = *state;
    check_ok(stp_renderer_set_models(r, models, 32, err));
    check_rest(r, *state, &view, &params, &stats);
    params.hidden_models = UINT32_MAX ^ UINT32_C(1) << 31;
    check_ok(stp_renderer_draw(r, &view, &params, &stats, err));
    check_ok(stp_renderer_draw(r, &view, &params, &stats, err));
    params.hidden_models = UINT32_MAX;
    stats = rest(r, &view, &params);
    assert_int_equal(stats.chunks_drawn, 0);
    assert_true(stats.cut_complete);
    stp_renderer_destroy(&r);
}

/* ---- changes at each frame ---- */

/* Size, road, reconstruction and shading change: no frame may fail, and at rest the picture is the
 * usual one. */
static void all_changes_each_frame(void **state)
{
    static const int sizes[][2] = {{SIZE, SIZE}, {1, 1}, {1, 300}, {301, 1}, {64, 65}, {2, 3}};
    stp_renderer *r = renderer_of(*state);
    stp_draw_stats stats;
    for (int i = 0; i < 24; i++) {
        const int *size = sizes[i % 6];
        stp_view view = look(*state, 0.1 * i, 0.6, size[0], size[1]);
        stp_draw_params params = {.lod = (stp_lod)(i % 4),
                                  .reconstruct = (stp_reconstruct)(i % (STP_RECONSTRUCT_LAST + 1)),
                                  .shade = (stp_shade)(i % 8),
                                  .threshold_px = i % 5 == 0 ? 64.0 : 0.1 * (i % 5),
                                  .fade = i % 2 * 0.7,
                                  .stream = i % 7 != 0,
                                  .refine = i % 5 == 1,
                                  .keep_pixels = i % 3 == 1};
        view.orthographic = i % 9 == 8;
        check_ok(stp_renderer_draw(r, &view, &params, &stats, err));
    }
    stp_draw_params params = {.threshold_px = 0.3, .stream = true};
    stp_view view = look(*state, 0.3, 0.6, SIZE, SIZE);
    check_rest(r, *state, &view, &params, &stats);
    assert_true(stats.cut_complete);
    stp_renderer_destroy(&r);
}

/* Invalid parameters must be refused with a message, and the last picture stays. */
static void nonsense_is_refused(void **state)
{
    static const double fades[] = {NAN, -0.1, 1.0, 2.0, INFINITY};
    static const int sizes[][2] = {{1 << 30, 8}, {8, 40000}, {0, 8}, {8, -1}};
    static uint8_t before[4 * PIXELS], after[4 * PIXELS];
    stp_renderer *r = renderer_of(*state);
    stp_view view = look(*state, 0.3, 0.6, SIZE, SIZE);
    check_ok(stp_renderer_draw(r, &view, &(stp_draw_params){0}, NULL, err));
    read_picture(r, before);
    for (size_t i = 0; i < sizeof fades / sizeof *fades; i++) {
        stp_draw_params params = {.stream = true, .fade = fades[i]};
        assert_int_equal(stp_renderer_draw(r, &view, &params, NULL, NULL), STP_INVALID_ARGUMENT);
    }
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        stp_view wrong = view;
        wrong.width = sizes[i][0];
        wrong.height = sizes[i][1];
        assert_int_equal(stp_renderer_draw(r, &wrong, &(stp_draw_params){0}, NULL, NULL),
                         STP_LIMIT);
    }
    read_picture(r, after);
    assert_memory_equal(before, after, sizeof before);
    stp_renderer_destroy(&r);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    stp_model *model = NULL;
    model_fixture_build(path, &(model_recipe){.shape = GEN_BUMPY, .point_count = 200000});
    check_ok(stp_model_open(&model, path, err));
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate(damage_is_met_once, model),
        cmocka_unit_test_prestate(outages_pass, model),
        cmocka_unit_test_prestate(a_return_is_noticed_soon, model),
        cmocka_unit_test_prestate(a_server_fails_in_part, model),
        cmocka_unit_test_prestate(a_group_gets_farther, model),
        cmocka_unit_test_prestate(waiting_fails_and_goes_on, model),
        cmocka_unit_test_prestate(silence_holds_nothing_up, model),
        cmocka_unit_test_prestate(no_memory_ends_a_waiting_picture, model),
        cmocka_unit_test_prestate(no_memory_before_is_old_news, model),
        cmocka_unit_test_prestate(no_model_is_left, model),
        cmocka_unit_test_prestate(one_model_many_times, model),
        cmocka_unit_test_prestate(all_changes_each_frame, model),
        cmocka_unit_test_prestate(nonsense_is_refused, model),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stp_model_close(&model);
    stp_gl_context_destroy(&context);
    return failed;
}

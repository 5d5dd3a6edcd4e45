/* Tests what a renderer asks of a server: how many requests, how many bytes at a time, and that it
 * gives up what nobody wants any longer. */
#include "runtime/stream/gather.h"
#include "runtime/stream/stream.h"
#include "tests/fixtures/chunk_fixture.h"
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/support/fault_server.h"

#include <errno.h>
#include <sys/stat.h>
#include <unistd.h>

enum { SIZE = 160, FRAMES_LIMIT = 10000, STALL_MS = 600000 };

static const char path[] = "requests.stipple";
static fault_server server;
static stp_model *model;

static void order(fault_kind kind)
{
    fault_server_order(&server, &(fault_orders){.kind = kind, .count = UINT32_MAX});
}

static int open_model(void **state)
{
    (void)state;
    const stp_byte_source_params params = {.stall_ms = STALL_MS, .tries = 1};
    order(FAULT_NONE);
    check_ok(stp_model_open_at(&model, server.address, &params, err));
    return 0;
}

static int close_model(void **state)
{
    (void)state;
    stp_model_close(&model);
    return 0;
}

/* ---- groups ---- */

static stp_gather_item item_of(const stp_block *block, const atomic_bool *unwanted)
{
    stp_gather_item item = {.block = block, .unwanted = unwanted};
    item.end = stp_block_payload_bytes(block, 0);
    item.out = calloc(item.end, 1);
    assert_non_null(item.out);
    return item;
}

static void check_bytes(const stp_gather_item *item)
{
    uint8_t *alone = malloc(item->end);
    assert_non_null(alone);
    check_ok(stp_block_fetch(model->file, item->block, 0, item->end, alone, err));
    assert_memory_equal(item->out, alone, item->end);
    free(alone);
}

/* The parts of the root lie side by side. */
static void a_block_is_one_request(void **state)
{
    (void)state;
    stp_gather_item item = item_of(&model->blocks[0], NULL);
    assert_true(item.end > 0 && item.end < STP_SOURCE_REQUEST_BYTES &&
                item.block->parts[1].bytes > 0);
    order(FAULT_NONE);
    assert_true(stp_gather_read(model->file, &item, 1) >= item.end);
    assert_int_equal(fault_server_requests(&server), 1);
    assert_int_equal(item.status, STP_OK);
    assert_int_equal(item.got, item.end);
    check_bytes(&item);
    free(item.out);
}

/* Reads three blocks that lie far from each other. Returns the number of requests. */
static unsigned read_far_blocks(stp_model *m)
{
    stp_gather_item items[3];
    const uint32_t count = m->first_block[m->info->chunk_count];
    for (uint32_t i = 0; i < 3; i++)
        items[i] = item_of(&m->blocks[i * (count - 1) / 2], NULL);
    assert_false(stp_gather_joins(m->file, &items[0], &items[1]));
    assert_false(stp_gather_joins(m->file, &items[1], &items[2]));
    stp_gather_read(m->file, items, 3);
    const unsigned requests = fault_server_requests(&server);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(items[i].status, STP_OK);
        check_bytes(&items[i]);
        free(items[i].out);
    }
    return requests;
}

/* They are read at once, if the server takes that. */
static void far_blocks_are_one_request(void **state)
{
    (void)state;
    for (int takes = 0; takes < 2; takes++) {
        stp_model *own = NULL;
        order(FAULT_NONE);
        check_ok(stp_model_open_at(&own, server.address, NULL, err));
        fault_server_order(&server, &(fault_orders){.kind = takes ? FAULT_NONE : FAULT_WHOLE,
                                                    .count = UINT32_MAX,
                                                    .apart = true});
        const unsigned requests = read_far_blocks(own);
        assert_int_equal(fault_server_apart(&server), 1);
        assert_true(takes ? requests == 1 : requests > 3);
        stp_model_close(&own);
    }
}

/* A request is given up only if none of its blocks is wanted. */
static void unwanted_blocks_are_not_read(void **state)
{
    const atomic_bool yes = true, no = false;
    (void)state;
    for (int wanted = 0; wanted < 2; wanted++) {
        const stp_block *second = &model->blocks[0];
        stp_gather_item items[2] = {item_of(second, &yes), item_of(second, wanted ? &no : &yes)};
        order(FAULT_NONE);
        stp_gather_read(model->file, items, 2);
        assert_int_equal(fault_server_requests(&server), wanted);
        for (int i = 0; i < 2; i++) {
            assert_int_equal(items[i].status, wanted ? STP_OK : STP_CANCELLED);
            assert_int_equal(items[i].got, wanted ? items[i].end : 0);
            if (wanted)
                check_bytes(&items[i]);
            free(items[i].out);
        }
    }
}

/* ---- frames ---- */

static stp_view look(bool away)
{
    stp_view view;
    stp_camera camera = stp_camera_around(&model->ball, (stp_dvec3){0.3, 0.3, 1.0},
                                          (stp_dvec3){0.0, 1.0, 0.0}, 45.0, SIZE, SIZE);
    if (away)
        camera.look = stp_dvec3_add(camera.eye, stp_dvec3_sub(camera.eye, camera.look));
    check_ok(stp_view_create(&view, &camera, &model->ball, SIZE, SIZE, err));
    return view;
}

static stp_draw_stats draw(stp_renderer *r, bool away, stp_lod lod)
{
    const stp_view view = look(away);
    const stp_draw_params params = {.lod = lod, .threshold_px = 1e6, .stream = true};
    stp_draw_stats stats;
    check_ok(stp_renderer_draw(r, &view, &params, &stats, err));
    usleep(1000);
    return stats;
}

/* Asks a server for all samples that never sends more than half of a range. Returns how many
 * requests are in flight. */
static unsigned ask_in_vain(stp_renderer *r)
{
    unsigned before = 0, count = 0;
    order(FAULT_STALL_BODY);
    for (int frame = 0, still = 0; still < 100; frame++) {
        assert_true(frame < FRAMES_LIMIT);
        draw(r, false, STP_LOD_FULL);
        count = fault_server_requests(&server);
        still = count > 0 && count == before ? still + 1 : 0;
        before = count;
    }
    return count;
}

/* What the camera leaves is given up: the frames come to rest although the server is silent, and
 * nothing more is asked for. What the camera sees again is read, and nothing counts as trouble. */
static void what_the_camera_leaves_is_given_up(void **state)
{
    const stp_renderer_params params = {.model = model, .thread_count = 2};
    stp_renderer *r = NULL;
    (void)state;
    order(FAULT_NONE);
    check_ok(stp_renderer_create(&r, &params, err));
    for (int frame = 0; !draw(r, false, STP_LOD_CPU).cut_complete; frame++)
        assert_true(frame < FRAMES_LIMIT);
    const unsigned count = ask_in_vain(r);
    assert_int_equal(count, STP_STREAM_READERS_LIMIT);
    assert_true(2 * fault_server_bytes(&server) <= (uint64_t)count * STP_SOURCE_REQUEST_BYTES);
    for (int frame = 0; draw(r, true, STP_LOD_FULL).chunks_loading > 0; frame++)
        assert_true(frame < FRAMES_LIMIT);
    assert_int_equal(fault_server_requests(&server), count);
    assert_string_equal(stp_renderer_trouble(r), "");
    order(FAULT_NONE);
    for (int frame = 0; !draw(r, false, STP_LOD_FULL).cut_complete; frame++)
        assert_true(frame < FRAMES_LIMIT);
    assert_string_equal(stp_renderer_damage(r), "");
    stp_renderer_destroy(&r);
}

/* A picture asks for blocks before it compiles programs: if these do not compile, blocks still
 * come, and a picture with programs that compile finds them. */
static void blocks_are_asked_for_before_programs_compile(void **state)
{
    static const char folder[] = "requests_shaders", broken[] = "requests_shaders/resolve.frag";
    const stp_renderer_params params = {.model = model, .shader_folder = folder, .thread_count = 2};
    const stp_view view = look(false);
    (void)state;
    order(FAULT_NONE);
    for (int streams = 0; streams < 2; streams++) {
        const stp_draw_params drawn = {.threshold_px = 0.1, .stream = streams};
        stp_renderer *r = NULL;
        assert_true(mkdir(folder, 0700) == 0 || errno == EEXIST);
        fixture_write_file(broken, "broken", 6);
        check_ok(stp_renderer_create(&r, &params, err));
        const uint64_t roots = stp_renderer_bytes_read(r);
        assert_int_equal(stp_renderer_draw(r, &view, &drawn, NULL, NULL), STP_GL);
        for (int i = 0; stp_renderer_bytes_read(r) == roots; i++) {
            assert_true(i < FRAMES_LIMIT);
            usleep(10000);
        }
        assert_int_equal(unlink(broken), 0);
        stp_draw_stats stats = {0};
        for (int frame = 0; !stats.cut_complete; frame++) {
            assert_true(frame < FRAMES_LIMIT);
            check_ok(stp_renderer_draw(r, &view, &drawn, &stats, err));
        }
        stp_renderer_destroy(&r);
    }
    assert_int_equal(rmdir(folder), 0);
}

/* ---- wants ---- */

/* Reads blocks that lie apart. Returns the number of requests. */
static unsigned requests_of_wants(fault_kind kind)
{
    stp_model *own = NULL;
    stp_scene scene;
    stp_stream *stream = NULL;
    stp_want wants[STP_STREAM_WANTS_LIMIT];
    size_t count = 0, fetched = 0;
    order(FAULT_NONE);
    check_ok(stp_model_open_at(&own, server.address, NULL, err));
    fault_server_order(&server, &(fault_orders){.kind = kind, .count = UINT32_MAX, .apart = true});
    read_far_blocks(own); /* the server is known from then on */
    check_ok(stp_scene_create(&scene, (const stp_model *const[]){own}, 1, err));
    const stp_stream_params params = {
        .scene = &scene, .payload_bytes = 64u << 20, .decoder_count = 1};
    check_ok(stp_stream_create(&stream, &params, err));
    for (uint32_t b = 0; b < scene.block_count; b += 8)
        wants[count++] = (stp_want){.block = b};
    const unsigned before = fault_server_requests(&server);
    stp_stream_want(stream, wants, count);
    while (fetched < count) {
        const uint64_t seen = stp_stream_news_count(stream);
        stp_load *load = stp_stream_next_fetched(stream);
        assert_null(stp_stream_next_done(stream));
        if (load != NULL)
            stp_stream_release(stream, load);
        else
            stp_stream_wait(stream, seen);
        fetched += load != NULL;
    }
    const unsigned requests = fault_server_requests(&server) - before;
    printf("%zu wants: %u requests\n", count, requests);
    assert_true(kind == FAULT_NONE || requests >= count);
    stp_stream_destroy(&stream);
    stp_scene_destroy(&scene);
    stp_model_close(&own);
    return requests;
}

/* If the server takes several ranges in a request, blocks that lie apart come together. */
static void blocks_that_lie_apart_come_together(void **state)
{
    (void)state;
    const unsigned apart = requests_of_wants(FAULT_NONE), alone = requests_of_wants(FAULT_WHOLE);
    assert_true(apart >= STP_STREAM_READERS_LIMIT && 4 * apart < alone);
}

int main(void)
{
    size_t size = 0;
    stp_gl_context *context = gl_fixture_context();
    model_fixture_build(path, &(model_recipe){.shape = GEN_BUMPY, .point_count = 500000});
    uint8_t *bytes = fixture_read_file(path, &size);
    if (!fault_server_create(&server, bytes, size))
        return 1;
    free(bytes);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_block_is_one_request),
        cmocka_unit_test(far_blocks_are_one_request),
        cmocka_unit_test(unwanted_blocks_are_not_read),
        cmocka_unit_test(what_the_camera_leaves_is_given_up),
        cmocka_unit_test(blocks_are_asked_for_before_programs_compile),
        cmocka_unit_test(blocks_that_lie_apart_come_together),
    };
    int failed = cmocka_run_group_tests(tests, open_model, close_model);
    fault_server_destroy(&server);
    stp_gl_context_destroy(&context);
    return failed;
}

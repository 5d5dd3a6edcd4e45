/* Tests the lists that the stream and the cache keep, against plain searches: ranges of memory,
 * payloads, victims, and requests for several blocks at once. */
#include "base/random.h"
#include "runtime/stream/cache/victims.h"
#include "runtime/stream/gather.h"
#include "runtime/stream/payload_store.h"
#include "runtime/stream/stream.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"

enum { CAPACITY = 2000, STEPS = 20000, RANGES_LIMIT = 400, VICTIMS = 500, BLOCKS = 800 };

static uint32_t draw(uint64_t *at, uint32_t count)
{
    return (uint32_t)(stp_random_u64(7, (*at)++) % count);
}

/* ---- ranges ---- */

/* Where the first gap of `count` begins among the elements in use; CAPACITY: nowhere. */
static uint32_t first_fit(const bool *used, uint32_t count)
{
    for (uint32_t begin = 0, run = 0; begin < CAPACITY; begin++) {
        run = used[begin] ? 0 : run + 1;
        if (run == count)
            return begin + 1 - count;
    }
    return CAPACITY;
}

static void mark(bool *used, stp_range range, bool value)
{
    memset(used + range.begin, value, range.count);
}

static void ranges(void **state)
{
    (void)state;
    static bool used[CAPACITY];
    stp_range taken[RANGES_LIMIT];
    size_t count = 0, refused = 0;
    uint64_t at = 0;
    stp_range_pool pool = {.capacity = CAPACITY};
    for (int i = 0; i < STEPS; i++) {
        stp_status status = STP_OK;
        if (count == RANGES_LIMIT || (count > 0 && draw(&at, 100) < 45)) {
            uint32_t k = draw(&at, (uint32_t)count);
            stp_range_pool_give(&pool, taken[k]);
            mark(used, taken[k], false);
            taken[k] = taken[--count];
            continue;
        }
        uint32_t wanted = 1 + draw(&at, 40), begin = first_fit(used, wanted);
        bool found = stp_range_pool_take(&pool, wanted, &taken[count], &status, NULL);
        assert_int_equal(status, STP_OK);
        assert_int_equal(found, begin < CAPACITY);
        refused += !found;
        if (!found)
            continue;
        assert_int_equal(taken[count].begin, begin);
        assert_int_equal(taken[count].count, wanted);
        const uint32_t kept = 1 + draw(&at, wanted);
        if (draw(&at, 3) == 0) {
            stp_range_pool_trim(&pool, &taken[count], kept);
            assert_int_equal(taken[count].count, kept);
        }
        mark(used, taken[count++], true);
    }
    assert_true(refused > 100);
    stp_range_pool_destroy(&pool);
}

/* ---- victims ---- */

static void victims(void **state)
{
    (void)state;
    stp_victim items[VICTIMS];
    stp_victims v = {items, VICTIMS};
    uint64_t at = 1000000;
    for (uint32_t i = 0; i < VICTIMS; i++)
        items[i] = (stp_victim){(float)draw(&at, 100), i, i};
    stp_victims_sort(&v);
    stp_victim last = {.need = -1.0f};
    for (uint32_t i = 0; i < VICTIMS; i++) {
        stp_victim next = stp_victims_take(&v);
        assert_true(next.need > last.need || (next.need == last.need && next.slot > last.slot));
        last = next;
    }
    assert_int_equal(v.count, 0);
}

/* ---- payloads ---- */

static void fill(stp_payload_store *s, uint32_t block, uint32_t bytes, uint32_t expected_known)
{
    stp_range range;
    uint32_t known = 0;
    stp_status status = STP_OK;
    assert_true(stp_payload_store_make(s, block, bytes, &range, &known, &status, NULL));
    assert_int_equal(known, expected_known);
    uint8_t *memory = stp_payload_memory(s, range);
    for (uint32_t i = 0; i < bytes; i++) {
        if (i < known)
            assert_int_equal(memory[i], (block + i) & 255);
        memory[i] = (uint8_t)(block + i);
    }
    stp_payload_store_filled(s, block, bytes);
    assert_int_equal(stp_payload_store_known(s, block), bytes);
}

/* The store has room for ten payloads of three units. */
static void payloads(void **state)
{
    (void)state;
    enum { UNIT = STP_PAYLOAD_UNIT_BYTES, BYTES = 2 * UNIT, ROOM = 10 };
    stp_payload_store s;
    stp_range range;
    uint32_t known;
    stp_status status;
    check_ok(stp_payload_store_create(&s, ROOM * 3 * UNIT, 2 * ROOM + 1, err));
    for (uint32_t b = 0; b < ROOM; b++)
        fill(&s, b, BYTES, 0);
    assert_false(stp_payload_store_make(&s, ROOM, BYTES, &range, &known, &status, NULL));
    assert_int_equal(status, STP_OK);
    for (uint32_t b = 1; b < ROOM; b++)
        stp_payload_store_unpin(&s, b);
    assert_true(stp_payload_store_find(&s, 1, BYTES, &range)); /* used last now */
    stp_payload_store_unpin(&s, 1);
    for (uint32_t b = ROOM; b < 2 * ROOM - 2; b++) { /* 2 to 9 go, in this order; 0 is pinned */
        fill(&s, b, BYTES, 0);
        assert_int_equal(stp_payload_store_known(&s, b - ROOM + 2), 0);
        assert_true(b == 2 * ROOM - 3 || stp_payload_store_known(&s, b - ROOM + 3) == BYTES);
        stp_payload_store_unpin(&s, b);
    }
    assert_int_equal(stp_payload_store_known(&s, 1), BYTES);
    stp_payload_store_discard(&s, 0);
    assert_false(stp_payload_store_find(&s, 0, 1, &range));
    fill(&s, 0, UNIT, 0);
    stp_payload_store_unpin(&s, 0);
    assert_false(stp_payload_store_find(&s, 0, BYTES, &range));
    fill(&s, 0, BYTES, UNIT); /* a longer prefix keeps the shorter one's bytes */
    stp_payload_store_destroy(&s);
}

/* ---- requests ---- */

/* Reads of all items together and of each alone must bring the same bytes. */
static void compare_reads(stp_chunk_file *file, stp_gather_item *items, size_t count)
{
    uint64_t bytes = 0, read;
    for (size_t i = 0; i < count; i++) {
        bytes += items[i].end - items[i].begin;
        items[i].out = calloc(items[i].end - items[i].begin + 1, 1);
        assert_non_null(items[i].out);
    }
    read = stp_gather_read(file, items, count);
    assert_true(read >= bytes);
    for (size_t i = 0; i < count; i++) {
        uint32_t size = items[i].end - items[i].begin;
        uint8_t *alone = calloc(size + 1, 1);
        assert_int_equal(items[i].status, STP_OK);
        check_ok(stp_block_fetch(file, items[i].block, items[i].begin, items[i].end, alone, err));
        assert_memory_equal(items[i].out, alone, size);
        free(alone);
        free(items[i].out);
    }
}

static void requests(void **state)
{
    (void)state;
    static stp_block blocks[BLOCKS];
    stp_gather_item items[STP_GATHER_BLOCKS];
    stp_chunk_file *file = NULL;
    uint64_t at = 2000000;
    size_t joined = 0;
    model_fixture_build("lists.stipple",
                        &(model_recipe){.shape = GEN_BUMPY, .point_count = 600000});
    check_ok(stp_chunk_file_open(&file, "lists.stipple", err));
    uint32_t chunks = stp_chunk_file_get_info(file)->chunk_count, count = 0;
    for (uint32_t i = 0, more; i < chunks; i++, count += more) {
        check_ok(stp_chunk_file_block_count(file, i, &more, err));
        assert_true(count + more <= BLOCKS);
        check_ok(stp_chunk_file_blocks(file, i, &blocks[count], err));
    }
    assert_true(chunks >= 4 && count > chunks);
    for (int round = 0; round < 50; round++) {
        size_t n = 0;
        for (uint32_t i = draw(&at, BLOCKS / 2); i < count && n < STP_GATHER_BLOCKS; i++) {
            int from = (int)draw(&at, 4), to = (int)draw(&at, 3); /* levels there, and wanted */
            uint32_t begin = from < 3 ? stp_block_payload_bytes(&blocks[i], from) : 0;
            uint32_t end = stp_block_payload_bytes(&blocks[i], to);
            if (begin < end)
                items[n++] = (stp_gather_item){.block = &blocks[i], .begin = begin, .end = end};
        }
        for (size_t i = 1; i < n; i++)
            joined += stp_gather_joins(file, &items[i - 1], &items[i]);
        if (n > 0)
            compare_reads(file, items, n);
    }
    assert_true(joined > 0);
    stp_chunk_file_close(&file);
}

/* A read that fails fails for its own blocks only. */
static void failed_request(void **state)
{
    (void)state;
    static uint8_t out[3][64];
    stp_chunk_file *file = NULL;
    check_ok(stp_chunk_file_open(&file, "lists.stipple", err));
    uint64_t size = stp_chunk_file_get_info(file)->file_bytes;
    const stp_block blocks[3] = {{.parts = {{.offset = 4096, .bytes = 64}}},
                                 {.parts = {{.offset = 4200, .bytes = 64}}},
                                 {.parts = {{.offset = size - 10, .bytes = 64}}}};
    stp_gather_item items[3];
    for (int i = 0; i < 3; i++)
        items[i] = (stp_gather_item){.block = &blocks[i], .end = 64, .out = out[i]};
    assert_true(stp_gather_joins(file, &items[1], &items[0]));
    assert_false(stp_gather_joins(file, &items[1], &items[2]));
    stp_gather_read(file, items, 3);
    assert_true(items[0].status == STP_OK && items[1].status == STP_OK);
    assert_int_equal(items[2].status, STP_CORRUPT);
    assert_true(items[2].error.message[0] != '\0');
    stp_chunk_file_close(&file);
}

/* ---- order ---- */

static uint32_t units_of(const stp_scene *scene, uint32_t block)
{
    return stp_block_payload_bytes(&scene->blocks[block], 0) / STP_PAYLOAD_UNIT_BYTES + 1;
}

/* Wants blocks and takes them in this order, as a picture that waits does. Returns how many came.
 */
static size_t take_in_order(stp_stream *stream, const stp_want *wants, size_t count)
{
    uint64_t seen = UINT64_MAX;
    size_t next = 0;
    for (int i = 0; next < count && i < 5000; i++) {
        const uint64_t news = stp_stream_news_count(stream);
        stp_load *load = stp_stream_find(stream, wants[next].block);
        if (load == NULL && news != seen)
            stp_stream_want(stream, wants + next, count - next);
        seen = news;
        if (load == NULL) {
            usleep(1000);
            continue;
        }
        assert_int_equal(load->state, STP_LOAD_FETCHED);
        stp_stream_release(stream, load);
        seen = UINT64_MAX;
        next++;
    }
    return next;
}

/* The last want lies beside the first one and is read with it. In memory it lies where the one
 * between them, the largest, has no room in one piece. */
static void what_is_read_ahead_makes_room(void **state)
{
    (void)state;
    stp_model *model = NULL;
    stp_scene scene;
    stp_stream *stream = NULL;
    uint32_t large = 0, small = 0;
    check_ok(stp_model_open(&model, "lists.stipple", err));
    check_ok(stp_scene_create(&scene, (const stp_model *const[]){model}, 1, err));
    for (uint32_t b = 1; b < scene.block_count; b++)
        large = units_of(&scene, b) > units_of(&scene, large) ? b : large;
    while (units_of(&scene, small) >= units_of(&scene, large) || small == large ||
           small + 1 == large)
        small++;
    const stp_want wants[3] = {{small, 0}, {large, 0}, {small + 1, 0}};
    const uint32_t units =
        units_of(&scene, small) + units_of(&scene, small + 1) + units_of(&scene, large) - 1;
    const stp_stream_params params = {
        .scene = &scene, .payload_bytes = units * STP_PAYLOAD_UNIT_BYTES, .decoder_count = 1};
    check_ok(stp_stream_create(&stream, &params, err));
    assert_int_equal(take_in_order(stream, wants, 3), 3);
    stp_stream_destroy(&stream);
    stp_scene_destroy(&scene);
    stp_model_close(&model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ranges),         cmocka_unit_test(victims),
        cmocka_unit_test(payloads),       cmocka_unit_test(requests),
        cmocka_unit_test(failed_request), cmocka_unit_test(what_is_read_ahead_makes_room),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

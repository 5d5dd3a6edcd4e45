/* Flips every single bit of a chunk file of a million bytes: verify must name each.
 *
 * A whole verify for each of these millions of bits would take days. So the test splits the file
 * into the reader's parts and asserts that each byte is in one part. If opening reads a part, open
 * and verify run for every bit. For a payload segment, the checksum is computed for every bit, and
 * the reader itself runs for some. */
#include "tests/fixtures/flip_fixture.h"

#include "formats/chunk/layout.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>

#include <cmocka.h>

/* The number of bits in each segment for which the reader runs. */
#define READ_BITS 40

typedef struct walk {
    flip_file file;
    stp_pool *pool;
    stp_chunk_file *opened;
    const stp_chunk_file_info *info;
    uint8_t *seen; /* for each byte: how many parts contain it */
    uint64_t bit_count;
} walk;

static void mark(walk *w, uint64_t begin, uint64_t end)
{
    assert_true(begin <= end && end <= w->file.size);
    for (uint64_t i = begin; i < end; i++)
        w->seen[i]++;
}

/* Walks a part that opening reads. */
static void walk_frame(walk *w, uint64_t begin, uint64_t end)
{
    mark(w, begin, end);
    for (uint64_t bit = 8 * begin; bit < 8 * end; bit++, w->bit_count++) {
        stp_error err = {0};
        stp_status status = flip_and_verify(&w->file, bit, w->pool, &err);
        assert_true(status == STP_CORRUPT || (bit < 64 && status == STP_FORMAT) ||
                    (bit >= 64 && bit < 80 && status == STP_VERSION));
        assert_int_equal(strncmp(err.message, w->file.path, strlen(w->file.path)), 0);
        assert_true(bit < 80 || strstr(err.message, "byte"));
    }
}

/* Changes the file under the open reader, which keeps no payloads. */
static void read_flipped(walk *w, uint32_t id, int segment, uint64_t at, uint64_t bit)
{
    stp_error err = {0};
    stp_chunk *chunk = NULL;
    char part[64], place[64];
    snprintf(part, sizeof part, "chunk %u: the checksum of segment %d", id, segment);
    snprintf(place, sizeof place, "at byte %llu)", (unsigned long long)at);
    flip_bit(&w->file, 8 * at + bit, true);
    assert_int_equal(stp_chunk_file_read(w->opened, id, 0, &chunk, &err), STP_CORRUPT);
    assert_non_null(strstr(err.message, part));
    assert_non_null(strstr(err.message, place));
    flip_bit(&w->file, 8 * at + bit, false);
}

static void walk_segment(walk *w, uint32_t id, int segment, uint64_t begin, uint64_t end,
                         uint64_t hash)
{
    const size_t size = (size_t)(end - begin);
    uint8_t *bytes = w->file.bytes + begin;
    mark(w, begin, end);
    assert_true(stp_hash(bytes, size) == hash);
    for (size_t bit = 0; bit < 8 * size; bit++, w->bit_count++) {
        bytes[bit / 8] = (uint8_t)(bytes[bit / 8] ^ 1u << bit % 8);
        bool named = stp_hash(bytes, size) != hash;
        bytes[bit / 8] = (uint8_t)(bytes[bit / 8] ^ 1u << bit % 8);
        assert_true(named);
    }
    for (uint64_t i = 0; i < READ_BITS && size > 0; i++)
        read_flipped(w, id, segment, begin, stp_random_u64(begin, i) % (8 * size));
}

static void walk_chunk(walk *w, uint32_t id)
{
    stp_chunk_entry e;
    stp_chunk *chunk = NULL;
    uint64_t begin;
    assert_int_equal(stp_chunk_file_entry(w->opened, id, &e, NULL), STP_OK);
    begin = e.offset;
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        walk_segment(w, id, s, begin, e.offset + e.segment_end[s], e.segment_hash[s]);
        begin = e.offset + e.segment_end[s];
    }
    assert_int_equal(stp_chunk_file_read(w->opened, id, 0, &chunk, NULL), STP_OK);
    stp_chunk_destroy(&chunk);
}

static void test_all_bits(void **state)
{
    (void)state;
    walk w = {.file = flip_large_file()};
    assert_int_equal(stp_pool_create(&w.pool, 1, NULL), STP_OK);
    assert_int_equal(stp_chunk_file_open(&w.opened, w.file.path, NULL), STP_OK);
    w.info = stp_chunk_file_get_info(w.opened);
    w.seen = calloc(w.file.size, 1);
    assert_non_null(w.seen);
    assert_true(w.file.size > 900000);
    walk_frame(&w, 0, w.info->payloads_begin);
    for (uint32_t id = 0; id < w.info->chunk_count; id++)
        walk_chunk(&w, id);
    walk_frame(&w, w.info->payloads_end, w.file.size);
    for (size_t i = 0; i < w.file.size; i++)
        assert_int_equal(w.seen[i], 1);
    assert_int_equal(w.bit_count, 8 * w.file.size);
    assert_int_equal(flip_verify(w.file.path, w.pool, NULL), STP_OK);
    print_message("%llu bits of %zu bytes: each is named\n", (unsigned long long)w.bit_count,
                  w.file.size);
    free(w.seen);
    stp_chunk_file_close(&w.opened);
    stp_pool_destroy(&w.pool);
    flip_file_close(&w.file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_bits),
    };
    return cmocka_run_group_tests_name("all flips", tests, NULL, fixture_remove_folder);
}

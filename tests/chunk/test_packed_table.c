/* Tests packed tables of blocks: round trips, and what is no table of so many records. */
#include "base/random.h"
#include "formats/chunk/block/packed_table.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <zstd.h>

#define COUNT 1000u

/* Records as files have them: some bytes are alike, checksums are not. */
static uint8_t *make_records(size_t count)
{
    uint8_t *records = malloc(count * STP_BLOCK_BYTES);
    assert_non_null(records);
    for (size_t i = 0; i < count * STP_BLOCK_BYTES; i++)
        records[i] = (uint8_t)(i % STP_BLOCK_BYTES < 36 ? i % STP_BLOCK_BYTES + i / 3000
                                                        : stp_random_u64(1, i));
    return records;
}

static stp_bytes pack(const uint8_t *records, size_t count)
{
    stp_bytes out = {0};
    stp_error err = {0};
    assert_int_equal(stp_table_pack(records, count, &out, &err), STP_OK);
    return out;
}

static void round_trips(void **state)
{
    static const size_t counts[] = {STP_PACKED_LEAST, STP_PACKED_LEAST + 1, COUNT};
    (void)state;
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        stp_error err = {0};
        uint8_t *records = make_records(counts[i]), *found = NULL;
        stp_bytes packed = pack(records, counts[i]);
        assert_true(packed.size < counts[i] * STP_BLOCK_BYTES * 2 / 3);
        assert_int_equal(stp_packed_table_bytes(packed.data, packed.size, counts[i]), packed.size);
        assert_int_equal(stp_table_unpack(packed.data, packed.size, counts[i], &found, &err),
                         STP_OK);
        assert_memory_equal(found, records, counts[i] * STP_BLOCK_BYTES);
        free(found);
        free(packed.data);
        free(records);
    }
}

static void few_records_stay(void **state)
{
    (void)state;
    uint8_t *records = make_records(STP_PACKED_LEAST);
    assert_int_equal(pack(records, STP_PACKED_LEAST - 1).size, 0);
    assert_int_equal(pack(records, 0).size, 0);
    free(records);
}

static void expect_corrupt(const uint8_t *packed, size_t size, uint64_t count)
{
    stp_error err = {0};
    uint8_t *found = NULL;
    assert_int_equal(stp_table_unpack(packed, size, count, &found, &err), STP_CORRUPT);
    assert_non_null(strstr(err.message, "the table of blocks"));
    assert_null(found);
}

static void damage(void **state)
{
    (void)state;
    uint8_t *records = make_records(COUNT);
    stp_bytes packed = pack(records, COUNT);
    expect_corrupt(packed.data, packed.size, COUNT - 1);
    expect_corrupt(packed.data, packed.size, UINT64_MAX / STP_BLOCK_BYTES);
    for (size_t size = 0; size < packed.size; size += size < 40 ? 1 : 997) {
        uint8_t *cut = malloc(size + 1); /* so that a sanitizer sees what is read behind it */
        assert_non_null(cut);
        memcpy(cut, packed.data, size);
        expect_corrupt(cut, size, COUNT);
        free(cut);
    }
    for (size_t at = 0; at < packed.size; at += at < 40 ? 1 : 997) {
        packed.data[at] ^= 1;
        expect_corrupt(packed.data, packed.size, COUNT);
        packed.data[at] ^= 1;
    }
    stp_error err = {0};
    assert_int_equal(stp_bytes_append(&packed, NULL, 1, &err), STP_OK);
    expect_corrupt(packed.data, packed.size, COUNT); /* a byte more */
    free(packed.data);
    free(records);
}

/* A few bytes that ask for much memory: no reader takes them, no writer makes them. */
static void bombs(void **state)
{
    (void)state;
    uint8_t packed[COUNT], *records = calloc(COUNT, STP_BLOCK_BYTES);
    assert_non_null(records);
    assert_int_equal(pack(records, COUNT).size, 0);
    const size_t frame =
        ZSTD_compress(packed + 16, sizeof packed - 16, records, COUNT * STP_BLOCK_BYTES, 12);
    assert_false(ZSTD_isError(frame));
    stp_put_u32(packed, STP_SECTION_PACKED_BLOCKS);
    stp_put_u32(packed + 4, COUNT);
    stp_put_u64(packed + 8, stp_hash(packed + 16, frame));
    assert_int_equal(stp_packed_table_bytes(packed, 16 + frame, COUNT), 16 + frame);
    expect_corrupt(packed, 16 + frame, COUNT);
    free(records);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_trips),
        cmocka_unit_test(few_records_stay),
        cmocka_unit_test(damage),
        cmocka_unit_test(bombs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

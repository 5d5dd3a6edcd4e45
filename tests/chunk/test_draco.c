/* Tests Draco behind its shim: order, duplicates, extremes, invalid streams, and the columns and
 * blocks that use it. */
#include "formats/chunk/codec/table/draco_shim.h"

#include "base/random.h"
#include "formats/chunk/codec/table/table_code.h"
#include "tests/support/draco_cloud_shim.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Encodes and decodes; the values must come back in the same order. */
static void round_trip(const int16_t *values, uint32_t count)
{
    void *stream = NULL;
    size_t bytes = 0;
    stp_error err = {0};
    int16_t *out = malloc(count * sizeof *out);
    assert_non_null(out);
    assert_int_equal(stp_draco_encode(values, count, &stream, &bytes, &err), STP_OK);
    assert_int_equal(stp_stream_check(stream, bytes, &err), STP_OK);
    assert_int_equal(stp_draco_decode(stream, bytes, out, count, &err), STP_OK);
    assert_memory_equal(values, out, count * sizeof *out);
    free(stream);
    free(out);
}

static void test_order(void **state)
{
    (void)state;
    static const uint32_t counts[] = {1, 2, 3, 64, 1000, 65536};
    static const unsigned shifts[] = {0, 8, 12, 15};
    int16_t *values = malloc(65536 * sizeof *values);
    assert_non_null(values);
    for (size_t n = 0; n < sizeof counts / sizeof *counts; n++) {
        for (size_t s = 0; s < sizeof shifts / sizeof *shifts; s++) {
            for (uint32_t i = 0; i < counts[n]; i++)
                values[i] = (int16_t)((int16_t)stp_random_u64(n, i) >> shifts[s]);
            round_trip(values, counts[n]);
        }
    }
    for (uint32_t i = 0; i < 65536; i++) /* every value of 16 bits */
        values[i] = (int16_t)(uint16_t)(i * 40503u);
    round_trip(values, 65536);
    free(values);
}

/* Draco must not merge points with equal values, apart or side by side. */
static void test_duplicates(void **state)
{
    (void)state;
    static const int16_t values[] = {1, 1, 1, 2, 2, 1, 1, -3, 1, 5, 5, 5, 6, 6, 5, 5, 0, 5};
    round_trip(values, sizeof values / sizeof *values);
}

static void test_extremes(void **state)
{
    (void)state;
    static const int16_t values[] = {INT16_MIN, INT16_MAX, 0, -1, INT16_MAX, INT16_MIN, 1};
    for (uint32_t count = 1; count <= sizeof values / sizeof *values; count++)
        round_trip(values, count);
}

/* Any Draco decoder must read a stream as a point cloud if the 25 bytes of SPEC.md come before
 * it. */
static void test_whole(void **state)
{
    (void)state;
    static const unsigned shifts[] = {0, 6, 12, 15}; /* tagged and raw symbols */
    enum { COUNT = 3000 };
    static int16_t values[COUNT], out[COUNT];
    for (size_t s = 0; s < sizeof shifts / sizeof *shifts; s++) {
        uint8_t head[25] = {'D', 'R', 'A',         'C',        'O', 2,    3, 0, 0,
                            0,   0,   COUNT & 255, COUNT >> 8, 0,   0,    1, 1, 4,
                            3,   1,   0,           0,          1,   0xfe, 1};
        void *stream = NULL;
        size_t bytes = 0;
        for (uint32_t i = 0; i < COUNT; i++)
            values[i] = (int16_t)((int16_t)stp_random_u64(s, i) >> shifts[s]);
        assert_int_equal(stp_draco_encode(values, COUNT, &stream, &bytes, NULL), STP_OK);
        uint8_t *whole = malloc(sizeof head + bytes);
        assert_non_null(whole);
        memcpy(whole, head, sizeof head);
        memcpy(whole + sizeof head, stream, bytes);
        assert_int_equal(draco_cloud_read(whole, sizeof head + bytes, out, COUNT), 0);
        assert_memory_equal(values, out, sizeof values);
        free(whole);
        free(stream);
    }
}

static void test_counts(void **state)
{
    (void)state;
    int16_t value = 1;
    void *stream = NULL;
    size_t bytes = 0;
    assert_int_equal(stp_draco_encode(&value, 0, &stream, &bytes, NULL), STP_INVALID_ARGUMENT);
    assert_int_equal(stp_draco_encode(&value, 65537, &stream, &bytes, NULL), STP_INVALID_ARGUMENT);
    assert_int_equal(stp_draco_decode("x", 1, &value, 0, NULL), STP_INVALID_ARGUMENT);
    assert_null(stream);
}

/* Decodes a copy that ends where its memory ends, so that a sanitizer sees reads behind the end. */
static stp_status decode_copy(const uint8_t *stream, size_t bytes, int16_t *out, uint32_t count)
{
    uint8_t *copy = malloc(bytes ? bytes : 1);
    assert_non_null(copy);
    memcpy(copy, stream, bytes);
    stp_status status = stp_stream_check(copy, bytes, NULL);
    if (status == STP_OK)
        status = stp_draco_decode(copy, bytes, out, count, NULL);
    free(copy);
    return status;
}

/* The stream has another count than expected, is cut, or has a changed byte: the result must be an
 * error or other values, never harm. */
static void test_hostile(void **state)
{
    (void)state;
    int16_t values[200];
    int16_t out[201];
    for (unsigned width = 0; width < 16; width += 5) { /* tagged and raw symbols */
        void *stream = NULL;
        size_t bytes = 0;
        for (unsigned i = 0; i < 200; i++)
            values[i] = (int16_t)((int16_t)stp_random_u64(2, i) >> width);
        assert_int_equal(stp_draco_encode(values, 200, &stream, &bytes, NULL), STP_OK);
        uint8_t *changed = malloc(bytes);
        assert_non_null(changed);
        (void)decode_copy(stream, bytes, out, 201);
        for (size_t cut = 0; cut < bytes; cut++)
            (void)decode_copy(stream, cut, out, 200);
        for (size_t i = 0; i < bytes; i++) {
            for (unsigned x = 1; x < 256; x += i < 8 ? 1 : 37) {
                memcpy(changed, stream, bytes);
                changed[i] = (uint8_t)(changed[i] ^ x);
                (void)decode_copy(changed, bytes, out, 200);
            }
        }
        free(changed);
        free(stream);
    }
}

/* Draco would allocate 64 symbols for each remaining byte, so counts above 2^16 must never reach
 * Draco. */
static void test_guard(void **state)
{
    (void)state;
    static const struct {
        stp_status status;
        uint8_t stream[6];
    } cases[] = {
        {STP_OK, {1, 18, 0x80, 0x80, 0x04, 0}},      /* 65536 symbols, raw */
        {STP_CORRUPT, {1, 18, 0x81, 0x80, 0x04, 0}}, /* 65537 */
        {STP_CORRUPT, {1, 18, 0xff, 0xff, 0xff, 1}}, /* a count of four bytes */
        {STP_CORRUPT, {1, 19, 2, 0, 0, 0}},          /* longer symbols than Draco knows */
        {STP_OK, {0, 33, 0, 0, 0, 0}},               /* 33 tags */
        {STP_CORRUPT, {0, 34, 0, 0, 0, 0}},
        {STP_CORRUPT, {2, 2, 0, 0, 0, 0}}, /* unknown coding */
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_int_equal(stp_stream_check(cases[i].stream, 6, NULL), cases[i].status);
    for (size_t size = 0; size < 5; size++)
        assert_int_equal(stp_stream_check(cases[0].stream, size, NULL), STP_CORRUPT);
}

/* ---- columns ---- */

static size_t column_bytes(const int16_t *cells, uint32_t count)
{
    int16_t *out = malloc(count * sizeof *out);
    stp_bytes bytes = {0}, smallest = {0};
    size_t used = 0;
    assert_non_null(out);
    assert_int_equal(stp_column_encode(cells, count, true, &smallest, NULL), STP_OK);
    assert_int_equal(stp_column_decode(smallest.data, smallest.size, out, count, &used, NULL),
                     STP_OK);
    assert_memory_equal(cells, out, count * sizeof *out);
    assert_int_equal(used, smallest.size);
    assert_int_equal(stp_column_encode(cells, count, false, &bytes, NULL), STP_OK);
    /* The size of Draco's table is an estimate, which is off where a column has two cells. */
    assert_true(smallest.size <= bytes.size + (count < 3 ? 4 : 0));
    assert_int_equal(stp_column_decode(bytes.data, bytes.size, out, count, &used, NULL), STP_OK);
    assert_memory_equal(cells, out, count * sizeof *out);
    assert_int_equal(used, bytes.size);
    for (size_t cut = 0; cut < bytes.size; cut += 1 + bytes.size / 64)
        assert_int_equal(stp_column_decode(bytes.data, cut, out, count, &used, NULL), STP_CORRUPT);
    free(smallest.data);
    free(bytes.data);
    free(out);
    return used;
}

/* Tests cells of every magnitude, calm and noisy runs in turn, and extremes among small values. */
static void test_columns(void **state)
{
    (void)state;
    static const uint32_t counts[] = {1, 2, 63, 2999, 3000, 65536};
    int16_t *cells = malloc(65536 * sizeof *cells);
    assert_non_null(cells);
    for (size_t n = 0; n < sizeof counts / sizeof *counts; n++) {
        for (unsigned width = 0; width <= 16; width++) {
            for (uint32_t i = 0; i < counts[n]; i++)
                cells[i] = (int16_t)((int16_t)stp_random_u64(width, i) >> (16 - width));
            column_bytes(cells, counts[n]);
        }
        for (uint32_t i = 0; i < counts[n]; i++)
            cells[i] = (int16_t)((int16_t)stp_random_u64(n, i) >> (15 - i / 100 % 15));
        column_bytes(cells, counts[n]);
        for (uint32_t i = 0; i < counts[n]; i++)
            cells[i] = (int16_t)(i % 77 == 5 ? INT16_MIN : i % 77 == 6 ? INT16_MAX : 2);
        column_bytes(cells, counts[n]);
    }
    free(cells);
}

/* A cell that cannot be predicted may cost its bits and little more, whatever its magnitude. So may
 * cells whose magnitude changes slowly. */
static void test_column_bytes(void **state)
{
    (void)state;
    static int16_t cells[40000];
    double fair = 0.0;
    for (unsigned width = 3; width <= 13; width++) {
        for (uint32_t i = 0; i < 40000; i++)
            cells[i] = (int16_t)((int16_t)stp_random_u64(width, i) >> (16 - width));
        assert_true((double)column_bytes(cells, 40000) < (width + 0.2) * 40000 / 8);
    }
    for (uint32_t i = 0; i < 40000; i++) {
        unsigned width = 4 + i / 1000 % 8;
        cells[i] = (int16_t)((int16_t)stp_random_u64(0, i) >> (16 - width));
        fair += width;
    }
    assert_true((double)column_bytes(cells, 40000) < (fair + 0.3 * 40000) / 8);
}

/* ---- blocks ---- */

static void test_table(void **state)
{
    (void)state;
    int16_t values[4 * 5] = {7, 7, 7, 7, 7, 1, 2, 3, 4, 5, -9, -9, -9, -9, -9, 0, 0, 0, 0, 300};
    int16_t decoded[4 * 5];
    stp_table in = {.values = values, .stride = 5, .column_count = 4, .row_count = 5};
    stp_table out = {.values = decoded, .stride = 5, .column_count = 4, .row_count = 5};
    stp_bytes bytes = {0};
    size_t used = 0;
    assert_int_equal(stp_table_encode(&in, &bytes, NULL), STP_OK);
    assert_int_equal(stp_table_decode(bytes.data, bytes.size, &out, &used, NULL), STP_OK);
    assert_int_equal(used, bytes.size);
    assert_memory_equal(values, decoded, sizeof values);
    for (size_t cut = 0; cut < bytes.size; cut++)
        assert_int_equal(stp_table_decode(bytes.data, cut, &out, &used, NULL), STP_CORRUPT);
    bytes.data[5] |= 1; /* the table has four columns; this mentions another */
    assert_int_equal(stp_table_decode(bytes.data, bytes.size, &out, &used, NULL), STP_CORRUPT);
    free(bytes.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_order),        cmocka_unit_test(test_duplicates),
        cmocka_unit_test(test_extremes),     cmocka_unit_test(test_whole),
        cmocka_unit_test(test_counts),       cmocka_unit_test(test_hostile),
        cmocka_unit_test(test_guard),        cmocka_unit_test(test_columns),
        cmocka_unit_test(test_column_bytes), cmocka_unit_test(test_table),
    };
    return cmocka_run_group_tests_name("draco", tests, NULL, NULL);
}

/* Tests columns coded by odds: every magnitude, kinds, few rows, hostile bytes, and what they cost;
 * and the scan's own scale. */
#include "formats/chunk/codec/odds/cells.h"

#include "base/random.h"
#include "formats/chunk/codec/odds/symbols.h"
#include "formats/chunk/codec/predict/scale.h"
#include "formats/chunk/codec/table/table_code.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define COLUMNS 5u
#define ROWS_MOST 3000u

/* Two columns of numbers, one beside the other; two of kinds; a number beside a kind. */
static const int16_t beside[COLUMNS] = {STP_BESIDE_NONE, 0, STP_BESIDE_KINDS, STP_BESIDE_KINDS, 2};

static stp_table table_of(int16_t *values, uint32_t rows)
{
    return (stp_table){.values = values,
                       .stride = rows,
                       .column_count = COLUMNS,
                       .row_count = rows,
                       .beside = beside,
                       .by_odds = true};
}

/* Encodes and decodes; the cells must come back. Returns the bytes, which the caller frees. */
static stp_bytes round_trip(int16_t *values, uint32_t rows)
{
    int16_t *decoded = calloc((size_t)COLUMNS * rows, sizeof *decoded);
    stp_bytes bytes = {0};
    uint64_t column_bytes[COLUMNS] = {0};
    size_t used = 0;
    assert_non_null(decoded);
    stp_table in = table_of(values, rows), out = table_of(decoded, rows);
    assert_int_equal(stp_table_encode(&in, &bytes, NULL), STP_OK);
    for (int counted = 0; counted < 2; counted++) {
        memset(decoded, 0, (size_t)COLUMNS * rows * sizeof *decoded);
        out.column_bytes = counted ? column_bytes : NULL;
        out.by_odds = false; /* the bytes say it */
        assert_int_equal(stp_table_decode(bytes.data, bytes.size, &out, &used, NULL), STP_OK);
        assert_int_equal(used, bytes.size);
        assert_memory_equal(values, decoded, (size_t)COLUMNS * rows * sizeof *decoded);
    }
    free(decoded);
    return bytes;
}

/* Numbers of `width` bits, now and then an extreme; kinds of any value. */
static void fill(int16_t *values, uint32_t rows, unsigned width)
{
    for (uint32_t i = 0; i < COLUMNS * rows; i++) {
        const uint64_t random = stp_random_u64(width, i);
        const unsigned column = i / rows;
        if (column == 2 || column == 3)
            values[i] = random % 5 ? (int16_t)0 : (int16_t)(int)(random >> 8 & 0xff) - 128;
        else
            values[i] = (int16_t)((int16_t)random >> (16 - width));
        if (column != 2 && column != 3 && random >> 40 == 0)
            values[i] = i % 2 ? INT16_MIN : INT16_MAX;
    }
    values[rows - 1] = INT16_MIN;
}

static void test_cells(void **state)
{
    (void)state;
    static const uint32_t counts[] = {1, 2, 3, 63, 64, 300, ROWS_MOST};
    static int16_t values[COLUMNS * ROWS_MOST];
    for (size_t n = 0; n < sizeof counts / sizeof *counts; n++) {
        for (unsigned width = 1; width <= 16; width++) {
            fill(values, counts[n], width);
            free(round_trip(values, counts[n]).data);
        }
    }
    memset(values, 0, sizeof values);
    free(round_trip(values, 70).data);
}

/* A number that cannot be predicted costs its bits and little more, even in a short table. */
static void test_bytes(void **state)
{
    (void)state;
    static int16_t values[COLUMNS * ROWS_MOST];
    for (unsigned width = 3; width <= 13; width++) {
        for (uint32_t rows = 100; rows <= ROWS_MOST; rows *= 30) {
            for (uint32_t i = 0; i < COLUMNS * rows; i++) {
                const int wide = (int16_t)stp_random_u64(width, i);
                values[i] = (int16_t)(i / rows > 1 ? 0 : wide >> (16 - width));
            }
            stp_bytes bytes = round_trip(values, rows);
            assert_true((double)bytes.size < 50 + (width + 0.5) * 2 * rows / 8);
            free(bytes.data);
        }
    }
}

/* Cut, extended or changed bytes: an error or other cells, and nothing is read beyond the end. */
static void test_hostile(void **state)
{
    (void)state;
    static int16_t values[COLUMNS * 200], decoded[COLUMNS * 200];
    size_t used = 0;
    fill(values, 200, 9);
    stp_bytes bytes = round_trip(values, 200);
    stp_table out = table_of(decoded, 200);
    for (size_t cut = 0; cut < bytes.size; cut++) {
        uint8_t *copy = malloc(cut + 1);
        assert_non_null(copy);
        memcpy(copy, bytes.data, cut);
        if (cut >= 4)
            stp_put_u32(copy, (uint32_t)cut - 4); /* it says that it is whole */
        assert_int_equal(stp_table_decode(copy, cut, &out, &used, NULL), STP_CORRUPT);
        free(copy);
    }
    for (size_t i = 4; i < bytes.size; i++) {
        for (unsigned bit = 0; bit < 8; bit++) {
            bytes.data[i] ^= (uint8_t)(1u << bit);
            (void)stp_table_decode(bytes.data, bytes.size, &out, &used, NULL);
            bytes.data[i] ^= (uint8_t)(1u << bit);
        }
    }
    bytes.data[4 + 8] = 24; /* the first mean of the first column */
    assert_int_equal(stp_table_decode(bytes.data, bytes.size, &out, &used, NULL), STP_CORRUPT);
    out.beside = NULL; /* a table that cannot have odds */
    assert_int_equal(stp_table_decode(bytes.data, bytes.size, &out, &used, NULL), STP_CORRUPT);
    free(bytes.data);
}

/* ---- scale ---- */

#define POINTS 60u

/* A patch of points that are multiples of 0.01, off by `off`, on a lattice of 2^-8. */
static void fill_patch(stp_patch *patch, stp_sample *samples, double off)
{
    *patch = (stp_patch){.exponent = -8, .origin = {-1000, 70000, 3}, .counts = {POINTS, 15, 4, 1}};
    for (uint32_t i = 0; i < POINTS; i++) {
        for (int a = 0; a < 3; a++) {
            const double start = ceil((patch->origin[a] / 256.0 - off) / 0.01);
            const double place = start + (double)(stp_random_u64((uint64_t)a, i) % 3000);
            samples[i].position[a] =
                (uint16_t)(lround((place * 0.01 + off) * 256.0) - patch->origin[a]);
        }
    }
}

static void test_scale(void **state)
{
    (void)state;
    static stp_sample samples[POINTS];
    stp_patch patch;
    uint32_t begin[2] = {0, POINTS};
    stp_chunk chunk = {
        .patch_count = 1, .patches = &patch, .level_begin = {begin}, .samples = {samples}};
    stp_scale scale;
    for (int k = 0; k < 7; k++) {
        fill_patch(&patch, samples, 0.0013 * k);
        stp_scale_find(&chunk, &scale);
        assert_true(fabs(scale.step - 0.01) < 1e-12);
        const stp_patch_scale s = stp_scale_of_patch(&scale, &patch);
        assert_true(s.used);
        for (uint32_t i = 0; i < POINTS; i++)
            for (int a = 0; a < 3; a++)
                assert_int_equal(
                    stp_scale_position(&s, a, stp_scale_place(&s, a, samples[i].position[a])),
                    samples[i].position[a]);
    }
    samples[7].position[1]++; /* one that is no multiple */
    stp_scale_find(&chunk, &scale);
    assert_true(scale.step == 0.0);
    assert_false(stp_scale_of_patch(&scale, &patch).used);
}

/* A patch takes a scale only if its lattice is finer than that, and not by too much. */
static void test_scale_of_patch(void **state)
{
    (void)state;
    const stp_scale scale = {.step = 0.01, .phase = {0, 7, 65535}};
    for (int exponent = -200; exponent <= 200; exponent++) {
        const stp_patch patch = {.exponent = (int16_t)exponent,
                                 .origin = {INT32_MIN, 0, INT32_MAX}};
        const stp_patch_scale s = stp_scale_of_patch(&scale, &patch);
        assert_int_equal(s.used, exponent <= -7 && exponent >= -18);
        for (int a = 0; a < 3 && s.used; a++) {
            assert_in_range(stp_scale_place(&s, a, 65535), 0, 65536);
            assert_in_range(stp_scale_position(&s, a, 65535), 0, 65535);
            assert_in_range(stp_scale_position(&s, a, 0), 0, 65535);
        }
    }
}

/* The bytes of a table keep the scale; a step that is none is refused. */
static void test_scale_bytes(void **state)
{
    (void)state;
    static const double bad[] = {0.0, -1.0, 1e16, INFINITY, NAN};
    int16_t values[COLUMNS * 2] = {0}, decoded[COLUMNS * 2];
    stp_table in = table_of(values, 2), out = table_of(decoded, 2);
    stp_bytes bytes = {0};
    size_t used = 0;
    in.scale = (stp_scale){.step = 0.001, .phase = {1, 2, 65535}};
    assert_int_equal(stp_table_encode(&in, &bytes, NULL), STP_OK);
    assert_int_equal(stp_table_decode(bytes.data, bytes.size, &out, &used, NULL), STP_CORRUPT);
    out.may_scale = true;
    assert_int_equal(stp_table_decode(bytes.data, bytes.size, &out, &used, NULL), STP_OK);
    assert_true(out.scale.step == in.scale.step);
    assert_memory_equal(out.scale.phase, in.scale.phase, sizeof in.scale.phase);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        stp_put_f64(bytes.data + 12, bad[i]);
        assert_int_equal(stp_table_decode(bytes.data, bytes.size, &out, &used, NULL), STP_CORRUPT);
    }
    free(bytes.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cells),          cmocka_unit_test(test_bytes),
        cmocka_unit_test(test_hostile),        cmocka_unit_test(test_scale),
        cmocka_unit_test(test_scale_of_patch), cmocka_unit_test(test_scale_bytes),
    };
    return cmocka_run_group_tests_name("odds", tests, NULL, NULL);
}

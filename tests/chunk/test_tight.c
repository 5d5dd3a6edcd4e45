/* Tests tight parts: any block comes back, other parts are not tight, tables cost next to nothing
 * beside their cells, and hostile bytes are refused. */
#include "formats/chunk/codec/odds/tight.h"

#include "formats/chunk/codec/predict/predict.h"
#include "formats/chunk/sample/patch.h"
#include "tests/fixtures/any_chunk.h"

#include <math.h>

/* In the fourth byte: states are not short. */
#define LONG_MARK 6

static stp_bytes encoded(stp_chunk *chunk, int segment)
{
    stp_bytes bytes = {0};
    chunk->is_block = true;
    assert_int_equal(stp_segment_encode(chunk, segment, STP_CODEC_DRACO, &bytes, NULL), STP_OK);
    return bytes;
}

static bool is_tight(stp_chunk *chunk, int segment)
{
    stp_bytes bytes = encoded(chunk, segment);
    const bool tight = stp_is_tight(bytes.data, bytes.size);
    free(bytes.data);
    return tight;
}

static void any_blocks_come_back(void **state)
{
    (void)state;
    static const uint32_t counts[] = {1, 2, 3, 70, 300};
    static const unsigned most[] = {1, 4, 5, 64};
    stp_chunk_scratch scratch = {0};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++)
        for (size_t m = 0; m < sizeof most / sizeof *most; m++)
            for (int kind = 0; kind < 3; kind++) {
                stp_chunk *chunk = any_chunk(counts[c], most[m], 10 * c + m, kind);
                assert_true(is_tight(chunk, 0));
                chunk->linked = kind == 0;
                any_chunk_round_trip(chunk, STP_CODEC_DRACO, &scratch);
                stp_chunk_destroy(&chunk);
            }
    stp_chunk_scratch_free(&scratch);
}

/* Long tables, strips and chunks without blocks are as they were. */
static void others_are_not_tight(void **state)
{
    (void)state;
    for (uint32_t count = 1499; count <= 1500; count++) {
        stp_chunk *chunk = any_chunk(count, 1, 5, 1);
        for (int s = 0; s < STP_SEGMENT_COUNT; s++)
            assert_int_equal(is_tight(chunk, s), count < 1500);
        stp_chunk_destroy(&chunk);
    }
    stp_chunk *chunk = any_chunk(9, 1, 5, 1);
    stp_bytes bytes = {0};
    assert_int_equal(stp_segment_encode(chunk, 0, STP_CODEC_DRACO, &bytes, NULL), STP_OK);
    assert_false(stp_is_tight(bytes.data, bytes.size));
    free(bytes.data);
    chunk->patches[8].flags |= STP_PATCH_STRIP;
    assert_false(is_tight(chunk, 0));
    assert_true(is_tight(chunk, 1));
    stp_chunk_destroy(&chunk);
}

/* A level whose samples are all as predicted costs two states of two bytes and a bit or two a
 * column. */
static void constants_cost_nothing(void **state)
{
    (void)state;
    stp_chunk *chunk = any_chunk(200, 1, 6, 2);
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        memset(chunk->patches[p].radius, 0, sizeof chunk->patches[p].radius);
    stp_bytes bytes = encoded(chunk, 1);
    assert_in_range(bytes.size, 7, 7 + STP_SAMPLE_COLUMN_COUNT * 2 / 8 + 1);
    free(bytes.data);
    stp_chunk_destroy(&chunk);
}

/* Items of one lane behind items of both: a reader could not tell whose the words are, so the
 * states are not short. Else they are. Both come back, and cost what the items are worth. */
static void lanes_may_be_uneven(void **state)
{
    (void)state;
    for (unsigned alone = 0; alone < 30; alone++) {
        stp_tight_writer w = {0};
        stp_tight_reader r;
        stp_bytes bytes = {0};
        assert_int_equal(stp_symbols_reserve(&w.symbols, 200, NULL), STP_OK);
        for (uint32_t i = 0; i < 100 + alone; i++)
            stp_symbol_put_bits(&w.symbols, i < 100 && i % 2, 77 * i + 1, 16);
        assert_int_equal(stp_symbols_write_known(&w.symbols, &bytes, NULL), STP_OK);
        assert_true(stp_is_tight(bytes.data, bytes.size));
        assert_true(stp_symbols_are_sized(bytes.data, bytes.size, true));
        assert_int_equal((bytes.data[3] & 7) == LONG_MARK, alone >= 3);
        assert_in_range(bytes.size, 2 * (100 + alone), 2 * (100 + alone) + (alone < 3 ? 8 : 16));
        assert_int_equal(stp_tight_read(&r, bytes.data, bytes.size, NULL), STP_OK);
        for (uint32_t i = 0; i < 100 + alone; i++)
            assert_int_equal(stp_symbol_get_bits(&r.symbols, i < 100 && i % 2, 16),
                             (uint16_t)(77 * i + 1));
        assert_int_equal(stp_tight_end(&r, NULL), STP_OK);
        free(bytes.data);
        stp_tight_clear(&w);
    }
}

/* How many bytes states have: only what a writer may say is one. */
static void sizes_are_checked(void **state)
{
    (void)state;
    for (unsigned sizes = 0; sizes < 256; sizes++) {
        const uint8_t head[4] = {0, 0, 0, (uint8_t)sizes};
        const unsigned more = sizes & 7u, others = sizes >> 3 & 7u;
        const bool is_short = more >= 1 && more <= 5;
        const bool is_long = more == LONG_MARK && others >= 1 && others <= 5;
        assert_int_equal(stp_symbols_are_sized(head, 4, true),
                         sizes >> 6 == 0 && (is_short || is_long));
        assert_int_equal(stp_symbols_are_sized(head, 4, false), sizes >> 6 == 1 && is_short);
        assert_false(stp_symbols_are_sized(head, 3, true));
    }
}

/* ---- hostile ---- */

static stp_status decoded(const uint8_t *bytes, size_t size, int segment, stp_chunk *out,
                          stp_error *err)
{
    stp_chunk_scratch scratch = {0};
    uint8_t *exact = malloc(size + 1); /* so that a sanitizer sees reads behind the end */
    assert_non_null(exact);
    memcpy(exact + 1, bytes, size);
    const stp_status status =
        stp_segment_decode(exact + 1, size, segment, STP_CODEC_DRACO, 0, out, &scratch, err);
    stp_chunk_scratch_free(&scratch);
    free(exact);
    return status;
}

/* Cut and longer parts are refused; changed ones do no harm. */
static void damage_is_refused(void **state)
{
    (void)state;
    stp_chunk *chunk = any_chunk(5, 9, 3, 0), *out = NULL;
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        stp_bytes bytes = encoded(chunk, s);
        out = any_chunk_empty_like(chunk);
        for (int before = 0; before < s; before++) {
            stp_bytes whole = encoded(chunk, before);
            assert_int_equal(decoded(whole.data, whole.size, before, out, NULL), STP_OK);
            free(whole.data);
        }
        for (size_t cut = 0; cut < bytes.size; cut++)
            assert_int_equal(decoded(bytes.data, cut, s, out, NULL), STP_CORRUPT);
        for (size_t bit = 0; bit < 8 * bytes.size; bit++) {
            bytes.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
            (void)decoded(bytes.data, bytes.size, s, out, NULL);
            bytes.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
        }
        assert_int_equal(stp_bytes_append(&bytes, NULL, 4, NULL), STP_OK);
        assert_int_equal(decoded(bytes.data, bytes.size, s, out, NULL), STP_CORRUPT);
        free(bytes.data);
        stp_chunk_destroy(&out);
    }
    stp_chunk_destroy(&chunk);
}

/* Reads a table of level 0 that begins with this shift, scale and way of its first column. */
static stp_status head_status(unsigned shift, double step, unsigned how, stp_error *err)
{
    stp_tight_writer w = {0};
    stp_tight_reader r;
    stp_bytes bytes = {0};
    int16_t cells[STP_SAMPLE_COLUMN_COUNT] = {0}, beside[STP_SAMPLE_COLUMN_COUNT] = {0};
    stp_table table = {.values = cells,
                       .stride = 1,
                       .column_count = STP_SAMPLE_COLUMN_COUNT,
                       .row_count = 1,
                       .may_shift = true,
                       .may_scale = true,
                       .beside = beside,
                       .tight_first = stp_tight_elder,
                       .known = stp_known_level(false, 0, false)};
    const stp_scale scale = {.step = step};
    uint8_t scale_bytes[STP_SCALE_BYTES];
    stp_scale_write(&scale, scale_bytes);
    assert_int_equal(stp_symbols_reserve(&w.symbols, 50, NULL), STP_OK);
    stp_symbol_put_bits(&w.symbols, 0, shift, 4);
    stp_symbol_put_bits(&w.symbols, 0, 1, 1);
    for (size_t i = 0; i < STP_SCALE_BYTES; i += 2)
        stp_symbol_put_bits(&w.symbols, 0, stp_get_u16(scale_bytes + i), 16);
    for (unsigned c = 0; c < STP_SAMPLE_COLUMN_COUNT; c++) {
        stp_odds odds;
        stp_known_begin(table.known[STP_KNOWN_COUNT * c + STP_KNOWN_HOW + (c > 0)], &odds);
        stp_symbol_put(&w.symbols, 0, &odds, 5, c == 0 ? how : 1, 0, 0);
    }
    assert_int_equal(stp_symbols_write_known(&w.symbols, &bytes, NULL), STP_OK);
    assert_int_equal(stp_tight_read(&r, bytes.data, bytes.size, NULL), STP_OK);
    stp_status status = stp_tight_get(&r, &table, err);
    if (status == STP_OK)
        status = stp_tight_end(&r, err);
    free(bytes.data);
    stp_tight_clear(&w);
    return status;
}

static void wrong_heads_are_refused(void **state)
{
    (void)state;
    stp_error err = {0};
    assert_int_equal(head_status(11, 0.01, 1, &err), STP_OK);
    assert_int_equal(head_status(12, 0.01, 1, &err), STP_CORRUPT);
    assert_non_null(strstr(err.message, "shifted by 12 bits"));
    static const double steps[] = {0.0, -1.0, 1e16, (double)NAN};
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
        assert_int_equal(head_status(0, steps[i], 1, &err), STP_CORRUPT);
        assert_non_null(strstr(err.message, "a scale of"));
    }
    for (unsigned how = 3; how < STP_ODDS_SYMBOLS; how++) {
        assert_int_equal(head_status(0, 0.01, how, &err), STP_CORRUPT);
        assert_non_null(strstr(err.message, "in no known way"));
    }
}

/* In a part that is not tight, the mask's bit of tight tables needs that of middles. */
static void bit_needs_middles(void **state)
{
    (void)state;
    stp_error err = {0};
    stp_chunk *chunk = any_chunk(1500, 1, 3, 0), *back = any_chunk_empty_like(chunk);
    stp_bytes bytes = encoded(chunk, 0);
    back->is_block = true;
    assert_int_equal(bytes.data[4 + 6] & 128u, 128u); /* bit 55 */
    bytes.data[4 + 7] &= 254u;                        /* bit 56 */
    assert_int_equal(decoded(bytes.data, bytes.size, 0, back, &err), STP_CORRUPT);
    assert_non_null(strstr(err.message, "columns it lacks"));
    free(bytes.data);
    stp_chunk_destroy(&back);
    stp_chunk_destroy(&chunk);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_blocks_come_back),    cmocka_unit_test(others_are_not_tight),
        cmocka_unit_test(constants_cost_nothing),  cmocka_unit_test(lanes_may_be_uneven),
        cmocka_unit_test(sizes_are_checked),       cmocka_unit_test(damage_is_refused),
        cmocka_unit_test(wrong_heads_are_refused), cmocka_unit_test(bit_needs_middles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

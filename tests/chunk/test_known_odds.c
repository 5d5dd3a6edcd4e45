/* Tests known odds: the lists of numbers are sound, parts have them, and rows are
 * told by their parents. */
#include "formats/chunk/codec/odds/known_odds.h"

#include "base/memory.h"
#include "formats/chunk/codec/odds/tight.h"
#include "formats/chunk/codec/predict/predict.h"
#include "formats/chunk/sample/patch.h"
#include "tests/fixtures/any_chunk.h"

static void curves_are_odds(const uint8_t *columns, unsigned count)
{
    for (unsigned i = 0; i < count * STP_KNOWN_COUNT; i++) {
        stp_odds odds;
        stp_known_begin(columns[i], &odds);
        assert_int_equal(odds.below[0], 0);
        for (unsigned s = 0; s < STP_ODDS_SYMBOLS; s++)
            assert_in_range(stp_odds_of(&odds, s), 4, STP_ODDS_ALL);
    }
}

static void all_curves_are_odds(void **state)
{
    (void)state;
    for (int squares = 0; squares < 2; squares++) {
        curves_are_odds(stp_known_patches(squares), STP_LINKED_PATCH_COLUMN_COUNT);
        curves_are_odds(stp_known_vertices(squares), STP_SAMPLE_COLUMN_COUNT);
        for (int level = 0; level < STP_LEVEL_COUNT - 1; level++)
            for (int last = 0; last < 2; last++)
                curves_are_odds(stp_known_level(squares, level, last), STP_SAMPLE_COLUMN_COUNT);
        assert_ptr_equal(stp_known_level(squares, 2, false),
                         stp_known_vertices(squares) + STP_SAMPLE_COLUMN_COUNT * STP_KNOWN_COUNT);
    }
    /* Tables of squares alone follow each other in the list: 11, 2, 3 and 3 columns. */
    assert_ptr_equal(stp_known_squares(),
                     stp_known_level(true, 0, true) + STP_SAMPLE_COLUMN_COUNT * STP_KNOWN_COUNT);
    assert_ptr_equal(stp_known_ladder(), stp_known_squares() + 11 * STP_KNOWN_COUNT);
    assert_ptr_equal(stp_known_colours(false), stp_known_ladder() + 2 * STP_KNOWN_COUNT);
    assert_ptr_equal(stp_known_colours(true), stp_known_colours(false) + 3 * STP_KNOWN_COUNT);
    curves_are_odds(stp_known_squares(), 11 + 2 + 3 + 3);
}

static void parts_have_them(void **state)
{
    (void)state;
    stp_chunk *chunk = any_chunk(20, 64, 3, 0);
    chunk->is_block = true;
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        stp_bytes bytes = {0};
        assert_int_equal(stp_segment_encode(chunk, s, STP_CODEC_DRACO, &bytes, NULL), STP_OK);
        assert_true(stp_symbols_are_sized(bytes.data, bytes.size, true));
        assert_false(stp_symbols_are_sized(bytes.data, bytes.size, false));
        free(bytes.data);
    }
    stp_chunk_destroy(&chunk);
}

/* Elder children have 3 to 1 siblings behind them, last ones none; the parent tells fit and closed.
 */
static void rows_are_told_by_parents(void **state)
{
    (void)state;
    stp_chunk *chunk = any_chunk(3, 64, 5, 0);
    stp_corner *corners = NULL;
    uint8_t elder[200], last[200], told_elder[200], told_last[200];
    uint32_t counts[2];
    for (int level = 0; level < STP_LEVEL_COUNT - 1; level++) {
        unsigned e = 0, l = 0;
        stp_predict_row_counts(chunk, level, &counts[0], &counts[1]);
        stp_predict_row_kinds(chunk, level, NULL, elder, last);
        for (uint32_t p = 0; p < chunk->patch_count; p++)
            for (unsigned j = 0; j < chunk->patches[p].counts[level + 1]; j++) {
                const unsigned count = chunk->patches[p].counts[level + 1];
                const unsigned finer = chunk->patches[p].counts[level];
                const unsigned children = stp_level_children_begin(j + 1, count, finer) -
                                          stp_level_children_begin(j, count, finer);
                const unsigned flags =
                    chunk->samples[level + 1][chunk->level_begin[level + 1][p] + j].flags;
                const unsigned kind = (flags >> 6) * 4 + (flags >> 3 & 1u) * 16;
                for (unsigned left = children - 1; left > 0; left--)
                    assert_int_equal(elder[e++], kind + left);
                assert_int_equal(last[l++], kind);
            }
        assert_int_equal(e, counts[0]);
        assert_int_equal(l, counts[1]);
    }
    /* Corners that are not told have no row. */
    assert_int_equal(stp_alloc(&corners, chunk->level_begin[0][3], sizeof *corners, "", NULL),
                     STP_OK);
    corners[0].ago = 1;
    const bool alone = chunk->patches[0].counts[0] == 1;
    stp_predict_row_kinds(chunk, 0, corners, told_elder, told_last);
    stp_predict_row_kinds(chunk, 0, NULL, elder, last);
    stp_predict_row_counts(chunk, 0, &counts[0], &counts[1]);
    assert_memory_equal(told_elder, elder + !alone, counts[0] - !alone);
    assert_memory_equal(told_last, last + alone, counts[1] - alone);
    free(corners);
    stp_chunk_destroy(&chunk);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_curves_are_odds),
        cmocka_unit_test(parts_have_them),
        cmocka_unit_test(rows_are_told_by_parents),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

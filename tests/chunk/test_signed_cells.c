/* Tests odds by signed cells: the lists of numbers are sound, any cells come back, signs pay, and
 * only tables that may have them are told that they do. */
#include "formats/chunk/codec/odds/tight.h"

#include "formats/chunk/codec/predict/predict.h"
#include "formats/chunk/codec/table/part_tables.h"
#include "tests/fixtures/any_chunk.h"

#define ROWS 1400u
#define COLUMNS STP_SAMPLE_COLUMN_COUNT

static void curves_are_odds(void **state)
{
    (void)state;
    stp_odds odds[STP_SIGNED_BESIDE];
    const uint8_t *expected = stp_signed_column(STP_LEVEL_COUNT - 2, 0);
    for (int level = STP_LEVEL_COUNT - 2; level >= 0; level--)
        for (unsigned c = 0; c < COLUMNS; c++) {
            const unsigned width = stp_signed_width(c);
            assert_ptr_equal(stp_signed_column(level, c), expected);
            expected += width;
            stp_signed_cells(stp_signed_column(level, c), width, odds);
            for (unsigned i = 0; i < width; i++) {
                assert_int_equal(odds[i].below[0], 0);
                for (unsigned s = 0; s < STP_ODDS_SYMBOLS; s++)
                    assert_in_range(stp_odds_of(&odds[i], s), 4, STP_ODDS_ALL);
            }
        }
}

/* Elder children of families of four: 3, 2, 1 siblings follow. */
static stp_table elder_table(const int16_t *beside, int level, int16_t *cells, uint8_t *kinds)
{
    for (uint32_t i = 0; i < ROWS; i++)
        kinds[i] = (uint8_t)(3 - i % 3);
    return (stp_table){.values = cells,
                       .stride = ROWS,
                       .column_count = COLUMNS,
                       .row_count = ROWS,
                       .tight = true,
                       .may_shift = true,
                       .may_sign = true,
                       .level = level,
                       .beside = beside,
                       .tight_first = stp_tight_elder,
                       .known = stp_known_level(false, level, false),
                       .row_kinds = kinds};
}

static stp_bytes written(const stp_table *table)
{
    stp_tight_writer w = {0};
    stp_bytes bytes = {0};
    assert_int_equal(stp_tight_put(&w, table, NULL), STP_OK);
    assert_int_equal(stp_symbols_write_known(&w.symbols, &bytes, NULL), STP_OK);
    stp_tight_clear(&w);
    return bytes;
}

static stp_status got(const stp_bytes *bytes, stp_table *table, stp_error *err)
{
    stp_tight_reader r;
    assert_int_equal(stp_tight_read(&r, bytes->data, bytes->size, NULL), STP_OK);
    const stp_status status = stp_tight_get(&r, table, err);
    return status == STP_OK ? stp_tight_end(&r, err) : status;
}

/* Cells of any size, or, if bits is 0, the sign of each is that of its elder sibling turned. Some
 * columns are constant. Returns the bytes they take by signed cells and without. */
static void round_trip(int level, unsigned bits, uint64_t constant, size_t sizes[2])
{
    static const int16_t beside[COLUMNS] = {-1, -2, -2, -1, 3, -1, 5, 6, -1, -1, 9, 10};
    static int16_t cells[COLUMNS * ROWS], back[COLUMNS * ROWS];
    uint8_t kinds[ROWS];
    for (uint32_t i = 0; i < COLUMNS * ROWS; i++) {
        const uint64_t random = stp_random_u64(bits, i);
        const int turned = i % ROWS % 3 == 0 ? (int)(random & 2u) - 1 : cells[i - 1] < 0 ? 1 : -1;
        const int any = (int16_t)(random >> 8) >> (16 - bits % 17);
        cells[i] = (int16_t)(bits > 0 ? any : turned * (1 + (int)(random >> 8 & 1u)));
        if (i / ROWS == STP_COLUMN_FLAGS || i / ROWS == STP_COLUMN_CLASS)
            cells[i] = (int16_t)((int16_t)((uint16_t)cells[i] << 8) >> 8);
        if (constant >> (i / ROWS) & 1u)
            cells[i] = 3;
    }
    for (int is_signed = 0; is_signed < 2; is_signed++) {
        stp_table table = elder_table(beside, level, cells, kinds);
        table.is_signed = is_signed;
        stp_bytes bytes = written(&table);
        sizes[is_signed] = bytes.size;
        table.values = back;
        table.is_signed = !is_signed;
        memset(back, 7, sizeof back);
        assert_int_equal(got(&bytes, &table, NULL), STP_OK);
        assert_int_equal(table.is_signed, is_signed);
        assert_memory_equal(back, cells, sizeof back);
        free(bytes.data);
    }
}

static void any_cells_come_back(void **state)
{
    (void)state;
    size_t sizes[2];
    for (int level = 0; level < STP_LEVEL_COUNT - 1; level++)
        for (unsigned bits = 1; bits <= 16; bits++)
            round_trip(level, bits, bits % 3 ? 0 : UINT64_C(0x5a5) << bits % 5, sizes);
}

/* In two rows of three the signs of seven columns follow from those before: a tenth of that, at
 * least, is learned at level 0. */
static void signs_pay(void **state)
{
    (void)state;
    size_t sizes[2];
    round_trip(0, 0, 0, sizes);
    assert_in_range(sizes[1], 1000, sizes[0] - 7 * ROWS * 2 / 3 / 8 / 10);
}

static void others_are_not_signed(void **state)
{
    (void)state;
    static const int16_t beside[COLUMNS] = {-1, -2, -2, -1, 3, -1, 5, 6, -1, -1, 9, 10};
    static int16_t cells[COLUMNS * ROWS];
    uint8_t kinds[ROWS];
    stp_error err = {0};
    stp_table table = elder_table(beside, 1, cells, kinds);
    table.is_signed = true;
    stp_bytes bytes = written(&table);
    assert_int_equal(got(&bytes, &table, &err), STP_OK);
    table.may_sign = false;
    assert_int_equal(got(&bytes, &table, &err), STP_CORRUPT);
    assert_non_null(strstr(err.message, "shifted by 13 bits"));
    free(bytes.data);
}

/* Elder children of points, unless corners were told before. */
static void tables_may_be_signed(void **state)
{
    (void)state;
    stp_chunk *chunk = any_chunk(3, STP_PATCH_SAMPLES, 1, 0);
    chunk->is_block = true;
    for (int i = 0; i < 3; i++) {
        stp_level_tables tables = {0};
        tables.corners.of = i == 2 ? calloc(1, sizeof *tables.corners.of) : NULL;
        assert_int_equal(stp_level_tables_create(chunk, 0, i == 1, &tables, NULL), STP_OK);
        assert_int_equal(tables.elder.may_sign, i == 0);
        assert_false(tables.last.may_sign);
        stp_level_tables_destroy(&tables);
    }
    stp_chunk_destroy(&chunk);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(curves_are_odds),
        cmocka_unit_test(any_cells_come_back),
        cmocka_unit_test(signs_pay),
        cmocka_unit_test(others_are_not_signed),
        cmocka_unit_test(tables_may_be_signed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

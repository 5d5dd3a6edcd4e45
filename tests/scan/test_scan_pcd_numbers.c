/* Tests the attributes of PCD files: every type, COUNT, encoding, and values that do not fit. */
#include "tests/fixtures/numbers_fixture.h"
#include "tests/fixtures/scan/pcd_fixture.h"

#define POINTS 1700u

#define COLUMN(name, type, size, values)                                                           \
    {                                                                                              \
        name, type, size, 1, values                                                                \
    }

static void write_as(const pcd_file *file, pcd_encoding encoding, const char *path)
{
    byte_row bytes = pcd_make(file, encoding);
    scan_fixture_bytes(path, bytes.data, bytes.size);
    bytes_free(&bytes);
}

static const struct {
    const char *name, *type;
    char letter;
    unsigned size;
    double low, high;
} kinds[] = {
    {"a", "u8", 'U', 1, 0.0, 255.0},
    {"b", "i8", 'I', 1, -128.0, 127.0},
    {"c", "u16", 'U', 2, 0.0, 65535.0},
    {"d", "i16", 'I', 2, -32768.0, 32767.0},
    {"e", "u32", 'U', 4, 0.0, 4294967295.0},
    {"f", "i32", 'I', 4, -2147483648.0, 2147483647.0},
    {"g", "u64", 'U', 8, 0.0, 9007199254740992.0},
    {"h", "i64", 'I', 8, -9007199254740992.0, 9007199254740992.0},
    {"i", "f32", 'F', 4, -16777216.0, 16777216.0},
    {"j", "f64", 'F', 8, -1e300, 1e300},
};
#define KINDS (sizeof kinds / sizeof *kinds)

/* Every type with its extremes, a field of three values, an intensity and a label that a sample has
 * in 8 bits, padding, and points that are rejected between the others. */
static void every_type(void **state)
{
    (void)state;
    static double values[KINDS][POINTS], xs[POINTS], many[3 * POINTS], wide[POINTS], pad[POINTS];
    pcd_column columns[KINDS + 8] = {{"_", 'U', 1, 1, pad}, COLUMN("x", 'F', 8, xs)};
    for (unsigned i = 0; i < POINTS; i++) {
        xs[i] = i % 7 == 3 ? (double)NAN : i;
        wide[i] = 300.0 * i;
        for (unsigned k = 0; k < 3; k++)
            many[3 * i + k] = 1000.0 * k + i;
        for (size_t k = 0; k < KINDS; k++) {
            const double share = (double)(i % 5) / 4.0; /* both extremes, exactly */
            values[k][i] = kinds[k].letter == 'F'
                               ? kinds[k].low * share
                               : floor(kinds[k].low + (kinds[k].high - kinds[k].low) * share);
        }
    }
    size_t count = 2;
    for (size_t k = 0; k < KINDS; k++)
        columns[count++] =
            (pcd_column)COLUMN(kinds[k].name, kinds[k].letter, kinds[k].size, values[k]);
    columns[count++] = (pcd_column){"many", 'I', 4, 3, many};
    columns[count++] = (pcd_column)COLUMN("y", 'F', 4, wide);
    columns[count++] = (pcd_column)COLUMN("z", 'F', 4, wide);
    columns[count++] = (pcd_column)COLUMN("Intensity", 'F', 4, wide);
    columns[count++] = (pcd_column)COLUMN("label", 'U', 4, wide);
    const pcd_file file = {columns, count, POINTS, 1, NULL};
    for (int e = 0; e < PCD_ENCODING_COUNT; e++) {
        write_as(&file, (pcd_encoding)e, "types.pcd");
        numbers n = numbers_read("types.pcd", NULL);
        assert_int_equal(n.list.count, KINDS + 5);
        assert_string_equal(n.left_out, "");
        for (size_t k = 0; k < KINDS; k++)
            numbers_expect_type(&n, kinds[k].name, kinds[k].type);
        for (unsigned i = 0; i < POINTS; i++) {
            assert_true(isnan(n.points[i].position.x) ? i % 7 == 3 : n.points[i].position.x == i);
            for (size_t k = 0; k < KINDS; k++)
                numbers_expect(&n, kinds[k].name, i, values[k][i]);
            numbers_expect(&n, "many_0", i, i);
            numbers_expect(&n, "many_1", i, 1000.0 + i);
            numbers_expect(&n, "many_2", i, 2000.0 + i);
            numbers_expect(&n, "Intensity", i, 300.0 * i);
            numbers_expect(&n, "label", i, 300.0 * i);
        }
        numbers_free(&n);
    }
}

/* Intensities and labels of one byte are in the sample; a second x would hide the position; a field
 * that does not fit as a whole is left out, and so are names that are taken. */
static void what_is_none(void **state)
{
    (void)state;
    static double zeros[100];
    const pcd_column columns[] = {
        COLUMN("x", 'F', 4, zeros),
        COLUMN("y", 'F', 4, zeros),
        COLUMN("z", 'F', 4, zeros),
        COLUMN("intensity", 'U', 1, zeros),
        COLUMN("label", 'U', 1, zeros),
        COLUMN("x", 'F', 4, zeros),
        COLUMN("ring", 'U', 2, zeros),
        COLUMN("ring", 'U', 2, zeros),
        {"shot_352", 'F', 4, 65, zeros},
        COLUMN("b_1", 'U', 1, zeros),
        {"b", 'U', 1, 2, zeros},
        COLUMN("curvature", 'F', 4, zeros),
        COLUMN("a_name_of_forty-eight_characters_or_more_of_them", 'F', 4, zeros),
    };
    const pcd_file file = {columns, sizeof columns / sizeof *columns, 1, 1, NULL};
    for (int e = 0; e < PCD_ENCODING_COUNT; e++) {
        write_as(&file, (pcd_encoding)e, "none.pcd");
        numbers n = numbers_read("none.pcd", NULL);
        assert_int_equal(n.list.count, 3);
        assert_string_equal(n.list.items[0].name, "ring");
        assert_string_equal(n.list.items[1].name, "b_1");
        assert_string_equal(n.list.items[2].name, "curvature");
        assert_string_equal(n.left_out, "x, ring, shot_352, b, a_name_of_forty-eight_characters_or_"
                                        "more_of_them");
        numbers_free(&n);
    }
}

#define HEAD                                                                                       \
    "VERSION .7\nFIELDS x y z v\nSIZE 4 4 4 %u\nTYPE F F F %c\nWIDTH 1\nHEIGHT 1\nDATA ascii\n"    \
    "1 2 3 %s\n"

static void write_text(char type, unsigned size, const char *text)
{
    char bytes[400];
    snprintf(bytes, sizeof bytes, HEAD, size, type, text);
    scan_fixture_text("text.pcd", bytes);
}

/* All 64 bits of whole numbers in text, and texts that are no such number. */
static void numbers_in_text(void **state)
{
    (void)state;
    static const struct {
        char type;
        unsigned size;
        const char *text;
        uint64_t word;
    } good[] = {
        {'U', 8, "18446744073709551615", UINT64_MAX},
        {'I', 8, "-9223372036854775808", (uint64_t)INT64_MIN},
        {'I', 8, "9223372036854775807", (uint64_t)INT64_MAX},
        {'I', 1, "-128", (uint64_t)-128},
        {'U', 1, "+255", 255},
        {'U', 4, "1e+06", 1000000},
        {'I', 2, "-3.0", (uint64_t)-3},
        {'U', 2, "-0", 0},
        {'F', 4, "0.1", 0x3DCCCCCD},
        {'F', 8, "-inf", 0xFFF0000000000000},
    };
    static const struct {
        char type;
        unsigned size;
        const char *text;
    } bad[] = {
        {'U', 1, "256"},
        {'U', 1, "-1"},
        {'I', 1, "128"},
        {'I', 1, "-129"},
        {'U', 4, "0.5"},
        {'U', 4, "nan"},
        {'I', 8, "9223372036854775808"},
        {'I', 8, "-9223372036854775809"},
        {'U', 8, "18446744073709551616"},
        {'U', 4, "inf"},
        {'F', 4, "many"},
        {'I', 4, "-"},
        {'I', 4, "--1"},
    };
    const stp_scan_params params = {.numbers = true};
    stp_scan_info info;
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        write_text(good[i].type, good[i].size, good[i].text);
        numbers n = numbers_read("text.pcd", NULL);
        if (numbers_word(&n, "v", 0) != good[i].word)
            fail_msg("%s is %llx", good[i].text, (unsigned long long)numbers_word(&n, "v", 0));
        numbers_free(&n);
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        write_text(bad[i].type, bad[i].size, bad[i].text);
        scan_fixture_fails("text.pcd", &params, STP_CORRUPT, "is not a number that fits field `v`");
        free(scan_fixture_read("text.pcd", NULL, &info)); /* nobody asked for the field */
    }
}

/* Counts of values that no record has: a sentence, and no memory. */
static void hostile_counts(void **state)
{
    (void)state;
    static const char *const counts[] = {"1000000000", "18446744073709551615", "4194305"};
    const stp_scan_params params = {.numbers = true};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        char text[300];
        snprintf(text, sizeof text,
                 "VERSION .7\nFIELDS x y z v\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 %s\n"
                 "WIDTH 1\nHEIGHT 1\nDATA binary\n",
                 counts[i]);
        scan_fixture_text("count.pcd", text);
        scan_fixture_fails("count.pcd", &params, STP_LIMIT, "records of more than");
    }
}

/* Cut anywhere, each encoding fails with a sentence. */
static void cut_anywhere(void **state)
{
    (void)state;
    static const double v[] = {1, 2, 3, 4, 5, 6};
    const pcd_column columns[] = {COLUMN("x", 'F', 4, v),
                                  COLUMN("y", 'F', 4, v),
                                  COLUMN("z", 'F', 4, v),
                                  {"pair", 'U', 2, 2, v},
                                  COLUMN("time", 'F', 8, v)};
    const pcd_file file = {columns, 5, 3, 1, NULL};
    for (int e = PCD_BINARY; e < PCD_ENCODING_COUNT; e++) {
        byte_row bytes = pcd_make(&file, (pcd_encoding)e);
        const stp_scan_params params = {.numbers = true};
        scan_fixture_expect_cuts("cut.pcd", bytes.data, bytes.size, &params);
        bytes_free(&bytes);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type),      cmocka_unit_test(what_is_none),
        cmocka_unit_test(numbers_in_text), cmocka_unit_test(hostile_counts),
        cmocka_unit_test(cut_anywhere),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

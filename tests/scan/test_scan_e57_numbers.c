/* Tests the attributes of E57 files: every kind of field, states that are invalid, scans with other
 * fields. */
#include "base/random.h"
#include "tests/fixtures/numbers_fixture.h"
#include "tests/fixtures/scan/e57_fixture.h"

#define POINTS 1300u
#define XYZ                                                                                        \
    E57_FLOAT("cartesianX", "single")                                                              \
    E57_FLOAT("cartesianY", "single") E57_FLOAT("cartesianZ", "single")

static void add_positions(e57_stream *streams, size_t count)
{
    for (size_t i = 0; i < count; i++)
        for (int axis = 0; axis < 3; axis++)
            bytes_float(&streams[axis].bytes, (float)i);
}

/* Adds a scan of these bytestreams and frees them. */
static void add_scan(e57_file *file, e57_stream *streams, size_t count, uint64_t records,
                     const char *prototype)
{
    e57_vector(file, streams, count, true);
    e57_scan(file, "", records, prototype);
    for (size_t i = 0; i < count; i++)
        bytes_free(&streams[i].bytes);
}

static void write_file(e57_file *file, const char *path)
{
    e57_end(file, "");
    e57_write(path, file);
    e57_free(file);
}

/* What the standard and extensions have, in packets that are out of step. Records whose position is
 * not valid keep the others aligned. */
static void fields_of_a_scanner(void **state)
{
    (void)state;
    e57_file file;
    e57_stream s[12] = {
        [3] = {.part = 41}, [4] = {.part = 97}, [5] = {.part = 13}, [6] = {.part = 5}};
    add_positions(s, POINTS);
    for (unsigned i = 0; i < POINTS; i++) {
        bytes_bits(&s[3].bytes, i % 5000, 13);
        bytes_bits(&s[4].bytes, i % 3, 2);
        bytes_double(&s[5].bytes, i * 0.001);
        bytes_bits(&s[6].bytes, i % 1000, 10);
        bytes_float(&s[7].bytes, 0.1f * (float)i);
        bytes_bits(&s[8].bytes, i % 4 == 1, 1);
        bytes_bits(&s[9].bytes, i, 64);
        bytes_float(&s[11].bytes, -0.5f * (float)i);
    }
    e57_begin(&file);
    add_scan(
        &file, s, 12, POINTS,
        XYZ E57_INTEGER("rowIndex", "100", "5099") E57_INTEGER("returnIndex", "-1", "1")
            E57_FLOAT("timeStamp", "double") E57_SCALED("ext:range", "-500", "499", "0.25", "3")
                E57_FLOAT("intensity", "single") E57_INTEGER("cartesianInvalidState", "0", "1")
                    E57_INTEGER("big", "-9223372036854775808", "9223372036854775807")
                        E57_INTEGER("returnCount", "4", "4") E57_FLOAT("demo:deviation", "single"));
    write_file(&file, "fields.e57");
    numbers n = numbers_read("fields.e57", NULL);
    assert_int_equal(n.list.count, 8);
    assert_string_equal(n.left_out, "");
    numbers_expect_type(&n, "rowIndex", "u16");
    numbers_expect_type(&n, "returnIndex", "i8");
    numbers_expect_type(&n, "timeStamp", "f64");
    numbers_expect_type(&n, "range", "i16");
    numbers_expect_type(&n, "intensity", "f32");
    numbers_expect_type(&n, "big", "i64");
    numbers_expect_type(&n, "returnCount", "u8");
    numbers_expect_type(&n, "deviation", "f32");
    for (unsigned i = 0; i < POINTS; i++) {
        assert_int_equal(n.points[i].reject, i == 0       ? STP_REJECT_ORIGIN
                                             : i % 4 == 1 ? STP_REJECT_NO_RETURN
                                                          : STP_REJECT_NONE);
        numbers_expect(&n, "rowIndex", i, 100.0 + i % 5000);
        numbers_expect(&n, "returnIndex", i, (double)(i % 3) - 1.0);
        numbers_expect(&n, "timeStamp", i, i * 0.001);
        assert_int_equal(numbers_word(&n, "range", i), (uint64_t)((int64_t)(i % 1000) - 500));
        numbers_expect(&n, "range", i, ((double)(i % 1000) - 500.0) * 0.25 + 3.0);
        numbers_expect(&n, "intensity", i, (double)(0.1f * (float)i));
        assert_int_equal(numbers_word(&n, "big", i), (uint64_t)INT64_MIN + i);
        numbers_expect(&n, "returnCount", i, 4.0);
        numbers_expect(&n, "deviation", i, (double)(-0.5f * (float)i));
    }
    numbers_free(&n);
}

/* Whole numbers of every width have the least type that holds what their bits can say. */
static void every_width(void **state)
{
    (void)state;
    for (unsigned bits = 0; bits <= 64; bits++) {
        const uint64_t range = bits == 0 ? 0 : UINT64_MAX >> (64 - bits);
        const bool below = bits % 2 == 1; /* a minimum below 0 */
        const int64_t minimum = bits == 64 ? INT64_MIN : below ? -(int64_t)(range / 2) - 1 : 0;
        char prototype[400];
        snprintf(prototype, sizeof prototype,
                 XYZ "<v type=\"Integer\" minimum=\"%lld\" maximum=\"%lld\"/>", (long long)minimum,
                 (long long)(int64_t)((uint64_t)minimum + range));
        e57_stream s[4] = {[3] = {.part = 11 + bits}};
        e57_file file;
        add_positions(s, POINTS);
        for (uint64_t i = 0; i < POINTS; i++)
            bytes_bits(&s[3].bytes, stp_random_u64(bits, i) & range, bits);
        e57_begin(&file);
        add_scan(&file, s, 4, POINTS, prototype);
        write_file(&file, "width.e57");
        numbers n = numbers_read("width.e57", NULL);
        const char *type = bits > 32 ? "i64" : bits > 16 ? "u32" : bits > 8 ? "u16" : "u8";
        const char *low = bits > 32 ? "i64" : bits > 16 ? "i32" : bits > 8 ? "i16" : "i8";
        numbers_expect_type(&n, "v", below ? low : type);
        for (uint64_t i = 0; i < POINTS; i++)
            assert_int_equal(numbers_word(&n, "v", i),
                             (uint64_t)minimum + (stp_random_u64(bits, i) & range));
        numbers_free(&n);
    }
}

/* A state that is not valid makes an intensity or a time missing, whole numbers and floats. */
static void invalid_states(void **state)
{
    (void)state;
    e57_file file;
    e57_stream s[7] = {0};
    add_positions(s, POINTS);
    for (unsigned i = 0; i < POINTS; i++) {
        bytes_bits(&s[3].bytes, i % 65536, 16);
        bytes_bits(&s[4].bytes, i % 3 == 0, 1);
        bytes_double(&s[5].bytes, i);
        bytes_bits(&s[6].bytes, i % 5 == 2, 1);
    }
    e57_begin(&file);
    add_scan(&file, s, 7, POINTS,
             XYZ E57_INTEGER("intensity", "0", "65535") E57_INTEGER("isIntensityInvalid", "0", "1")
                 E57_FLOAT("timeStamp", "double") E57_INTEGER("isTimeStampInvalid", "0", "1"));
    write_file(&file, "states.e57");
    numbers n = numbers_read("states.e57", NULL);
    assert_int_equal(n.list.count, 2);
    assert_string_equal(n.left_out, "");
    numbers_expect_type(&n, "intensity", "u32"); /* 65535 is a number, and missing is another */
    assert_true(numbers_find(&n, "intensity")->has_missing);
    assert_true(numbers_find(&n, "timeStamp")->has_missing);
    for (unsigned i = 0; i < POINTS; i++) {
        numbers_expect(&n, "intensity", i, i % 3 == 0 ? (double)NAN : i);
        numbers_expect(&n, "timeStamp", i, i % 5 == 2 ? (double)NAN : i);
    }
    numbers_free(&n);
    stp_scan_info info; /* who keeps no numbers reads neither */
    free(scan_fixture_read("states.e57", NULL, &info));
    assert_int_equal(info.point_count, POINTS);
}

/* Scans with other fields, types and scales join; what a scan lacks is missing there. */
static void scans_join(void **state)
{
    (void)state;
    e57_file file;
    e57_stream s[3][6] = {0};
    for (int k = 0; k < 3; k++)
        add_positions(s[k], 3);
    for (unsigned i = 0; i < 3; i++) {
        bytes_integer(&s[0][3].bytes, i, 1);
        bytes_float(&s[0][4].bytes, 0.5f);
        bytes_bits(&s[0][5].bytes, i == 1, 1);
        bytes_bits(&s[1][3].bytes, i, 10);
        bytes_bits(&s[1][4].bytes, i, 3);
        bytes_integer(&s[2][3].bytes, 255 - i, 1);
    }
    e57_begin(&file);
    add_scan(&file, s[0], 6, 3,
             XYZ E57_INTEGER("intensity", "0", "200") E57_FLOAT("a", "single")
                 E57_INTEGER("isIntensityInvalid", "0", "1"));
    add_scan(&file, s[1], 5, 3,
             XYZ E57_INTEGER("intensity", "0", "1023") E57_SCALED("b", "-4", "3", "0.5", "0"));
    add_scan(&file, s[2], 4, 3, XYZ E57_SCALED("b", "0", "255", "2", "1"));
    write_file(&file, "join.e57");
    numbers n = numbers_read("join.e57", NULL);
    assert_int_equal(n.list.count, 3);
    numbers_expect_type(&n, "intensity", "u32");
    numbers_expect_type(&n, "a", "f32");
    numbers_expect_type(&n, "b", "f64");
    for (unsigned i = 0; i < 3; i++) {
        const double none = (double)NAN;
        numbers_expect(&n, "intensity", i, i == 1 ? none : i);
        numbers_expect(&n, "intensity", 3 + i, i);
        numbers_expect(&n, "intensity", 6 + i, none);
        numbers_expect(&n, "a", i, 0.5);
        numbers_expect(&n, "a", 3 + i, none);
        numbers_expect(&n, "b", i, none);
        numbers_expect(&n, "b", 3 + i, ((double)i - 4.0) * 0.5);
        numbers_expect(&n, "b", 6 + i, (255.0 - i) * 2.0 + 1.0);
    }
    numbers_free(&n);
}

/* Intensities and classes that a sample has; texts, fields within structures, names that are taken
 * and more than 64 names. */
static void what_is_none(void **state)
{
    (void)state;
    e57_file file;
    e57_stream s[9] = {0};
    add_positions(s, 2);
    for (unsigned i = 0; i < 2; i++) {
        for (int k = 3; k < 9; k++)
            bytes_integer(&s[k].bytes, 7, 1);
    }
    e57_begin(&file);
    add_scan(&file, s, 9, 2,
             XYZ E57_INTEGER("intensity", "0", "255") E57_INTEGER(
                 "classification", "0", "255") "<note type=\"String\"/><group "
                                               "type=\"Structure\">" E57_INTEGER(
                                                   "inner", "0",
                                                   "255") "</group>" E57_INTEGER("a:v", "0", "255")
                                                   E57_INTEGER("b:v", "0", "255"));
    write_file(&file, "none.e57");
    numbers n = numbers_read("none.e57", NULL);
    assert_int_equal(n.list.count, 1);
    numbers_expect(&n, "v", 1, 7.0);
    assert_string_equal(n.left_out, "note, inner, b:v");
    numbers_free(&n);
    e57_stream many[73] = {0};
    char prototype[8000] = XYZ;
    add_positions(many, 2);
    for (unsigned k = 0; k < 70; k++) {
        const size_t used = strlen(prototype);
        snprintf(prototype + used, sizeof prototype - used,
                 "<v%u type=\"Integer\" minimum=\"0\" maximum=\"255\"/>", k);
        bytes_integer(&many[3 + k].bytes, k, 1);
        bytes_integer(&many[3 + k].bytes, k + 100, 1);
    }
    e57_begin(&file);
    add_scan(&file, many, 73, 2, prototype);
    write_file(&file, "many.e57");
    n = numbers_read("many.e57", NULL);
    assert_int_equal(n.list.count, 64);
    assert_string_equal(n.left_out, "v64, v65, v66, v67, v68, v69");
    numbers_expect(&n, "v0", 1, 100.0);
    numbers_expect(&n, "v63", 1, 163.0);
    numbers_free(&n);
}

/* The bytestream of an attribute is too short or too long: a sentence, if somebody reads it. */
static void wrong_length(void **state)
{
    (void)state;
    const stp_scan_params params = {.numbers = true};
    for (unsigned extra = 0; extra < 2; extra++) {
        e57_file file;
        e57_stream s[4] = {0};
        add_positions(s, 40);
        for (unsigned i = 0; i < (extra ? 60u : 30u); i++)
            bytes_double(&s[3].bytes, i);
        e57_begin(&file);
        add_scan(&file, s, 4, 40, XYZ E57_FLOAT("timeStamp", "double"));
        write_file(&file, "length.e57");
        scan_fixture_fails("length.e57", &params, STP_CORRUPT,
                           extra ? "hold more than the 40 points"
                                 : "end after 30 of its 40 points");
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fields_of_a_scanner), cmocka_unit_test(every_width),
        cmocka_unit_test(invalid_states),      cmocka_unit_test(scans_join),
        cmocka_unit_test(what_is_none),        cmocka_unit_test(wrong_length),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

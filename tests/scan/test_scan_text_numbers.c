/* Tests the attributes of lines of text: named columns, intensities, and cells that are no numbers.
 */
#include "tests/fixtures/numbers_fixture.h"

static numbers read_text(const char *path, const char *text, const char *columns)
{
    scan_fixture_text(path, text);
    return numbers_read(path, columns);
}

static void expect_names(const numbers *n, const char *names)
{
    char found[512] = "";
    for (uint32_t i = 0; i < n->list.count; i++) {
        const size_t used = strlen(found);
        snprintf(found + used, sizeof found - used, "%s%s", i > 0 ? "," : "",
                 n->list.items[i].name);
        assert_string_equal(stp_attribute_type_name(n->list.items[i].type), "f64");
        assert_true(n->list.items[i].has_missing);
    }
    assert_string_equal(found, names);
}

/* Named columns come back to the last digit, whatever lies between them. */
static void named_columns(void **state)
{
    (void)state;
    numbers n = read_text("named.csv",
                          "gps_time,X,Y,Z,return,class,Pulse width (ns)\n"
                          "245370.4177060001,1,2,3,2,8,-1e-3\n"
                          "9007199254740992,4,5,6,1,9,+7.25\n",
                          NULL);
    expect_names(&n, "gps_time,return,Pulse width (ns)");
    assert_string_equal(n.left_out, "");
    numbers_expect(&n, "gps_time", 0, 245370.4177060001);
    numbers_expect(&n, "gps_time", 1, 9007199254740992.0);
    numbers_expect(&n, "return", 0, 2.0);
    numbers_expect(&n, "return", 1, 1.0);
    numbers_expect(&n, "Pulse width (ns)", 0, -1e-3);
    numbers_expect(&n, "Pulse width (ns)", 1, 7.25);
    scan_fixture_position(&n.points[1], 4, 5, 6);
    assert_int_equal(n.points[1].class_id, 9);
    numbers_free(&n);
    n = read_text("tabs.txt", "//x\ty\tz\tScalar field\n1\t2\t3\t0,5\n", NULL);
    expect_names(&n, "Scalar field");
    numbers_expect(&n, "Scalar field", 0, 0.5);
    numbers_free(&n);
}

/* Thousands of lines: blocks of the reader do not shift numbers against points. */
static void many_lines(void **state)
{
    (void)state;
    enum { LINES = 5000 };
    FILE *file = fopen("many.csv", "w");
    assert_non_null(file);
    fputs("x;y;z;id;half\n", file);
    for (int i = 0; i < LINES; i++)
        fprintf(file, "%d;0;0;%d;%d.5\n", i, 3 * i, i);
    fclose(file);
    numbers n = numbers_read("many.csv", NULL);
    assert_int_equal(n.count, LINES);
    for (int i = 0; i < LINES; i++) {
        scan_fixture_position(&n.points[i], i, 0, 0);
        numbers_expect(&n, "id", (uint64_t)i, 3.0 * i);
        numbers_expect(&n, "half", (uint64_t)i, i + 0.5);
    }
    numbers_free(&n);
}

/* A cell without a number is missing; a column without any number is none. */
static void cells_without_numbers(void **state)
{
    (void)state;
    numbers n = read_text(
        "cells.csv", "x,y,z,a,word,b\n1,2,3,,oak,5\n1,2,3,n/a,elm,\n1,2,3,7,ash,nan\n1,2,3,8,,\n",
        NULL);
    static const double a[] = {(double)NAN, (double)NAN, 7, 8};
    static const double b[] = {5, (double)NAN, (double)NAN, (double)NAN};
    expect_names(&n, "a,b");
    assert_string_equal(n.left_out, "word");
    for (uint64_t i = 0; i < 4; i++) {
        numbers_expect(&n, "a", i, a[i]);
        numbers_expect(&n, "b", i, b[i]);
    }
    numbers_free(&n);
}

/* Columns without a name, or with one that is taken, are no attributes. */
static void what_is_none(void **state)
{
    (void)state;
    numbers n = read_text("bare.xyz", "1 2 3 4.5 -5\n1 2 3 4 5\n", NULL);
    expect_names(&n, "");
    assert_string_equal(n.left_out, "column 4, column 5");
    numbers_free(&n);
    n = read_text("taken.txt", "x y z t t x\n1 2 3 4 5 6\n", NULL);
    expect_names(&n, "t");
    numbers_expect(&n, "t", 0, 4.0);
    assert_string_equal(n.left_out, "t, x");
    numbers_free(&n);
}

/* An intensity is an attribute exactly if a sample's 8 bits are not its numbers. */
static void intensities(void **state)
{
    (void)state;
    static const struct {
        const char *path, *text, *names;
        double first;
    } cases[] = {
        {"bytes.xyz", "1 2 3 0\n1 2 3 255\n", "", 0},
        {"small.xyz", "1 2 3 0.25\n1 2 3 1\n", "intensity", 0.25},
        {"parts.xyz", "1 2 3 7.5\n1 2 3 255\n", "intensity", 7.5},
        {"words.xyz", "1 2 3 700\n1 2 3 65535\n", "intensity", 700},
        {"leica.pts", "2\n1 2 3 -2048\n1 2 3 2047\n", "intensity", -2048},
        {"named.txt", "x y z Amplitude\n1 2 3 -17.25\n1 2 3 -3\n", "Amplitude", -17.25},
        {"class.txt", "x y z class\n1 2 3 300\n1 2 3 2\n", "class", 300},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        numbers n = read_text(cases[i].path, cases[i].text, NULL);
        expect_names(&n, cases[i].names);
        if (n.list.count > 0)
            numbers_expect(&n, cases[i].names, 0, cases[i].first);
        numbers_free(&n);
    }
}

/* --columns names attributes, too, if they are wanted; else an unknown name is a mistake. */
static void given_columns(void **state)
{
    (void)state;
    const stp_scan_params wanted = {.numbers = true, .columns = "x,y,z,9th"};
    const stp_scan_params twice = {.numbers = true, .columns = "x,y,z,t,t"};
    const stp_scan_params unwanted = {.columns = "x,y,z,gps_time"};
    numbers n = read_text("given.txt", "1 2 3 8 0.5 6\n4 5 6 9 1.5 7\n", "x,y,z,_,gps_time,echo");
    expect_names(&n, "gps_time,echo");
    assert_string_equal(n.left_out, "column 4");
    numbers_expect(&n, "gps_time", 1, 1.5);
    numbers_expect(&n, "echo", 0, 6.0);
    numbers_free(&n);
    n = read_text("given.xyz", "1 2 3 0.25\n", "x,y,z,i");
    expect_names(&n, "intensity");
    numbers_free(&n);
    n = read_text("given.pts", "1\n1 2 3 8 0.5\n", "x,y,z,_,gps_time");
    numbers_expect(&n, "gps_time", 0, 0.5);
    numbers_free(&n);
    stp_error err = {0};
    stp_scan *scan = NULL;
    assert_int_equal(stp_scan_open(&scan, "given.txt", &wanted, &err), STP_INVALID_ARGUMENT);
    assert_non_null(strstr(err.message, "`9th` is no known column"));
    assert_int_equal(stp_scan_open(&scan, "given.txt", &twice, &err), STP_INVALID_ARGUMENT);
    assert_non_null(strstr(err.message, "`t` is named twice"));
    assert_int_equal(stp_scan_open(&scan, "given.txt", &unwanted, &err), STP_INVALID_ARGUMENT);
    assert_non_null(strstr(err.message, "--attributes keeps columns of other names"));
}

/* Scans of a PTX with and without intensity; rays without a return have none. */
static void scans_of_ptx(void **state)
{
    (void)state;
#define POSE "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
    numbers n = read_text("mixed.ptx",
                          "1\n3\n" POSE "1 2 3 0.25\n0 0 0 0.5\n4 5 6 0.75\n"
                          "1\n1\n" POSE "7 8 9 10 20 30\n"
                          "1\n1\n" POSE "7 8 9 0.125 10 20 30\n",
                          NULL);
    expect_names(&n, "intensity");
    numbers_expect(&n, "intensity", 0, 0.25);
    assert_int_equal(n.points[1].reject, STP_REJECT_NO_RETURN);
    numbers_expect(&n, "intensity", 1, (double)NAN);
    numbers_expect(&n, "intensity", 2, 0.75);
    numbers_expect(&n, "intensity", 3, (double)NAN);
    numbers_expect(&n, "intensity", 4, 0.125);
    numbers_free(&n);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(named_columns),         cmocka_unit_test(many_lines),
        cmocka_unit_test(cells_without_numbers), cmocka_unit_test(what_is_none),
        cmocka_unit_test(intensities),           cmocka_unit_test(given_columns),
        cmocka_unit_test(scans_of_ptx),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

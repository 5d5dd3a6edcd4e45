/* Tests that readers which can go on anywhere give the points that they give from the beginning on,
 * and that the others say so. Real LAZ files, too, if STIPPLE_SCANS names a folder of scans. */
#include "tests/fixtures/scan/e57_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"

#define POINTS_LIMIT 200000u
#define RUN 5u

static stp_scan *open_scan(const char *path)
{
    stp_error err = {0};
    stp_scan *scan = NULL;
    if (stp_scan_open(&scan, path, NULL, &err) != STP_OK)
        fail_msg("%s", err.message);
    return scan;
}

static size_t read_points(stp_scan *scan, stp_point *points, size_t most)
{
    size_t sum = 0, count = 1;
    while (count > 0 && sum < most) {
        assert_int_equal(stp_scan_read(scan, points + sum, most - sum, &count, NULL), STP_OK);
        sum += count;
    }
    return sum;
}

/* Reads runs from the last seek place to the first and back, and holds them against all points. */
static void check_seeks(const char *path)
{
    stp_point *all = calloc(POINTS_LIMIT, sizeof *all), run[RUN];
    stp_scan *scan = open_scan(path);
    assert_non_null(all);
    const size_t count = read_points(scan, all, POINTS_LIMIT);
    const uint64_t apart = stp_scan_get_info(scan)->seek_points;
    const uint64_t places = apart > 0 ? (count + apart - 1) / apart : 0, step = places / 50 + 1;
    assert_true(apart > 0);
    for (uint64_t i = 0; i < 2 * places; i += step) {
        const uint64_t place = (i < places ? places - 1 - i : i - places) * apart;
        assert_int_equal(stp_scan_seek(scan, place, NULL), STP_OK);
        const size_t got = read_points(scan, run, RUN);
        assert_int_equal(got, count - place < RUN ? count - place : RUN);
        assert_memory_equal(run, all + place, got * sizeof *run);
    }
    stp_scan_close(&scan);
    free(all);
}

static void generated(void **state)
{
    static const char *const names[] = {"seek.las", "seek.ply"};
    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char command[4200];
        snprintf(command, sizeof command, "'%s' gen bumpy -n 3000 -o %s --quiet", getenv("STIPPLE"),
                 names[i]);
        assert_int_equal(system(command), 0);
        check_seeks(names[i]);
    }
}

/* Heights with a hole and colours beside them; normals need the rows above and below. */
static void grids(void **state)
{
    enum { COLUMNS = 37, ROWS = 60 };
    static const char *const names[] = {"seek.asc", "seek.pgm"};
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        FILE *file = fopen(names[kind], "w");
        assert_non_null(file);
        if (kind == 0)
            fprintf(file,
                    "ncols %d\nnrows %d\nxllcorner 5\nyllcorner 7\ncellsize 2\n"
                    "NODATA_value -1\n",
                    COLUMNS, ROWS);
        else
            fprintf(file, "P2\n%d %d\n65535\n", COLUMNS, ROWS);
        for (int i = 0; i < COLUMNS * ROWS; i++)
            fprintf(file, "%d\n", kind == 0 && i % 91 < 3 ? -1 : i * i % 211);
        assert_int_equal(fclose(file), 0);
        check_seeks(names[kind]);
    }
}

/* Lines of text with comments and blank lines between them. */
static void lines(void **state)
{
    (void)state;
    FILE *file = fopen("seek.csv", "w");
    assert_non_null(file);
    fprintf(file, "x,y,z,r,g,b\r\n");
    for (int i = 0; i < 50000; i++)
        fprintf(file, "%s%d.25,%d,%d,%d,9,200\r\n", i % 16384 == 0 ? "# a comment\r\n\r\n" : "",
                i % 300, i / 300, i % 300 * i % 7, i % 256);
    assert_int_equal(fclose(file), 0);
    check_seeks("seek.csv");
}

/* Records with a field that is not read between the others. */
static void binary_pcd(void **state)
{
    static const char header[] = "VERSION .7\nFIELDS x y odd z intensity\nSIZE 4 8 1 4 2\n"
                                 "TYPE F F U F U\nCOUNT 1 1 3 1 1\nWIDTH 3000\nHEIGHT 1\n"
                                 "VIEWPOINT 1 2 3 1 0 0 0\nPOINTS 3000\nDATA binary\n";
    byte_row bytes = {0};
    (void)state;
    bytes_add(&bytes, header, sizeof header - 1);
    for (int i = 0; i < 3000; i++) {
        bytes_float(&bytes, (float)(i % 70));
        bytes_double(&bytes, i / 70.0);
        bytes_integer(&bytes, (uint64_t)i * 77, 3);
        bytes_float(&bytes, (float)i);
        bytes_integer(&bytes, (uint64_t)i * 21, 2);
    }
    scan_fixture_bytes("seek.pcd", bytes.data, bytes.size);
    bytes_free(&bytes);
    check_seeks("seek.pcd");
}

/* Three lists of points, of which the second one is empty. */
static void lists(void **state)
{
    static const int counts[3] = {20000, 0, 21000};
    FILE *file = fopen("seek.pts", "w");
    (void)state;
    assert_non_null(file);
    for (int k = 0; k < 3; k++) {
        fprintf(file, "%d\n", counts[k]);
        for (int i = 0; i < counts[k]; i++)
            fprintf(file, "%s%d.25 %d %d -100 9 20 %d\n", i % 9999 == 0 ? "\n" : "", i % 300, k,
                    i % 17, i % 256);
    }
    assert_int_equal(fclose(file), 0);
    check_seeks("seek.pts");
}

/* Scans of floats and of whole numbers of few bits, whose bytestreams go into packets by other
 * parts; an empty scan lies between them. */
static void packets(void **state)
{
    static const size_t counts[3] = {9000, 0, 11000};
    e57_file file;
    (void)state;
    e57_begin(&file);
    for (int scan = 0; scan < 3; scan++) {
        e57_stream s[4] = {{.part = 801}, {.part = 1200}, {.part = 400}, {.part = 333}};
        for (size_t i = 0; i < counts[scan]; i++) {
            bytes_float(&s[0].bytes, (float)i);
            bytes_double(&s[1].bytes, (double)(i % 77) + scan);
            bytes_float(&s[2].bytes, (float)(i % 13));
            bytes_bits(&s[3].bytes, i * 5 % 1021, 10);
        }
        e57_vector(&file, s, 4, false);
        e57_scan(&file, "", counts[scan],
                 E57_FLOAT("cartesianX", "single") E57_FLOAT("cartesianY", "double")
                     E57_FLOAT("cartesianZ", "single") E57_INTEGER("intensity", "0", "1023"));
        for (int i = 0; i < 4; i++)
            bytes_free(&s[i].bytes);
    }
    e57_end(&file, "");
    e57_write("seek.e57", &file);
    e57_free(&file);
    check_seeks("seek.e57");
}

static void only_forwards(void **state)
{
    static const char text[] = "1 2 3\n4 5 6\n";
    stp_error err = {0};
    (void)state;
    scan_fixture_bytes("text.xyz", text, sizeof text - 1);
    stp_scan *scan = open_scan("text.xyz");
    assert_true(stp_scan_get_info(scan)->seek_points == 0);
    assert_int_equal(stp_scan_seek(scan, 1, &err), STP_INVALID_ARGUMENT);
    assert_non_null(strstr(err.message, "text.xyz"));
    stp_scan_close(&scan);
}

static void real(void **state)
{
    static const char *const names[] = {"laz/autzen_trim.laz", "laz/simple.laz",
                                        "laz/pdrf8-1.4.laz", "laz/pdrf4-1.3.laz"};
    char path[4096];
    (void)state;
    for (size_t i = 0; scan_fixture_has_real() && i < sizeof names / sizeof *names; i++)
        if (scan_fixture_real(names[i], path))
            check_seeks(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(generated),     cmocka_unit_test(grids), cmocka_unit_test(lines),
        cmocka_unit_test(binary_pcd),    cmocka_unit_test(lists), cmocka_unit_test(packets),
        cmocka_unit_test(only_forwards), cmocka_unit_test(real),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

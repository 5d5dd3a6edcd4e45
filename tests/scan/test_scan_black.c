/* Tests that colours which are all zero count as no colours in PCD, PTX and E57, and that a single
 * colour that is not zero makes all of them count. */
#include "tests/fixtures/scan/e57_fixture.h"
#include "tests/fixtures/scan/pcd_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"

enum { COUNT = 70000 }; /* more than the records that a reader samples at the beginning of a file */

/* Points of which the last but one has this value, and all others zero. */
static double values[COUNT];

/* Reads the file; free the points with free(). */
static stp_point *expect(const char *path, double value, unsigned expected)
{
    stp_scan_info info;
    stp_point *points = scan_fixture_read(path, NULL, &info);
    assert_int_equal(!!(info.attributes & STP_POINT_HAS_COLOUR), value != 0.0);
    for (int k = 0; value != 0.0 && k < 3; k++)
        assert_int_equal(points[COUNT - 2].rgb[k], expected);
    return points;
}

static void pcd_files(void **state)
{
    (void)state;
    static double xs[COUNT];
    for (int i = 0; i < COUNT; i++)
        xs[i] = i;
    for (unsigned size = 1; size <= 4; size += 3) {
        for (int e = 0; e < 2 * PCD_ENCODING_COUNT; e++) {
            const bool lit = e >= PCD_ENCODING_COUNT;
            const pcd_encoding encoding = (pcd_encoding)(e % PCD_ENCODING_COUNT);
            if (lit && encoding == PCD_BINARY)
                continue; /* it is sampled in blocks, which may miss a point */
            values[COUNT - 2] = !lit ? 0.0 : size == 1 ? 51.0 : 0x333333;
            const pcd_column columns[] = {
                {"x", 'F', 4, 1, xs},        {"y", 'F', 4, 1, xs},
                {"z", 'F', 4, 1, xs},        {size == 1 ? "r" : "rgba", 'U', size, 1, values},
                {"g", 'U', size, 1, values}, {"b", 'U', size, 1, values}};
            const pcd_file file = {columns, 6, COUNT, 1, NULL};
            byte_row bytes = pcd_make(&file, encoding);
            scan_fixture_bytes("black.pcd", bytes.data, bytes.size);
            bytes_free(&bytes);
            free(expect("black.pcd", values[COUNT - 2], 51 * 257));
        }
    }
}

static void ptx_files(void **state)
{
    (void)state;
    for (int lit = 0; lit < 2; lit++) {
        byte_row text = {0};
        char line[99];
        snprintf(line, sizeof line, "%d\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n", COUNT);
        bytes_text(&text, line);
        bytes_text(&text, "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
        for (int i = 0; i < COUNT; i++) {
            snprintf(line, sizeof line, "%d 2 3 0.5 %d %d %d\n", i, 51 * lit, 51 * lit, 51 * lit);
            bytes_text(&text, line);
        }
        scan_fixture_bytes("black.ptx", text.data, text.size);
        bytes_free(&text);
        free(expect("black.ptx", lit, 51 * 257));
    }
}

/* A scan of COUNT points with colours, which are zero but for one, and one whose colours are all
 * zero: its points are grey, not black, if the other has colours. */
static void e57_files(void **state)
{
    (void)state;
    for (int lit = 0; lit < 2; lit++) {
        e57_file file;
        e57_stream s[6] = {{{0}, 0}};
        for (int i = 0; i < COUNT; i++) {
            for (int k = 0; k < 3; k++)
                bytes_float(&s[k].bytes, (float)i);
            for (int k = 3; k < 6; k++)
                bytes_integer(&s[k].bytes, lit && i == COUNT - 2 ? 51 : 0, 1);
        }
        const char *prototype = E57_FLOAT("cartesianX", "single") E57_FLOAT("cartesianY", "single")
            E57_FLOAT("cartesianZ", "single") E57_INTEGER("colorRed", "0", "255")
                E57_INTEGER("colorGreen", "0", "255") E57_INTEGER("colorBlue", "0", "255");
        e57_begin(&file);
        e57_vector(&file, s, 6, false);
        e57_scan(&file, "", COUNT, prototype);
        for (int k = 3; k < 6; k++)
            memset(s[k].bytes.data, 0, s[k].bytes.size);
        e57_vector(&file, s, 6, false);
        e57_scan(&file, "", COUNT, prototype);
        e57_end(&file, "");
        e57_write("black.e57", &file);
        e57_free(&file);
        for (int k = 0; k < 6; k++)
            bytes_free(&s[k].bytes);
        stp_point *points = expect("black.e57", lit, 51 * 257);
        if (lit)
            scan_fixture_rgb(&points[COUNT], STP_POINT_GREY, STP_POINT_GREY, STP_POINT_GREY);
        free(points);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pcd_files),
        cmocka_unit_test(ptx_files),
        cmocka_unit_test(e57_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Tests arrays of points that NumPy saved: types, orders, fields with names, what is refused. */
#include "tests/fixtures/scan/scan_fixture.h"

#include <math.h>

/* Writes a file of version 1 or 2 with this dictionary and these bytes. */
static void write_array(const char *path, int version, const char *dictionary, const void *data,
                        size_t size)
{
    unsigned char bytes[8192] = "\x93NUMPY";
    const size_t length = strlen(dictionary), before = version > 1 ? 12 : 10;
    assert_true(before + length + size <= sizeof bytes);
    bytes[6] = (unsigned char)version;
    bytes[8] = (unsigned char)(length & 255);
    bytes[9] = (unsigned char)(length >> 8);
    for (size_t i = 0; i < length; i++)
        bytes[before + i] = (unsigned char)dictionary[i];
    memcpy(bytes + before + length, data, size);
    scan_fixture_bytes(path, bytes, before + length + size);
}

#define DICTIONARY(descr, order, shape)                                                            \
    "{'descr': " descr ", 'fortran_order': " order ", 'shape': " shape ", }   \n"

static const float rows[2][6] = {{1.5f, -2, 3e10f, 10, 20, 30}, {4, 5.25f, 6, 70, 80, 255}};

static void check(const char *path)
{
    stp_scan_info info;
    print_message("%s\n", path);
    stp_point *points = scan_fixture_read(path, NULL, &info);
    assert_string_equal(info.format, "NumPy array");
    assert_int_equal(info.point_count, 2);
    assert_int_equal(info.attributes, STP_POINT_HAS_COLOUR);
    assert_true(info.coordinate_step == 0.0);
    scan_fixture_position(&points[0], 1.5, -2, (double)3e10f);
    scan_fixture_position(&points[1], 4, 5.25, 6);
    scan_fixture_rgb(&points[0], 10 * 257, 20 * 257, 30 * 257);
    scan_fixture_rgb(&points[1], 70 * 257, 80 * 257, 65535);
    free(points);
}

/* The same points in every order, width and shape. */
static void arrays(void **state)
{
    (void)state;
    float columns[6][2];
    double wide[2][6];
    unsigned char big[sizeof rows];
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 6; k++) {
            columns[k][i] = rows[i][k];
            wide[i][k] = (double)rows[i][k];
            for (int b = 0; b < 4; b++)
                big[(6 * i + k) * 4 + b] = ((const unsigned char *)&rows[i][k])[3 - b];
        }
    write_array("rows.npy", 1, DICTIONARY("'<f4'", "False", "(2, 6)"), rows, sizeof rows);
    check("rows.npy");
    write_array("second.npy", 2, DICTIONARY("'<f4'", "False", "(1, 2, 6)"), rows, sizeof rows);
    check("second.npy");
    write_array("wide.npy", 1, DICTIONARY("'<f8'", "False", "(2, 6)"), wide, sizeof wide);
    check("wide.npy");
    write_array("big.npy", 1, DICTIONARY("'>f4'", "False", "(2, 6)"), big, sizeof big);
    check("big.npy");
    write_array("fortran.npy", 1, DICTIONARY("'<f4'", "True", "(2, 6)"), columns, sizeof columns);
    check("fortran.npy");
}

/* Three rows of many numbers are points, too. */
static void transposed(void **state)
{
    (void)state;
    enum { COUNT = 100 };
    int16_t numbers[3][COUNT];
    stp_scan_info info;
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < COUNT; i++)
            numbers[k][i] = (int16_t)(100 * k - i);
    write_array("t.npy", 1, DICTIONARY("'<i2'", "False", "(3, 100)"), numbers, sizeof numbers);
    stp_point *points = scan_fixture_read("t.npy", NULL, &info);
    assert_int_equal(info.point_count, COUNT);
    assert_true(info.coordinate_step == 1.0);
    scan_fixture_position(&points[99], -99, 1, 101);
    free(points);
    const stp_scan_params params = {.columns = "z,x,y"};
    points = scan_fixture_read("t.npy", &params, &info);
    scan_fixture_position(&points[99], 1, 101, -99);
    free(points);
}

/* Records as PDAL's and ROS' arrays have them; other fields are attributes. */
static void records(void **state)
{
    (void)state;
    unsigned char bytes[2 * 29];
    for (int i = 0; i < 2; i++) {
        const double x = 7 + i, z = -1;
        const float y = 0.5f;
        const uint32_t rgb = 0x4650FFu;
        const uint16_t ring = (uint16_t)(300 + i);
        unsigned char *at = bytes + (ptrdiff_t)29 * i;
        memcpy(at, &x, 8);
        memcpy(at + 8, &y, 4);
        memcpy(at + 12, &z, 8);
        memcpy(at + 20, &rgb, 4);
        memcpy(at + 24, &ring, 2);
        at[26] = 6;
        at[27] = at[28] = 0;
    }
    write_array("records.npy", 1,
                DICTIONARY("[('X', '<f8'), ('Y', '<f4'), ('Z', '<f8'), ('rgb', '<f4'), "
                           "('ring', '<u2'), ('Classification', '|u1'), ('other', '<i2')]",
                           "False", "(2,)"),
                bytes, sizeof bytes);
    const stp_scan_params numbers = {.numbers = true};
    stp_error err = {0};
    stp_scan *scan = NULL;
    stp_point points[2];
    size_t count;
    double ring;
    assert_int_equal(stp_scan_open(&scan, "records.npy", &numbers, &err), STP_OK);
    assert_int_equal(stp_scan_get_info(scan)->attributes,
                     STP_POINT_HAS_COLOUR | STP_POINT_HAS_CLASS);
    assert_string_equal(stp_scan_get_info(scan)->extra->items[0].name, "ring");
    assert_int_equal(stp_scan_read(scan, points, 2, &count, &err), STP_OK);
    assert_int_equal(count, 2);
    scan_fixture_position(&points[1], 8, 0.5, -1);
    scan_fixture_rgb(&points[1], 70 * 257, 80 * 257, 65535);
    scan_fixture_scalars(&points[0], 0, 6);
    memcpy(&ring, stp_scan_numbers(scan) + 16, sizeof ring);
    assert_true(ring == 301.0);
    stp_scan_close(&scan);
}

/* Gaps and texts are passed over, and opaque colours in floats keep their bits. */
static void records_with_gaps(void **state)
{
    (void)state;
    unsigned char bytes[2 * 26] = {0};
    stp_scan_info info;
    for (int i = 0; i < 2; i++) {
        const float xyz[3] = {(float)i, 2, 3};
        const uint32_t rgb = 0xFF8050FFu;
        memcpy(bytes + (ptrdiff_t)26 * i, xyz, 12);
        memcpy(bytes + (ptrdiff_t)26 * i + 16, &rgb, 4);
    }
    write_array("gaps.npy", 1,
                DICTIONARY("[('x', '<f4'), ('y', '<f4'), ('z', '<f4'), ('', '|V4'), "
                           "('rgb', '<f4'), ('a,b', '<i2'), ('name', '<U1')]",
                           "False", "(2,)"),
                bytes, sizeof bytes);
    stp_point *points = scan_fixture_read("gaps.npy", NULL, &info);
    assert_int_equal(info.attributes, STP_POINT_HAS_COLOUR);
    scan_fixture_position(&points[1], 1, 2, 3);
    scan_fixture_rgb(&points[1], 0x80 * 257, 0x50 * 257, 65535);
    free(points);
}

/* A pole is no column of degrees, however many digits its floats have. */
static void a_pole_stays(void **state)
{
    (void)state;
    double pole[60][3];
    stp_error err = {0};
    stp_scan *scan = NULL;
    for (int i = 0; i < 60; i++) {
        pole[i][0] = 0.1 * sin(i);
        pole[i][1] = 0.1 * cos(i);
        pole[i][2] = 0.25 * i;
    }
    write_array("pole.npy", 1, DICTIONARY("'<f8'", "False", "(60, 3)"), pole, sizeof pole);
    assert_int_equal(stp_scan_open(&scan, "pole.npy", NULL, &err), STP_OK);
    const stp_scan_info *info = stp_scan_get_info(scan);
    for (uint32_t i = 0; i < info->note_count; i++)
        assert_string_not_equal(info->notes[i].name, "degrees");
    stp_scan_close(&scan);
}

static void refused(void **state)
{
    (void)state;
    const struct {
        const char *dictionary;
        stp_status status;
        const char *text;
    } cases[] = {
        {DICTIONARY("'<f4'", "False", "(12,)"), STP_UNSUPPORTED, "no list of points"},
        {DICTIONARY("'<f4'", "False", "(6, 2)"), STP_UNSUPPORTED, "no list of points"},
        {DICTIONARY("'<f4'", "False", "(200, 300)"), STP_UNSUPPORTED, "heights as TIFF"},
        {DICTIONARY("'<f4'", "False", "(1, 1, 1, 12)"), STP_CORRUPT, "cannot be read"},
        {DICTIONARY("'<f4'", "False", "(3, 4"), STP_CORRUPT, "cannot be read"},
        {DICTIONARY("'<c8'", "False", "(2, 3)"), STP_UNSUPPORTED, "`<c8` are not read"},
        {DICTIONARY("[('x', '|V4096'), ('y', '|V4096')]", "False", "(4,)"), STP_UNSUPPORTED,
         "`|V4096` are not read"},
        {DICTIONARY("'|O'", "False", "(2, 3)"), STP_UNSUPPORTED, "no list of points"},
        {DICTIONARY("[('a', '<f4', (3,))]", "False", "(4,)"), STP_UNSUPPORTED, "no list"},
        {DICTIONARY("[('a', '<f4'), ('b', '<f4'), ('c', '<f4')]", "False", "(4,)"), STP_FORMAT,
         "named x, y and z"},
        {DICTIONARY("'<f4'", "False", "(5, 3)"), STP_CORRUPT, "do not fit"},
        {DICTIONARY("'<f4'", "False", "(18446744073709551615, 3)"), STP_UNSUPPORTED, "no list"},
        {"{'shape': (4, 3)}", STP_CORRUPT, "cannot be read"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        print_message("%s\n", cases[i].dictionary);
        write_array("refused.npy", 1, cases[i].dictionary, rows, sizeof rows);
        scan_fixture_fails("refused.npy", NULL, cases[i].status, cases[i].text);
    }
    scan_fixture_bytes("short.npy", "\x93NUMPY\1", 8);
    scan_fixture_fails("short.npy", NULL, STP_CORRUPT, "cannot be read");
    const stp_scan_params params = {.columns = "x,y,z,i,r,g,b"};
    write_array("rows.npy", 1, DICTIONARY("'<f4'", "False", "(2, 6)"), rows, sizeof rows);
    scan_fixture_fails("rows.npy", &params, STP_INVALID_ARGUMENT, "names 7 columns");
    const stp_scan_params salvage = {.salvage = true};
    stp_scan_info info;
    write_array("cut.npy", 1, DICTIONARY("'<f4'", "False", "(2, 6)"), rows, sizeof rows - 1);
    stp_point *points = scan_fixture_read("cut.npy", &salvage, &info);
    assert_int_equal(points[1].reject, STP_REJECT_LOST);
    free(points);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arrays),       cmocka_unit_test(transposed),
        cmocka_unit_test(records),      cmocka_unit_test(refused),
        cmocka_unit_test(a_pole_stays), cmocka_unit_test(records_with_gaps),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

/* Tests PCD files: every encoding, type, order and field, and files that are wrong. */
#include "base/random.h"
#include "tests/fixtures/scan/pcd_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"

#include <math.h>

#define COLUMN(name, type, size, values)                                                           \
    {                                                                                              \
        name, type, size, 1, values                                                                \
    }

/* Writes the file in this encoding and reads it; free it with free(). */
static stp_point *read_as(const pcd_file *file, pcd_encoding encoding, stp_scan_info *info)
{
    byte_row bytes = pcd_make(file, encoding);
    char path[64];
    snprintf(path, sizeof path, "%s.pcd", pcd_encoding_names[encoding]);
    scan_fixture_bytes(path, bytes.data, bytes.size);
    bytes_free(&bytes);
    return scan_fixture_read(path, NULL, info);
}

static const double xs[] = {1.5, -2.25, 1e-3};
static const double ys[] = {100.0, 0.0, 7.0};
static const double zs[] = {-1.0, 0.5, 4096.0};
static const double packed[] = {0xFF102030u, 0x00FFFFFFu, 0x00010203u};

static pcd_file three_points(const pcd_column *columns, size_t count)
{
    return (pcd_file){columns, count, 3, 1, NULL};
}

/* Fields of every kind in an unusual order, with padding and counts. */
static void fields_in_any_order(void **state)
{
    (void)state;
    static const double pads[9] = {9, 9, 9, 9, 9, 9, 9, 9, 9};
    static const double many[12] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
    static const double nx[] = {0, 0, 3}, ny[] = {0, 2, 0}, nz[] = {-1, 0, 4};
    static const double labels[] = {0, 6, 300};
    static const double intensities[] = {0, 51, 255};
    const pcd_column columns[] = {
        COLUMN("label", 'U', 4, labels),
        COLUMN("z", 'F', 4, zs),
        {"_", 'U', 1, 3, pads},
        COLUMN("normal_z", 'F', 4, nz),
        {"fpfh", 'F', 4, 4, many},
        COLUMN("x", 'F', 8, xs),
        COLUMN("rgba", 'U', 4, packed),
        COLUMN("normal_x", 'F', 4, nx),
        COLUMN("y", 'F', 4, ys),
        COLUMN("curvature", 'F', 4, many),
        COLUMN("intensity", 'F', 4, intensities),
        COLUMN("normal_y", 'F', 8, ny),
    };
    const pcd_file file = three_points(columns, sizeof columns / sizeof *columns);
    for (int e = 0; e < PCD_ENCODING_COUNT; e++) {
        stp_scan_info info;
        stp_point *p = read_as(&file, (pcd_encoding)e, &info);
        char format[64];
        snprintf(format, sizeof format, "PCD %s", pcd_encoding_names[e]);
        assert_string_equal(info.format, format);
        assert_int_equal(info.point_count, 3);
        assert_int_equal(info.attributes, STP_POINT_HAS_NORMAL | STP_POINT_HAS_COLOUR |
                                              STP_POINT_HAS_INTENSITY | STP_POINT_HAS_CLASS);
        assert_true(info.coordinate_step == 0.0);
        scan_fixture_position(&p[0], 1.5, 100.0, -1.0);
        scan_fixture_position(&p[1], -2.25, 0.0, 0.5);
        scan_fixture_position(&p[2], 1e-3, 7.0, 4096.0);
        scan_fixture_normal(&p[0], 0, 0, -1);
        scan_fixture_normal(&p[1], 0, 1, 0);
        scan_fixture_normal(&p[2], 0.6, 0, 0.8);
        scan_fixture_rgb(&p[0], 0x1010, 0x2020, 0x3030);
        scan_fixture_rgb(&p[1], 0xFFFF, 0xFFFF, 0xFFFF);
        scan_fixture_rgb(&p[2], 0x0101, 0x0202, 0x0303);
        scan_fixture_scalars(&p[0], 0, 0);
        scan_fixture_scalars(&p[1], 51 * 257, 6);
        scan_fixture_scalars(&p[2], 65535, 255);
        for (int i = 0; i < 3; i++) {
            assert_int_equal(p[i].reject, STP_REJECT_NONE);
            assert_int_equal(p[i].station, 1);
        }
        free(p);
    }
}

static void left_out_is_said(void **state)
{
    (void)state;
    const double zeros[12] = {0};
    const pcd_column columns[] = {
        COLUMN("x", 'F', 4, xs),
        COLUMN("y", 'F', 4, ys),
        COLUMN("z", 'F', 4, zs),
        {"_", 'U', 1, 1, zeros},
        COLUMN("normal_x", 'F', 4, zeros),
        {"fpfh", 'F', 4, 4, zeros},
        COLUMN("x", 'F', 4, zeros),
        COLUMN("rgb", 'U', 2, zeros),
        COLUMN("curvature", 'F', 4, zeros),
    };
    const pcd_file file = three_points(columns, sizeof columns / sizeof *columns);
    byte_row bytes = pcd_make(&file, PCD_BINARY);
    stp_scan *scan = NULL;
    scan_fixture_bytes("left.pcd", bytes.data, bytes.size);
    bytes_free(&bytes);
    assert_int_equal(stp_scan_open(&scan, "left.pcd", NULL, NULL), STP_OK);
    const stp_scan_info *info = stp_scan_get_info(scan);
    assert_int_equal(info->attributes, 0);
    assert_int_equal(info->note_count, 1);
    assert_string_equal(info->notes[0].name, "left_out");
    assert_string_equal(info->notes[0].text, "normal_x, fpfh, x, rgb, curvature");
    stp_scan_close(&scan);
}

static void every_type(void **state)
{
    (void)state;
    static const struct {
        char type;
        unsigned size;
        double low, high;
    } types[] = {
        {'I', 1, -128.0, 127.0},
        {'I', 2, -32768.0, 32767.0},
        {'I', 4, -2147483648.0, 2147483647.0},
        {'I', 8, -9007199254740992.0, 9007199254740992.0},
        {'U', 1, 0.0, 255.0},
        {'U', 2, 0.0, 65535.0},
        {'U', 4, 0.0, 4294967295.0},
        {'U', 8, 0.0, 9007199254740992.0},
        {'F', 4, -16777215.0, 0.1f},
        {'F', 8, -1e300, 0.1},
    };
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        const double values[] = {types[i].low, types[i].high, 1.0};
        const pcd_column columns[] = {COLUMN("x", types[i].type, types[i].size, values),
                                      COLUMN("y", types[i].type, types[i].size, values),
                                      COLUMN("z", types[i].type, types[i].size, values)};
        const pcd_file file = three_points(columns, 3);
        for (int e = 0; e < PCD_ENCODING_COUNT; e++) {
            stp_scan_info info;
            stp_point *p = read_as(&file, (pcd_encoding)e, &info);
            for (int k = 0; k < 3; k++)
                scan_fixture_position(&p[k], values[k], values[k], values[k]);
            assert_true(info.coordinate_step == (types[i].type == 'F' ? 0.0 : 1.0));
            free(p);
        }
    }
}

/* Colours packed as a float, whose bits may be a NaN with a payload, as different writers pack
 * them. */
static void packed_colours(void **state)
{
    (void)state;
    static const double nans[] = {0xFFA05070u, 0xFF801020u, 0x7F812345u};
    stp_scan_info info;
    const pcd_column binary[] = {COLUMN("x", 'F', 4, xs), COLUMN("y", 'F', 4, ys),
                                 COLUMN("z", 'F', 4, zs), COLUMN("rgb", 'P', 4, nans)};
    const pcd_file file = three_points(binary, 4);
    for (int e = PCD_BINARY; e <= PCD_COMPRESSED; e++) {
        stp_point *p = read_as(&file, (pcd_encoding)e, &info);
        scan_fixture_rgb(&p[0], 0xA0A0, 0x5050, 0x7070);
        scan_fixture_rgb(&p[1], 0x8080, 0x1010, 0x2020);
        scan_fixture_rgb(&p[2], 0x8181, 0x2323, 0x4545);
        free(p);
    }
    stp_point *p = scan_fixture_points("signed.pcd",
                                       "VERSION .7\nFIELDS x y z rgba\nSIZE 4 4 4 4\nTYPE F F F I\n"
                                       "WIDTH 1\nDATA ascii\n0 0 0 -16777215\n", /* 0xFF000001 */
                                       &info);
    scan_fixture_rgb(&p[0], 0, 0, 0x0101);
    free(p);
}

/* Reads a file whose column rgb of type F has these four texts. */
static stp_point *read_packed(const char *texts[4])
{
    char file[512];
    stp_scan_info info;
    snprintf(file, sizeof file,
             "VERSION .7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH 4\nDATA ascii\n"
             "0 0 0 %s\n0 0 0 %s\n0 0 0 %s\n0 0 0 %s\n",
             texts[0], texts[1], texts[2], texts[3]);
    return scan_fixture_points("packed.pcd", file, &info);
}

/* Type F as text: some programs print the float, others the integer. The whole column decides. */
static void packed_text(void **state)
{
    (void)state;
    /* the float 4210800 has the bits 0x4A8080E0, 5.9e-39 0x00403ECD, -1 0xBF800000 */
    const char *floats[] = {"4.2108e+06", "5.9e-39", "-1", "nan"};
    stp_point *p = read_packed(floats);
    scan_fixture_rgb(&p[0], 0x8080, 0x8080, 0xE0E0);
    scan_fixture_rgb(&p[1], 0x4040, 0x3E3E, 0xCDCD);
    scan_fixture_rgb(&p[2], 0x8080, 0x0000, 0x0000);
    scan_fixture_rgb(&p[3], 0, 0, 0);
    free(p);
    /* all are rounded, or a whole number stands beside one that is not */
    const char *rounded[] = {"4.2108e+06", "4210800", "4.2108e6", "4.2108E+06"};
    p = read_packed(rounded);
    for (int i = 0; i < 4; i++)
        scan_fixture_rgb(&p[i], 0x8080, 0x8080, 0xE0E0);
    free(p);
    /* 0x404070 and 0xFF0000, with all digits of an integer */
    const char *integers[] = {"4210800", "4.210800e+06", "4.210800000000000000e+06", "16711680.0"};
    p = read_packed(integers);
    for (int i = 0; i < 3; i++)
        scan_fixture_rgb(&p[i], 0x4040, 0x4040, 0x7070);
    scan_fixture_rgb(&p[3], 65535, 0, 0);
    free(p);
}

static void colours_in_parts(void **state)
{
    (void)state;
    static const struct {
        char type;
        unsigned size;
        double high;
    } kinds[] = {{'U', 1, 255}, {'U', 2, 255}, {'U', 2, 65535}, {'F', 4, 1.0}, {'F', 4, 255.0}};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        const double r[] = {0, 0, 0}, g[] = {kinds[i].high, 0, kinds[i].high};
        const double b[] = {0, kinds[i].high, kinds[i].high};
        const pcd_column columns[] = {COLUMN("x", 'F', 4, xs),
                                      COLUMN("y", 'F', 4, ys),
                                      COLUMN("z", 'F', 4, zs),
                                      COLUMN("b", kinds[i].type, kinds[i].size, b),
                                      COLUMN("g", kinds[i].type, kinds[i].size, g),
                                      COLUMN("r", kinds[i].type, kinds[i].size, r)};
        const pcd_file file = three_points(columns, 6);
        for (int e = 0; e < PCD_ENCODING_COUNT; e++) {
            stp_scan_info info;
            stp_point *p = read_as(&file, (pcd_encoding)e, &info);
            assert_int_equal(info.attributes, STP_POINT_HAS_COLOUR);
            scan_fixture_rgb(&p[0], 0, 65535, 0);
            scan_fixture_rgb(&p[1], 0, 0, 65535);
            scan_fixture_rgb(&p[2], 0, 65535, 65535);
            free(p);
        }
    }
}

/* The greatest value stands far behind the first block, so the reader must look on and come
 * back. */
static void intensity_ranges(void **state)
{
    (void)state;
    enum { POINTS = 3000 };
    static const struct {
        char type;
        unsigned size;
        double high;
    } kinds[] = {{'F', 4, 1.0},  {'F', 4, 255.0}, {'F', 8, 65535.0}, {'U', 1, 255.0},
                 {'U', 2, 4095}, {'U', 2, 200.0}, {'I', 4, 255.0}};
    static double x[POINTS], intensity[POINTS];
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        const double full =
            kinds[k].high == 4095 ? 65535.0 : (kinds[k].high == 200.0 ? 255.0 : kinds[k].high);
        for (int i = 0; i < POINTS; i++) {
            x[i] = i;
            intensity[i] = i == 2000 ? kinds[k].high : (kinds[k].high == 1.0 ? 0.5 : i % 2);
        }
        const pcd_column columns[] = {COLUMN("x", 'F', 4, x), COLUMN("y", 'F', 4, x),
                                      COLUMN("z", 'F', 4, x),
                                      COLUMN("intensity", kinds[k].type, kinds[k].size, intensity)};
        const pcd_file file = {columns, 4, POINTS, 1, NULL};
        for (int e = 0; e < PCD_ENCODING_COUNT; e++) {
            stp_scan_info info;
            stp_point *p = read_as(&file, (pcd_encoding)e, &info);
            for (int i = 0; i < POINTS; i++) {
                assert_true(p[i].position.x == i);
                assert_int_equal(p[i].intensity, lround(intensity[i] * 65535.0 / full));
            }
            free(p);
        }
    }
}

static void missing_points(void **state)
{
    (void)state;
    static const double gaps[] = {1, NAN, 3, INFINITY, 5, 6};
    static const double line[] = {0, 0, 0, 0, 0, 0};
    const pcd_column columns[] = {COLUMN("x", 'F', 4, line), COLUMN("y", 'F', 4, gaps),
                                  COLUMN("z", 'F', 4, line)};
    for (int e = 0; e < PCD_ENCODING_COUNT; e++) {
        stp_scan_info info;
        const pcd_file organised = {columns, 3, 3, 2, NULL};
        stp_point *p = read_as(&organised, (pcd_encoding)e, &info);
        for (int i = 0; i < 6; i++)
            assert_int_equal(p[i].reject,
                             i == 1 || i == 3 ? STP_REJECT_NO_RETURN : STP_REJECT_NONE);
        free(p);
        const pcd_file loose = {columns, 3, 6, 1, NULL};
        p = read_as(&loose, (pcd_encoding)e, &info);
        for (int i = 0; i < 6; i++) {
            assert_int_equal(p[i].reject, STP_REJECT_NONE); /* the caller counts the rejects */
            assert_int_equal(stp_dvec3_finite(p[i].position), i != 1 && i != 3);
        }
        free(p);
    }
}

/* Two pixels at (0, 0, 0) are holes, one may be a point. Of a cloud that is no image, all are
 * points. Points after them are read as before. */
static void zeros_are_holes(void **state)
{
    (void)state;
    enum { COUNT = 1400 }; /* several blocks */
    for (int zeros = 1; zeros < 4; zeros++) {
        double x[COUNT], y[COUNT];
        for (int i = 0; i < COUNT; i++)
            x[i] = y[i] = i % 699 == 1 && i / 699 < zeros ? 0.0 : i + 1.0;
        const pcd_column columns[] = {COLUMN("x", 'F', 4, x), COLUMN("y", 'F', 8, y),
                                      COLUMN("z", 'F', 4, x)};
        for (int e = 0; e < 2 * PCD_ENCODING_COUNT; e++) {
            const size_t rows = e < PCD_ENCODING_COUNT ? 2 : 1;
            const pcd_file file = {columns, 3, COUNT / rows, rows, NULL};
            stp_scan_info info;
            stp_point *p = read_as(&file, (pcd_encoding)(e % PCD_ENCODING_COUNT), &info);
            for (int i = 0; i < COUNT; i++) {
                const bool is_hole = rows > 1 && zeros > 1 && x[i] == 0.0;
                assert_int_equal(p[i].reject, is_hole ? STP_REJECT_ORIGIN : STP_REJECT_NONE);
                scan_fixture_position(&p[i], x[i], y[i], x[i]);
            }
            free(p);
        }
    }
}

static void viewpoints(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        bool is_station;
        stp_station_word word;
        stp_dvec3 position;
    } cases[] = {
        {NULL, true, STP_STATION_DEFAULT, {0, 0, 0}},
        {"0 0 0 1 0 0 0", true, STP_STATION_DEFAULT, {0, 0, 0}},
        {"0.0 0 0 1.0 0 0 0", true, STP_STATION_DEFAULT, {0, 0, 0}},
        {"0 0 0 0 1 0 0", true, STP_STATION_CLAIMED, {0, 0, 0}},
        {"1.5 -2 1e3 1 0 0 0", true, STP_STATION_CLAIMED, {1.5, -2, 1000}},
        {"nan 0 0 1 0 0 0", false, STP_STATION_TOLD, {0, 0, 0}},
    };
    const pcd_column columns[] = {COLUMN("x", 'F', 4, xs), COLUMN("y", 'F', 4, ys),
                                  COLUMN("z", 'F', 4, zs)};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const pcd_file file = {columns, 3, 3, 1, cases[i].text};
        byte_row bytes = pcd_make(&file, PCD_BINARY);
        stp_scan *scan = NULL;
        stp_point p[4];
        size_t count;
        scan_fixture_bytes("view.pcd", bytes.data, bytes.size);
        bytes_free(&bytes);
        assert_int_equal(stp_scan_open(&scan, "view.pcd", NULL, NULL), STP_OK);
        const stp_scan_info *info = stp_scan_get_info(scan);
        assert_int_equal(info->station_count, cases[i].is_station);
        assert_int_equal(!!(info->attributes & STP_POINT_HAS_STATION),
                         cases[i].word == STP_STATION_CLAIMED);
        assert_int_equal(info->station_word, cases[i].word);
        if (cases[i].is_station)
            assert_memory_equal(&info->stations[0], &cases[i].position, sizeof *info->stations);
        assert_int_equal(stp_scan_read(scan, p, 4, &count, NULL), STP_OK);
        assert_int_equal(count, 3);
        for (int k = 0; k < 3; k++)
            assert_int_equal(p[k].station, cases[i].is_station);
        stp_scan_close(&scan);
    }
}

/* Headers as different versions and writers write them. */
static void headers(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "# .PCD v.5 - Point Cloud Data file format\nVERSION .5\nFIELDS x y z\nSIZE 4 4 4\n"
        "TYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1 2 3\n4 5 6\n",
        "# .PCD v.6\r\nVERSION 0.6\r\nCOLUMNS x y z\r\nSIZE 4 4 4\r\nTYPE F F F\r\nPOINTS 2\r\n"
        "DATA ascii\r\n1 2 3\r\n\r\n4\t5  6\r\n",
        "\n# a comment\n#\nVERSION .7\nFIELDS x y z\n\nSIZE 8 4 1\nTYPE F I U\nHEIGHT 2\nWIDTH 1\n"
        "# .PCD\nDATA ASCII\n  1 2 3\n4 5 6",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        stp_scan_info info;
        stp_point *p = scan_fixture_points("header.scan", texts[i], &info);
        assert_string_equal(info.format, "PCD ascii");
        assert_int_equal(info.point_count, 2);
        scan_fixture_position(&p[0], 1, 2, 3);
        scan_fixture_position(&p[1], 4, 5, 6);
        free(p);
    }
}

static void no_points(void **state)
{
    (void)state;
    const pcd_column columns[] = {COLUMN("x", 'F', 4, xs), COLUMN("y", 'F', 4, ys),
                                  COLUMN("z", 'F', 4, zs), COLUMN("intensity", 'F', 4, zs)};
    const pcd_file file = {columns, 4, 0, 1, NULL};
    for (int e = 0; e < PCD_ENCODING_COUNT; e++) {
        stp_scan_info info;
        stp_point *p = read_as(&file, (pcd_encoding)e, &info);
        assert_int_equal(info.point_count, 0);
        free(p);
    }
}

/* Many blocks, with matches that are near, far, overlapping and long, and stretches without
 * matches. */
static void large_compressed(void **state)
{
    (void)state;
    enum { POINTS = 60000 };
    double *x = calloc(POINTS, sizeof *x), *y = calloc(POINTS, sizeof *y);
    double *z = calloc(POINTS, sizeof *z), *label = calloc(POINTS, sizeof *label);
    assert_true(x && y && z && label);
    for (int i = 0; i < POINTS; i++) {
        x[i] = (double)(stp_random_u64(7, (uint64_t)i) >> 40);
        y[i] = i % 1000;
        z[i] = i / 30000;
        label[i] = (i / 5000) % 7;
    }
    const pcd_column columns[] = {COLUMN("x", 'F', 4, x), COLUMN("y", 'F', 8, y),
                                  COLUMN("z", 'F', 4, z), COLUMN("label", 'U', 1, label)};
    const pcd_file file = {columns, 4, POINTS, 1, NULL};
    stp_scan_info info;
    stp_point *p = read_as(&file, PCD_COMPRESSED, &info);
    for (int i = 0; i < POINTS; i++) {
        scan_fixture_position(&p[i], x[i], y[i], z[i]);
        assert_int_equal(p[i].class_id, label[i]);
    }
    free(p);
    free(x);
    free(y);
    free(z);
    free(label);
}

#define XYZ "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n"

static void malformed_headers(void **state)
{
    (void)state;
    static const scan_malformed cases[] = {
        {"bad.pcd", "# .PCD v.7\n", STP_CORRUPT, "no line DATA"},
        {"bad.pcd", "VERSION .7\nFIELDS x y z\n", STP_CORRUPT, "no line DATA"},
        {"bad.pcd", "VERSION .8\n", STP_VERSION, "line 1 of the PCD header declares version `.8`"},
        {"bad.pcd", "VERSION\n", STP_VERSION, "version ``"},
        {"bad.pcd", "VERSION .7\nFIELD x y z\n", STP_CORRUPT,
         "line 2 of the PCD header begins with `FIELD`"},
        {"bad.pcd", "VERSION .7\nSIZE 4 4 4\n", STP_CORRUPT, "line 2"},
        {"bad.pcd", "VERSION .7\nFIELDS x y z\nSIZE 4 4\n", STP_CORRUPT,
         "2 values of SIZE for 3 fields"},
        {"bad.pcd", "VERSION .7\nFIELDS x y z\nSIZE 4 4 4 4\n", STP_CORRUPT, "more values of SIZE"},
        {"bad.pcd", "VERSION .7\nFIELDS x y z\nSIZE 4 3 4\n", STP_UNSUPPORTED, "`y` 3 bytes"},
        {"bad.pcd", "VERSION .7\nFIELDS x y z\nSIZE 4 -4 4\n", STP_CORRUPT, "`-4`"},
        {"bad.pcd", "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F C\n", STP_UNSUPPORTED,
         "type `C`"},
        {"bad.pcd", "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F FF\n", STP_UNSUPPORTED,
         "type `FF`"},
        {"bad.pcd", "VERSION .7\nFIELDS x y z\nFIELDS x y z\n", STP_CORRUPT, "again"},
        {"bad.pcd", "VERSION .7\nFIELDS x y \x01z\n", STP_CORRUPT, "names field 3 in characters"},
        {"bad.pcd", XYZ "COUNT 1 0 1\n", STP_CORRUPT, "gives field `y` no values"},
        {"bad.pcd", XYZ "COUNT 1 1 18446744073709551615\nWIDTH 1\nDATA binary\n", STP_LIMIT,
         "records of more than"},
        {"bad.pcd", XYZ "COUNT 1 1 18446744073709551616\n", STP_CORRUPT, "18446744073709551616"},
        {"bad.pcd", XYZ "COUNT 1 4194304 1\nWIDTH 1\nDATA binary\n", STP_LIMIT,
         "records of more than"},
        {"bad.pcd", XYZ "COUNT 1 2 1\nWIDTH 1\nDATA ascii\n1 2 3 4\n", STP_CORRUPT,
         "without a field `y`"},
        {"bad.pcd", XYZ "VIEWPOINT 0 0 0 1 0 0\n", STP_CORRUPT, "value 7 of the 7"},
        {"bad.pcd", XYZ "VIEWPOINT 0 zero 0 1 0 0 0\n", STP_CORRUPT, "value 2 of the 7"},
        {"bad.pcd", XYZ "WIDTH\n", STP_CORRUPT, "WIDTH without a number"},
        {"bad.pcd", XYZ "WIDTH 1.5\n", STP_CORRUPT, "`1.5`"},
        {"bad.pcd", XYZ "DATA ascii\n", STP_CORRUPT, "without WIDTH or POINTS"},
        {"bad.pcd", XYZ "WIDTH 2\nPOINTS 3\nDATA ascii\n", STP_CORRUPT, "do not agree"},
        {"bad.pcd", XYZ "WIDTH 4294967296\nHEIGHT 4294967297\nPOINTS 4294967296\nDATA binary\n",
         STP_CORRUPT, "do not agree"},
        {"bad.pcd", XYZ "POINTS 1\nDATA zipped\n", STP_UNSUPPORTED, "DATA `zipped`"},
        {"bad.pcd", XYZ "POINTS 1\nDATA binary_compresse\n", STP_UNSUPPORTED, "binary_compresse"},
        {"bad.pcd", "VERSION .7\nPOINTS 1\nDATA ascii\n", STP_CORRUPT,
         "without FIELDS, SIZE and TYPE"},
        {"bad.pcd", "VERSION .7\nFIELDS x y z\nTYPE F F F\nPOINTS 1\nDATA ascii\n", STP_CORRUPT,
         "without FIELDS, SIZE and TYPE"},
        {"bad.pcd",
         "VERSION .7\nFIELDS x y w\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA ascii\n0 0 0\n",
         STP_CORRUPT, "without a field `z`"},
        {"bad.pcd", "VERSION .7\nFIELDS x y z\nSIZE 4 2 4\nTYPE F F F\nPOINTS 1\nDATA binary\n",
         STP_UNSUPPORTED, "`y` of type F and 2 bytes"},
    };
    scan_fixture_malformed(cases, sizeof cases / sizeof *cases);
}

static void malformed_data(void **state)
{
    (void)state;
    static const scan_malformed cases[] = {
        {"bad.pcd", XYZ "POINTS 2\nDATA ascii\n0 0 0\n", STP_CORRUPT, "declares 2 points"},
        {"bad.pcd", XYZ "POINTS 2\nDATA ascii\n0.25 0.5 0.125\n\n", STP_CORRUPT,
         "ends at line 8 after 1 of 2"},
        {"bad.pcd", XYZ "POINTS 99999999999999999\nDATA ascii\n0 0 0\n", STP_CORRUPT,
         "99999999999999999"},
        {"bad.pcd", XYZ "POINTS 2\nDATA ascii\n0 0 0\n1 abc 1\n", STP_CORRUPT, "line 8: `abc`"},
        {"bad.pcd", XYZ "POINTS 2\nDATA ascii\n0.5 0.5 0.5\n1 1\n", STP_CORRUPT,
         "line 8 has fewer values"},
        {"bad.pcd", XYZ "POINTS 1\nDATA ascii\n0 0 0 1\n", STP_CORRUPT, "line 7 has more values"},
        {"bad.pcd", XYZ "POINTS 1\nDATA binary\n12345678901", STP_CORRUPT, "hold 0"},
        {"bad.pcd", XYZ "POINTS 18446744073709551615\nDATA binary\n123456789012", STP_CORRUPT,
         "18446744073709551615 points"},
        {"bad.pcd", XYZ "POINTS 1\nDATA binary_compressed\n1234567", STP_CORRUPT, "after 0 of 1"},
        {"bad.pcd", XYZ "POINTS 18446744073709551615\nDATA binary_compressed\n12345678",
         STP_CORRUPT, "18446744073709551615 points"},
    };
    scan_fixture_malformed(cases, sizeof cases / sizeof *cases);
}

/* Checks a point whose 12 bytes are compressed to these bytes. */
static void check_compressed(const void *bytes, size_t size, int64_t more_in, int64_t more_out,
                             const char *text)
{
    byte_row file = {0};
    bytes_text(&file, XYZ "POINTS 1\nDATA binary_compressed\n");
    bytes_integer(&file, (uint64_t)((int64_t)size + more_in), 4);
    bytes_integer(&file, (uint64_t)(12 + more_out), 4);
    bytes_add(&file, bytes, size);
    scan_fixture_bytes("lzf.pcd", file.data, file.size);
    bytes_free(&file);
    if (text) {
        scan_fixture_fails("lzf.pcd", NULL, STP_CORRUPT, text);
        return;
    }
    stp_scan_info info;
    stp_point *p = scan_fixture_read("lzf.pcd", NULL, &info);
    float ones;
    memset(&ones, 1, sizeof ones);
    scan_fixture_position(p, (double)ones, (double)ones, (double)ones);
    free(p);
}

/* Twelve bytes of 1, compressed rightly and wrongly. */
static void compressed_blocks(void **state)
{
    (void)state;
    check_compressed("\x00\x01\xe0\x02\x00", 5, 0, 0, NULL); /* one, then 11 from 1 back */
    check_compressed("\x0b\1\1\1\1\1\1\1\1\1\1\1\1", 13, 0, 0, NULL);
    check_compressed("\x01\x01\x01\x40\x01\x60\x00\x00\x01", 9, 0, 0, NULL); /* 2, 4, 5, 1 */
    check_compressed("\x00\x01\xe0\x03\x00", 5, 0, 0, "holds more than is declared");
    check_compressed("\x0c\1\1\1\1\1\1\1\1\1\1\1\1\1", 14, 0, 0, "holds more than is declared");
    check_compressed("\x00\x01\xe0\x01\x00", 5, 0, 0, "ends early");
    check_compressed("\x00\x01\xe0\x02\x01", 5, 0, 0, "before its begin");
    check_compressed("\xe0\x03\x00", 3, 0, 0, "before its begin");
    check_compressed("\x00\x01\xe0\x02", 4, 0, 0, "ends early");
    check_compressed("\x00\x01\xe0", 3, 0, 0, "ends early");
    check_compressed("\x00", 1, 0, 0, "ends early");
    check_compressed("", 0, 0, 0, "ends early");
    check_compressed("\x00\x01\xe0\x02\x00\x00\x01", 7, 0, 0, "goes on behind its last value");
    check_compressed("\x00\x01\xe0\x02\x00", 5, 1, 0, "6 bytes of compressed data");
    check_compressed("\x00\x01\xe0\x02\x00", 5, -1, 0, "ends early");
    check_compressed("\x00\x01\xe0\x02\x00", 5, 0, 1, "declares 13 bytes");
    check_compressed("\x00\x01\xe0\x02\x00", 5, 0, -12, "declares 0 bytes");
}

/* Cuts each encoding anywhere: reading must fail with a sentence. */
static void cut_anywhere(void **state)
{
    (void)state;
    const pcd_column columns[] = {COLUMN("x", 'F', 4, xs), COLUMN("y", 'F', 4, ys),
                                  COLUMN("z", 'F', 4, zs), COLUMN("rgb", 'P', 4, packed),
                                  COLUMN("intensity", 'F', 4, ys)};
    const pcd_file file = three_points(columns, 5);
    for (int e = 0; e < PCD_ENCODING_COUNT; e++) {
        byte_row bytes = pcd_make(&file, (pcd_encoding)e);
        /* text ends with "0 " and the end of the line: a cut last number would still be a number */
        const size_t whole = e == PCD_ASCII ? bytes.size - 5 : bytes.size;
        scan_fixture_expect_cuts("cut.pcd", bytes.data, whole, NULL);
        bytes_free(&bytes);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fields_in_any_order), cmocka_unit_test(left_out_is_said),
        cmocka_unit_test(every_type),          cmocka_unit_test(packed_colours),
        cmocka_unit_test(packed_text),         cmocka_unit_test(colours_in_parts),
        cmocka_unit_test(intensity_ranges),    cmocka_unit_test(missing_points),
        cmocka_unit_test(viewpoints),          cmocka_unit_test(headers),
        cmocka_unit_test(no_points),           cmocka_unit_test(large_compressed),
        cmocka_unit_test(malformed_headers),   cmocka_unit_test(malformed_data),
        cmocka_unit_test(compressed_blocks),   cmocka_unit_test(cut_anywhere),
        cmocka_unit_test(zeros_are_holes),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

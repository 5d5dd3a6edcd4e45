/* Tests the PLY reader on valid files: encodings, types, properties, elements, colours. */
#include "tests/fixtures/scan/scan_fixture.h"

#include <math.h>

/* Builds a binary PLY byte by byte, in either byte order. */
typedef struct ply_bytes {
    unsigned char data[4096];
    size_t size;
    bool big_endian;
} ply_bytes;

static void add_text(ply_bytes *p, const char *text)
{
    memcpy(p->data + p->size, text, strlen(text));
    p->size += strlen(text);
}

static void add_raw(ply_bytes *p, const void *value, size_t size)
{
    for (size_t i = 0; i < size; i++)
        p->data[p->size + i] = ((const unsigned char *)value)[p->big_endian ? size - 1 - i : i];
    p->size += size;
}

static void add_float(ply_bytes *p, float value)
{
    add_raw(p, &value, sizeof value);
}

static void add_double(ply_bytes *p, double value)
{
    add_raw(p, &value, sizeof value);
}

static void add_u8(ply_bytes *p, unsigned value)
{
    const uint8_t byte = (uint8_t)value;
    add_raw(p, &byte, 1);
}

static void add_u16(ply_bytes *p, unsigned value)
{
    const uint16_t word = (uint16_t)value;
    add_raw(p, &word, 2);
}

static void add_i32(ply_bytes *p, int32_t value)
{
    add_raw(p, &value, 4);
}

static void ascii_in_any_order(void **state)
{
    (void)state;
    stp_scan_info info;
    stp_point *points =
        scan_fixture_points("order.ply",
                            "ply\nformat ascii 1.0\ncomment element vertex 7\n"
                            "obj_info num_cols 512\nelement vertex 2\n"
                            "property uchar blue\nproperty double z\nproperty float nz\n"
                            "property float32 x\nproperty float confidence\n"
                            "property uint8 red\nproperty float nx\nproperty float64 y\n"
                            "property float ny\nproperty uchar green\nend_header\n"
                            "3 -2.5 4 1e3 0.5 1 0 0.1 3 2\n"
                            "\n  255\t1.5 0 .25 0 128 0 +7 0 0   \n",
                            &info);
    assert_string_equal(info.format, "PLY ascii");
    assert_int_equal(info.point_count, 2);
    assert_int_equal(info.attributes, STP_POINT_HAS_NORMAL | STP_POINT_HAS_COLOUR);
    assert_false(info.normals_from_faces);
    scan_fixture_position(&points[0], 1000.0, 0.1, -2.5);
    scan_fixture_normal(&points[0], 0.0, 0.6, 0.8);
    scan_fixture_rgb(&points[0], 257, 514, 771);
    scan_fixture_position(&points[1], 0.25, 7.0, 1.5);
    scan_fixture_normal(&points[1], 0.0, 0.0, 0.0);
    scan_fixture_rgb(&points[1], 128 * 257, 0, 65535);
    free(points);
}

static void ascii_numbers(void **state)
{
    (void)state;
    stp_scan_info info;
    stp_point *points =
        scan_fixture_points("numbers.ply",
                            "ply\r\nformat ascii 1.0\r\nelement vertex 6\r\nproperty double x\r\n"
                            "property double y\r\nproperty double z\r\nend_header\r\n"
                            "5400000.456000001 -0.35444599999999998 1.7976931348623157e308\r\n"
                            "4.9406564584124654e-324 123456789012345678901234567890 1e400\r\n"
                            "nan -nan(ind) -1.#IND\r\nInf -inf -1.#INF\r\n"
                            "0.1e1 1E-5 -.5e+1\r\n1. -0 00012\r\n",
                            &info);
    scan_fixture_position(&points[0], 5400000.456000001, -0.35444599999999998,
                          1.7976931348623157e308);
    scan_fixture_position(&points[1], 4.9406564584124654e-324, 123456789012345678901234567890.0,
                          INFINITY);
    assert_true(isnan(points[2].position.x) && isnan(points[2].position.y) &&
                isnan(points[2].position.z));
    scan_fixture_position(&points[3], INFINITY, -INFINITY, -INFINITY);
    scan_fixture_position(&points[4], 1.0, 1e-5, -5.0);
    scan_fixture_position(&points[5], 1.0, -0.0, 12.0);
    free(points);
}

/* All eight types, a list inside the vertex and one before it, and other elements around it. */
static void check_binary(bool big_endian)
{
    ply_bytes p = {.big_endian = big_endian};
    add_text(&p, "ply\nformat ");
    add_text(&p, big_endian ? "binary_big_endian" : "binary_little_endian");
    add_text(&p, " 1.0\nelement camera 1\nproperty float view_px\nproperty double f\n"
                 "element strange 2\nproperty list uchar short ids\nproperty char c\n"
                 "element vertex 2\nproperty ushort intensity\nproperty list int float w\n"
                 "property int x\nproperty double y\nproperty short z\nproperty uchar class\n"
                 "property uint u\nelement user 1\nproperty char c\nend_header\n");
    add_float(&p, 1.0f);
    add_double(&p, 2.0);
    add_u8(&p, 3);
    for (unsigned i = 0; i < 3; i++)
        add_u16(&p, i);
    add_u8(&p, 9);
    add_u8(&p, 0);
    add_u8(&p, 9);
    for (int i = 0; i < 2; i++) {
        add_u16(&p, i == 0 ? 60000 : 300);
        add_i32(&p, i);
        for (int k = 0; k < i; k++)
            add_float(&p, 5.0f);
        add_i32(&p, i == 0 ? -2000000000 : 17);
        add_double(&p, 0.1 + i);
        add_u16(&p, i == 0 ? (unsigned)-3 : 4);
        add_u8(&p, i == 0 ? 2 : 200);
        add_i32(&p, -1);
    }
    scan_fixture_bytes("types.ply", p.data, p.size);
    stp_scan_info info;
    stp_point *points = scan_fixture_read("types.ply", NULL, &info);
    assert_int_equal(info.attributes, STP_POINT_HAS_INTENSITY | STP_POINT_HAS_CLASS);
    scan_fixture_position(&points[0], -2000000000.0, 0.1, -3.0);
    scan_fixture_position(&points[1], 17.0, 1.1, 4.0);
    scan_fixture_scalars(&points[0], 60000, 2);
    scan_fixture_scalars(&points[1], 300, 200);
    free(points);
}

static void binary_little_endian(void **state)
{
    (void)state;
    check_binary(false);
}

static void binary_big_endian(void **state)
{
    (void)state;
    check_binary(true);
}

/* Lines may end in \r alone, as Rhinoceros writes them, in ASCII too. */
static void lines_in_cr(void **state)
{
    (void)state;
    static const float at[2][3] = {{1.5f, 2.5f, 13.0f}, {10.0f, 0.0f, -1.0f}}; /* \r, \n in bytes */
    char file[256] = "ply\rformat binary_little_endian 1.0\relement vertex 2\rproperty float x\r"
                     "property float y\rproperty float z\rend_header\r";
    const size_t header = strlen(file);
    memcpy(file + header, at, sizeof at);
    scan_fixture_bytes("cr.ply", file, header + sizeof at);
    stp_scan_info info;
    stp_point *points = scan_fixture_read("cr.ply", NULL, &info);
    for (int i = 0; i < 2; i++)
        scan_fixture_position(&points[i], (double)at[i][0], (double)at[i][1], (double)at[i][2]);
    free(points);
    points = scan_fixture_points("cr.ply",
                                 "ply\rformat ascii 1.0\relement vertex 2\rproperty float x\r"
                                 "property float y\rproperty float z\rend_header\r1 2 3\r4 5 6\r",
                                 &info);
    scan_fixture_position(&points[1], 4.0, 5.0, 6.0);
    free(points);
}

/* The header's lines may end in \r\n, and the data begins directly after; \r and \n in the data
 * must stay. */
static void binary_after_crlf(void **state)
{
    (void)state;
    ply_bytes p = {0};
    const char text[] = "\r\n\r\n\r\n\r\n\r\n\r\n";
    float expected;
    memcpy(&expected, text, sizeof expected);
    add_text(&p,
             "ply\r\nformat binary_little_endian 1.0\r\nelement vertex 1\r\nproperty float x\r\n"
             "property float y\r\nproperty float z\r\nend_header\r\n");
    add_text(&p, text);
    add_text(&p, "trailing bytes are tolerated");
    scan_fixture_bytes("crlf.ply", p.data, p.size);
    stp_scan_info info;
    stp_point *points = scan_fixture_read("crlf.ply", NULL, &info);
    scan_fixture_position(&points[0], (double)expected, (double)expected, (double)expected);
    free(points);
}

typedef struct depth_case {
    const char *type, *values;
    unsigned first[3];
} depth_case;

/* The data decides what a colour value means. */
static void colour_depths(void **state)
{
    (void)state;
    const depth_case cases[] = {
        {"uchar", "1 2 255\n0 0 0\n", {257, 514, 65535}},
        {"ushort", "1 2 255\n0 7 0\n", {257, 514, 65535}},
        {"ushort", "1 2 255\n0 4096 0\n", {1, 2, 255}},
        {"ushort", "1 2 1023\n0 256 0\n", {64, 128, 65535}},
        {"ushort", "1 2 4095\n0 256 0\n", {16, 32, 65535}},
        {"int", "1 2 255\n0 0 0\n", {257, 514, 65535}},
        {"int", "-5 70000 255\n0 0 0\n", {0, 65535, 255}},
        {"float", "0.5 1 0\n0 0 0\n", {32768, 65535, 0}},
        {"float", "0.5 1.0001 0.2\n0 1.5 0\n", {32768, 65535, 13107}},
        {"float", "0.5 1 nan\n0 200 0\n", {129, 257, 0}},
        {"double", "1000 65535 2\n0 0 0\n", {1000, 65535, 2}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        static const char *const names[][3] = {{"red", "green", "blue"},
                                               {"r", "g", "b"},
                                               {"diffuse_red", "diffuse_green", "diffuse_blue"}};
        char text[1024];
        const char *const *n = names[i % 3];
        const char *second = strchr(cases[i].values, '\n') + 1, *type = cases[i].type;
        snprintf(text, sizeof text,
                 "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
                 "property float z\nproperty %s %s\nproperty %s %s\nproperty %s %s\nend_header\n"
                 "0 0 0 %.*s\n1 1 1 %s",
                 type, n[0], type, n[1], type, n[2], (int)(second - 1 - cases[i].values),
                 cases[i].values, second);
        scan_fixture_text("depth.ply", text);
        stp_scan_info info;
        stp_point *points = scan_fixture_read("depth.ply", NULL, &info);
        assert_int_equal(info.attributes, STP_POINT_HAS_COLOUR);
        scan_fixture_rgb(&points[0], cases[i].first[0], cases[i].first[1], cases[i].first[2]);
        free(points);
    }
}

/* Colours that are all zero are none. One value that is not makes them colours. */
static void all_black_is_no_colour(void **state)
{
    (void)state;
    enum { COUNT = 200000, RECORD = 15 };
    const char header[] = "ply\nformat binary_little_endian 1.0\nelement vertex 200000\n"
                          "property float x\nproperty float y\nproperty float z\n"
                          "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                          "end_header\n";
    const char ascii[] = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                         "property float y\nproperty float z\nproperty float red\n"
                         "property float green\nproperty float blue\nend_header\n"
                         "0 0 0 0 0 0\n1 1 1 0 %d 0\n";
    const size_t begin = sizeof header - 1, size = begin + (size_t)COUNT * RECORD;
    unsigned char *bytes = calloc(size, 1);
    assert_non_null(bytes);
    memcpy(bytes, header, begin);
    for (int coloured = 0; coloured < 2; coloured++) {
        char text[512];
        stp_scan_info info;
        const uint32_t expected = coloured ? STP_POINT_HAS_COLOUR : 0u;
        for (size_t i = COUNT / 2; i < COUNT; i++)
            bytes[begin + i * RECORD + 14] = (unsigned char)coloured;
        scan_fixture_bytes("black.ply", bytes, size);
        free(scan_fixture_read("black.ply", NULL, &info));
        assert_int_equal(info.attributes, expected);
        snprintf(text, sizeof text, ascii, coloured);
        free(scan_fixture_points("black.ply", text, &info));
        assert_int_equal(info.attributes, expected);
    }
    free(bytes);
}

/* White colours that hide intensities are none; colours of 0 and 1 are dark and full. */
static void colours_for_want_of_any(void **state)
{
    (void)state;
    const char head[] = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                        "property float y\nproperty float z\nproperty uchar red\n"
                        "property uchar green\nproperty uchar blue\n";
    const struct {
        const char *rest;
        uint32_t attributes;
    } cases[] = {
        {"property float intensity\nend_header\n0 0 0 255 255 255 3\n1 1 1 255 255 255 9\n",
         STP_POINT_HAS_INTENSITY},
        {"property float intensity\nend_header\n0 0 0 255 255 255 3\n1 1 1 255 254 255 9\n",
         STP_POINT_HAS_INTENSITY | STP_POINT_HAS_COLOUR},
        {"end_header\n0 0 0 255 255 255\n1 1 1 255 255 255\n", STP_POINT_HAS_COLOUR},
        {"end_header\n0 0 0 1 0 1\n1 1 1 0 0 1\n", STP_POINT_HAS_COLOUR},
    };
    stp_scan_info info;
    char text[512];
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        snprintf(text, sizeof text, "%s%s", head, cases[i].rest);
        stp_point *points = scan_fixture_points("white.ply", text, &info);
        assert_int_equal(info.attributes, cases[i].attributes);
        if (i == 3)
            scan_fixture_rgb(&points[0], 65535, 0, 65535);
        free(points);
    }
}

/* Of lines, only the first are looked at: if these are dark, 1 is not full. */
static void dark_beginning(void **state)
{
    (void)state;
    enum { COUNT = 65537 };
    stp_scan_info info;
    FILE *file = fopen("dark.ply", "wb");
    assert_non_null(file);
    fprintf(file,
            "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
            "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
            "end_header\n",
            COUNT);
    for (int i = 0; i < COUNT; i++)
        fprintf(file, "%d 0 0 %d 0 1\n", i, i == COUNT - 1 ? 200 : 1);
    assert_int_equal(fclose(file), 0);
    stp_point *points = scan_fixture_read("dark.ply", NULL, &info);
    scan_fixture_rgb(&points[0], 257, 0, 257);
    scan_fixture_rgb(&points[COUNT - 1], 200 * 257, 0, 257);
    free(points);
}

/* Gaussian splats have colours as spherical harmonics: 1/2 + 0.2820948 c. They stay attributes. */
static void splats_have_colours(void **state)
{
    (void)state;
    static const char text[] = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                               "property float y\nproperty float z\nproperty float f_dc_0\n"
                               "property float f_dc_1\nproperty float f_dc_2\n"
                               "property float opacity\nend_header\n"
                               "0 0 0 0 -0.8862269 0.8862269 1\n1 1 1 -1.7724539 1.7724539 9 1\n"
                               "2 2 2 -9 0 0 1\n";
    const stp_scan_params params = {.numbers = true};
    stp_scan_info info;
    scan_fixture_text("splats.ply", text);
    stp_point *points = scan_fixture_read("splats.ply", &params, &info);
    assert_int_equal(info.attributes, STP_POINT_HAS_COLOUR);
    scan_fixture_rgb(&points[0], 32768, 16384, 49151);
    scan_fixture_rgb(&points[1], 0, 65535, 65535);
    scan_fixture_rgb(&points[2], 0, 32768, 32768);
    free(points);
    stp_scan *scan = NULL;
    assert_int_equal(stp_scan_open(&scan, "splats.ply", &params, NULL), STP_OK);
    assert_int_equal(stp_scan_get_info(scan)->extra->count, 4);
    assert_string_equal(stp_scan_get_info(scan)->extra->items[0].name, "f_dc_0");
    stp_scan_close(&scan);
}

/* Whole colours, as PCD has them: integers, and floats of the same bits. */
static void packed_colours(void **state)
{
    (void)state;
    static const char *const types[] = {"uint rgba", "int rgb", "float rgb"};
    /* 0xff324380, and 0x324380 as an integer and as a float */
    static const char *const values[] = {"4281484160", "3294080", "4.61598925e-39"};
    for (size_t i = 0; i < 3; i++) {
        char text[512];
        stp_scan_info info;
        snprintf(text, sizeof text,
                 "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
                 "property float z\nproperty %s\nend_header\n0 0 0 %s\n1 1 1 0\n",
                 types[i], values[i]);
        scan_fixture_text("packed.ply", text);
        stp_point *points = scan_fixture_read("packed.ply", NULL, &info);
        assert_int_equal(info.attributes, STP_POINT_HAS_COLOUR);
        scan_fixture_rgb(&points[0], 257 * 0x32, 257 * 0x43, 257 * 0x80);
        scan_fixture_rgb(&points[1], 0, 0, 0);
        free(points);
    }
}

/* A binary float may have the bits of a NaN: 0xff8010c0. */
static void packed_colours_in_floats(void **state)
{
    (void)state;
    const char header[] = "ply\nformat binary_little_endian 1.0\nelement vertex 1\n"
                          "property float x\nproperty float y\nproperty float z\n"
                          "property float rgb\nend_header\n";
    unsigned char bytes[sizeof header - 1 + 16] = {0};
    static const unsigned char bits[4] = {0xc0, 0x10, 0x80, 0xff};
    memcpy(bytes, header, sizeof header); /* and a byte of x */
    memcpy(bytes + sizeof bytes - sizeof bits, bits, sizeof bits);
    scan_fixture_bytes("packed.ply", bytes, sizeof bytes);
    stp_scan_info info;
    stp_point *points = scan_fixture_read("packed.ply", NULL, &info);
    scan_fixture_rgb(&points[0], 257 * 0x80, 257 * 0x10, 257 * 0xc0);
    free(points);
}

/* Of other types the numbers are no colours, but are kept. */
static void other_numbers_of_such_names_are_kept(void **state)
{
    (void)state;
    static const char *const types[] = {"uchar rgb", "double rgba", "float scalar_rgb"};
    for (size_t i = 0; i < 3; i++) {
        char text[512];
        stp_scan *scan = NULL;
        snprintf(text, sizeof text,
                 "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                 "property float z\nproperty %s\nend_header\n0 0 0 7\n",
                 types[i]);
        scan_fixture_text("packed.ply", text);
        const stp_scan_params params = {.numbers = true};
        assert_int_equal(stp_scan_open(&scan, "packed.ply", &params, NULL), STP_OK);
        assert_int_equal(stp_scan_get_info(scan)->extra->count, 1);
        assert_false(stp_scan_get_info(scan)->attributes & STP_POINT_HAS_COLOUR);
        stp_scan_close(&scan);
    }
}

/* The values that tell 8 from 16 bits are looked for in the whole file, even if it begins dark. */
static void colour_depth_of_late_values(void **state)
{
    (void)state;
    enum { COUNT = 200000, RECORD = 18 };
    const char header[] = "ply\nformat binary_little_endian 1.0\nelement vertex 200000\n"
                          "property float x\nproperty float y\nproperty float z\n"
                          "property ushort red\nproperty ushort green\nproperty ushort blue\n"
                          "end_header\n";
    const size_t begin = sizeof header - 1, size = begin + (size_t)COUNT * RECORD;
    unsigned char *bytes = calloc(size, 1);
    assert_non_null(bytes);
    memcpy(bytes, header, begin);
    for (size_t i = 0; i < COUNT; i++)
        bytes[begin + i * RECORD + 12] = 100;
    for (size_t i = COUNT / 2; i < COUNT; i++)
        bytes[begin + i * RECORD + 15] = 100; /* green, upper byte */
    scan_fixture_bytes("late.ply", bytes, size);
    free(bytes);
    stp_scan_info info;
    stp_point *points = scan_fixture_read("late.ply", NULL, &info);
    scan_fixture_rgb(&points[0], 100, 0, 0);
    scan_fixture_rgb(&points[COUNT - 1], 100, 25600, 0);
    free(points);
}

static void scalar_fields(void **state)
{
    (void)state;
    stp_scan_info info;
    stp_point *points = scan_fixture_points(
        "fields.ply",
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
        "property float z\nproperty float normal_x\nproperty float normal_y\n"
        "property float normal_z\nproperty float scalar_Intensity\n"
        "property float scalar_Classification\nproperty float scalar_Scan\n"
        "end_header\n0 0 0 2 0 0 0.25 6 1\n0 0 0 nan 0 0 1 300 1\n",
        &info);
    assert_int_equal(info.attributes,
                     STP_POINT_HAS_NORMAL | STP_POINT_HAS_INTENSITY | STP_POINT_HAS_CLASS);
    scan_fixture_normal(&points[0], 1.0, 0.0, 0.0);
    scan_fixture_normal(&points[1], 0.0, 0.0, 0.0);
    scan_fixture_scalars(&points[0], 16384, 6);
    scan_fixture_scalars(&points[1], 65535, 255);
    free(points);
}

/* Integers of 64 bits, as programs of NumPy write them. */
static void wide_integers(void **state)
{
    (void)state;
    for (int big = 0; big < 2; big++) {
        ply_bytes p = {.big_endian = big};
        const int64_t label = 5, least = -7000000000;
        stp_scan_info info;
        add_text(&p, big ? "ply\nformat binary_big_endian 1.0\n"
                         : "ply\nformat binary_little_endian 1.0\n");
        add_text(&p, "element vertex 1\nproperty int64 label\nproperty int64 x\n"
                     "property uint64 y\nproperty float z\nend_header\n");
        add_raw(&p, &label, sizeof label);
        add_raw(&p, &least, sizeof least);
        add_raw(&p, &label, sizeof label);
        add_float(&p, 0.5f);
        scan_fixture_bytes("wide.ply", p.data, p.size);
        stp_point *points = scan_fixture_read("wide.ply", NULL, &info);
        scan_fixture_position(&points[0], -7e9, 5, 0.5);
        scan_fixture_scalars(&points[0], 0, 5);
        free(points);
    }
}

/* A structured scan: each cell of the grid names a vertex or none. The grid makes neither points
 * nor faces. */
static void range_grid(void **state)
{
    (void)state;
    stp_scan_info info;
    stp_point *points = scan_fixture_points(
        "grid.ply",
        "ply\nformat ascii 1.0\nobj_info num_cols 2\nobj_info num_rows 2\n"
        "element vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
        "element range_grid 4\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 1\n1 0 2\n1 0\n0\n0\n1 1\n",
        &info);
    assert_int_equal(info.point_count, 2);
    assert_int_equal(info.face_count, 0);
    assert_int_equal(info.attributes, 0);
    scan_fixture_position(&points[1], 1.0, 0.0, 2.0);
    free(points);
}

static void no_points(void **state)
{
    (void)state;
    stp_scan_info info;
    stp_point *points =
        scan_fixture_points("none.ply",
                            "ply\nformat binary_little_endian 1.0\nelement vertex 0\n"
                            "property float x\nproperty float y\nproperty float z\n"
                            "element face 0\nproperty list uchar int vertex_indices\n"
                            "end_header\n",
                            &info);
    assert_int_equal(info.point_count, 0);
    free(points);
}

static void recomputed_normals(void **state)
{
    (void)state;
    scan_fixture_text(
        "recompute.ply",
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
        "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
        "end_header\n0 0 0 1 0 0\n");
    stp_scan_info info;
    const stp_scan_params params = {.recompute_normals = true};
    stp_point *points = scan_fixture_read("recompute.ply", &params, &info);
    assert_int_equal(info.attributes, 0);
    scan_fixture_normal(&points[0], 0.0, 0.0, 0.0);
    free(points);
}

/* The last line may lack its end, and blocks may end anywhere within a line. */
static void many_ascii_lines(void **state)
{
    (void)state;
    enum { COUNT = 100000 };
    FILE *file = fopen("many.ply", "wb");
    assert_non_null(file);
    fprintf(file,
            "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
            "property float z\nend_header\n",
            COUNT);
    for (int i = 0; i < COUNT; i++)
        fprintf(file, "%s%d %d.5 %.*f", i ? "\n" : "", i, -i, i % 20, i / 3.0);
    assert_int_equal(fclose(file), 0);
    stp_scan_info info;
    stp_point *points = scan_fixture_read("many.ply", NULL, &info);
    for (int i = 0; i < COUNT; i++) {
        char text[64];
        snprintf(text, sizeof text, "%d.5", -i);
        const double y = strtod(text, NULL);
        snprintf(text, sizeof text, "%.*f", i % 20, i / 3.0);
        scan_fixture_position(&points[i], i, y, strtod(text, NULL));
    }
    free(points);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_in_cr),
        cmocka_unit_test(ascii_in_any_order),
        cmocka_unit_test(ascii_numbers),
        cmocka_unit_test(binary_little_endian),
        cmocka_unit_test(binary_big_endian),
        cmocka_unit_test(binary_after_crlf),
        cmocka_unit_test(colour_depths),
        cmocka_unit_test(all_black_is_no_colour),
        cmocka_unit_test(colours_for_want_of_any),
        cmocka_unit_test(dark_beginning),
        cmocka_unit_test(splats_have_colours),
        cmocka_unit_test(packed_colours),
        cmocka_unit_test(packed_colours_in_floats),
        cmocka_unit_test(other_numbers_of_such_names_are_kept),
        cmocka_unit_test(colour_depth_of_late_values),
        cmocka_unit_test(scalar_fields),
        cmocka_unit_test(wide_integers),
        cmocka_unit_test(range_grid),
        cmocka_unit_test(no_points),
        cmocka_unit_test(recomputed_normals),
        cmocka_unit_test(many_ascii_lines),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

/* Tests E57 files: fields of every width and kind, poses, limits, packets out of step. */
#include "base/random.h"
#include "tests/fixtures/scan/e57_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"

#include <math.h>

#define XYZ                                                                                        \
    E57_FLOAT("cartesianX", "double")                                                              \
    E57_FLOAT("cartesianY", "double") E57_FLOAT("cartesianZ", "double")
#define PI 3.14159265358979323846

/* Adds three bytestreams of doubles: (i, 10 i, 100 i). */
static void add_positions(e57_stream *streams, size_t count)
{
    for (size_t i = 0; i < count; i++)
        for (int axis = 0; axis < 3; axis++)
            bytes_double(&streams[axis].bytes, (double)i * pow(10.0, axis));
}

static void free_streams(e57_stream *streams, size_t count)
{
    for (size_t i = 0; i < count; i++)
        bytes_free(&streams[i].bytes);
}

/* Writes one scan of these bytestreams. */
static void write_scan(const char *path, e57_stream *streams, size_t stream_count,
                       const char *before, uint64_t records, const char *prototype,
                       const char *after)
{
    e57_file file;
    e57_begin(&file);
    e57_vector(&file, streams, stream_count, false);
    e57_scan(&file, before, records, prototype);
    e57_end(&file, after);
    e57_write(path, &file);
    e57_free(&file);
}

static void floats_and_colours(void **state)
{
    (void)state;
    e57_stream s[6] = {0};
    for (int i = 0; i < 500; i++) {
        bytes_float(&s[0].bytes, (float)i * 0.1f);
        bytes_double(&s[1].bytes, i * 0.1);
        bytes_float(&s[2].bytes, (float)-i);
        bytes_integer(&s[3].bytes, (uint64_t)i & 255u, 1);
        bytes_integer(&s[4].bytes, 255, 1);
        bytes_bits(&s[5].bytes, (uint64_t)(i % 100), 7);
    }
    write_scan("floats.e57", s, 6, "", 500,
               E57_FLOAT("cartesianX", "single") E57_FLOAT("cartesianY", "double")
                   E57_FLOAT("cartesianZ", "single") E57_INTEGER("colorRed", "0", "255")
                       E57_INTEGER("colorGreen", "0", "255") E57_INTEGER("colorBlue", "0", "99"),
               "");
    free_streams(s, 6);
    stp_scan_info info;
    stp_point *p = scan_fixture_read("floats.e57", NULL, &info);
    assert_string_equal(info.format, "E57");
    assert_int_equal(info.point_count, 500);
    assert_int_equal(info.attributes, STP_POINT_HAS_COLOUR);
    assert_int_equal(info.station_count, 0);
    assert_int_equal(info.note_count, 0);
    assert_true(info.coordinate_step == 0.0);
    for (int i = 0; i < 500; i++) {
        scan_fixture_position(&p[i], (double)((float)i * 0.1f), i * 0.1, -i);
        scan_fixture_rgb(&p[i], (unsigned)(i & 255) * 257, 65535, (unsigned)(i % 100) * 257);
        assert_int_equal(p[i].reject, STP_REJECT_NONE);
        assert_int_equal(p[i].station, 0);
    }
    free(p);
}

/* X as integers of each width. Bytestreams are cut anywhere and out of step, with other packets
 * between. */
static void every_width(void **state)
{
    (void)state;
    enum { POINTS = 1500 };
    for (unsigned bits = 0; bits <= 64; bits++) {
        const uint64_t range = bits == 64 ? UINT64_MAX : ((uint64_t)1 << bits) - 1;
        const int64_t minimum = bits == 64 ? INT64_MIN : -(int64_t)(range / 3) - 5;
        char prototype[900];
        snprintf(prototype, sizeof prototype,
                 "<cartesianX type=\"Integer\" minimum=\"%lld\" maximum=\"%lld\"/>"
                 "<rowIndex type=\"Integer\" minimum=\"0\" maximum=\"0\"/>"
                 "<cartesianY type=\"ScaledInteger\" minimum=\"0\" maximum=\"1\" scale=\"-0.5\" "
                 "offset=\"3\"/><cartesianZ type=\"Float\" precision=\"single\"/>",
                 (long long)minimum, (long long)(int64_t)((uint64_t)minimum + range));
        e57_stream s[4] = {0};
        for (uint64_t i = 0; i < POINTS; i++) {
            bytes_bits(&s[0].bytes, stp_random_u64(bits, i) & range, bits);
            bytes_bits(&s[2].bytes, i, 1);
            bytes_float(&s[3].bytes, (float)i);
        }
        s[0].part = 101;
        s[2].part = 7 + bits;
        s[3].part = 1021;
        e57_file file;
        e57_begin(&file);
        e57_vector(&file, s, 4, true);
        e57_scan(&file, "", POINTS, prototype);
        e57_end(&file, "");
        e57_write("bits.e57", &file);
        e57_free(&file);
        free_streams(s, 4);
        stp_scan_info info;
        stp_point *p = scan_fixture_read("bits.e57", NULL, &info);
        for (uint64_t i = 0; i < POINTS; i++) {
            const uint64_t raw = stp_random_u64(bits, i) & range;
            scan_fixture_position(&p[i], (double)(int64_t)((uint64_t)minimum + raw),
                                  3.0 - 0.5 * (double)(i & 1u), (double)i);
        }
        assert_int_equal(info.point_count, POINTS);
        free(p);
    }
}

/* Fields are so far out of step that they need more packets than the reader keeps: the first
 * packets hold X alone. */
static void fields_far_apart(void **state)
{
    (void)state;
    enum { POINTS = 30000 };
    e57_stream s[3] = {{.part = 60000}, {.part = 4004}, {.part = 101}};
    add_positions(s, POINTS);
    write_scan("apart.e57", s, 3, "", POINTS, XYZ, "");
    free_streams(s, 3);
    stp_scan_info info;
    stp_point *p = scan_fixture_read("apart.e57", NULL, &info);
    assert_int_equal(info.point_count, POINTS);
    for (int i = 0; i < POINTS; i++)
        scan_fixture_position(&p[i], i, 10.0 * i, 100.0 * i);
    free(p);
}

static void scaled_steps(void **state)
{
    (void)state;
    e57_stream s[3] = {0};
    for (int i = 0; i < 8; i++)
        for (int axis = 0; axis < 3; axis++)
            bytes_bits(&s[axis].bytes, (uint64_t)i, axis == 2 ? 20 : 3);
    write_scan("scaled.e57", s, 3, "", 8,
               E57_SCALED("cartesianX", "0", "7", "0.001", "500000")
                   E57_SCALED("cartesianY", "-3", "4", "-0.0005", "0")
                       E57_SCALED("cartesianZ", "0", "1048575", "0.002", "1e2"),
               "");
    free_streams(s, 3);
    stp_scan_info info;
    stp_point *p = scan_fixture_read("scaled.e57", NULL, &info);
    assert_true(info.coordinate_step == 0.0005);
    for (int i = 0; i < 8; i++)
        scan_fixture_position(&p[i], i * 0.001 + 500000.0, (i - 3) * -0.0005, i * 0.002 + 1e2);
    free(p);
}

/* A quarter turn about z, then a shift. */
#define TURNED                                                                                     \
    "<pose type=\"Structure\"><rotation type=\"Structure\">" E57_NUMBER("w",                       \
                                                                        "0.70710678118654757")     \
        E57_NUMBER("x", "0") E57_NUMBER("y", "0") E57_NUMBER(                                      \
            "z",                                                                                   \
            " 0.70710678118654757\n") "</rotation>"                                                \
                                      "<translation "                                              \
                                      "type=\"Structure\">" E57_NUMBER("x", "1000000") E57_NUMBER( \
                                          "y", "-20.5") "<z type=\"ScaledInteger\" "               \
                                                        "scale=\"0.25\" offset=\"1\">10</z>"       \
                                                        "</translation></pose>\n"
#define UNTURNED                                                                                   \
    "<pose type=\"Structure\"><rotation type=\"Structure\">" E57_NUMBER("w", "1")                  \
        E57_NUMBER("x", "0") E57_NUMBER("y", "0") "<z type=\"Float\"/></rotation>"                 \
                                                  "<translation type=\"Structure\"/></pose>\n"

static void check_near(const stp_point *p, double x, double y, double z)
{
    const double away = hypot(hypot(p->position.x - x, p->position.y - y), p->position.z - z);
    if (!(away < 1e-9 * fmax(1.0, fabs(x))))
        fail_msg("position %.17g %.17g %.17g, expected %.17g %.17g %.17g", p->position.x,
                 p->position.y, p->position.z, x, y, z);
}

/* Writes four scans: turned; without a pose; spherical with an identity pose; moved without a
 * rotation. */
static void write_four_scans(const char *path)
{
    e57_file file;
    e57_stream s[6] = {0}, spherical[4] = {0};
    add_positions(s, 3);
    for (int i = 0; i < 3; i++)
        for (int axis = 0; axis < 3; axis++)
            bytes_double(&s[3 + axis].bytes, i == axis ? 2.0 : 0.0);
    for (int i = 0; i < 3; i++) {
        bytes_double(&spherical[0].bytes, 2.0);
        bytes_double(&spherical[1].bytes, i == 1 ? PI / 2 : 0.0);
        bytes_double(&spherical[2].bytes, i == 2 ? -PI / 6 : 0.0);
        bytes_bits(&spherical[3].bytes, (uint64_t)i, 2);
    }
    e57_begin(&file);
    e57_vector(&file, s, 6, false);
    e57_scan(&file, TURNED, 3,
             XYZ E57_FLOAT("nor:normalX", "double") E57_FLOAT("nor:normalY", "double")
                 E57_FLOAT("nor:normalZ", "double"));
    e57_vector(&file, s, 3, true);
    e57_scan(&file, "", 3, XYZ);
    e57_vector(&file, spherical, 4, false);
    e57_scan(&file, UNTURNED, 3,
             E57_FLOAT("sphericalRange", "double") E57_FLOAT("sphericalAzimuth", "double")
                 E57_FLOAT("sphericalElevation", "double")
                     E57_INTEGER("sphericalInvalidState", "0", "2"));
    e57_vector(&file, s, 3, false);
    e57_scan(&file,
             "<pose type=\"Structure\"><translation type=\"Structure\">" E57_NUMBER(
                 "x", "7") "</translation></pose>",
             3, XYZ);
    e57_end(&file, "");
    e57_write(path, &file);
    e57_free(&file);
    free_streams(s, 6);
    free_streams(spherical, 4);
}

static void scans_with_poses(void **state)
{
    (void)state;
    static const uint16_t stations[] = {1, 1, 1, 0, 0, 0, 2, 2, 2, 3, 3, 3};
    static const stp_dvec3 positions[] = {{1e6, -20.5, 3.5}, {0, 0, 0}, {7, 0, 0}};
    stp_scan *scan = NULL;
    stp_point p[20];
    size_t count;
    write_four_scans("poses.e57");
    assert_int_equal(stp_scan_open(&scan, "poses.e57", NULL, NULL), STP_OK);
    const stp_scan_info *info = stp_scan_get_info(scan);
    assert_int_equal(info->attributes, STP_POINT_HAS_NORMAL | STP_POINT_HAS_STATION);
    assert_int_equal(info->station_count, 3);
    assert_memory_equal(info->stations, positions, sizeof positions);
    assert_int_equal(info->point_count, 12);
    assert_int_equal(stp_scan_read(scan, p, 20, &count, NULL), STP_OK);
    assert_int_equal(count, 12);
    stp_scan_close(&scan);
    for (int i = 0; i < 12; i++)
        assert_int_equal(p[i].station, stations[i]);
    for (int i = 0; i < 3; i++) {
        check_near(&p[i], 1e6 - 10.0 * i, -20.5 + i, 3.5 + 100.0 * i);
        scan_fixture_position(&p[3 + i], i, 10.0 * i, 100.0 * i);
        scan_fixture_normal(&p[3 + i], 0, 0, 0);
        check_near(&p[9 + i], 7.0 + i, 10.0 * i, 100.0 * i);
    }
    scan_fixture_normal(&p[0], 0, 1, 0);
    scan_fixture_normal(&p[1], -1, 0, 0);
    scan_fixture_normal(&p[2], 0, 0, 1);
    check_near(&p[6], 2, 0, 0);
    assert_int_equal(p[6].reject, STP_REJECT_NONE);
    assert_int_equal(p[7].reject, STP_REJECT_NO_RETURN);
    assert_int_equal(p[8].reject, STP_REJECT_INVALID);
}

static void spherical_coordinates(void **state)
{
    (void)state;
    e57_stream s[3] = {0};
    static const double angles[][2] = {{0, 0}, {PI / 2, 0}, {-PI, 0}, {0.3, PI / 2}, {0.3, -0.4}};
    for (int i = 0; i < 5; i++) {
        bytes_float(&s[0].bytes, 2.5f);
        bytes_double(&s[1].bytes, angles[i][0]);
        bytes_double(&s[2].bytes, angles[i][1]);
    }
    write_scan("sphere.e57", s, 3, "", 5,
               E57_FLOAT("sphericalRange", "single") E57_FLOAT("sphericalAzimuth", "double")
                   E57_FLOAT("sphericalElevation", "double"),
               "");
    free_streams(s, 3);
    stp_scan_info info;
    stp_point *p = scan_fixture_read("sphere.e57", NULL, &info);
    assert_int_equal(info.attributes, 0); /* no pose, no station */
    check_near(&p[0], 2.5, 0, 0);
    check_near(&p[1], 0, 2.5, 0);
    check_near(&p[2], -2.5, 0, 0);
    check_near(&p[3], 0, 0, 2.5);
    check_near(&p[4], 2.5 * cos(0.4) * cos(0.3), 2.5 * cos(0.4) * sin(0.3), -2.5 * sin(0.4));
    free(p);
}

/* An identity pose is a station if the scan has rows; otherwise it is none. Only then no point can
 * be at the origin. */
static void plain_poses(void **state)
{
    (void)state;
    e57_stream s[4] = {0};
    stp_scan_info info;
    add_positions(s, 2);
    bytes_bits(&s[3].bytes, 2, 2);
    write_scan("rows.e57", s, 4, UNTURNED, 2, XYZ E57_INTEGER("rowIndex", "0", "1"), "");
    stp_point *p = scan_fixture_read("rows.e57", NULL, &info);
    assert_int_equal(info.attributes, STP_POINT_HAS_STATION);
    assert_int_equal(info.station_count, 1);
    assert_int_equal(p[1].station, 1);
    assert_int_equal(p[0].reject, STP_REJECT_ORIGIN);
    assert_int_equal(p[1].reject, STP_REJECT_NONE);
    free(p);
    write_scan("merged.e57", s, 3, UNTURNED, 2, XYZ, "");
    p = scan_fixture_read("merged.e57", NULL, &info);
    assert_int_equal(info.attributes, 0);
    assert_int_equal(info.station_count, 0);
    assert_int_equal(p[0].reject, STP_REJECT_NONE);
    assert_int_equal(p[1].station, 0);
    free(p);
    free_streams(s, 4);
}

/* The validity of a cartesian point, of its colour and of its intensity. */
static void invalid_states(void **state)
{
    (void)state;
    e57_stream s[9] = {0};
    add_positions(s, 4);
    for (unsigned i = 0; i < 4; i++) {
        bytes_bits(&s[3].bytes, i, 2);
        for (int c = 4; c < 7; c++)
            bytes_integer(&s[c].bytes, 10, 1);
        bytes_bits(&s[7].bytes, i & 1u, 1);
        bytes_integer(&s[8].bytes, 20, 1);
    }
    write_scan("states.e57", s, 9, "", 4,
               XYZ E57_INTEGER("cartesianInvalidState", "0", "3")
                   E57_INTEGER("colorRed", "0", "255") E57_INTEGER("colorGreen", "0", "255")
                       E57_INTEGER("colorBlue", "0", "255") E57_INTEGER("isColorInvalid", "0", "1")
                           E57_INTEGER("classification", "0", "255"),
               "");
    free_streams(s, 9);
    stp_scan_info info;
    stp_point *p = scan_fixture_read("states.e57", NULL, &info);
    assert_int_equal(info.attributes, STP_POINT_HAS_COLOUR | STP_POINT_HAS_CLASS);
    static const int rejects[] = {STP_REJECT_NONE, STP_REJECT_NO_RETURN, STP_REJECT_INVALID,
                                  STP_REJECT_INVALID};
    for (int i = 0; i < 4; i++) {
        assert_int_equal(p[i].reject, rejects[i]);
        assert_int_equal(p[i].class_id, 20);
        assert_int_equal(p[i].rgb[0], i & 1 ? 200 * 257 : 10 * 257);
    }
    free(p);
}

#define LIMITS(low, high)                                                                          \
    "<intensityLimits type=\"Structure\">" E57_NUMBER("intensityMinimum", low)                     \
        E57_NUMBER("intensityMaximum", high) "</intensityLimits>\n"

static const struct {
    const char *before, *field;
    bool is_float;
    double low, high; /* the values that become 0 and 65535 */
    double values[3];
} limit_cases[] = {
    {LIMITS("0", "1"), E57_FLOAT("intensity", "single"), true, 0, 1, {0, 0.5, 1}},
    {LIMITS("-2048", "2047"),
     E57_FLOAT("intensity", "single"),
     true,
     -2048,
     2047,
     {-2048, 0, 2047}},
    {LIMITS("0", "4095"), E57_INTEGER("intensity", "0", "65535"), false, 0, 4095, {0, 4095, 5000}},
    {"", E57_INTEGER("intensity", "0", "65535"), false, 0, 65535, {0, 1, 65535}},
    {LIMITS("5", "5"), E57_INTEGER("intensity", "0", "65535"), false, 0, 65535, {0, 5, 10}},
    {"", E57_FLOAT("intensity", "single"), true, 0, 1, {0, 0.25, 1}},
    {"", E57_FLOAT("intensity", "single"), true, 0, 255, {0, 10, 254}},
    {"", E57_FLOAT("intensity", "single"), true, 0, 65535, {0, 300, 60000}},
    {"", E57_FLOAT("intensity", "single"), true, -2048, 2047, {-2000, 0, 1000}},
    {"", E57_FLOAT("intensity", "single"), true, -30.5, 0, {-30.5, -10, -1.5}},
    {"",
     "<intensity type=\"Float\" precision=\"single\" minimum=\"-3.4e38\" maximum=\"3.4e38\"/>",
     true,
     0,
     255,
     {0, 10, 254}},
    {"",
     "<intensity type=\"Float\" precision=\"single\" minimum=\"-1\" maximum=\"3\"/>",
     true,
     -1,
     3,
     {-1, 0, 3}},
};

static void intensity_limits(void **state)
{
    (void)state;
    for (size_t c = 0; c < sizeof limit_cases / sizeof *limit_cases; c++) {
        e57_stream s[4] = {0};
        char prototype[1000];
        add_positions(s, 3);
        for (int i = 0; i < 3; i++) {
            if (limit_cases[c].is_float)
                bytes_float(&s[3].bytes, (float)limit_cases[c].values[i]);
            else
                bytes_integer(&s[3].bytes, (uint64_t)limit_cases[c].values[i], 2);
        }
        snprintf(prototype, sizeof prototype, "%s%s", XYZ, limit_cases[c].field);
        write_scan("limits.e57", s, 4, limit_cases[c].before, 3, prototype, "");
        free_streams(s, 4);
        stp_scan_info info;
        stp_point *p = scan_fixture_read("limits.e57", NULL, &info);
        assert_int_equal(info.attributes, STP_POINT_HAS_INTENSITY);
        for (int i = 0; i < 3; i++) {
            const double part = (limit_cases[c].values[i] - limit_cases[c].low) /
                                (limit_cases[c].high - limit_cases[c].low);
            assert_int_equal(p[i].intensity, lround(fmin(part, 1.0) * 65535.0));
        }
        free(p);
    }
}

/* Two scans with different limits, one with colours: the same value must give the same
 * brightness. */
static void limits_of_several_scans(void **state)
{
    (void)state;
    e57_file file;
    e57_stream s[5] = {0};
    add_positions(s, 2);
    for (int i = 0; i < 2; i++) {
        bytes_float(&s[3].bytes, (float)(10 + i));
        bytes_bits(&s[4].bytes, 600u + 400u * (unsigned)i, 10);
    }
    const e57_stream coloured[7] = {s[0], s[1], s[2], s[3], s[4], s[4], s[4]};
    e57_begin(&file);
    e57_vector(&file, s, 4, false);
    e57_scan(&file, LIMITS("0", "11"), 2, XYZ E57_FLOAT("intensity", "single"));
    e57_vector(&file, coloured, 7, false);
    e57_scan(&file,
             LIMITS("5", "20") "<colorLimits type=\"Structure\">" E57_NUMBER("colorRedMinimum", "0")
                 E57_NUMBER("colorRedMaximum", "1000")
                     E57_NUMBER("colorGreenMaximum", "900") "</colorLimits>",
             2,
             XYZ E57_FLOAT("intensity", "single") E57_INTEGER("colorRed", "0", "1023")
                 E57_INTEGER("colorGreen", "0", "1023") E57_INTEGER("colorBlue", "0", "1023"));
    e57_end(&file, "");
    e57_write("two.e57", &file);
    e57_free(&file);
    free_streams(s, 5);
    stp_scan_info info;
    stp_point *p = scan_fixture_read("two.e57", NULL, &info);
    for (int i = 0; i < 4; i++)
        assert_int_equal(p[i].intensity, lround((10 + i % 2) / 20.0 * 65535.0));
    scan_fixture_rgb(&p[0], 200 * 257, 200 * 257, 200 * 257);
    for (int i = 0; i < 2; i++) {
        const unsigned value = (unsigned)lround((600 + 400 * i) / 1000.0 * 65535.0);
        scan_fixture_rgb(&p[2 + i], value, value, value);
    }
    free(p);
}

static void notes(void **state)
{
    (void)state;
    e57_stream s[8] = {0};
    add_positions(s, 2);
    bytes_bits(&s[3].bytes, 2, 2);
    bytes_text(&s[4].bytes, "anything");
    bytes_double(&s[5].bytes, 1.0);
    bytes_double(&s[5].bytes, 2.0);
    bytes_bits(&s[6].bytes, 0, 2);
    bytes_integer(&s[7].bytes, 0x0201, 2);
    write_scan("notes.e57", s, 8, "<name type=\"String\">x &amp; y</name>", 2,
               XYZ E57_INTEGER("rowIndex", "0", "1") "<ext:comment type=\"String\"/>" E57_FLOAT(
                   "timeStamp",
                   "double") "<group type=\"Structure\"><colorRed type=\"Integer\" minimum=\"0\" "
                             "maximum=\"1\"/></group>" E57_INTEGER("colorBlue", "0", "255"),
               "<coordinateMetadata type=\"String\"><![CDATA[PROJCS[\"a & b\"]]]>tail"
               "</coordinateMetadata>\n"
               "<images2D type=\"Vector\"><vectorChild type=\"Structure\"><pose><rotation><w>junk"
               "</w></rotation></pose></vectorChild></images2D>");
    free_streams(s, 8);
    stp_scan *scan = NULL;
    stp_point p[4];
    size_t count;
    assert_int_equal(stp_scan_open(&scan, "notes.e57", NULL, NULL), STP_OK);
    const stp_scan_info *info = stp_scan_get_info(scan);
    assert_int_equal(info->attributes, 0);
    assert_int_equal(info->note_count, 2);
    assert_string_equal(info->notes[0].name, "wkt");
    assert_string_equal(info->notes[0].text, "PROJCS[\"a & b\"]tail");
    assert_string_equal(info->notes[1].name, "left_out");
    assert_string_equal(info->notes[1].text,
                        "rowIndex, ext:comment, timeStamp, colorRed, colorBlue");
    assert_int_equal(stp_scan_read(scan, p, 4, &count, NULL), STP_OK);
    assert_int_equal(count, 2);
    scan_fixture_position(&p[1], 1, 10, 100);
    stp_scan_close(&scan);
}

/* A file without scans, a scan without points, and a scan of no points whose section is missing. */
static void no_points(void **state)
{
    (void)state;
    e57_file file;
    stp_scan_info info;
    e57_begin(&file);
    e57_end(&file, "");
    e57_write("none.e57", &file);
    e57_free(&file);
    stp_point *p = scan_fixture_read("none.e57", NULL, &info);
    assert_int_equal(info.point_count, 0);
    free(p);
    e57_stream s[3] = {0};
    add_positions(s, 2);
    e57_begin(&file);
    bytes_text(&file.xml, "<vectorChild type=\"Structure\"/>\n");
    e57_scan(&file, TURNED, 0, XYZ E57_FLOAT("intensity", "single"));
    e57_vector(&file, s, 3, false);
    e57_scan(&file, TURNED, 2, XYZ);
    e57_end(&file, "");
    e57_write("some.e57", &file);
    e57_free(&file);
    free_streams(s, 3);
    p = scan_fixture_read("some.e57", NULL, &info);
    assert_int_equal(info.point_count, 2);
    assert_int_equal(info.station_count, 1);
    assert_int_equal(info.attributes, STP_POINT_HAS_STATION);
    assert_int_equal(p[1].station, 1);
    free(p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(floats_and_colours),
        cmocka_unit_test(every_width),
        cmocka_unit_test(fields_far_apart),
        cmocka_unit_test(scaled_steps),
        cmocka_unit_test(scans_with_poses),
        cmocka_unit_test(spherical_coordinates),
        cmocka_unit_test(plain_poses),
        cmocka_unit_test(invalid_states),
        cmocka_unit_test(intensity_limits),
        cmocka_unit_test(limits_of_several_scans),
        cmocka_unit_test(notes),
        cmocka_unit_test(no_points),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

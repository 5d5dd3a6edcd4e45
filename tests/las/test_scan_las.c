/* Tests LAS files of every version and point format, written here byte by byte: each field must
 * come back. */
#include "tests/fixtures/scan/las_fixture.h"

enum { FORMATS = 11 };

/* Gives distinct values to the fields that the reader takes and to those that it ignores. */
static void fill_point(las_file *f, size_t at, unsigned format, unsigned i)
{
    const bool extended = format >= 6;
    las_put(f, at + 12, 2, 1000 * i + 7);
    las_put(f, at + 14, 1, 0xff);
    if (extended) {
        las_put(f, at + 15, 1, 0xfb); /* all flags but withheld */
        las_put(f, at + 16, 1, 200 + i);
    } else {
        las_put(f, at + 15, 1, 0x60 | (i + 29)); /* synthetic, key-point */
        las_put(f, at + 16, 1, 0x80);
    }
    las_put(f, at + 17, 1, 0xff);
    memset(f->bytes + at + 18, 0xee, las_record_bytes[format] - 18);
    for (unsigned k = 0; k < 3 && las_rgb_at[format] > 0; k++)
        las_put(f, at + las_rgb_at[format] + 2 * k, 2, 4097 * i + 300 * k + 1);
}

static void one_format(unsigned minor, unsigned format, unsigned extra)
{
    las_file f;
    char name[64], text[64];
    const int32_t steps[3][3] = {{0, 0, 0}, {INT32_MAX, -7, 9}, {INT32_MIN, 123456789, -8}};
    snprintf(name, sizeof name, "1.%u-%u+%u.las", minor, format, extra);
    las_begin(&f, minor, format, las_record_bytes[format] + extra);
    las_set_count(&f, 3);
    for (unsigned i = 0; i < 3; i++) {
        const size_t at = las_add_point(&f, steps[i][0], steps[i][1], steps[i][2]);
        fill_point(&f, at, format, i);
        memset(f.bytes + at + las_record_bytes[format], 0xdd, extra);
    }
    las_save(&f, name);
    stp_scan_info info;
    stp_point *points = scan_fixture_read(name, NULL, &info);
    assert_int_equal(info.point_count, 3);
    assert_int_equal(info.face_count, 0);
    assert_int_equal(info.station_count, 0);
    assert_int_equal(info.attributes, STP_POINT_HAS_INTENSITY | STP_POINT_HAS_CLASS |
                                          (las_rgb_at[format] ? STP_POINT_HAS_COLOUR : 0));
    assert_true(info.coordinate_step == 0.125);
    for (unsigned i = 0; i < 3; i++) {
        scan_fixture_position(&points[i], steps[i][0] * 0.5 + 1000.0, steps[i][1] * 0.25 - 2000.0,
                              steps[i][2] * 0.125 + 3000.0);
        scan_fixture_scalars(&points[i], 1000 * i + 7, format >= 6 ? 200 + i : i + 29);
        assert_int_equal(points[i].reject, STP_REJECT_NONE);
        assert_int_equal(points[i].station, 0);
        scan_fixture_normal(&points[i], 0.0, 0.0, 0.0);
        if (las_rgb_at[format])
            scan_fixture_rgb(&points[i], 4097 * i + 1, 4097 * i + 301, 4097 * i + 601);
    }
    free(points);
    stp_scan *scan = NULL;
    assert_int_equal(stp_scan_open(&scan, name, NULL, NULL), STP_OK);
    snprintf(text, sizeof text, "LAS 1.%u point format %u", minor, format);
    assert_string_equal(stp_scan_get_info(scan)->format, text);
    stp_scan_close(&scan);
}

static void every_format_and_version(void **state)
{
    (void)state;
    for (unsigned format = 0; format < FORMATS; format++)
        for (unsigned minor = las_least_minor[format]; minor <= 5; minor++) {
            one_format(minor, format, 0);
            one_format(minor, format, 5);
        }
}

/* A header longer than its version's, and a 1.3 header as short as 1.2's. */
static void other_header_lengths(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        las_file f;
        stp_scan_info info;
        las_begin(&f, i == 0 ? 2 : 3, 0, 20);
        f.size = i == 0 ? 300 : 227;
        las_put(&f, 94, 2, f.size);
        las_put(&f, 96, 4, f.size + 2); /* 1.0 has two bytes more before the points */
        f.size += 2;
        las_set_count(&f, 1);
        las_add_point(&f, 2, 4, 8);
        las_save(&f, "length.las");
        stp_point *points = scan_fixture_read("length.las", NULL, &info);
        scan_fixture_position(&points[0], 1001.0, -1999.0, 3001.0);
        free(points);
    }
}

static void withheld_points(void **state)
{
    (void)state;
    for (unsigned format = 0; format < FORMATS; format++) {
        las_file f;
        stp_scan_info info;
        las_begin(&f, 4, format, las_record_bytes[format]);
        las_set_count(&f, 3);
        for (unsigned i = 0; i < 3; i++) {
            const size_t at = las_add_point(&f, 1, 2, 3);
            las_put(&f, at + 15, 1, i == 1 ? (format >= 6 ? 0x04 : 0x82) : 0x02);
        }
        las_save(&f, "withheld.las");
        stp_point *points = scan_fixture_read("withheld.las", NULL, &info);
        assert_int_equal(info.point_count, 3);
        for (unsigned i = 0; i < 3; i++)
            assert_int_equal(points[i].reject, i == 1 ? STP_REJECT_INVALID : STP_REJECT_NONE);
        free(points);
        const stp_scan_params keep = {.keep_withheld = true};
        points = scan_fixture_read("withheld.las", &keep, &info);
        for (unsigned i = 0; i < 3; i++) {
            assert_int_equal(points[i].reject, STP_REJECT_NONE);
            scan_fixture_position(&points[i], points[0].position.x, points[0].position.y,
                                  points[0].position.z);
        }
        free(points);
    }
}

/* Reads points of format 2. Point `special_at` has the blue and the intensity `special`, the others
 * `ordinary`. */
static stp_point *read_depths(unsigned count, unsigned ordinary, unsigned special_at,
                              unsigned special, stp_scan_info *info)
{
    las_file f;
    las_begin(&f, 2, 2, 26);
    las_set_count(&f, count);
    for (unsigned i = 0; i < count; i++) {
        const size_t at = las_add_point(&f, (int32_t)i, 0, 0);
        las_put(&f, at + 12, 2, i == special_at ? special : ordinary);
        las_put(&f, at + 24, 2, i == special_at ? special : ordinary);
    }
    las_save(&f, "depth.las");
    return scan_fixture_read("depth.las", NULL, info);
}

static void depth_is_told_from_data(void **state)
{
    (void)state;
    static const struct {
        unsigned ordinary, special, colour, special_colour, intensity, special_intensity;
    } cases[] = {
        {10, 255, 2570, 65535, 2570, 65535},     /* 8 bits in 16 */
        {10, 4096, 10, 4096, 10, 4096},          /* 16 bits */
        {10, 1023, 641, 65535, 10, 1023},        /* 10 bits, in colours only */
        {100, 4095, 1600, 65535, 100, 4095},     /* 12 bits */
        {2560, 65280, 2570, 65535, 2560, 65280}, /* 8 bits times 256, in colours only */
        {2560, 65281, 2560, 65281, 2560, 65281}, {0, 1, 0, 257, 0, 257},
        {65535, 0, 65535, 0, 65535, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        stp_scan_info info;
        stp_point *points = read_depths(2000, cases[i].ordinary, 1999, cases[i].special, &info);
        assert_true(info.attributes & STP_POINT_HAS_COLOUR);
        const unsigned most =
            cases[i].special > cases[i].ordinary ? cases[i].special : cases[i].ordinary;
        assert_int_equal((int)info.intensity_full, most <= 255 ? 255 : 65535);
        scan_fixture_rgb(&points[0], 0, 0, cases[i].colour);
        scan_fixture_rgb(&points[1999], 0, 0, cases[i].special_colour);
        scan_fixture_scalars(&points[0], cases[i].intensity, 0);
        scan_fixture_scalars(&points[1999], cases[i].special_intensity, 0);
        free(points);
    }
}

/* A file whose colours are all zero has no colour, and a note says so. */
static void no_colours_at_all(void **state)
{
    (void)state;
    char text[1024];
    stp_scan_info info;
    free(read_depths(100, 0, 0, 0, &info));
    assert_int_equal(info.attributes, STP_POINT_HAS_INTENSITY | STP_POINT_HAS_CLASS);
    las_note("depth.las", "left_out", text, sizeof text);
    assert_non_null(strstr(text, ", red, green, blue (all zero)"));
}

/* White colours would hide the intensities; where there are none, they stay. */
static void white_hides_no_intensities(void **state)
{
    (void)state;
    for (unsigned kind = 0; kind < 3; kind++) {
        char text[1024];
        stp_scan_info info;
        las_file f;
        las_begin(&f, 2, 2, 26);
        las_set_count(&f, 100);
        for (unsigned i = 0; i < 100; i++) {
            const size_t at = las_add_point(&f, (int32_t)i, 0, 0);
            las_put(&f, at + 12, 2, kind == 1 ? 0 : 5 * i);
            for (unsigned k = 0; k < 3; k++)
                las_put(&f, at + 20 + 2 * k, 2, kind == 2 && i == 9 ? 65534 : 65535);
        }
        las_save(&f, "white.las");
        free(scan_fixture_read("white.las", NULL, &info));
        assert_int_equal((info.attributes & STP_POINT_HAS_COLOUR) != 0, kind > 0);
        las_note("white.las", "left_out", text, sizeof text);
        assert_int_equal(strstr(text, ", red, green, blue (all white)") != NULL, kind == 0);
    }
}

/* The depth must be found in the whole file: only the last of 400,000 points are brighter than
 * 255. */
static void depth_looks_far(void **state)
{
    (void)state;
    enum { COUNT = 400000, HEADER = 227, RECORD = 26 };
    las_file f;
    stp_scan_info info;
    unsigned char *bytes = calloc(HEADER + (size_t)COUNT * RECORD, 1);
    assert_non_null(bytes);
    las_begin(&f, 2, 2, RECORD);
    las_set_count(&f, COUNT);
    memcpy(bytes, f.bytes, HEADER);
    for (size_t i = 0; i < COUNT; i++) {
        bytes[HEADER + i * RECORD + 20] = 200;
        bytes[HEADER + i * RECORD + 21] = i > COUNT - 7000 ? 3 : 0;
    }
    scan_fixture_bytes("far.las", bytes, HEADER + (size_t)COUNT * RECORD);
    free(bytes);
    stp_point *points = scan_fixture_read("far.las", NULL, &info);
    scan_fixture_rgb(&points[0], 12812, 0, 0); /* of 10 bits */
    scan_fixture_rgb(&points[COUNT - 1], 62012, 0, 0);
    scan_fixture_position(&points[COUNT - 1], 1000.0, -2000.0, 3000.0);
    free(points);
}

/* Which of the two counts is taken. */
static void counts_of_both_widths(void **state)
{
    (void)state;
    static const struct {
        unsigned format, wide, narrow, expected;
        const char *note;
    } cases[] = {
        {6, 2, 0, 2, ""},
        {1, 2, 2, 2, ""},
        {1, 0, 2, 2, "the 64-bit field says 0 points, the legacy one 2: those were read"},
        {1, 2, 1, 2, "the 64-bit field says 2 points, the legacy one 1: 2 were read"},
        {1, 1, 2, 1, "the 64-bit field says 1 points, the legacy one 2: 1 were read"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        las_file f;
        stp_scan_info info;
        las_begin(&f, 4, cases[i].format, las_record_bytes[cases[i].format]);
        las_put(&f, 247, 8, cases[i].wide);
        las_put(&f, 107, 4, cases[i].narrow);
        las_add_point(&f, 0, 0, 0);
        las_add_point(&f, 0, 0, 0);
        las_save(&f, "counts.las");
        free(scan_fixture_read("counts.las", NULL, &info));
        assert_int_equal(info.point_count, cases[i].expected);
        las_expect_note("counts.las", "counts", cases[i].note);
    }
}

/* Bytes after the points of an old file, and a file without points. */
static void more_and_no_points(void **state)
{
    (void)state;
    las_file f;
    stp_scan_info info;
    las_begin(&f, 2, 0, 20);
    las_set_count(&f, 1);
    for (int i = 0; i < 3; i++)
        las_add_point(&f, 0, 0, 0);
    las_save(&f, "more.las");
    free(scan_fixture_read("more.las", NULL, &info));
    las_expect_note("more.las", "counts",
                    "behind the 1 points that the header counts, 40 bytes follow, which were not "
                    "read");
    las_begin(&f, 2, 3, 34);
    las_save(&f, "none.las");
    free(scan_fixture_read("none.las", NULL, &info));
    assert_int_equal(info.point_count, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_format_and_version), cmocka_unit_test(other_header_lengths),
        cmocka_unit_test(withheld_points),          cmocka_unit_test(depth_is_told_from_data),
        cmocka_unit_test(no_colours_at_all),        cmocka_unit_test(white_hides_no_intensities),
        cmocka_unit_test(depth_looks_far),          cmocka_unit_test(counts_of_both_widths),
        cmocka_unit_test(more_and_no_points),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

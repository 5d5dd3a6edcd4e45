/* Tests what a LAS file says beside its points: coordinate system, fields left out, extra bytes. */
#include "tests/fixtures/scan/las_fixture.h"

#define ALL_LEFT_OUT                                                                               \
    "return number, number of returns, scan direction flag, edge of flight line, synthetic, "      \
    "key-point, "
#define WAVES ", wave packets"

static void one_point(las_file *f)
{
    las_set_count(f, 1);
    las_add_point(f, 0, 0, 0);
}

static void fields_left_out(void **state)
{
    (void)state;
    static const char *const behind[] = {
        "scan angle rank, user data, point source ID",
        "scan angle rank, user data, point source ID, GPS time",
        "scan angle rank, user data, point source ID",
        "scan angle rank, user data, point source ID, GPS time",
        "scan angle rank, user data, point source ID, GPS time" WAVES,
        "scan angle rank, user data, point source ID, GPS time" WAVES,
        "overlap, scanner channel, scan angle, user data, point source ID, GPS time",
        "overlap, scanner channel, scan angle, user data, point source ID, GPS time",
        "overlap, scanner channel, scan angle, user data, point source ID, GPS time, NIR",
        "overlap, scanner channel, scan angle, user data, point source ID, GPS time" WAVES,
        "overlap, scanner channel, scan angle, user data, point source ID, GPS time, NIR" WAVES,
    };
    for (unsigned format = 0; format <= 10; format++) {
        las_file f;
        char expected[1024];
        las_begin(&f, 4, format, las_record_bytes[format]);
        las_set_count(&f, 1);
        const size_t at = las_add_point(&f, 0, 0, 0);
        if (las_rgb_at[format])
            las_put(&f, at + las_rgb_at[format], 2, 9);
        las_save(&f, "left.las");
        snprintf(expected, sizeof expected, ALL_LEFT_OUT "%s", behind[format]);
        las_expect_note("left.las", "left_out", expected);
        las_expect_note("left.las", "wkt", "");
        las_expect_note("left.las", "geokeys", "");
        las_expect_note("left.las", "counts", "");
    }
}

/* Writes a field's text, which need not end in a zero. */
static void put_text(char *field, const char *text)
{
    while (*text != '\0')
        *field++ = *text++;
}

static void extra_bytes(void **state)
{
    (void)state;
    las_file f;
    char described[2 * 192 + 100] = {0};
    put_text(described + 4, "Amplitude");
    put_text(described + 192 + 4, "a name of just thirty-two bytes!");
    memset(described + 2 * 192, 'x', 100); /* an incomplete description */
    las_begin(&f, 4, 0, 20 + 6);
    las_add_vlr(&f, "LASF_Spec", 4, described, sizeof described);
    one_point(&f);
    las_save(&f, "extra.las");
    las_expect_note("extra.las", "left_out",
                    ALL_LEFT_OUT "scan angle rank, user data, point source ID, extra bytes (6 a "
                                 "point: Amplitude, a name of just thirty-two bytes!)");
    las_begin(&f, 2, 0, 20 + 1);
    one_point(&f);
    las_save(&f, "bare.las");
    las_expect_note("bare.las", "left_out",
                    ALL_LEFT_OUT "scan angle rank, user data, point source ID, extra bytes (1 a "
                                 "point)");
}

static void wkt(void **state)
{
    (void)state;
    las_file f;
    las_begin(&f, 4, 6, 30);
    las_add_vlr(&f, "someone", 2112, "not this", 8);
    las_add_vlr(&f, "LASF_Projection", 2111, "nor this", 8);
    las_add_vlr(&f, "LASF_Projection", 2112, "GEOGCS[\"R\xc3\xa9union\n\xff\"]\0rest", 25);
    las_add_vlr(&f, "LASF_Projection", 2112, "a second one", 12);
    one_point(&f);
    las_save(&f, "wkt.las");
    las_expect_note("wkt.las", "wkt", "GEOGCS[\"R\xc3\xa9union ?\"]");
    las_begin(&f, 4, 6, 30);
    one_point(&f);
    las_add_evlr(&f, "LASF_Spec", 9, "data", 4);
    las_add_evlr(&f, "LASF_Projection", 2112, "PROJCS[\"far behind\"]", 20);
    las_save(&f, "evlr.las");
    las_expect_note("evlr.las", "wkt", "PROJCS[\"far behind\"]");
}

/* LAS 1.5 may count times from an offset; only its bit of the encoding says so. */
static void time_offset(void **state)
{
    (void)state;
    las_file f;
    for (unsigned bits = 0; bits < 2; bits++) {
        las_begin(&f, 5, 6, 30);
        las_put(&f, 6, 2, bits ? 0x51 : 0x11);
        las_put(&f, 391, 2, 1400);
        one_point(&f);
        las_save(&f, "offset.las");
        las_expect_note("offset.las", "gps_time_offset", bits ? "1400" : "");
    }
}

/* Each byte that is not valid UTF-8 must become `?`. */
static void texts_are_utf8(void **state)
{
    (void)state;
    static const struct {
        const char *bytes, *expected;
    } cases[] = {
        {"\xe2\x82\xac \xf0\x9f\x8c\xb2", "\xe2\x82\xac \xf0\x9f\x8c\xb2"},
        {"\xc0\xaf", "??"},           /* longer than needed */
        {"\xe0\x80\xaf", "???"},      /* longer than needed */
        {"\xed\xa0\x80", "???"},      /* half of a surrogate pair */
        {"\xf4\x90\x80\x80", "????"}, /* beyond the last character */
        {"a\xe2\x82", "a??"},         /* cut */
        {"\x80 \xf8z\tb\x7f", "? ?z b "},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        las_file f;
        las_begin(&f, 2, 0, 20);
        las_add_vlr(&f, "LASF_Projection", 2112, cases[i].bytes, strlen(cases[i].bytes));
        one_point(&f);
        las_save(&f, "utf8.las");
        las_expect_note("utf8.las", "wkt", cases[i].expected);
    }
}

static void add_keys(las_file *f, const uint16_t *keys, size_t count)
{
    unsigned char bytes[512];
    for (size_t i = 0; i < count; i++) {
        bytes[2 * i] = (unsigned char)(keys[i] & 0xff);
        bytes[2 * i + 1] = (unsigned char)(keys[i] >> 8);
    }
    las_add_vlr(f, "LASF_Projection", 34735, bytes, 2 * count);
}

static void geokeys(void **state)
{
    (void)state;
    las_file f;
    const double doubles[3] = {6378137.0, 0.25, -1e-9};
    const uint16_t keys[] = {1,     1,     0, 10, /* header: claims ten keys, nine follow */
                             1024,  0,     1, 1,  /* value in the key itself */
                             1026,  34737, 4, 0,  /* "abc|" */
                             2057,  34736, 1, 0,  2062, 34736, 2, 1,
                             60000, 0,     1, 7,  2059, 34736, 2, 2, /* one value too many */
                             3073,  34737, 9, 1,                     /* too long */
                             3074,  34735, 2, 3, /* in the directory: 10, 1024 */
                             3075,  4711,  1, 0};
    las_begin(&f, 2, 0, 20);
    add_keys(&f, keys, sizeof keys / sizeof *keys);
    las_add_vlr(&f, "LASF_Projection", 34736, doubles, sizeof doubles);
    las_add_vlr(&f, "LASF_Projection", 34737, "abc|de", 7);
    one_point(&f);
    las_save(&f, "keys.las");
    las_expect_note("keys.las", "geokeys",
                    "GTModelTypeGeoKey=1\nGTCitationGeoKey=abc\nGeogSemiMajorAxisGeoKey=6378137\n"
                    "GeogTOWGS84GeoKey=0.25,-1e-09\nKey60000=7\n"
                    "GeogInvFlatteningGeoKey=(missing: numbers 3 to 4 of 3)\n"
                    "PCSCitationGeoKey=(missing: characters 2 to 10 of 7)\n"
                    "ProjectionGeoKey=10,1024\nProjCoordTransGeoKey=(missing: in tag 4711)\n"
                    "(missing: keys 10 to 10)");
}

/* Keys without values, and keys of records that are missing. */
static void geokeys_of_nothing(void **state)
{
    (void)state;
    las_file f;
    const uint16_t keys[] = {1, 1, 0,    4,     1026, 34737, 0,    0,     2057, 34736,
                             0, 0, 3074, 34735, 0,    0,     2049, 34737, 1,    0};
    las_begin(&f, 2, 0, 20);
    add_keys(&f, keys, sizeof keys / sizeof *keys);
    one_point(&f);
    las_save(&f, "nothing.las");
    las_expect_note("nothing.las", "geokeys",
                    "GTCitationGeoKey=\nGeogSemiMajorAxisGeoKey=\nProjectionGeoKey=\n"
                    "GeogCitationGeoKey=(missing: characters 1 to 1 of 0)");
    las_begin(&f, 2, 0, 20);
    add_keys(&f, keys, 3);
    one_point(&f);
    las_save(&f, "short.las");
    las_expect_note("short.las", "geokeys", "");
}

/* A scale of 0 would make one point of all; one below 0 is read as it stands. */
static void scales(void **state)
{
    (void)state;
    las_file f;
    stp_scan_info info;
    las_begin(&f, 2, 0, 20);
    las_put_double(&f, 131, 0.0);
    las_put_double(&f, 139, -0.5);
    las_put_double(&f, 147, 0.25);
    las_put_double(&f, 155, 7.0);
    las_put_double(&f, 163, 8.0);
    las_put_double(&f, 171, 9.0);
    las_set_count(&f, 1);
    las_add_point(&f, 2000, 3, 4);
    las_save(&f, "scales.las");
    stp_point *points = scan_fixture_read("scales.las", NULL, &info);
    scan_fixture_position(points, 9.0, 6.5, 10.0);
    assert_true(info.coordinate_step == 0.001);
    free(points);
    las_expect_note("scales.las", "scales",
                    "the header gives x a scale of 0: 0.001 is assumed; the header gives y a scale "
                    "of -0.5: read as it says, which may mirror the scan");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fields_left_out),
        cmocka_unit_test(extra_bytes),
        cmocka_unit_test(wkt),
        cmocka_unit_test(time_offset),
        cmocka_unit_test(texts_are_utf8),
        cmocka_unit_test(geokeys),
        cmocka_unit_test(geokeys_of_nothing),
        cmocka_unit_test(scales),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

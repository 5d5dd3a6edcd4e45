/* Tests point sets of Expe: all properties, in any order, and what is cut off or wrong. */
#include "tests/fixtures/byte_fixture.h"
#include "tests/fixtures/numbers_fixture.h"

#define MAGIC "[Expe/PointSet/Binary/0.1]\n"
#define POINTS 300u

/* Surfels whose properties are in this order: radius, own (2 bytes), color, position, normal. */
static byte_row make_surfels(void)
{
    byte_row row = {0};
    bytes_text(&row, MAGIC "property radius 4\nproperty own 2\nproperty color 4\n");
    bytes_text(&row, "property position 12\nproperty normal 12\nnofpoints 300\ndata\n");
    for (unsigned i = 0; i < POINTS; i++) {
        const float radius = 0.5f + (float)i, position[3] = {(float)i, 2.0f, -0.25f};
        const float normal[3] = {0.0f, 3.0f, 4.0f};
        const uint8_t rest[6] = {1, 2, (uint8_t)i, 128, 255, 77};
        bytes_add(&row, &radius, sizeof radius);
        bytes_add(&row, rest, sizeof rest);
        bytes_add(&row, position, sizeof position);
        bytes_add(&row, normal, sizeof normal);
    }
    return row;
}

static void all_properties(void **state)
{
    (void)state;
    byte_row row = make_surfels();
    scan_fixture_bytes("surfels.pts", row.data, row.size);
    bytes_free(&row);
    numbers n = numbers_read("surfels.pts", NULL);
    assert_int_equal(n.count, POINTS);
    assert_string_equal(n.left_out, "own");
    numbers_expect_type(&n, "radius", "f32");
    for (unsigned i = 0; i < POINTS; i++) {
        scan_fixture_position(&n.points[i], i, 2.0, -0.25);
        scan_fixture_normal(&n.points[i], 0.0, 0.6, 0.8);
        scan_fixture_rgb(&n.points[i], 257 * (i % 256), 257 * 128, 65535);
        numbers_expect(&n, "radius", i, 0.5 + i);
    }
    numbers_free(&n);
}

static void any_point_first(void **state)
{
    (void)state;
    stp_scan *scan = NULL;
    stp_error err = {0};
    stp_point point;
    size_t count = 0;
    assert_int_equal(stp_scan_open(&scan, "surfels.pts", NULL, &err), STP_OK);
    assert_int_equal(stp_scan_seek(scan, 211, &err), STP_OK);
    assert_int_equal(stp_scan_read(scan, &point, 1, &count, &err), STP_OK);
    assert_int_equal(count, 1);
    scan_fixture_position(&point, 211.0, 2.0, -0.25);
    stp_scan_close(&scan);
}

static void wrong_files(void **state)
{
    (void)state;
    static const scan_malformed cases[] = {
        {"ascii.pts", "[Expe/PointSet/Ascii/0.1]\n", STP_UNSUPPORTED, "save it as binary"},
        {"end.pts", MAGIC "property position 12\n", STP_CORRUPT, "line 2: the header has no end"},
        {"no.pts", MAGIC "property normal 12\nnofpoints 0\ndata\n", STP_FORMAT, "no position"},
        {"twice.pts", MAGIC "property normal 12\nproperty normal 12\n", STP_FORMAT,
         "line 3: a known"},
        {"size.pts", MAGIC "property position 24\n", STP_FORMAT, "another size"},
        {"large.pts", MAGIC "property a 65000\nproperty b 900\n", STP_FORMAT, "65536 in all"},
        {"zero.pts", MAGIC "property a 0\n", STP_FORMAT, "needs a name and its bytes"},
        {"minus.pts", MAGIC "nofpoints -1\n", STP_FORMAT, "expected `property NAME BYTES`"},
        {"many.pts", MAGIC "property position 12\nnofpoints 18446744073709551615\ndata\n",
         STP_CORRUPT, "do not fit"},
        {"word.pts", MAGIC "proper position 12\n", STP_FORMAT, "line 2: expected"},
    };
    scan_fixture_malformed(cases, sizeof cases / sizeof *cases);
    byte_row row = make_surfels();
    scan_fixture_expect_cuts("cut.pts", row.data, 400, NULL);
    scan_fixture_bytes("cut.pts", row.data, row.size - 1);
    scan_fixture_fails("cut.pts", NULL, STP_CORRUPT, "cut off");
    bytes_free(&row);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(all_properties),
                                       cmocka_unit_test(any_point_first),
                                       cmocka_unit_test(wrong_files)};
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

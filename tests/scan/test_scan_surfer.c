/* Tests grids of Surfer: text, and binary of versions 6 and 7; the lowest row comes first. */
#include "tests/fixtures/scan/scan_fixture.h"

static size_t put(unsigned char *to, const void *bytes, size_t size)
{
    memcpy(to, bytes, size);
    return size;
}

static size_t put_double(unsigned char *to, double number)
{
    return put(to, &number, sizeof number);
}

/* 3 x 2 heights from (10, 20) to (14, 21); the last is none. */
static size_t write_6(unsigned char *out)
{
    const uint16_t size[2] = {3, 2};
    const double ends[6] = {10, 14, 20, 21, 1, 5};
    const float heights[6] = {1, 2, 3, 4, 5, 1.70141e38f};
    size_t n = put(out, "DSBB", 4);
    n += put(out + n, size, sizeof size);
    n += put(out + n, ends, sizeof ends);
    return n + put(out + n, heights, sizeof heights);
}

static size_t write_7(unsigned char *out, double none)
{
    const uint32_t head[] = {4, 2}, sizes[] = {72, 2, 3};
    const uint32_t bytes = 48;
    const double place[] = {10, 20, 2, 1, 1, 5, 0, none};
    size_t n = put(out, "DSRB", 4);
    n += put(out + n, head, sizeof head);
    n += put(out + n, "GRID", 4);
    n += put(out + n, sizes, sizeof sizes);
    n += put(out + n, place, sizeof place);
    n += put(out + n, "DATA", 4);
    n += put(out + n, &bytes, sizeof bytes);
    for (int i = 0; i < 6; i++)
        n += put_double(out + n, i < 5 ? i + 1.0 : none);
    return n;
}

static void expect_heights(const char *name)
{
    stp_scan_info info;
    stp_point *points = scan_fixture_read(name, &(stp_scan_params){0}, &info);
    assert_string_equal(info.format, "Surfer grid of heights");
    assert_true(info.heights);
    assert_int_equal(info.point_count, 6);
    unsigned seen = 0;
    for (int i = 0; i < 6; i++) {
        const stp_dvec3 p = points[i].position;
        if (stp_scan_is_nowhere(p) || points[i].reject != STP_REJECT_NONE)
            continue;
        const int place = (int)((p.x - 10.0) / 2.0 + 3.0 * (p.y - 20.0));
        scan_fixture_position(&points[i], 10.0 + 2.0 * (place % 3), 20.0 + place / 3, place + 1.0);
        seen |= 1u << place;
    }
    assert_int_equal(seen, 31);
    free(points);
}

static void all_kinds(void **state)
{
    (void)state;
    unsigned char bytes[256];
    scan_fixture_text("a.grd", "DSAA\n3 2\n10 14\n20 21\n1 5\n1 2 3\n\n4 5 1.70141e+038\n");
    expect_heights("a.grd");
    scan_fixture_bytes("b.grd", bytes, write_6(bytes));
    expect_heights("b.grd");
    scan_fixture_bytes("c.grd", bytes, write_7(bytes, 1.70141e38));
    expect_heights("c.grd");
    scan_fixture_bytes("d.grd", bytes, write_7(bytes, -3000.0));
    expect_heights("d.grd");
}

/* Version 7 names its own blank value; a 0 there is none. */
static void blank_values(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        unsigned char bytes[256];
        const size_t size = write_7(bytes, 1.70141e38);
        stp_scan_info info;
        unsigned valid = 0;
        put_double(bytes + 12 + 8 + 64, k == 0 ? 4.0 : 0.0);
        scan_fixture_bytes("blank.grd", bytes, size);
        stp_point *points = scan_fixture_read("blank.grd", &(stp_scan_params){0}, &info);
        for (int i = 0; i < 6; i++)
            valid += points[i].reject == STP_REJECT_NONE;
        assert_int_equal(valid, k == 0 ? 4 : 5);
        free(points);
    }
}

/* Cut anywhere; and headers that no grid has. */
static void malformed(void **state)
{
    (void)state;
    unsigned char bytes[256];
    for (int version = 6; version < 8; version++) {
        const size_t size = version == 6 ? write_6(bytes) : write_7(bytes, 1.70141e38);
        for (size_t cut = 4; cut < size; cut++) {
            stp_error err = {0};
            stp_scan *scan = NULL;
            stp_point points[8];
            size_t count = 1;
            scan_fixture_bytes("cut.grd", bytes, cut);
            stp_status status = stp_scan_open(&scan, "cut.grd", &(stp_scan_params){0}, &err);
            while (status == STP_OK && count > 0)
                status = stp_scan_read(scan, points, 8, &count, &err);
            assert_int_equal(status, STP_CORRUPT);
            stp_scan_close(&scan);
        }
    }
    const scan_malformed cases[] = {
        {"a.grd", "DSAA\n1 2\n0 1\n0 1\n0 9\n1\n3\n", STP_CORRUPT, "2 columns and rows"},
        {"b.grd", "DSAA\n2 2\n1 0\n0 1\n0 9\n1 2\n3 4\n", STP_CORRUPT, "the lower first"},
        {"c.grd", "DSAA\n2 2\n0 1\nnan 1\n0 9\n1 2\n3 4\n", STP_CORRUPT, "the lower first"},
        {"d.grd", "DSAA\n2 2.5\n0 1\n0 1\n0 9\n1 2\n3 4\n", STP_CORRUPT, "2 columns and rows"},
        {"e.grd", "DSRB\4\1\1\1", STP_CORRUPT, "no grid"},
        {"f.grd", "DSBB", STP_CORRUPT, "ends at byte 4"},
    };
    scan_fixture_malformed(cases, sizeof cases / sizeof *cases);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_kinds),
        cmocka_unit_test(blank_values),
        cmocka_unit_test(malformed),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

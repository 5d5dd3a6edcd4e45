/* Tests HGT tiles, whose size tells columns and rows, and whose name tells the place. */
#include "tests/fixtures/scan/scan_fixture.h"

enum { SIDE = 1201, COUNT = SIDE * SIDE, HOLE = 5 * SIDE + 7 };

static int height_at(int i)
{
    return i % SIDE - 2 * (i / SIDE); /* also below zero */
}

static void write_tile(const char *path, size_t size)
{
    unsigned char *bytes = calloc(2, COUNT);
    assert_non_null(bytes);
    for (int i = 0; i < COUNT; i++) {
        const unsigned number = (unsigned)(i == HOLE ? -32768 : height_at(i)) & 0xffffu;
        bytes[2 * i] = (unsigned char)(number >> 8);
        bytes[2 * i + 1] = (unsigned char)number;
    }
    scan_fixture_bytes(path, bytes, size);
    free(bytes);
}

/* The texts of an info live as long as the scan. */
static void check_texts(const char *name)
{
    stp_error err = {0};
    stp_scan *scan = NULL;
    assert_int_equal(stp_scan_open(&scan, name, NULL, &err), STP_OK);
    const stp_scan_info *info = stp_scan_get_info(scan);
    assert_string_equal(info->format, "HGT of heights");
    assert_string_equal(info->notes[0].text, "GTModelTypeGeoKey=2\nGeographicTypeGeoKey=4326");
    stp_scan_close(&scan);
}

static void names_tell_the_corner(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double x, y; /* of the top left sample */
    } cases[] = {{"N47E008.hgt", 8.0, 48.0},
                 {"s01w070.HGT", -70.0, 0.0},
                 {"n00_e179_1arc_v3.hgt", 179.0, 1.0}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        stp_scan_info info;
        write_tile(cases[k].name, 2ull * COUNT);
        check_texts(cases[k].name);
        stp_point *points = scan_fixture_read(cases[k].name, NULL, &info);
        assert_int_equal(info.point_count, COUNT);
        for (int i = 0; i < COUNT; i++) {
            assert_int_equal(points[i].reject, i == HOLE ? STP_REJECT_INVALID : STP_REJECT_NONE);
            if (i != HOLE)
                scan_fixture_position(&points[i], cases[k].x + i % SIDE * (1.0 / 1200.0),
                                      cases[k].y - i / SIDE * (1.0 / 1200.0), height_at(i));
        }
        free(points);
    }
}

/* Every other byte is 0 and the rest are characters, as in UTF-16. */
static void low_land_is_no_text(void **state)
{
    (void)state;
    stp_scan_info info;
    unsigned char *bytes = calloc(2, COUNT);
    assert_non_null(bytes);
    for (int i = 0; i < COUNT; i++)
        bytes[2 * i + 1] = (unsigned char)(40 + i % 50);
    scan_fixture_bytes("N52E005.hgt", bytes, 2ull * COUNT);
    free(bytes);
    stp_point *points = scan_fixture_read("N52E005.hgt", NULL, &info);
    scan_fixture_position(&points[1], 5.0 + 1.0 / 1200.0, 53.0, 41);
    free(points);
}

/* Another name tells no place: columns and rows are as far apart as suits their heights. */
static void other_names_tell_no_place(void **state)
{
    (void)state;
    static const char *const names[] = {"alps.hgt", "N47E08.hgt", "X47E008.hgt"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        stp_scan_info info;
        write_tile(names[k], 2ull * COUNT);
        free(scan_fixture_read(names[k], NULL, &info));
        assert_true(info.raster.x == 0.0 && info.raster.y == 16.0 * (SIDE - 1.0));
        assert_true(info.raster.dx == 16.0 && info.raster.dy == 16.0);
        assert_int_equal(info.note_count, 1);
    }
}

static void other_sizes_are_refused(void **state)
{
    (void)state;
    write_tile("N47E008.hgt", 2ull * COUNT - 2);
    scan_fixture_fails("N47E008.hgt", NULL, STP_CORRUPT, "2884802");
    scan_fixture_bytes("N47E008.hgt", "", 0);
    scan_fixture_fails("N47E008.hgt", NULL, STP_EMPTY, "empty");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_tell_the_corner),
        cmocka_unit_test(low_land_is_no_text),
        cmocka_unit_test(other_names_tell_no_place),
        cmocka_unit_test(other_sizes_are_refused),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

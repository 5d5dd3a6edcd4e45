/* Tests the points of COLMAP's sparse models, which their numbers alone tell. */
#include "tests/fixtures/scan/scan_fixture.h"

enum { COUNT = 40, RECORD = 51, TRACK = 8 };

static void put(unsigned char **at, const void *value, size_t size)
{
    memcpy(*at, value, size);
    *at += size;
}

/* Point i has a track of i % 4 pictures. Returns the size. */
static size_t fill(unsigned char *bytes)
{
    unsigned char *at = bytes;
    const uint64_t count = COUNT;
    put(&at, &count, sizeof count);
    for (int i = 0; i < COUNT; i++) {
        const uint64_t identity = 7u * (uint64_t)i, length = (uint64_t)i % 4;
        const double position[3] = {i - 20.5, 0.25 * i, 1e-3 * i}, error = 0.5;
        const unsigned char rgb[3] = {(unsigned char)i, 80, 255};
        const uint32_t picture[2] = {3, 1000};
        put(&at, &identity, sizeof identity);
        put(&at, position, sizeof position);
        put(&at, rgb, sizeof rgb);
        put(&at, &error, sizeof error);
        put(&at, &length, sizeof length);
        for (uint64_t k = 0; k < length; k++)
            put(&at, picture, sizeof picture);
    }
    return (size_t)(at - bytes);
}

static unsigned char bytes[8 + COUNT * (RECORD + 3 * TRACK)];

static void points_are_read(void **state)
{
    (void)state;
    stp_scan_info info;
    scan_fixture_bytes("points3D.bin", bytes, fill(bytes));
    stp_point *points = scan_fixture_read("points3D.bin", NULL, &info);
    assert_string_equal(info.format, "COLMAP points");
    assert_int_equal(info.point_count, COUNT);
    assert_int_equal(info.attributes, STP_POINT_HAS_COLOUR);
    assert_true(info.y_down);
    for (int i = 0; i < COUNT; i++) {
        scan_fixture_position(&points[i], i - 20.5, 0.25 * i, 1e-3 * i);
        scan_fixture_rgb(&points[i], 257u * (unsigned)i, 257 * 80, 65535);
    }
    free(points);
}

/* What is within the bytes that are looked at is checked before the format is believed. */
static void nothing_else(void **state)
{
    (void)state;
    const size_t size = fill(bytes);
    const uint64_t many = UINT64_MAX, none = 0;
    const double nowhere = (double)NAN;
    const struct {
        size_t place, size;
        const void *value;
    } wrong[] = {{0, 8, &many},         {0, 8, &none},      {8 + 8, 8, &nowhere},
                 {8 + 35, 8, &nowhere}, {8 + 43, 8, &many}, {8 + 43, 8, "\1\0\0\0\0\0\0"}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        fill(bytes);
        memcpy(bytes + wrong[i].place, wrong[i].value, wrong[i].size);
        scan_fixture_bytes("wrong.bin", bytes, size);
        scan_fixture_fails("wrong.bin", NULL, STP_FORMAT, "no known format");
    }
    fill(bytes);
    scan_fixture_bytes("cut.bin", bytes, size - 1);
    scan_fixture_fails("cut.bin", NULL, STP_FORMAT, "no known format");
    scan_fixture_bytes("points3D.dat", bytes, size);
    scan_fixture_fails("points3D.dat", NULL, STP_FORMAT, "no known format");
}

/* Beyond the first 64 KiB a cut is found when it is read; what is there can be salvaged. */
static void long_files_are_cut(void **state)
{
    (void)state;
    const size_t record = RECORD + 2 * TRACK, count = 2000, size = 8 + count * record;
    unsigned char *all = calloc(size, 1);
    const uint64_t points = count, track = 2;
    const stp_scan_params salvage = {.salvage = true};
    stp_scan_info info;
    assert_non_null(all);
    memcpy(all, &points, sizeof points);
    for (size_t i = 0; i < count; i++)
        memcpy(all + 8 + i * record + 43, &track, sizeof track);
    scan_fixture_bytes("long.bin", all, size - record - 5);
    scan_fixture_fails("long.bin", NULL, STP_CORRUPT, "after 1998 of 2000 points");
    stp_point *read = scan_fixture_read("long.bin", &salvage, &info);
    assert_int_equal(read[1997].reject, STP_REJECT_NONE);
    assert_int_equal(read[1998].reject, STP_REJECT_LOST);
    free(read);
    free(all);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_are_read),
        cmocka_unit_test(nothing_else),
        cmocka_unit_test(long_files_are_cut),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

/* Tests turns of a lidar in floats, whose name and numbers alone tell what they are. */
#include "tests/fixtures/scan/scan_fixture.h"

enum { COUNT = 60 };

static size_t fill(float *out, int floats, float full)
{
    for (int i = 0; i < COUNT; i++) {
        const float v[5] = {(float)i - 30.5f, 0.25f * (float)i, -1.75f, full * (float)i / 59.0f,
                            (float)(i % 16)};
        memcpy(out + i * floats, v, (size_t)floats * sizeof *v);
    }
    return (size_t)(COUNT * floats) * sizeof *out;
}

/* The size of 60 records of four floats is that of 48 records of five. */
static void both_kinds(void **state)
{
    (void)state;
    float numbers[5 * COUNT];
    for (int floats = 4; floats <= 5; floats++) {
        stp_scan_info info;
        const float full = floats == 4 ? 1.0f : 255.0f;
        scan_fixture_bytes("000000.bin", numbers, fill(numbers, floats, full));
        stp_point *points = scan_fixture_read("000000.bin", &(stp_scan_params){0}, &info);
        assert_string_equal(info.format, "KITTI frame");
        assert_int_equal(info.point_count, COUNT);
        assert_true(info.heights && info.station_count == 1);
        assert_int_equal(info.note_count, floats - 3);
        for (int i = 0; i < COUNT; i++)
            scan_fixture_position(&points[i], i - 30.5, 0.25 * i, -1.75);
        assert_int_equal(points[0].intensity, 0);
        assert_int_equal(points[COUNT - 1].intensity, 65535);
        assert_int_equal(points[COUNT - 1].station, 1);
        free(points);
    }
}

/* Other names and other numbers are no turns. */
static void nothing_else(void **state)
{
    (void)state;
    float numbers[5 * COUNT];
    const size_t size = fill(numbers, 4, 1.0f);
    scan_fixture_bytes("a.dat", numbers, size);
    scan_fixture_fails("a.dat", NULL, STP_FORMAT, "no known format");
    scan_fixture_bytes("cut.bin", numbers, size - 4);
    scan_fixture_fails("cut.bin", NULL, STP_FORMAT, "no known format");
    static const struct {
        int place;
        float number;
    } wrong[] = {{0, 2000.0f}, {6, (float)NAN}, {7, -1.0f}, {11, 300.0f}, {9, 1e-40f}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        fill(numbers, 4, 1.0f);
        numbers[wrong[i].place] = wrong[i].number;
        scan_fixture_bytes("wrong.bin", numbers, size);
        scan_fixture_fails("wrong.bin", NULL, STP_FORMAT, "no known format");
    }
    for (int i = 0; i < 5 * COUNT; i++)
        numbers[i] = 1.0f + 0.5f * (float)(i % 7); /* a mesh's corners, or heights */
    scan_fixture_bytes("positive.bin", numbers, size);
    scan_fixture_fails("positive.bin", NULL, STP_FORMAT, "no known format");
    memset(numbers, 0, sizeof numbers);
    scan_fixture_bytes("zeros.bin", numbers, size);
    scan_fixture_fails("zeros.bin", NULL, STP_FORMAT, "no known format");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(both_kinds),
        cmocka_unit_test(nothing_else),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

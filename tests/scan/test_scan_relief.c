/* Tests the spacing of heights whose file does not tell it. */
#include "tests/fixtures/scan/scan_fixture.h"

#include <math.h>

enum { SIDE = 49 };

static double hill(int column, int row)
{
    return 0.5 + 0.5 * sin(0.1 * column) * cos(0.08 * row);
}

static void write_whole(double most, int columns)
{
    FILE *file = fopen("whole.pgm", "wb");
    assert_non_null(file);
    fprintf(file, "P5 %d %d %d\n", columns, SIDE, most > 255.0 ? 65535 : 255);
    for (int i = 0; i < columns * SIDE; i++) {
        const int number = (int)lround(most * hill(i % columns, i / columns));
        if (most > 255.0)
            fputc(number >> 8, file);
        fputc(number & 255, file);
    }
    fclose(file);
}

static void write_floats(double low, double most, int columns)
{
    FILE *file = fopen("floats.pfm", "wb");
    assert_non_null(file);
    fprintf(file, "Pf\n%d %d\n-1.0\n", columns, SIDE);
    for (int i = 0; i < columns * SIDE; i++) {
        const float number = (float)(low + (most - low) * hill(i % columns, i / columns));
        assert_int_equal(fwrite(&number, sizeof number, 1, file), 1);
    }
    fclose(file);
}

/* Reads the grid and checks the distance of its columns and rows, and whether a note tells it. */
static void expect(const char *path, const stp_grid_params *grid, double spacing, bool told)
{
    const stp_scan_params params = {.grid = grid};
    stp_scan_info info;
    stp_point *points = scan_fixture_read(path, &params, &info);
    assert_true(points[1].position.x - points[0].position.x == spacing);
    assert_true(info.raster.dx == spacing && info.raster.dy == spacing);
    assert_int_equal(info.note_count, told ? 1 : 0);
    free(points);
}

static void needles_become_landscapes(void **state)
{
    (void)state;
    write_whole(65535.0, SIDE);
    expect("whole.pgm", NULL, 8192.0, true);
    write_whole(60.0 * 256.0, SIDE);
    expect("whole.pgm", NULL, 2048.0, true);
    write_floats(-3000.0, 1000.0, SIDE);
    expect("floats.pfm", NULL, 512.0, true);
}

static void flat_floats_become_landscapes(void **state)
{
    (void)state;
    write_floats(0.0, 1.0, 1025);
    expect("floats.pfm", NULL, 1.0 / 256.0, true);
    write_floats(0.0, 1.0, SIDE); /* steep enough as it is */
    expect("floats.pfm", NULL, 1.0, false);
    write_floats(100.0, 101.0, 1025); /* heights in metres */
    expect("floats.pfm", NULL, 1.0, false);
}

static void what_is_said_stays(void **state)
{
    (void)state;
    write_whole(60.0, SIDE);
    expect("whole.pgm", NULL, 1.0, false);
    write_whole(255.0, SIDE); /* of 8 bits */
    expect("whole.pgm", NULL, 1.0, false);
    write_whole(65535.0, 31); /* no landscape */
    expect("whole.pgm", NULL, 1.0, false);
    write_whole(65535.0, SIDE);
    expect("whole.pgm", &(stp_grid_params){.dx = 2.0, .dy = 2.0}, 2.0, false);
    expect("whole.pgm", &(stp_grid_params){.scale = 0.001}, 1.0, false);
}

/* Squares of numbers without a header, in both byte orders, and as floats. */
static void raw_squares(void **state)
{
    (void)state;
    static const char *const names[] = {"low.r16", "high.raw", "floats.r32"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        FILE *file = fopen(names[k], "wb");
        assert_non_null(file);
        for (int i = 0; i < SIDE * SIDE; i++) {
            const double height = hill(i % SIDE, i / SIDE);
            const int number = (int)lround(60000.0 * height);
            const float share = (float)height;
            if (k == 2)
                assert_int_equal(fwrite(&share, sizeof share, 1, file), 1);
            else
                fprintf(file, "%c%c", k == 0 ? number & 255 : number >> 8,
                        k == 0 ? number >> 8 : number & 255);
        }
        fclose(file);
        stp_scan_info info;
        stp_point *points = scan_fixture_read(names[k], NULL, &info);
        assert_int_equal(info.raster.columns, SIDE);
        assert_int_equal(info.raster.rows, SIDE);
        const double high = hill(5, 0), z = points[5].position.z;
        assert_true(k == 2 ? fabs(z - high) < 1e-6 : z == (double)lround(60000.0 * high));
        free(points);
    }
    scan_fixture_bytes("other.raw", "\1\2\3\4\5", 5);
    scan_fixture_fails("other.raw", NULL, STP_FORMAT, "no known format");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(needles_become_landscapes),
        cmocka_unit_test(flat_floats_become_landscapes),
        cmocka_unit_test(what_is_said_stays),
        cmocka_unit_test(raw_squares),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

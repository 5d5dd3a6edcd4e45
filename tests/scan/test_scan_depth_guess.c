/* Tests which images are taken as a depth camera's without being told, and that heights are not. */
#include "formats/scan/grid/depth_guess.h"
#include "tests/fixtures/scan/scan_fixture.h"

#include <math.h>

enum { COLUMNS = 320, ROWS = 240 };

/* A box on a floor, seen from above it, in units of one metre; 0: behind the box's left edge. */
static double camera_depth(int column, int row)
{
    const double y = (row - 119.5) / 262.5 + 0.6, floor = 1.4 / y;
    if (column > 120 && column < 200 && row > 60 && row < 160)
        return 1.2;
    if (column > 104 && column <= 120 && row > 60 && row < 160)
        return 0.0;
    return floor < 6.0 ? floor : 0.0;
}

/* The corner of a room: walls meet at its deepest line, amid most windows. */
static double corner_depth(int column, int row)
{
    const double x = (column - 159.5) / 262.5, left = 1.2 / fmax(0.35 - x, 1e-3);
    const double right = 1.2 / fmax(0.35 + x, 1e-3);
    return row < 12 ? 0.0 : left < right ? left : right;
}

/* The same steps and holes, on a slope. */
static double slope_height(int column, int row)
{
    const double z = camera_depth(column, row);
    return z == 0.0 ? 0.0 : z == 1.2 ? 2.2 : 1.3 + 0.01 * row + 0.002 * column;
}

/* Steps of 3 of 10 and dropouts of single pixels: a chip under a microscope. */
static double chip_height(int column, int row)
{
    const unsigned scattered = (unsigned)(column * 7919 + row * 104729) % 50u;
    return scattered == 0 ? 0.0 : 1.0 + 0.3 * ((column / 40 + row / 40) % 2);
}

/* Land in the sea, from the beach up. */
static double island_height(int column, int row)
{
    const double z = 4.0 - 0.05 * hypot(column - 160.0, row - 120.0);
    return z > 0.0 ? z : 0.0;
}

/* A wall that faces the camera, and a post before it with its shadow. */
static double wall_depth(int column, int row)
{
    return row < 20 || (column >= 90 && column < 100) ? 0.0
           : column >= 100 && column < 120            ? 2.0
                                                      : 3.0;
}

static void write_image(int columns, double unit, double (*depth)(int, int))
{
    FILE *file = fopen("image.pgm", "wb");
    assert_non_null(file);
    fprintf(file, "P5 %d %d 65535\n", columns, ROWS);
    for (int i = 0; i < columns * ROWS; i++) {
        const int number = (int)lround(depth(i % columns, i / columns) * unit);
        fputc(number >> 8, file);
        fputc(number & 255, file);
    }
    fclose(file);
}

/* As floats in metres, with NaN for zero. */
static void write_floats(double (*depth)(int, int))
{
    FILE *file = fopen("image.pfm", "wb");
    assert_non_null(file);
    fprintf(file, "Pf\n%d %d\n-1.0\n", COLUMNS, ROWS);
    for (int row = ROWS - 1; row >= 0; row--)
        for (int column = 0; column < COLUMNS; column++) {
            const double z = depth(column, row);
            const float number = z > 0.0 ? (float)z : NAN;
            assert_int_equal(fwrite(&number, sizeof number, 1, file), 1);
        }
    fclose(file);
}

static stp_grid_params guess(stp_grid_params params)
{
    char note[256] = "";
    stp_error err = {0};
    const stp_grid_params before = params;
    assert_int_equal(stp_depth_guess(&params, note, sizeof note, "image.pgm", &err), STP_OK);
    assert_int_equal(note[0] != '\0', params.fx != before.fx);
    return params;
}

static void cameras_are_known(void **state)
{
    (void)state;
    static const struct {
        double unit, scale;
    } cases[] = {{1000.0, 0.001}, {5000.0, 0.0002}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        write_image(COLUMNS, cases[i].unit, camera_depth);
        const stp_grid_params found = guess((stp_grid_params){0});
        assert_true(found.fx == 262.5 && found.fy == 262.5 && found.cx == 159.5 &&
                    found.cy == 119.5);
        assert_true(found.scale == cases[i].scale);
        assert_true(guess((stp_grid_params){.scale = 3.0}).scale == 3.0);
    }
    stp_scan_info info;
    write_floats(camera_depth);
    free(scan_fixture_read("image.pfm", NULL, &info));
    assert_true(info.station_count == 1 && !info.heights);
    write_floats(slope_height);
    free(scan_fixture_read("image.pfm", NULL, &info));
    assert_true(info.heights);
    write_image(COLUMNS, 1000.0, corner_depth);
    assert_true(guess((stp_grid_params){0}).fx == 262.5);
    write_image(COLUMNS, 1000.0, wall_depth);
    assert_true(guess((stp_grid_params){0}).fx == 262.5);
}

static void what_is_given_stays(void **state)
{
    (void)state;
    write_image(COLUMNS, 1000.0, camera_depth);
    assert_true(guess((stp_grid_params){.dx = 1.0, .dy = 1.0}).fx == 0.0);
    assert_true(guess((stp_grid_params){.fx = 300.0, .fy = 300.0}).fx == 300.0);
}

static void heights_are_not(void **state)
{
    (void)state;
    static double (*const kinds[])(int, int) = {slope_height, chip_height, island_height};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        for (double unit = 500.0; unit < 12000.0; unit *= 2.0) {
            write_image(COLUMNS, unit, kinds[i]);
            assert_true(guess((stp_grid_params){0}).fx == 0.0);
        }
    write_image(COLUMNS + 1, 1000.0, camera_depth); /* no camera has this size */
    assert_true(guess((stp_grid_params){0}).fx == 0.0);
}

/* Points are where they would be if the pinhole were given, and a note says so. */
static void points_are_the_cameras(void **state)
{
    (void)state;
    const stp_grid_params given = {
        .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5, .scale = 1e-3};
    const stp_scan_params told = {.grid = &given}, untold = {0}, thin = {.grid_step = 4};
    stp_scan_info info;
    write_image(COLUMNS, 1000.0, camera_depth);
    stp_point *expected = scan_fixture_read("image.pgm", &told, &info);
    assert_int_equal(info.note_count, 0);
    stp_point *found = scan_fixture_read("image.pgm", &untold, &info);
    assert_int_equal(info.station_count, 1);
    assert_false(info.heights);
    assert_memory_equal(found, expected, info.point_count * sizeof *found);
    free(found);
    free(expected);
    free(scan_fixture_read("image.pgm", &thin, &info));
    assert_int_equal(info.grid.columns, COLUMNS / 4);
    assert_false(info.heights);
}

static void the_note_says_how(void **state)
{
    (void)state;
    stp_scan *scan = NULL;
    stp_error err = {0};
    write_image(COLUMNS, 1000.0, camera_depth);
    assert_int_equal(stp_scan_open(&scan, "image.pgm", NULL, &err), STP_OK);
    const stp_scan_info *info = stp_scan_get_info(scan);
    assert_int_equal(info->note_count, 1);
    assert_string_equal(info->notes[0].name, "camera");
    assert_string_equal(info->notes[0].text,
                        "taken as a depth camera's image (--pinhole 262.5,262.5,159.5,119.5 "
                        "--height-scale 0.001): give the camera's own numbers, or --spacing 1 if "
                        "these are heights");
    stp_scan_close(&scan);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cameras_are_known), cmocka_unit_test(what_is_given_stays),
        cmocka_unit_test(heights_are_not),   cmocka_unit_test(points_are_the_cameras),
        cmocka_unit_test(the_note_says_how),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

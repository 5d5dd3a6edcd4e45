/* Tests finding the step of coordinates that are decimals stored as floats. */
#include "formats/scan/coordinate_step.h"
#include "tests/fixtures/byte_fixture.h"
#include "tests/fixtures/scan/las_fixture.h"

#include <math.h>

/* Writes a binary PLY file of count points, each three floats or three doubles. */
static void write_ply(const char *path, const double *xyz, size_t count, bool is_double)
{
    byte_row file = {0};
    char header[256];
    const char *type = is_double ? "double" : "float";
    snprintf(header, sizeof header,
             "ply\nformat binary_little_endian 1.0\nelement vertex %zu\nproperty %s x\n"
             "property %s y\nproperty %s z\nend_header\n",
             count, type, type, type);
    bytes_text(&file, header);
    for (size_t i = 0; i < 3 * count; i++) {
        if (is_double)
            bytes_double(&file, xyz[i]);
        else
            bytes_float(&file, (float)xyz[i]);
    }
    scan_fixture_bytes(path, file.data, file.size);
    bytes_free(&file);
}

static double step_by(const char *path, const stp_scan_params *params, bool fine)
{
    stp_error err = {0};
    stp_scan *scan = NULL;
    double step = -1.0;
    if (stp_scan_open(&scan, path, params, &err) != STP_OK ||
        stp_scan_find_step(scan, fine, &step, &err) != STP_OK)
        fail_msg("%s", err.message);
    stp_scan_close(&scan);
    return step;
}

static double step_of(const char *path)
{
    return step_by(path, NULL, false);
}

static void expect(double expected, const double *xyz, size_t count, bool is_double)
{
    write_ply("step.ply", xyz, count, is_double);
    const double step = step_of("step.ply");
    if (step != expected)
        fail_msg("step %g, expected %g (%zu points of %s, the first at %.17g %.17g %.17g)", step,
                 expected, count, is_double ? "double" : "float", xyz[0], xyz[1], xyz[2]);
}

static void decimals(void **state)
{
    (void)state;
    /* at UTM's coordinates floats have steps of 1/32 and 1/2: the third coordinate shows the
     * step */
    expect(0.01, (double[]){513449.69, 5402650.17, 248.41, 513449.7, 5402651.2, 248.05}, 2, false);
    expect(0.01, (double[]){513449.69, 5402650.17, 248.41}, 1, true);
    expect(0.001, (double[]){513449.69, 5402650.17, 248.413}, 1, true);
    expect(0.001, (double[]){513449.69, 5402650.17, 248.413}, 1, false);
    expect(0.1, (double[]){-0.1, 7.0, 0.3}, 1, false);
    expect(1.0, (double[]){-3.0, 7.0, 1e6}, 1, false);
    expect(0.0, (double[]){1.0, 2.0, 0.0625}, 1, false);
    expect(0.0, (double[]){513449.69, 5402650.17, 248.4133}, 1, true);
    expect(0.0, (double[]){513449.69, 5402650.1733, 248.41}, 1, true);
    expect(0.0, (double[]){0.37, M_PI, 1.0}, 1, false);
    /* an ulp off the decimal, as LAS readers compute it */
    const double computed = 63600176 * 0.01 + 1e-10;
    assert_true(computed != 636001.76);
    expect(0.01, (double[]){computed, 1.0, 2.0}, 1, true);
}

/* The last of many points decides; a point that is not finite does not count. */
static void many_points(void **state)
{
    (void)state;
    enum { COUNT = 5000 };
    static double xyz[3 * COUNT];
    for (size_t i = 0; i < 3 * COUNT; i++)
        xyz[i] = (double)(i % 977) / 10.0;
    expect(0.1, xyz, COUNT, true);
    xyz[3 * COUNT - 1] = 0.25;
    expect(0.01, xyz, COUNT, true);
    xyz[3 * COUNT - 1] = NAN;
    xyz[3 * COUNT - 2] = M_PI;
    expect(0.1, xyz, COUNT, true);
}

/* A value that stands for `none` must not spoil the step of the others; see the header. */
static void far_apart(void **state)
{
    (void)state;
    expect(0.1, (double[]){0.1, 0, 0, 9e7, 0, 0}, 2, true);
    expect(0.0, (double[]){0.1, 0, 0, 2e8, 0, 0}, 2, true);
    expect(0.0, (double[]){0.1, 0, 0, 9e29, 0, 0}, 2, true);
    expect(0.1, (double[]){0.1, 0, 0, 1e30, 0, 0}, 2, true); /* none, like NaN */
    expect(0.0, (double[]){-1.7e308, 0, 0, 1.7e308, 0, 0}, 2, true);
}

static void other_formats(void **state)
{
    (void)state;
    las_file f;
    las_begin(&f, 2, 0, 20);
    las_set_count(&f, 1);
    las_add_point(&f, 1, 1, 1);
    las_save(&f, "step.las");
    assert_true(step_of("step.las") == 0.125); /* the header's; the point: 1000.5 -1999.75 */
    scan_fixture_text("step.obj", "v 0.5 1 2\nv 1 2 3.25\n");
    assert_true(step_of("step.obj") == 0.01);
    scan_fixture_text("none.ply", "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\n"
                                  "property float y\nproperty float z\nend_header\n");
    assert_true(step_of("none.ply") == 0.0);
    scan_fixture_text("bad.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                                 "property float y\nproperty float z\nend_header\n0 0 zero\n");
    stp_error err = {0};
    stp_scan *scan = NULL;
    double step = -1.0;
    assert_int_equal(stp_scan_open(&scan, "bad.ply", NULL, &err), STP_OK);
    assert_int_equal(stp_scan_find_step(scan, false, &step, &err), STP_CORRUPT);
    assert_true(step == -1.0);
    stp_scan_close(&scan);
}

/* Of a grid of heights these alone were measured; but exact coordinates are all exact. */
static void grids_have_heights(void **state)
{
    (void)state;
    scan_fixture_text("grid.asc", "ncols 3\nnrows 2\nxllcorner 0.123456\nyllcorner 0\n"
                                  "cellsize 0.333\n1 2 3\n2 3 4\n");
    assert_true(step_of("grid.asc") == 1.0);
    assert_true(step_by("grid.asc", NULL, true) != 1.0);
}

/* A scale multiplies the step of the file's numbers, whether it is a decimal or not. Only a step
 * for which cells are too wide is none. */
static void grids_have_scales(void **state)
{
    (void)state;
    const struct {
        double scale, step, tenths; /* the steps of whole numbers and of tenths */
    } cases[] = {{0.125, 0.125, 0.0125}, {-0.125, 0.125, 0.0125},   {0.07, 0.07, 0.007},
                 {0.001, 0.001, 0.0},    {0.0009, 0.0009, 0.0},     {0.0001, 0.0, 0.0},
                 {8.0, 8.0, 0.8},        {0.3048, 0.3048, 0.03048}, {100.0, 100.0, 10.0}};
    scan_fixture_text("whole.asc", "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\n"
                                   "cellsize 0.5\n1 23 4567\n2 3 65533\n");
    scan_fixture_text("tenths.asc", "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\n"
                                    "cellsize 0.5\n1.3 23.1 4567.7\n2 3 65533.9\n");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const stp_grid_params grid = {.scale = cases[i].scale};
        const stp_scan_params params = {.grid = &grid};
        const double whole = step_by("whole.asc", &params, false);
        const double tenths = step_by("tenths.asc", &params, false);
        if (fabs(whole - cases[i].step) > 1e-12 || fabs(tenths - cases[i].tenths) > 1e-12)
            fail_msg("scale %g: steps %g and %g", cases[i].scale, whole, tenths);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(decimals),      cmocka_unit_test(grids_have_heights),
        cmocka_unit_test(many_points),   cmocka_unit_test(far_apart),
        cmocka_unit_test(other_formats), cmocka_unit_test(grids_have_scales),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

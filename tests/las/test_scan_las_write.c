/* Tests the writer of LAS and LAZ: its files are read back and compared with the standard byte by
 * byte. Files appear whole or not at all. */
#include "formats/scan/las/las_write.h"
#include "tests/fixtures/scan/las_fixture.h"

#include <math.h>

#define ALL (STP_POINT_HAS_COLOUR | STP_POINT_HAS_INTENSITY | STP_POINT_HAS_CLASS)

static stp_point sample(size_t i)
{
    return (stp_point){.position = {500000.123 + (double)i / 3.0, -5400000.456 - (double)i, 1e-3},
                       .rgb = {(uint16_t)(i * 13), 65535, 1},
                       .intensity = (uint16_t)(i * 7 + 256),
                       .class_id = (uint8_t)i,
                       .station = (uint16_t)(i % 3)};
}

static const stp_las_writer_params params_0 = {
    .force = true, .step = 1e-3, .offset = {500000.0, -5400000.0, 0.0}};

static stp_las_writer *create(const char *path, const stp_las_writer_params *params)
{
    stp_error err = {0};
    stp_las_writer *writer = NULL;
    if (stp_las_writer_create(&writer, path, params, &err) != STP_OK)
        fail_msg("%s", err.message);
    return writer;
}

static void check_point(const stp_point *point, size_t i, uint32_t attributes)
{
    const stp_point expected = sample(i);
    assert_true(fabs(point->position.x - expected.position.x) <= 0.5e-3 + 1e-9);
    assert_true(fabs(point->position.y - expected.position.y) <= 0.5e-3 + 1e-9);
    assert_true(fabs(point->position.z - expected.position.z) <= 1e-12);
    if (attributes & STP_POINT_HAS_COLOUR)
        assert_memory_equal(point->rgb, expected.rgb, sizeof expected.rgb);
    scan_fixture_scalars(point, attributes & STP_POINT_HAS_INTENSITY ? expected.intensity : 0,
                         attributes & STP_POINT_HAS_CLASS ? expected.class_id : 0);
}

static void points_come_back(void **state)
{
    (void)state;
    enum { COUNT = 5000 };
    for (uint32_t attributes = 0; attributes <= ALL; attributes++) {
        stp_error err = {0};
        stp_scan_info info;
        stp_las_writer_params params = params_0;
        if (attributes & STP_POINT_HAS_NORMAL)
            continue;
        params.attributes = attributes;
        stp_las_writer *writer = create("trip.las", &params);
        for (size_t i = 0; i < COUNT; i++) {
            const stp_point point = sample(i);
            assert_int_equal(stp_las_writer_points(writer, &point, 1, &err), STP_OK);
        }
        assert_int_equal(stp_las_writer_finish(&writer, &err), STP_OK);
        assert_null(writer);
        stp_point *points = scan_fixture_read("trip.las", NULL, &info);
        assert_int_equal(info.point_count, COUNT);
        assert_int_equal(info.attributes, STP_POINT_HAS_INTENSITY | STP_POINT_HAS_CLASS |
                                              (attributes & STP_POINT_HAS_COLOUR));
        assert_true(info.coordinate_step == 1e-3);
        for (size_t i = 0; i < COUNT; i++)
            check_point(&points[i], i, attributes);
        free(points);
        las_expect_note("trip.las", "counts", "");
    }
}

/* A packed file has the same header, but for the packing, and the same points. */
static void packed_points_come_back(void **state)
{
    (void)state;
    enum { COUNT = 60000 };
    stp_error err = {0};
    stp_scan_info info, packed_info;
    stp_las_writer_params params = params_0;
    params.attributes = ALL | STP_POINT_HAS_STATION;
    params.wkt = "GEOGCS[\"x\"]";
    for (int packed = 0; packed < 2; packed++) {
        params.packed = packed;
        stp_las_writer *writer = create(packed ? "trip.laz" : "trip.las", &params);
        for (size_t i = 0; i < COUNT; i++) {
            const stp_point point = sample(i);
            assert_int_equal(stp_las_writer_points(writer, &point, 1, &err), STP_OK);
        }
        assert_int_equal(stp_las_writer_finish(&writer, &err), STP_OK);
    }
    stp_point *points = scan_fixture_read("trip.las", NULL, &info);
    stp_point *unpacked = scan_fixture_read("trip.laz", NULL, &packed_info);
    assert_int_equal(packed_info.point_count, COUNT);
    assert_memory_equal(points, unpacked, COUNT * sizeof *points);
    free(points);
    free(unpacked);
    size_t size, packed_size;
    unsigned char *plain = scan_fixture_load("trip.las", &size);
    unsigned char *small = scan_fixture_load("trip.laz", &packed_size);
    assert_true(packed_size < size / 2);
    assert_int_equal(small[104], plain[104] | 0x80);
    assert_int_equal(las_bytes_get(small + 96, 4), las_bytes_get(plain + 96, 4) + 54 + 34 + 12);
    assert_int_equal(las_bytes_get(small + 100, 4), 2);
    assert_memory_equal(small + 105, plain + 105, 375 - 105);
    free(plain);
    free(small);
}

static double get_double(const las_file *f, size_t at)
{
    const uint64_t bits = las_get(f, at, 8);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Compares header and records with the tables of the standard. */
static void bytes_of_the_standard(void **state)
{
    (void)state;
    stp_error err = {0};
    las_file f;
    stp_las_writer_params params = params_0;
    params.attributes = ALL | STP_POINT_HAS_STATION;
    const stp_point points[2] = {sample(3), sample(5)};
    stp_las_writer *writer = create("bytes.las", &params);
    assert_int_equal(stp_las_writer_points(writer, points, 2, &err), STP_OK);
    assert_int_equal(access("bytes.las", F_OK), -1);
    assert_int_equal(stp_las_writer_finish(&writer, &err), STP_OK);
    FILE *file = fopen("bytes.las", "rb");
    assert_non_null(file);
    f.size = fread(f.bytes, 1, sizeof f.bytes, file);
    fclose(file);
    assert_int_equal(f.size, 375 + 2 * 36);
    assert_memory_equal(f.bytes, "LASF", 4);
    static const struct {
        size_t at, bytes;
        uint64_t value;
    } fields[] = {
        {6, 2, 16},   {24, 1, 1},     {25, 1, 4},
        {94, 2, 375}, {96, 4, 375},   {100, 4, 0},
        {104, 1, 7},  {105, 2, 36},   {107, 4, 0},
        {111, 4, 0},  {227, 8, 0},    {235, 8, 0},
        {243, 4, 0},  {247, 8, 2},    {255, 8, 2},
        {263, 8, 0},  {375, 4, 1123}, {379, 4, (uint32_t)-3456},
        {383, 4, 1},  {387, 2, 277},  {389, 1, 0x11},
        {390, 1, 0},  {391, 1, 3},    {395, 2, 0},
        {397, 8, 0},  {405, 2, 39},   {407, 2, 65535},
        {409, 2, 1},  {411, 4, 1790}, {411 + 20, 2, 2},
    };
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++)
        if (las_get(&f, fields[i].at, fields[i].bytes) != fields[i].value)
            fail_msg("byte %zu is %llu, expected %llu", fields[i].at,
                     (unsigned long long)las_get(&f, fields[i].at, fields[i].bytes),
                     (unsigned long long)fields[i].value);
    const double box[6] = {500001.790, 500001.123, -5400003.456, -5400005.456, 0.001, 0.001};
    for (size_t i = 0; i < 6; i++)
        assert_true(fabs(get_double(&f, 179 + 8 * i) - box[i]) < 1e-9);
    assert_true(get_double(&f, 131) == 1e-3 && get_double(&f, 163) == -5400000.0);
}

static void finest_steps(void **state)
{
    (void)state;
    static const struct {
        double reach, step;
    } cases[] = {{1.0, 1e-9},        {2.1, 1e-9},  {2.2, 1e-8},           {724.6, 1e-6},
                 {2147483647.0, 10}, {2.1e9, 1.0}, {2.1474836e-3, 1e-12}, {1e15, 1e6}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        if (stp_las_finest_step(cases[i].reach) != cases[i].step)
            fail_msg("step of %g is %.17g", cases[i].reach, stp_las_finest_step(cases[i].reach));
}

static void faults(void **state)
{
    (void)state;
    stp_error err = {0};
    stp_las_writer *writer = NULL;
    stp_las_writer_params params = params_0;
    const stp_point bad[] = {{.position = {500000.0 + 2147483.648, 0, 0}},
                             {.position = {0, NAN, 0}},
                             {.position = {500000.0, -5400000.0, INFINITY}}};
    for (size_t i = 0; i < 3; i++) {
        writer = create("fault.las", &params);
        assert_int_equal(stp_las_writer_points(writer, &bad[i], 1, &err), STP_INVALID_ARGUMENT);
        assert_non_null(strstr(err.message, "does not fit LAS integers"));
        stp_las_writer_destroy(&writer);
        assert_null(writer);
        assert_int_equal(access("fault.las", F_OK), -1);
    }
    params.attributes = STP_POINT_HAS_NORMAL;
    assert_int_equal(stp_las_writer_create(&writer, "fault.las", &params, &err),
                     STP_INVALID_ARGUMENT);
    assert_non_null(strstr(err.message, "LAS has no normals"));
    const double steps[] = {0.0, -1.0, NAN, INFINITY};
    for (size_t i = 0; i < 4; i++) {
        params = params_0;
        params.step = steps[i];
        assert_int_equal(stp_las_writer_create(&writer, "fault.las", &params, &err),
                         STP_INVALID_ARGUMENT);
    }
    scan_fixture_text("here.las", "already");
    params = params_0;
    params.force = false;
    assert_int_equal(stp_las_writer_create(&writer, "here.las", &params, &err), STP_EXISTS);
    assert_null(writer);
}

static void no_points(void **state)
{
    (void)state;
    stp_error err = {0};
    stp_scan_info info;
    stp_las_writer *writer = create("none.las", &params_0);
    assert_int_equal(stp_las_writer_finish(&writer, &err), STP_OK);
    free(scan_fixture_read("none.las", NULL, &info));
    assert_int_equal(info.point_count, 0);
    stp_las_writer_params packed = params_0;
    packed.packed = true;
    writer = create("none.laz", &packed);
    assert_int_equal(stp_las_writer_finish(&writer, &err), STP_OK);
    free(scan_fixture_read("none.laz", NULL, &info));
    assert_int_equal(info.point_count, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_come_back),
        cmocka_unit_test(bytes_of_the_standard),
        cmocka_unit_test(finest_steps),
        cmocka_unit_test(faults),
        cmocka_unit_test(packed_points_come_back),
        cmocka_unit_test(no_points),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

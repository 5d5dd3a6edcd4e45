/* Tests the PLY writer: its files are read back, and they appear whole or not at all. */
#include "formats/scan/mesh/mesh.h"
#include "formats/scan/ply/ply_write.h"
#include "tests/fixtures/scan/scan_fixture.h"

#include <math.h>

#define ALL                                                                                        \
    (STP_POINT_HAS_NORMAL | STP_POINT_HAS_COLOUR | STP_POINT_HAS_INTENSITY | STP_POINT_HAS_CLASS)

static stp_point sample(size_t i)
{
    const double angle = (double)i;
    return (stp_point){
        .position = {500000.123 + (double)i / 3.0, -5400000.456 - (double)i, 1e-3 * (double)i},
        .normal = {{(float)cos(angle), (float)sin(angle), 0.0f}},
        .rgb = {(uint16_t)(i % 256 * 257), 65535, 0},
        .intensity = (uint16_t)(i * 7 + 256),
        .class_id = (uint8_t)i};
}

static stp_ply_writer *create(const char *path, const stp_ply_writer_params *params)
{
    stp_error err = {0};
    stp_ply_writer *writer = NULL;
    if (stp_ply_writer_create(&writer, path, params, &err) != STP_OK)
        fail_msg("%s", err.message);
    return writer;
}

static void round_trip(uint32_t attributes, bool doubles)
{
    enum { COUNT = 5000 };
    stp_error err = {0};
    const stp_ply_writer_params params = {.force = true,
                                          .double_coordinates = doubles,
                                          .vertex_count = COUNT,
                                          .attributes = attributes};
    stp_ply_writer *writer = create("trip.ply", &params);
    for (size_t i = 0; i < COUNT; i++) {
        const stp_point point = sample(i);
        assert_int_equal(stp_ply_writer_points(writer, &point, 1, &err), STP_OK);
    }
    assert_int_equal(stp_ply_writer_finish(&writer, &err), STP_OK);
    assert_null(writer);
    stp_scan_info info;
    stp_point *points = scan_fixture_read("trip.ply", NULL, &info);
    assert_int_equal(info.attributes, attributes);
    assert_int_equal(info.point_count, COUNT);
    for (size_t i = 0; i < COUNT; i++) {
        stp_point expected = sample(i);
        if (doubles)
            scan_fixture_position(&points[i], expected.position.x, expected.position.y,
                                  expected.position.z);
        else
            scan_fixture_position(&points[i], (double)(float)expected.position.x,
                                  (double)(float)expected.position.y,
                                  (double)(float)expected.position.z);
        if (attributes & STP_POINT_HAS_NORMAL)
            scan_fixture_normal(&points[i], (double)expected.normal.x, (double)expected.normal.y,
                                0.0);
        if (attributes & STP_POINT_HAS_COLOUR)
            assert_memory_equal(points[i].rgb, expected.rgb, sizeof expected.rgb);
        if (attributes & STP_POINT_HAS_INTENSITY)
            assert_int_equal(points[i].intensity, expected.intensity);
        if (attributes & STP_POINT_HAS_CLASS)
            assert_int_equal(points[i].class_id, expected.class_id);
    }
    free(points);
}

static void points_come_back(void **state)
{
    (void)state;
    for (uint32_t attributes = 0; attributes <= ALL; attributes++)
        round_trip(attributes, attributes % 2 == 1);
    round_trip(ALL, false);
    round_trip(0, true);
}

static void triangles_come_back(void **state)
{
    (void)state;
    stp_error err = {0};
    const stp_ply_writer_params params = {.vertex_count = 4, .triangle_count = 2};
    const uint32_t triangles[2][3] = {{0, 1, 2}, {3, 2, 1}};
    stp_point points[4];
    for (size_t i = 0; i < 4; i++)
        points[i] = sample(i);
    stp_ply_writer *writer = create("mesh.ply", &params);
    assert_int_equal(stp_ply_writer_triangles(writer, triangles, 1, &err), STP_INVALID_ARGUMENT);
    assert_int_equal(stp_ply_writer_points(writer, points, 4, &err), STP_OK);
    assert_int_equal(stp_ply_writer_triangles(writer, triangles, 2, &err), STP_OK);
    assert_int_equal(access("mesh.ply", F_OK), -1);
    assert_int_equal(stp_ply_writer_finish(&writer, &err), STP_OK);
    stp_mesh *mesh = NULL;
    assert_int_equal(stp_mesh_load(&mesh, "mesh.ply", &err), STP_OK);
    assert_int_equal(mesh->triangle_count, 2);
    assert_memory_equal(mesh->triangles, triangles, sizeof triangles);
    stp_mesh_destroy(&mesh);
}

static void faults(void **state)
{
    (void)state;
    stp_error err = {0};
    stp_ply_writer *writer = NULL;
    stp_ply_writer_params params = {.vertex_count = 1, .triangle_count = 1};
    const uint32_t outside[1][3] = {{0, 0, 1}};
    const stp_point points[2] = {sample(0), sample(1)};
    writer = create("fault.ply", &params);
    assert_int_equal(stp_ply_writer_points(writer, points, 2, &err), STP_INVALID_ARGUMENT);
    assert_int_equal(stp_ply_writer_points(writer, points, 1, &err), STP_OK);
    assert_int_equal(stp_ply_writer_triangles(writer, outside, 1, &err), STP_INVALID_ARGUMENT);
    assert_non_null(strstr(err.message, "vertex 1 of 1"));
    assert_int_equal(stp_ply_writer_finish(&writer, &err), STP_INVALID_ARGUMENT);
    assert_non_null(strstr(err.message, "0 of 1 triangles"));
    assert_null(writer);
    assert_int_equal(access("fault.ply", F_OK), -1);

    params = (stp_ply_writer_params){.triangle_count = 1};
    assert_int_equal(stp_ply_writer_create(&writer, "fault.ply", &params, &err),
                     STP_INVALID_ARGUMENT);
    scan_fixture_text("here.ply", "already");
    params = (stp_ply_writer_params){0};
    assert_int_equal(stp_ply_writer_create(&writer, "here.ply", &params, &err), STP_EXISTS);
    assert_null(writer);
    params.force = true;
    writer = create("here.ply", &params);
    stp_ply_writer_destroy(&writer);
    assert_null(writer);
    scan_fixture_fails("here.ply", NULL, STP_CORRUPT, "");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_come_back),
        cmocka_unit_test(triangles_come_back),
        cmocka_unit_test(faults),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

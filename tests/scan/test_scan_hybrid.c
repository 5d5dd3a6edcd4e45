/* Tests meshes as hybrid surfaces: large triangles stay, the others become points, and borders
 * blend. */
#include "tests/fixtures/scan/scan_fixture.h"

/* Writes a PLY of two squares of 10 x 10 side by side; the second is cut into n x n. */
static void write_mesh(const char *path, int n, const char *edges)
{
    char text[65536];
    int at = snprintf(text, sizeof text,
                      "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\n"
                      "property float y\nproperty float z\nelement face %d\n"
                      "property list uchar int vertex_indices\n%send_header\n",
                      2 + (n + 1) * (n + 1), 2 + 2 * n * n,
                      edges ? "element edge 1\n"
                              "property int vertex1\nproperty int vertex2\n"
                            : "");
    at += sprintf(text + at, "-10 0 0\n-10 10 0\n");
    for (int y = 0; y <= n; y++)
        for (int x = 0; x <= n; x++)
            at += sprintf(text + at, "%g %g 0\n", 10.0 * x / n, 10.0 * y / n);
    at += sprintf(text + at, "3 0 2 1\n3 2 %d 1\n", 2 + n * (n + 1));
    for (int y = 0; y < n; y++)
        for (int x = 0; x < n; x++) {
            int a = 2 + y * (n + 1) + x, b = a + n + 1;
            at += sprintf(text + at, "3 %d %d %d\n3 %d %d %d\n", a, a + 1, b, a + 1, b + 1, b);
        }
    sprintf(text + at, "%s", edges ? edges : "");
    scan_fixture_text(path, text);
}

/* Opens a hybrid and takes its triangles; *points is the number of its points, all finite. */
static stp_triangle_set open_hybrid(const char *path, uint64_t sample_count, uint64_t *points)
{
    const stp_scan_params params = {.hybrid = true, .sample_count = sample_count};
    stp_triangle_set out = {0}, none = {0};
    stp_error err = {0};
    stp_scan *scan = NULL;
    stp_point batch[64];
    size_t count = 1;
    if (stp_scan_open(&scan, path, &params, &err) != STP_OK)
        fail_msg("%s", err.message);
    stp_scan_take_triangles(scan, &out);
    stp_scan_take_triangles(scan, &none);
    assert_int_equal(none.triangle_count, 0);
    for (*points = 0; count > 0; *points += count) {
        assert_int_equal(stp_scan_read(scan, batch, 64, &count, &err), STP_OK);
        for (size_t i = 0; i < count; i++)
            assert_true(batch[i].position.x >= 0.0 || out.triangle_count == 0);
    }
    assert_int_equal(*points, stp_scan_get_info(scan)->point_count);
    stp_scan_close(&scan);
    return out;
}

/* 21 x 21 + 2 vertices share an area of 200, so a point's share is 0.45: a triangle of 50 is large,
 * one of 0.125 is not. */
static void vertices_of_others_are_points(void **state)
{
    (void)state;
    uint64_t points;
    write_mesh("mesh.ply", 20, NULL);
    stp_triangle_set set = open_hybrid("mesh.ply", 0, &points);
    assert_int_equal(points, 21 * 21);
    assert_int_equal(set.triangle_count, 2);
    assert_int_equal(set.vertex_count, 4);
    const double radius = 1.7 * sqrt(200.0 / (21 * 21 + 2));
    for (int i = 0; i < 4; i++) {
        const stp_line_vertex *v = &set.vertices[i];
        assert_true(fabs((double)v->radius - (v->position.x < 0.0 ? 0.0 : radius)) < 1e-6);
        assert_true(fabsf(v->direction.z) > 0.999f);
        assert_int_equal(v->rgb[1], STP_POINT_GREY);
    }
    stp_triangle_set_clear(&set);
}

static void samples_fall_on_others(void **state)
{
    (void)state;
    uint64_t points;
    write_mesh("mesh.ply", 20, NULL);
    stp_triangle_set set = open_hybrid("mesh.ply", 1000, &points);
    assert_int_equal(points, 500);
    assert_int_equal(set.triangle_count, 2);
    stp_triangle_set_clear(&set);
    set = open_hybrid("mesh.ply", 10, &points); /* a point's share is 20: none is large */
    assert_int_equal(set.triangle_count, 0);
    stp_triangle_set_clear(&set);
    write_mesh("mesh.ply", 2, NULL);
    set = open_hybrid("mesh.ply", 100000, &points); /* all are large */
    assert_int_equal(points, 0);
    assert_int_equal(set.triangle_count, 10);
    assert_int_equal(set.vertex_count, 11);
    stp_triangle_set_clear(&set);
}

/* Each of the 800 small triangles would get 4 points of 6416, but all 802 would get 8 on average.
 */
static void few_triangles_all_stay(void **state)
{
    (void)state;
    uint64_t points;
    write_mesh("mesh.ply", 20, NULL);
    stp_triangle_set set = open_hybrid("mesh.ply", 8 * 802, &points);
    assert_int_equal(points, 0);
    assert_int_equal(set.triangle_count, 802);
    assert_int_equal(set.vertex_count, 21 * 21 + 2);
    for (uint64_t i = 0; i < set.vertex_count; i++) /* no border to points */
        assert_true(set.vertices[i].radius == 0.0f);
    stp_triangle_set_clear(&set);
    set = open_hybrid("mesh.ply", 8 * 802 - 1, &points);
    assert_int_equal(points, 3208);
    assert_int_equal(set.triangle_count, 2);
    stp_triangle_set_clear(&set);
}

/* A line beside the triangles stays a line. A file without faces cannot be a hybrid. */
static void lines_and_points_beside(void **state)
{
    (void)state;
    uint64_t points;
    write_mesh("edge.ply", 20, "0 30\n");
    stp_triangle_set set = open_hybrid("edge.ply", 0, &points);
    assert_int_equal(points, 21 * 21);
    stp_triangle_set_clear(&set);
    const stp_scan_params params = {.hybrid = true};
    scan_fixture_text("points.obj", "v 0 0 0\nv 1 0 0\n");
    scan_fixture_fails("points.obj", &params, STP_INVALID_ARGUMENT, "no --hybrid");
    scan_fixture_text("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    set = open_hybrid("flat.obj", 0, &points);
    assert_int_equal(points, 3);
    assert_int_equal(set.triangle_count, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(vertices_of_others_are_points),
        cmocka_unit_test(samples_fall_on_others),
        cmocka_unit_test(few_triangles_all_stay),
        cmocka_unit_test(lines_and_points_beside),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

/* Tests edges of PLY and l lines of OBJ as lines: chains, rings, junctions, errors, and points that
 * remain. */
#include "tests/fixtures/scan/scan_fixture.h"

#define HEAD "ply\nformat ascii 1.0\nelement vertex "
#define XYZ "property float x\nproperty float y\nproperty float z\n"
#define EDGES "property int vertex1\nproperty int vertex2\n"

static void assert_near(double found, double wanted, double off)
{
    assert_true(fabs(found - wanted) <= off);
}

/* Reads a file's lines, and its points to the end. Clear with stp_line_set_clear. */
static stp_line_set read_lines(const char *path, const char *text, const stp_scan_params *params,
                               stp_scan_info *info)
{
    stp_error err = {0};
    stp_scan *scan = NULL;
    stp_line_set out = {0}, none;
    stp_point points[16];
    size_t count = 1;
    uint64_t total = 0;
    scan_fixture_text(path, text);
    if (stp_scan_open(&scan, path, params, &err) != STP_OK)
        fail_msg("%s", err.message);
    *info = *stp_scan_get_info(scan);
    info->stations = NULL;
    info->notes = NULL;
    stp_scan_take_lines(scan, &out);
    stp_scan_take_lines(scan, &none);
    assert_int_equal(none.strip_count, 0);
    for (; count > 0; total += count)
        assert_int_equal(stp_scan_read(scan, points, 16, &count, &err), STP_OK);
    assert_int_equal(total, info->point_count);
    stp_scan_close(&scan);
    return out;
}

/* The x coordinates of a strip must be these digits. */
static void assert_strip(const stp_line_set *set, uint64_t strip, stp_line_kind kind,
                         const char *digits)
{
    char found[64] = "";
    assert_true(strip < set->strip_count);
    const stp_line_strip *s = &set->strips[strip];
    assert_in_range(s->count, 1, 60);
    for (uint64_t i = 0; i < s->count; i++)
        found[i] = (char)('0' + (int)set->vertices[s->begin + i].position.x);
    assert_string_equal(found, digits);
    assert_int_equal(s->kind, kind);
}

/* A chain 0-1-2-3 given backwards, a ring 4-5-6, a point 7, and three edges that meet in 8. */
static void edges_are_chained(void **state)
{
    (void)state;
    static const char text[] =
        HEAD "13\n" XYZ "element edge 9\n" EDGES "end_header\n"
             "0 0 0\n1 0 0\n2 1 0\n3 0 0\n4 0 0\n5 1 0\n6 0 1\n7 0 0\n8 0 0\n9 1 1\n"
             "9 2 2\n9 3 3\n9 9 9\n"
             "3 2\n1 2\n1 0\n6 5\n4 5\n4 6\n8 9\n10 8\n8 11\n";
    stp_scan_info info;
    stp_line_set set = read_lines("chains.ply", text, NULL, &info);
    assert_int_equal(info.point_count, 2);
    assert_int_equal(info.edges.read, 9);
    assert_int_equal(set.strip_count, 5);
    assert_strip(&set, 0, STP_LINE_TUBE, "0123");
    assert_strip(&set, 1, STP_LINE_TUBE, "89");
    assert_strip(&set, 2, STP_LINE_TUBE, "89");
    assert_strip(&set, 3, STP_LINE_TUBE, "89");
    assert_strip(&set, 4, STP_LINE_TUBE, "4564");
    assert_int_equal(set.vertex_count, 4 + 6 + 4);
    assert_int_equal(set.vertices[0].rgb[0], STP_POINT_GREY);
    double diagonal = sqrt(9.0 * 9.0 + 3.0 * 3.0 + 3.0 * 3.0);
    assert_near((double)set.vertices[0].radius, diagonal / 2000.0, 1e-6);
    stp_line_set_clear(&set);
}

/* Bad ends, loops, repeats and coordinates that are not finite must be counted; the rest is
 * read. */
static void wrong_edges_are_counted(void **state)
{
    (void)state;
    static const char text[] = HEAD "4\n" XYZ "element edge 9\n" EDGES "end_header\n"
                                    "0 0 0\n1 0 0\nnan 1 0\n3 0 0\n"
                                    "0 1\n1 0\n0 1\n0 4\n-1 0\n1 1\n0 2\n2 3\n1 2147483647\n";
    stp_scan_info info;
    stp_line_set set = read_lines("wrong.ply", text, NULL, &info);
    assert_int_equal(info.edges.read, 9);
    assert_int_equal(info.edges.no_vertex, 3);
    assert_int_equal(info.edges.no_length, 1);
    assert_int_equal(info.edges.repeated, 2);
    assert_int_equal(info.edges.not_finite, 2);
    assert_int_equal(info.point_count, 2);
    assert_int_equal(set.strip_count, 1);
    assert_strip(&set, 0, STP_LINE_TUBE, "01");
    stp_line_set_clear(&set);
}

/* Normals make ribbons, a radius is half the width, and edges may give the colours, as bytes or
 * other types. */
static void vertices_say_what_lines_are(void **state)
{
    (void)state;
    static const char text[] = HEAD
        "5\n" XYZ "property float nx\nproperty float ny\nproperty float nz\nproperty float radius\n"
        "element edge 3\n" EDGES "property uchar red\nproperty float green\n"
        "property ushort blue\nend_header\n"
        "0 0 0 0 0 2 0.5\n1 0 0 0 0 1 -1\n2 0 0 0 0 1 nan\n3 0 0 0 0 0 1\n4 0 0 0 0 1 1\n"
        "0 1 255 0.5 1000\n1 2 255 0.5 1000\n3 4 0 0 0\n";
    const stp_scan_params params = {.line_radius = 0.25};
    stp_scan_info info;
    stp_line_set set = read_lines("said.ply", text, &params, &info);
    assert_int_equal(set.strip_count, 2);
    assert_strip(&set, 0, STP_LINE_RIBBON, "012");
    assert_strip(&set, 1, STP_LINE_TUBE, "34");
    assert_true(info.attributes & STP_POINT_HAS_COLOUR);
    assert_near((double)set.vertices[0].radius, 0.5, 0.0);
    assert_near((double)set.vertices[1].radius, 0.25, 0.0);
    assert_near((double)set.vertices[2].radius, 0.25, 0.0);
    assert_near((double)set.vertices[0].direction.z, 1.0, 1e-6);
    assert_near((double)set.vertices[4].direction.z, 0.0, 0.0);
    assert_int_equal(set.vertices[0].rgb[0], 65535);
    assert_int_equal(set.vertices[0].rgb[1], 32768);
    assert_int_equal(set.vertices[0].rgb[2], 1000);
    assert_int_equal(set.vertices[3].rgb[0], 0);
    stp_line_set_clear(&set);
    const stp_scan_params recompute = {.recompute_normals = true};
    set = read_lines("said.ply", text, &recompute, &info);
    assert_strip(&set, 0, STP_LINE_TUBE, "012");
    stp_line_set_clear(&set);
}

/* Sides of faces are no lines. Vertices of faces stay points even if a line ends there. */
static void faces_stay_faces(void **state)
{
    (void)state;
    static const char text[] = HEAD
        "6\n" XYZ "element face 1\nproperty list uchar int vertex_indices\nelement edge 4\n" EDGES
        "end_header\n0 0 0\n1 0 0\n2 1 0\n3 0 0\n4 0 0\n5 5 5\n3 0 1 2\n3 4\n2 3\n2 0\n1 0\n";
    stp_scan_info info;
    stp_line_set set = read_lines("faces.ply", text, NULL, &info);
    assert_int_equal(info.point_count, 4);
    assert_int_equal(info.edges.of_faces, 2);
    assert_int_equal(info.face_count, 1);
    assert_true(info.normals_from_faces);
    assert_int_equal(set.strip_count, 1);
    assert_strip(&set, 0, STP_LINE_TUBE, "234");
    stp_line_set_clear(&set);
    const stp_scan_params params = {.sample_count = 10};
    set = read_lines("faces.ply", text, &params, &info);
    assert_int_equal(info.point_count, 10);
    assert_int_equal(set.strip_count, 1);
    stp_line_set_clear(&set);
}

static void binary_edges(void **state)
{
    (void)state;
    static const char head[] = "ply\nformat binary_big_endian 1.0\nelement edge 2\n"
                               "property uchar vertex1\nproperty ushort vertex2\n"
                               "element vertex 3\n"
                               "property uchar x\nproperty uchar y\nproperty uchar z\nend_header\n";
    static const unsigned char body[] = {2, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 2, 0, 0};
    char text[sizeof head + sizeof body];
    stp_error err = {0};
    stp_scan *scan = NULL;
    stp_line_set set = {0};
    memcpy(text, head, sizeof head - 1);
    memcpy(text + sizeof head - 1, body, sizeof body);
    scan_fixture_bytes("big.ply", text, sizeof head - 1 + sizeof body);
    if (stp_scan_open(&scan, "big.ply", NULL, &err) != STP_OK)
        fail_msg("%s", err.message);
    stp_scan_take_lines(scan, &set);
    assert_int_equal(stp_scan_get_info(scan)->point_count, 0);
    assert_strip(&set, 0, STP_LINE_TUBE, "012");
    stp_line_set_clear(&set);
    stp_scan_close(&scan);
    scan_fixture_bytes("cut.ply", text, sizeof head - 1 + sizeof body - 1);
    scan_fixture_fails("cut.ply", NULL, STP_CORRUPT, "vertices");
}

static void cut_edges_are_refused(void **state)
{
    (void)state;
    scan_fixture_text("short.ply",
                      HEAD "2\n" XYZ "element edge 2\n" EDGES "end_header\n0 0 0\n1 0 0\n0 1\n");
    scan_fixture_fails("short.ply", NULL, STP_CORRUPT, "the file was cut");
    scan_fixture_text("word.ply",
                      HEAD "2\n" XYZ "element edge 1\n" EDGES "end_header\n0 0 0\n1 0 0\n0 one\n");
    scan_fixture_fails("word.ply", NULL, STP_CORRUPT, "is not a number");
}

static void obj_lines(void **state)
{
    (void)state;
    static const char text[] =
        "v 0 0 0\nv 1 0 0\nv 2 1 0\nl 1 2/1 3//2 # a line\nv 3 0 0\nv 4 0 0\n"
        "l -1 -2\nl 4\nl 9 4\nl x 4\nl -9 4\nl 0 1\nl\nv 5 0 0\n";
    stp_scan_info info;
    stp_line_set set = read_lines("lines.obj", text, NULL, &info);
    assert_int_equal(info.edges.read, 7);
    assert_int_equal(info.edges.no_vertex, 4);
    assert_int_equal(info.point_count, 1);
    assert_int_equal(set.strip_count, 2);
    assert_strip(&set, 0, STP_LINE_TUBE, "012");
    assert_strip(&set, 1, STP_LINE_TUBE, "34");
    stp_line_set_clear(&set);
    set =
        read_lines("both.obj", "v 0 0 0\nv 1 0 0\nv 2 1 0\nv 3 1 0\nf 1 2 3\nl 3 4\n", NULL, &info);
    assert_int_equal(info.point_count, 3);
    assert_int_equal(info.face_count, 1);
    assert_strip(&set, 0, STP_LINE_TUBE, "23");
    stp_line_set_clear(&set);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edges_are_chained),
        cmocka_unit_test(wrong_edges_are_counted),
        cmocka_unit_test(vertices_say_what_lines_are),
        cmocka_unit_test(faces_stay_faces),
        cmocka_unit_test(binary_edges),
        cmocka_unit_test(cut_edges_are_refused),
        cmocka_unit_test(obj_lines),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

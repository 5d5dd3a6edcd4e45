/* Tests meshes: PLY faces and strips, OBJ, OFF, STL; normals of faces; samples spread over the
 * faces. */
#include "tests/fixtures/scan/scan_fixture.h"

#include <math.h>

#define PLY_XYZ "property double x\nproperty double y\nproperty double z\n"

static void expect_triangle(const stp_mesh *mesh, uint64_t index, uint32_t a, uint32_t b,
                            uint32_t c)
{
    assert_true(index < mesh->triangle_count);
    assert_int_equal(mesh->triangles[index][0], a);
    assert_int_equal(mesh->triangles[index][1], b);
    assert_int_equal(mesh->triangles[index][2], c);
}

/* A square of side 1, a triangle of half its area standing on an edge, and a vertex of no face. */
static const char folded_ply[] =
    "ply\nformat ascii 1.0\nelement vertex 6\n" PLY_XYZ
    "property float intensity\nelement face 2\nproperty uchar flags\n"
    "property list uchar int vertex_indices\nproperty list uchar float texcoord\n"
    "end_header\n0 0 0 0\n1 0 0 .5\n1 1 0 1\n0 1 0 1\n0 0 1 0\n9 9 9 0\n"
    "0 4 0 1 2 3 2 .5 .5\n1 3 0 4 1 0\n";

static void ply_polygons(void **state)
{
    (void)state;
    stp_scan_info info;
    stp_point *points = scan_fixture_points("folded.ply", folded_ply, &info);
    assert_int_equal(info.point_count, 6);
    assert_int_equal(info.face_count, 2);
    assert_true(info.normals_from_faces);
    assert_int_equal(info.attributes, STP_POINT_HAS_NORMAL | STP_POINT_HAS_INTENSITY);
    assert_int_equal(points[1].intensity, 32768);
    scan_fixture_normal(&points[2], 0.0, 0.0, 1.0);
    /* vertex 0: weights are areas, both halves of the square against the one standing triangle */
    const double n = hypot(1.0, 0.5);
    scan_fixture_normal(&points[0], 0.0, 0.5 / n, 1.0 / n);
    scan_fixture_normal(&points[4], 0.0, 1.0, 0.0);
    scan_fixture_normal(&points[5], 0.0, 0.0, 0.0);
    free(points);
    stp_mesh *mesh = scan_fixture_mesh("folded.ply");
    assert_int_equal(mesh->vertex_count, 6);
    assert_int_equal(mesh->triangle_count, 3);
    assert_null(mesh->normals);
    assert_null(mesh->rgb);
    expect_triangle(mesh, 0, 0, 1, 2);
    expect_triangle(mesh, 1, 0, 2, 3);
    expect_triangle(mesh, 2, 0, 4, 1);
    vec3s normals[6];
    stp_mesh_vertex_normals(mesh, normals);
    assert_true(fabsf(normals[0].y - (float)(0.5 / n)) < 1e-6f);
    assert_true(normals[5].x == 0.0f && normals[5].z == 0.0f);
    stp_mesh_destroy(&mesh);
    assert_null(mesh);
}

/* Stanford's strips: -1 begins a new strip, and every second triangle is reversed. */
static void ply_strips(void **state)
{
    (void)state;
    scan_fixture_text("strips.ply",
                      "ply\nformat ascii 1.0\nelement tristrips 1\n"
                      "property list int int vertex_indices\nelement vertex 5\n" PLY_XYZ
                      "end_header\n8 0 1 2 3 -1 2 3 4\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n");
    stp_mesh *mesh = scan_fixture_mesh("strips.ply");
    assert_int_equal(mesh->triangle_count, 3);
    expect_triangle(mesh, 0, 0, 1, 2);
    expect_triangle(mesh, 1, 2, 1, 3);
    expect_triangle(mesh, 2, 2, 3, 4);
    stp_mesh_destroy(&mesh);
    stp_scan_info info;
    stp_point *points = scan_fixture_read("strips.ply", NULL, &info);
    assert_int_equal(info.face_count, 3);
    scan_fixture_normal(&points[3], 0.0, 0.0, 1.0);
    free(points);
}

static void tiny_and_huge_triangles(void **state)
{
    (void)state;
    stp_scan_info info;
    stp_point *points = scan_fixture_points(
        "range.ply",
        "ply\nformat ascii 1.0\nelement vertex 6\n" PLY_XYZ
        "element face 2\nproperty list uchar int vertex_index\nend_header\n"
        "0 0 0\n1e-9 0 0\n0 1e-9 0\n0 0 0\n0 1e8 0\n0 0 1e8\n3 0 1 2\n3 3 4 5\n",
        &info);
    scan_fixture_normal(&points[0], 0.0, 0.0, 1.0);
    scan_fixture_normal(&points[3], 1.0, 0.0, 0.0);
    free(points);
}

/* OBJ that is georeferenced and partly coloured, with normals by corner, objects, relative and
 * forward indices, comments, continued lines, missing materials, and a face that OpenMesh's mesh
 * would refuse. */
static void obj(void **state)
{
    (void)state;
    stp_scan_info info;
    stp_point *points =
        scan_fixture_points("scan.obj",
                            "# comment\nmtllib none.mtl\no first\n"
                            "v 500000.123 5400000.456 10.789 1 0.5 0\n"
                            "v 500001.123 5400000.456 10.789 0 0 0\nvt 0.5\n"
                            "vn 0 0 1\r\nvn 0 2 0\nusemtl none\ng a b\n"
                            "f 1//1 2//1 \\\n3//1\n"
                            "v\t500001.123 5400001.456 10.789\n"
                            "o second\nf -3/1/2 -2/1/2 -1 # comment\nf 3 1 2\nl 1 2\n"
                            "f 1 2 3 4\nv 7 7 7\nv 8 8 8 \n",
                            &info);
    assert_string_equal(info.format, "OBJ");
    assert_int_equal(info.point_count, 5);
    assert_int_equal(info.face_count, 4);
    assert_int_equal(info.attributes, STP_POINT_HAS_NORMAL | STP_POINT_HAS_COLOUR);
    scan_fixture_position(&points[0], 500000.123, 5400000.456, 10.789);
    scan_fixture_position(&points[2], 500001.123, 5400001.456, 10.789);
    scan_fixture_position(&points[4], 8.0, 8.0, 8.0);
    scan_fixture_rgb(&points[0], 65535, 32768, 0);
    scan_fixture_rgb(&points[2], 0, 0, 0);
    scan_fixture_normal(&points[0], 0.0, sqrt(0.5), sqrt(0.5));
    scan_fixture_normal(&points[2], 0.0, 0.0, 1.0);
    free(points);
    stp_mesh *mesh = scan_fixture_mesh("scan.obj");
    assert_int_equal(mesh->triangle_count, 5);
    expect_triangle(mesh, 0, 0, 1, 2);
    expect_triangle(mesh, 3, 0, 1, 2);
    expect_triangle(mesh, 4, 0, 2, 3);
    assert_non_null(mesh->normals);
    assert_int_equal(mesh->rgb[0][1], 32768);
    stp_mesh_destroy(&mesh);
}

/* OBJ as MeshLab writes a point cloud: no faces, a normal for each vertex, colours as bytes. */
static void obj_points(void **state)
{
    (void)state;
    stp_scan_info info;
    stp_point *points = scan_fixture_points(
        "points.obj", "vn 0 0 1\nv 1 2 3 255 128 0\nvn 0 3 4\nv 4 5 6 1 1 1", &info);
    assert_int_equal(info.point_count, 2);
    assert_false(info.normals_from_faces);
    scan_fixture_position(&points[1], 4.0, 5.0, 6.0);
    scan_fixture_normal(&points[1], 0.0, 0.6, 0.8);
    scan_fixture_rgb(&points[0], 65535, 128 * 257, 0);
    free(points);
    points = scan_fixture_points("w.obj", "v 1 2 3 1 0 1 0.2\nv 4 5 6 1 0.2 0 1\n", &info);
    scan_fixture_rgb(&points[0], 0, 65535, 13107);
    scan_fixture_rgb(&points[1], 13107, 0, 65535);
    free(points);
    points = scan_fixture_points("a.obj", "v 1 2 3 1 0 0.2 1\nv 4 5 6 1 0.2 0 1\n", &info);
    scan_fixture_rgb(&points[0], 65535, 0, 13107);
    free(points);
    points = scan_fixture_points("over.obj", "v 1 2 3 0.2 1.0001 0\nv 4 5 6 0 0 0\n", &info);
    scan_fixture_rgb(&points[0], 13107, 65535, 0);
    free(points);
    free(scan_fixture_points("black.obj", "v 1 2 3 0 0 0\nv 4 5 6 0 0 0\n", &info));
    assert_int_equal(info.attributes, 0);
}

static void off(void **state)
{
    (void)state;
    const char *const kinds[] = {"OFF\n", "OFF ", "# comment\nCOFF\n", "OFF"};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        char text[512];
        snprintf(
            text, sizeof text,
            "%s4 2 0 # counts\n\n500000.123 5400000.456 0   255 0 128 255\n"
            "500001.123 5400000.456 0\t0 0 0 255\n# comment\n500001.123 5400001.456 0 0 0 0 255\n"
            "500000.123 5400001.456 0 0 0 0 255\r\n4  0 1 2 3\n3 0 1 2 0.5 0.5 0.5\n",
            kinds[i]);
        scan_fixture_text("scan.off", text);
        stp_scan_info info;
        stp_point *points = scan_fixture_read("scan.off", NULL, &info);
        assert_string_equal(info.format, "OFF");
        assert_int_equal(info.point_count, 4);
        assert_int_equal(info.face_count, 2);
        assert_true(info.normals_from_faces);
        scan_fixture_position(&points[3], 500000.123, 5400001.456, 0.0);
        scan_fixture_normal(&points[3], 0.0, 0.0, 1.0);
        scan_fixture_rgb(&points[0], 65535, 0, 128 * 257);
        free(points);
    }
    stp_scan_info info;
    stp_point *points = scan_fixture_points(
        "normals.off", "NOFF\n3 0 0\n0 0 0 0 3 4\n1 0 0 0 1 0\n0 1 0 1 0 0", &info);
    scan_fixture_normal(&points[0], 0.0, 0.6, 0.8);
    free(points);
}

static void check_stl(const char *path, const char *format)
{
    stp_scan_info info;
    stp_point *points = scan_fixture_read(path, NULL, &info);
    assert_string_equal(info.format, format);
    assert_int_equal(info.point_count, 4); /* two of the six corners repeat */
    assert_int_equal(info.face_count, 2);
    assert_true(info.normals_from_faces);
    scan_fixture_position(&points[1], 1.5, 0.0, 0.0);
    scan_fixture_normal(&points[0], 0.0, 0.0, 1.0);
    free(points);
}

static void stl(void **state)
{
    (void)state;
    scan_fixture_text("ascii.stl", "solid a b\n facet normal 0 0 1\n  outer loop\n"
                                   "   vertex 0 0 0\n   vertex 1.5 0 0\n   vertex 1 1 0\n"
                                   "  endloop\n endfacet\nFACET NORMAL 0 0 1\n\nOUTER LOOP\n\n"
                                   "VERTEX 0 0 0\nVERTEX 1 1 0\nVERTEX 0 1e0 0\nENDLOOP\nENDFACET\n"
                                   "endsolid a b");
    check_stl("ascii.stl", "STL ascii");
    const float corners[2][12] = {{0, 0, 1, 0, 0, 0, 1.5f, 0, 0, 1, 1, 0},
                                  {0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 1, 0}};
    unsigned char bytes[84 + 100] = "solid, though binary";
    bytes[80] = 2;
    for (size_t i = 0; i < 2; i++)
        memcpy(bytes + 84 + 50 * i, corners[i], sizeof corners[i]);
    scan_fixture_bytes("binary.stl", bytes, sizeof bytes);
    check_stl("binary.stl", "STL binary");
    scan_fixture_bytes("by content.dat", bytes, sizeof bytes);
    check_stl("by content.dat", "STL binary");
}

/* Facets with words of VisCAM's and of Materialise's; one whose corners coincide has none. */
static void stl_colours(void **state)
{
    (void)state;
    static const struct {
        const char *header;
        uint16_t words[2];
        bool coloured;
        unsigned rgb[2][3];
    } cases[] = {
        {"made by hand", {0xfc00, 0x801f}, true, {{255, 0, 0}, {0, 0, 255}}},
        {"made by hand", {0x7c00, 0x001f}, false, {{0}}}, /* bit 15 is clear: none */
        {"COLOR=\x0a\x14\x1e\xff", {0x001f, 0x8000}, true, {{255, 0, 0}, {10, 20, 30}}},
    };
    const float corners[3][9] = {
        {0, 0, 0, 1, 0, 0, 0, 1, 0},
        {0, 0, 5, 1e-40f, 0, 5, 0, 1, 5}, /* to OpenMesh, the first two are one */
        {0, 0, 1, 1, 0, 1, 0, 1, 1}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        unsigned char bytes[84 + 150 + 60] = {0}; /* some writers let bytes follow */
        stp_scan_info info;
        memcpy(bytes, cases[c].header, strlen(cases[c].header));
        bytes[80] = 3;
        for (size_t i = 84 + 150; i < sizeof bytes; i++)
            bytes[i] = (unsigned char)(i / 2);
        for (size_t i = 0; i < 3; i++) {
            const uint16_t word = i == 1 ? 0x83e0 : cases[c].words[i / 2];
            memcpy(bytes + 84 + 50 * i + 12, corners[i], sizeof corners[i]);
            memcpy(bytes + 84 + 50 * i + 48, &word, sizeof word);
        }
        scan_fixture_bytes("colours.stl", bytes, sizeof bytes);
        stp_point *points = scan_fixture_read("colours.stl", NULL, &info);
        assert_int_equal((info.attributes & STP_POINT_HAS_COLOUR) != 0, cases[c].coloured);
        for (uint64_t i = 0; i < info.point_count && cases[c].coloured; i++) {
            const unsigned *rgb = cases[c].rgb[points[i].position.z > 0.5];
            if (points[i].position.z < 2.0)
                scan_fixture_rgb(&points[i], rgb[0] * 257, rgb[1] * 257, rgb[2] * 257);
        }
        free(points);
    }
}

/* Two faces with areas 3 : 1, with red and green at their outer corners. */
static const char sampled_ply[] =
    "ply\nformat ascii 1.0\nelement vertex 6\n" PLY_XYZ
    "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar class\n"
    "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0 255 0 0 1\n3 0 0 255 0 0 1\n0 2 0 255 0 0 1\n"
    "0 0 5 0 255 0 2\n0 1 5 0 255 0 2\n-2 0 5 0 255 0 2\n3 0 1 2\n3 3 4 5\n";

static void samples(void **state)
{
    (void)state;
    enum { COUNT = 40000 };
    const stp_scan_params params = {.sample_count = COUNT, .seed = 7};
    scan_fixture_text("sampled.ply", sampled_ply);
    stp_scan_info info;
    stp_point *points = scan_fixture_read("sampled.ply", &params, &info);
    assert_int_equal(info.point_count, COUNT);
    size_t first = 0;
    double x = 0.0, y = 0.0;
    for (size_t i = 0; i < COUNT; i++) {
        const stp_dvec3 p = points[i].position;
        if (points[i].class_id == 1) {
            first++;
            x += p.x;
            y += p.y;
            assert_true(p.x >= 0.0 && p.y >= 0.0 && p.x / 3.0 + p.y / 2.0 <= 1.0 + 1e-12);
            scan_fixture_rgb(&points[i], 65535, 0, 0);
        } else {
            assert_true(p.z == 5.0);
            scan_fixture_rgb(&points[i], 0, 65535, 0);
        }
        scan_fixture_normal(&points[i], 0.0, 0.0, 1.0);
    }
    assert_true(labs((long)first - 30000) <= 1); /* stratified: exact to within one */
    /* the mean is the centroid; a mean of 30,000 deviates by less than 0.005 */
    assert_true(fabs(x / (double)first - 1.0) < 0.02);
    assert_true(fabs(y / (double)first - 2.0 / 3.0) < 0.02);
    stp_point *again = scan_fixture_read("sampled.ply", &params, &info);
    assert_memory_equal(points, again, COUNT * sizeof *points);
    free(again);
    const stp_scan_params other = {.sample_count = COUNT, .seed = 8};
    again = scan_fixture_read("sampled.ply", &other, &info);
    assert_memory_not_equal(points, again, COUNT * sizeof *points);
    free(again);
    free(points);
}

/* A mesh read through OpenMesh must give samples too, without normals if asked. */
static void samples_of_obj(void **state)
{
    (void)state;
    const stp_scan_params params = {.sample_count = 100, .recompute_normals = true};
    scan_fixture_text("sampled.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nf 1 2 3\nf 1 2 4\n"
                                     "f 1 2 2\n");
    stp_scan_info info;
    stp_point *points = scan_fixture_read("sampled.obj", &params, &info);
    assert_int_equal(info.point_count, 100);
    assert_int_equal(info.attributes, 0);
    for (size_t i = 0; i < 100; i++) {
        assert_true(points[i].position.x + points[i].position.y <= 1.0 + 1e-12);
        scan_fixture_normal(&points[i], 0.0, 0.0, 0.0);
    }
    free(points);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ply_polygons),
        cmocka_unit_test(ply_strips),
        cmocka_unit_test(tiny_and_huge_triangles),
        cmocka_unit_test(obj),
        cmocka_unit_test(obj_points),
        cmocka_unit_test(off),
        cmocka_unit_test(stl),
        cmocka_unit_test(stl_colours),
        cmocka_unit_test(samples),
        cmocka_unit_test(samples_of_obj),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

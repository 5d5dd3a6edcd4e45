/* Tests meshes whose vertices do not tell their faces: a drawn mesh is sampled, a scan's is not. */
#include "formats/scan/mesh/coarse_mesh.h"
#include "tests/fixtures/scan/scan_fixture.h"

static const char cube[] =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

typedef struct opened {
    stp_triangle_set triangles;
    uint64_t points, samples; /* read, and chosen */
    uint64_t left_out;
} opened;

static opened open_mesh(const char *path, const stp_scan_params *params)
{
    opened out = {.points = 0};
    stp_error err = {0};
    stp_scan *scan = NULL;
    stp_point batch[256];
    size_t count = 1;
    if (stp_scan_open(&scan, path, params, &err) != STP_OK)
        fail_msg("%s", err.message);
    out.samples = stp_scan_get_info(scan)->coarse_samples;
    out.left_out = stp_scan_get_info(scan)->loose_left_out;
    stp_scan_take_triangles(scan, &out.triangles);
    for (; count > 0; out.points += count)
        assert_int_equal(stp_scan_read(scan, batch, 256, &count, &err), STP_OK);
    assert_int_equal(out.points, stp_scan_get_info(scan)->point_count);
    stp_scan_close(&scan);
    return out;
}

static opened open_coarse(const char *path)
{
    return open_mesh(path, &(stp_scan_params){.sample_coarse = true});
}

/* The normal of a triangle of the set. */
static stp_dvec3 normal_of(const stp_triangle_set *set, uint64_t t)
{
    const uint32_t *c = set->triangles[t];
    const stp_dvec3 a = set->vertices[c[0]].position;
    return stp_dvec3_normalize(stp_dvec3_cross(stp_dvec3_sub(set->vertices[c[1]].position, a),
                                               stp_dvec3_sub(set->vertices[c[2]].position, a)));
}

/* The least cosine between a triangle and the normals of its corners. */
static double least_cosine(const stp_triangle_set *set)
{
    double least = 1.0;
    for (uint64_t t = 0; t < set->triangle_count; t++)
        for (int k = 0; k < 3; k++) {
            const vec3s corner = set->vertices[set->triangles[t][k]].direction;
            least = fmin(least, stp_dvec3_dot(normal_of(set, t), stp_dvec3_from_float(corner)));
        }
    return least;
}

/* Six sides of a cube share the area: all are large, and each has its own normals. */
static void a_cube_is_its_faces(void **state)
{
    (void)state;
    scan_fixture_text("cube.obj", cube);
    opened all = open_coarse("cube.obj");
    assert_int_equal(all.samples, 512 * 512 * 2); /* the area is twice the square of the diagonal */
    assert_int_equal(all.triangles.triangle_count, 12);
    assert_int_equal(all.triangles.vertex_count, 24); /* the eight themselves are used no more */
    assert_int_equal(all.points, 0);
    assert_true(least_cosine(&all.triangles) > 0.999999);
    stp_triangle_set_clear(&all.triangles);
    opened vertices = open_mesh("cube.obj", NULL);
    assert_int_equal(vertices.samples, 0);
    assert_int_equal(vertices.points, 8);
    opened few =
        open_mesh("cube.obj", &(stp_scan_params){.sample_coarse = true, .sample_count = 20});
    assert_int_equal(few.samples, 0);
    assert_int_equal(few.points, 20);
}

/* Writes a tube of n sides around z, its ends open, cut into rings; loose: vertices without a face
 * besides. normals: the file has them. */
static void write_tube(const char *path, int n, int rings, int loose, bool normals)
{
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fprintf(f,
            "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
            "property float z\n%selement face %d\nproperty list uchar int vertex_indices\n"
            "end_header\n",
            n * (rings + 1) + loose,
            normals ? "property float nx\nproperty float ny\nproperty float nz\n" : "", n * rings);
    for (int i = 0; i < n * (rings + 1) + loose; i++) {
        const double angle = 6.283185307179586 * (i % n) / n;
        fprintf(f, "%.9g %.9g %.9g%s\n", cos(angle), sin(angle), 2.0 * (i / n) / rings,
                normals ? " 0 0 1" : "");
    }
    for (int i = 0; i < n * rings; i++) {
        const int next = i % n == n - 1 ? i + 1 - n : i + 1;
        fprintf(f, "4 %d %d %d %d\n", i, next, next + n, i + n);
    }
    assert_int_equal(fclose(f), 0);
}

/* Sides that meet at 72 degrees meet in creases, those at 36 degrees do not. */
static void creases_have_two_normals(void **state)
{
    (void)state;
    write_tube("tube.ply", 5, 1, 0, false);
    opened five = open_coarse("tube.ply");
    assert_int_equal(five.triangles.triangle_count, 10);
    assert_int_equal(five.triangles.vertex_count, 20);
    assert_true(least_cosine(&five.triangles) > 0.999999);
    stp_triangle_set_clear(&five.triangles);
    write_tube("tube.ply", 10, 1, 0, false);
    opened ten = open_coarse("tube.ply");
    assert_int_equal(ten.triangles.vertex_count, 20);
    const double cosine =
        least_cosine(&ten.triangles); /* 18 degrees if both sides weigh the same */
    assert_true(cosine < 0.98 && cosine > 0.9);
    stp_triangle_set_clear(&ten.triangles);
}

/* A fine tube is a scan. If its file has normals, its faces are read only to find out. */
static void fine_meshes_are_their_vertices(void **state)
{
    (void)state;
    for (int normals = 0; normals < 2; normals++) {
        write_tube("tube.ply", 256, 64, 0, normals == 1);
        opened fine = open_coarse("tube.ply");
        assert_int_equal(fine.samples, 0);
        assert_int_equal(fine.points, 256 * 65);
        write_tube("tube.ply", 16, 8, 0, normals == 1);
        opened coarse = open_coarse("tube.ply");
        assert_true(coarse.samples > 0 && coarse.triangles.triangle_count == 2 * 16 * 8);
        const float z = coarse.triangles.vertices[0].direction.z;
        assert_true(normals == 1 ? z > 0.999f : fabsf(z) < 0.1f);
        stp_triangle_set_clear(&coarse.triangles);
    }
}

/* Quads of 0.0042 x 0.05 are shorter than 1/64 of the box, but 3.5 spacings long; of 0.0063 x 0.05,
 * 2.8 spacings. */
static void slivers_stay_triangles(void **state)
{
    (void)state;
    write_tube("tube.ply", 1500, 40, 0, false);
    opened slivers = open_coarse("tube.ply");
    assert_true(slivers.samples >= 8 * 2 * 1500 * 40);
    assert_int_equal(slivers.triangles.triangle_count, 2 * 1500 * 40);
    assert_int_equal(slivers.points, 0);
    stp_triangle_set_clear(&slivers.triangles);
    write_tube("tube.ply", 1000, 40, 0, false);
    opened quads = open_coarse("tube.ply");
    assert_int_equal(quads.samples, 0);
    assert_int_equal(quads.points, 1000 * 41);
}

/* Points besides a few faces must not get lost. */
static void loose_vertices_stay(void **state)
{
    (void)state;
    write_tube("tube.ply", 16, 8, 30, false);
    opened cloud = open_coarse("tube.ply");
    assert_true(cloud.samples > 0 && cloud.triangles.triangle_count == 2 * 16 * 8);
    assert_int_equal(cloud.points, 30); /* the faces are all large */
    stp_triangle_set_clear(&cloud.triangles);
    /* Small faces have samples, and behind them come the loose vertices. */
    write_tube("tube.ply", 48, 3, 30, false);
    cloud = open_coarse("tube.ply");
    assert_true(cloud.samples > 0 && cloud.points >= 30);
    stp_triangle_set_clear(&cloud.triangles);
}

/* Few are waste of an export; their discs would be as wide as the model. */
static void few_loose_vertices_are_left_out(void **state)
{
    (void)state;
    for (int loose = 16; loose <= 17; loose++) {
        write_tube("tube.ply", 16, 8, loose, false);
        opened tube = open_coarse("tube.ply");
        assert_int_equal(tube.triangles.triangle_count, 2 * 16 * 8);
        assert_int_equal(tube.points, loose == 17 ? 17 : 0);
        assert_int_equal(tube.left_out, loose == 17 ? 0 : 16);
        stp_triangle_set_clear(&tube.triangles);
    }
}

/* Edges that are no sides of faces are lines beside the samples. */
static void edges_are_lines(void **state)
{
    (void)state;
    char text[4096];
    sprintf(text, "%sv 3 0 0\nv 4 0 0\nl 1 9\nv 5 5 5\n", cube);
    scan_fixture_text("edges.obj", text);
    opened both = open_coarse("edges.obj");
    assert_true(both.samples > 0 && both.triangles.triangle_count == 12);
    assert_int_equal(both.points, 0);
    assert_int_equal(both.left_out, 2); /* vertices 10 and 11 */
    stp_triangle_set_clear(&both.triangles);
}

/* Faces without area, a point that is no number, and a vertex of many faces. */
static void odd_meshes_are_read(void **state)
{
    (void)state;
    char text[65536];
    sprintf(text, "%sv nan 0 0\nf 1 2 9\nf 1 1 1\nv 0.5 0.5 2\n", cube);
    scan_fixture_text("odd.obj", text);
    opened odd = open_coarse("odd.obj");
    assert_true(odd.samples > 0 && odd.triangles.triangle_count >= 12);
    stp_triangle_set_clear(&odd.triangles);
    int at = sprintf(text, "v 0 0 1\n");
    for (int i = 0; i < 1000; i++)
        at += sprintf(text + at, "v %g %g 0\n", cos(i * 0.00628), sin(i * 0.00628));
    for (int i = 0; i < 999; i++)
        at += sprintf(text + at, "f 1 %d %d\n", i + 2, i + 3);
    scan_fixture_text("odd.obj", text);
    opened cone = open_coarse("odd.obj");
    assert_int_equal(cone.points + cone.triangles.triangle_count > 0, 1);
    stp_triangle_set_clear(&cone.triangles);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cube_is_its_faces),
        cmocka_unit_test(creases_have_two_normals),
        cmocka_unit_test(fine_meshes_are_their_vertices),
        cmocka_unit_test(slivers_stay_triangles),
        cmocka_unit_test(loose_vertices_stay),
        cmocka_unit_test(few_loose_vertices_are_left_out),
        cmocka_unit_test(edges_are_lines),
        cmocka_unit_test(odd_meshes_are_read),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

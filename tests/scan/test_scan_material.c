/* Tests colours of meshes: materials, images on faces, and colours by face. */
#include "formats/image/image.h"
#include "formats/scan/mesh/point_mesh.h"
#include "tests/fixtures/scan/scan_fixture.h"

#define SIDE 8

/* The colour of a texel, the top row first. */
static void texel(int column, int row, uint8_t rgb[3])
{
    rgb[0] = (uint8_t)(30 * column);
    rgb[1] = (uint8_t)(30 * row);
    rgb[2] = 200;
}

static void write_image(const char *path, int side, bool checkers)
{
    stp_error err = {0};
    stp_image image = {side, side, calloc((size_t)side * (size_t)side, 4)};
    assert_non_null(image.rgba);
    for (int i = 0; i < side * side; i++) {
        texel(i % side, i / side, image.rgba + 4 * i);
        if (checkers)
            memset(image.rgba + 4 * i, (i % side + i / side) % 2 * 255, 3);
        image.rgba[4 * i + 3] = 255;
    }
    assert_int_equal(stp_image_save(&image, path, true, &err), STP_OK);
    stp_image_destroy(&image);
}

static const char library[] =
    "# two materials\nnewmtl red one\nKd 1 0 0.5\nKd spectral x.rfl\n"
    "newmtl photo\r\nKd 0 1 0\r\nmap_Kd -s 1 1 1 -clamp on -o 0 photo.png\r\n"
    "newmtl gone\nmap_Kd nowhere.png\n";

typedef struct opened {
    stp_triangle_set triangles;
    stp_scan_info info;
    stp_point *points;
    char missing[1024];
} opened;

static opened open_mesh(const char *path, const stp_scan_params *params)
{
    opened out = {.missing = ""};
    stp_error err = {0};
    stp_scan *scan = NULL;
    size_t count = 1;
    if (stp_scan_open(&scan, path, params, &err) != STP_OK)
        fail_msg("%s", err.message);
    out.info = *stp_scan_get_info(scan);
    if (out.info.colours_missing)
        snprintf(out.missing, sizeof out.missing, "%s", out.info.colours_missing);
    stp_scan_take_triangles(scan, &out.triangles);
    out.points = calloc(out.info.point_count + 1, sizeof *out.points);
    assert_non_null(out.points);
    for (size_t got = 0; count > 0; got += count)
        assert_int_equal(stp_scan_read(scan, out.points + got, 1000, &count, &err), STP_OK);
    stp_scan_close(&scan);
    return out;
}

static void close_mesh(opened *mesh)
{
    stp_triangle_set_clear(&mesh->triangles);
    free(mesh->points);
}

/* The square 0..1, its image turned by a quarter and repeated twice along x. */
static const char square[] = "mtllib the library.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                             "vt 0 1\nvt 0 3\nvt 1 3 0\nvt 1 1\n"
                             "usemtl photo\nf -4/-4 -3/-3 3/3 4/4\n";

static void images_lie_on_faces(void **state)
{
    (void)state;
    write_image("photo.png", SIDE, false);
    scan_fixture_text("the library.mtl", library);
    scan_fixture_text("square.obj", square);
    opened mesh = open_mesh("square.obj", &(stp_scan_params){.sample_coarse = true});
    assert_true(mesh.info.attributes & STP_POINT_HAS_COLOUR);
    assert_int_equal(mesh.triangles.triangle_count, 0); /* the corners would not keep the image */
    assert_true(mesh.info.point_count > 100000 && mesh.missing[0] == '\0');
    for (uint64_t i = 0; i < mesh.info.point_count; i++) {
        const stp_point *p = &mesh.points[i];
        /* u = y, v = 2 x + 1 */
        const double column = SIDE * p->position.y,
                     row = SIDE * (1.0 - fmod(2.0 * p->position.x, 1.0));
        if (fabs(column - round(column)) < 1e-3 || fabs(row - round(row)) < 1e-3)
            continue;
        uint8_t rgb[3];
        texel((int)column, (int)row, rgb);
        for (int k = 0; k < 3; k++)
            assert_int_equal(p->rgb[k], rgb[k] * 257);
    }
    close_mesh(&mesh);
    opened vertices = open_mesh("square.obj", NULL);
    assert_int_equal(vertices.info.point_count, 4);
    assert_true(vertices.info.attributes & STP_POINT_HAS_COLOUR);
    close_mesh(&vertices);
}

/* The same in PLY, as MeshLab writes it; a second face has another image, a third none. Vertices
 * may have normals, or one colour all, which says nothing. */
static void images_of_ply_files(void **state)
{
    (void)state;
    static const char head[] =
        "ply\nformat ascii 1.0\ncomment TextureFile photo.png\ncomment TextureFile  other one.png "
        "\n"
        "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n%s"
        "element face 3\nproperty list uchar float texcoord\nproperty list uchar int "
        "vertex_indices\n"
        "property uchar texnumber\nend_header\n0 0 0%s\n1 0 0%s\n1 1 0%s\n0 1 0%s\n"
        "6 0 0 1 0 1 1 3 0 1 2 0\n6 0 0 1 1 0 1 3 0 2 3 1\n0 3 0 1 2 7\n";
    write_image("photo.png", SIDE, false);
    write_image("other one.png", 1, true); /* black */
    static const char *const kinds[][2] = {
        {"", ""},
        {"property float nx\nproperty float ny\nproperty float nz\n", " 0 0 1"},
        {"property uchar red\nproperty uchar green\nproperty uchar blue\n", " 255 255 255"},
    };
    for (size_t kind = 0; kind < sizeof kinds / sizeof *kinds; kind++) {
        char text[2048];
        const char *n = kinds[kind][1];
        snprintf(text, sizeof text, head, kinds[kind][0], n, n, n, n);
        scan_fixture_text("square.ply", text);
        opened mesh = open_mesh("square.ply", &(stp_scan_params){.sample_coarse = true});
        assert_int_equal(mesh.triangles.triangle_count, 1); /* that without an image */
        unsigned black = 0, coloured = 0;
        for (uint64_t i = 0; i < mesh.info.point_count; i++) {
            const stp_point *p = &mesh.points[i];
            const double column = SIDE * p->position.x, row = SIDE * (1.0 - p->position.y);
            if (fabs(column - round(column)) < 1e-3 || fabs(row - round(row)) < 1e-3 ||
                fabs(column + row - SIDE) < 1e-3)
                continue;
            uint8_t rgb[3] = {0, 0, 0};
            const bool lower = p->position.x > p->position.y;
            if (lower)
                texel((int)column, (int)row, rgb);
            black += !lower;
            coloured += lower;
            for (int k = 0; k < 3; k++)
                assert_int_equal(p->rgb[k], rgb[k] * 257);
        }
        assert_true(black > 1000 && coloured > 1000);
        close_mesh(&mesh);
    }
}

/* Places in an image by vertex, under the names that programs give them. */
static void images_by_vertex(void **state)
{
    (void)state;
    static const char *const names[][2] = {{"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}};
    write_image("photo.png", SIDE, false);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char text[1024];
        uint8_t rgb[3];
        snprintf(text, sizeof text,
                 "ply\nformat ascii 1.0\ncomment TextureFile photo.png\nelement vertex 3\n"
                 "property float x\nproperty float y\nproperty float z\nproperty float %s\n"
                 "property float %s\nelement face 1\nproperty list uchar int vertex_indices\n"
                 "end_header\n0 0 0 0.05 0.9\n1 0 0 0.95 0.9\n1 1 0 0.95 0.1\n3 0 1 2\n",
                 names[i][0], names[i][1]);
        scan_fixture_text("places.ply", text);
        opened mesh = open_mesh("places.ply", &(stp_scan_params){.sample_coarse = true});
        for (uint64_t k = 0; k < mesh.info.point_count; k++) {
            const stp_dvec3 p = mesh.points[k].position;
            const double column = SIDE * (0.05 + 0.9 * p.x), row = SIDE * (0.1 + 0.8 * p.y);
            if (fabs(column - round(column)) < 1e-3 || fabs(row - round(row)) < 1e-3)
                continue;
            texel((int)column, (int)row, rgb);
            for (int c = 0; c < 3; c++)
                assert_int_equal(mesh.points[k].rgb[c], rgb[c] * 257);
        }
        assert_true(mesh.info.point_count > 1000);
        close_mesh(&mesh);
    }
}

/* A mesh that was renamed has its library under its own new name, perhaps. */
static void renamed(void **state)
{
    (void)state;
    scan_fixture_text("new.mtl", "newmtl a\nKd 1 0 0\n");
    scan_fixture_text("new.obj", "mtllib old.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl a\nf 1 2 3\n");
    opened mesh = open_mesh("new.obj", NULL);
    assert_string_equal(mesh.missing, "");
    assert_int_equal(mesh.points[0].rgb[0], 65535);
    assert_int_equal(mesh.points[0].rgb[1], 0);
    close_mesh(&mesh);
}

/* Where points are far apart, each takes the mean of what lies between. */
static void fine_images_are_averaged(void **state)
{
    (void)state;
    write_image("photo.png", 256, true);
    scan_fixture_text("the library.mtl", library);
    scan_fixture_text("square.obj", square);
    opened mesh = open_mesh("square.obj", &(stp_scan_params){.sample_count = 500});
    for (int i = 0; i < 500; i++)
        assert_int_equal(mesh.points[i].rgb[1], 128 * 257);
    close_mesh(&mesh);
}

#define TWO_FACES                                                                                  \
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red one\nf 1 2 3\nusemtl photo\nf 1 3 4\n"

/* Two faces of one edge keep their own colours, also as triangles; their vertices have the mean.
 * The library's name may stand anywhere. */
static void materials_colour_faces(void **state)
{
    (void)state;
    scan_fixture_text("the library.mtl", library);
    scan_fixture_text("two.obj", "mtllib the library.mtl\n" TWO_FACES);
    opened first = open_mesh("two.obj", NULL);
    assert_int_equal(first.points[1].rgb[0], 65535);
    close_mesh(&first);
    scan_fixture_text("two.obj", TWO_FACES "# mtllib none\n  mtllib the library.mtl");
    opened mesh = open_mesh("two.obj", &(stp_scan_params){.sample_coarse = true});
    assert_int_equal(mesh.triangles.triangle_count, 2);
    for (int t = 0; t < 2; t++)
        for (int k = 0; k < 3; k++) {
            const uint16_t *rgb = mesh.triangles.vertices[mesh.triangles.triangles[t][k]].rgb;
            assert_int_equal(rgb[0], t == 0 ? 65535 : 0);
            assert_int_equal(rgb[1], t == 0 ? 0 : 65535);
            assert_int_equal(rgb[2], t == 0 ? 32768 : 0);
        }
    close_mesh(&mesh);
    opened vertices = open_mesh("two.obj", NULL);
    assert_int_equal(vertices.points[1].rgb[0], 65535);
    assert_int_equal(vertices.points[0].rgb[0], 32768);
    close_mesh(&vertices);
    scan_fixture_text("one.obj", "mtllib the library.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\n"
                                 "usemtl red one\nf 1 2 3\n");
    opened one = open_mesh("one.obj", NULL);
    assert_int_equal(one.points[0].rgb[0], 65535);
    assert_int_equal(one.points[0].rgb[1], 0);
    close_mesh(&one);
    scan_fixture_text("grey.mtl", "newmtl red one\nKd 0.8 0.8 0.8\n");
    scan_fixture_text("one.obj", "mtllib grey.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\n"
                                 "usemtl red one\nf 1 2 3\n");
    one = open_mesh("one.obj", NULL); /* one grey for all says nothing */
    assert_int_equal(one.info.attributes & STP_POINT_HAS_COLOUR, 0);
    close_mesh(&one);
    scan_fixture_text("own.obj", "mtllib the library.mtl\nv 0 0 0 0 0 1\nv 1 0 0 0 0 1\n"
                                 "v 1 1 0 0 0 1\nusemtl red one\nf 1 2 3\nusemtl photo\nf 3 2 1\n");
    opened own = open_mesh("own.obj", NULL); /* vertices with colours keep them */
    assert_int_equal(own.points[0].rgb[2], 65535);
    assert_int_equal(own.points[0].rgb[0], 0);
    close_mesh(&own);
}

/* A square's two halves are red and blue, and a triangle beside it has no colour. Its two free
 * corners are neither. */
static void check_faces(const char *path, bool third)
{
    opened mesh = open_mesh(path, NULL);
    static const uint16_t none = STP_POINT_GREY;
    assert_true(mesh.info.attributes & STP_POINT_HAS_COLOUR);
    assert_int_equal(mesh.info.point_count, third ? 5 : 4);
    const uint16_t expected[5][3] = {
        {32768, 0, 32768}, {65535, 0, 0}, {32768, 0, 32768}, {0, 0, 65535}, {none, none, none}};
    for (uint64_t i = 0; i < mesh.info.point_count; i++)
        for (int k = 0; k < 3; k++)
            if (abs((int)mesh.points[i].rgb[k] - (int)expected[i][k]) > 1)
                fail_msg("%s: channel %d of vertex %d is %u", path, k, (int)i,
                         mesh.points[i].rgb[k]);
    close_mesh(&mesh);
}

static void faces_have_colours(void **state)
{
    (void)state;
    static const char ply[] =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property float z\n%selement face 2\nproperty %s red\nproperty list uchar int "
        "vertex_indices\nproperty %s green\nproperty %s blue\nend_header\n"
        "0 0 0%s\n1 0 0%s\n1 1 0%s\n0 1 0%s\n%s 3 0 1 2 0 0\n0 3 0 2 3 0 %s\n";
    static const char *const of_vertices = "property uchar red\nproperty uchar green\n"
                                           "property uchar blue\n";
    char text[2048];
    for (int floats = 0; floats < 2; floats++) {
        const char *type = floats ? "float" : "uchar", *full = floats ? "1.0" : "255";
        snprintf(text, sizeof text, ply, "", type, type, type, "", "", "", "", full, full);
        scan_fixture_text("faces.ply", text);
        check_faces("faces.ply", false);
    }
    /* Vertices know better. */
    const char *green = " 0 255 0";
    snprintf(text, sizeof text, ply, of_vertices, "uchar", "uchar", "uchar", green, green, green,
             green, "255", "255");
    scan_fixture_text("faces.ply", text);
    opened mesh = open_mesh("faces.ply", NULL);
    assert_int_equal(mesh.points[1].rgb[0], 0);
    assert_int_equal(mesh.points[1].rgb[1], 65535);
    close_mesh(&mesh);

    /* So if they have normals, too, nobody needs the faces, and the file is not held. */
    scan_fixture_text(
        "faces.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
        "property float y\nproperty float z\nproperty float nx\nproperty float ny\n"
        "property float nz\nproperty uchar red\nproperty uchar green\n"
        "property uchar blue\nproperty float quality\nelement face 1\nproperty list uchar int "
        "vertex_indices\nproperty uchar red\nproperty uchar green\n"
        "property uchar blue\nend_header\n0 0 0 0 0 1 9 9 9 5\n1 0 0 0 0 1 9 9 9 5\n"
        "1 1 0 0 0 1 9 9 9 5\n3 0 1 2 255 0 0\n");
    opened streamed = open_mesh("faces.ply", NULL);
    assert_non_null(streamed.info.extra); /* which held files have not */
    close_mesh(&streamed);

    static const char *const offs[] = {
        "OFF\n5 3 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 2 0\n3 0 1 2 255 0 0\n3 0 2 3 0 0 255 100\n"
        "3 4 4 4\n",
        "OFF\n5 3 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 2 0\n3 4 4 4 7\n3 0 1 2 1.0 0.0 0.0 # red\n"
        "3 0 2 3 0.0 .0 1.0 0.5\n",
        "5 3 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 2 0\n3 0 1 2 255 0 0\n3 4 4 4\n3 0 2 3 0 0 300\n",
    };
    for (size_t i = 0; i < sizeof offs / sizeof *offs; i++) {
        scan_fixture_text("faces.off", offs[i]);
        check_faces("faces.off", true);
    }
    scan_fixture_text("faces.off", "COFF\n3 1 0\n0 0 0 0 255 0\n1 0 0 0 255 0\n1 1 0 0 255 0\n"
                                   "3 0 1 2 255 0 0\n");
    mesh = open_mesh("faces.off", NULL);
    assert_int_equal(mesh.points[0].rgb[0], 0);
    assert_int_equal(mesh.points[0].rgb[1], 65535);
    close_mesh(&mesh);
}

/* Names of images as programs leave them: of other machines, in other case, in quotes. */
static void images_of_other_machines(void **state)
{
    (void)state;
    static const char *const names[] = {"C:\\Users\\me\\scan\\photo.png",
                                        "/mnt/scan/photo.png",
                                        "tex/photo.png",
                                        "PHOTO.PNG",
                                        "\"photo.png\"",
                                        ".\\photo.png"};
    write_image("photo.png", SIDE, false);
    scan_fixture_text("any.obj", "mtllib lost/any.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\n"
                                 "usemtl a\nf 1/1 2/1 3/1\n");
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char text[256];
        print_message("%s\n", names[i]);
        snprintf(text, sizeof text, "newmtl a\nmap_Kd %s\n", names[i]);
        scan_fixture_text("any.mtl", text);
        opened mesh = open_mesh("any.obj", NULL);
        assert_string_equal(mesh.missing, "");
        assert_int_equal(mesh.points[0].rgb[2], 200 * 257);
        close_mesh(&mesh);
    }
}

/* Whatever is wrong with libraries and images costs colours alone, and is said. */
static void faults_cost_colours_alone(void **state)
{
    (void)state;
    static const struct {
        const char *text, *missing;
    } cases[] = {
        {"mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl x\nf 1 2 3\n", "none.mtl"},
        {"mtllib the library.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nusemtl gone\nf 1/1 2/1 3/1\n"
         "usemtl photo\nf 3 2 1\n",
         "nowhere.png"},
        {"mtllib the library.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt x\nvt 1e30 nan\nusemtl photo\n"
         "f 1/1 2/2 3/9\nusemtl\nf 1/ 2/-7 3/99999999999\nusemtl \xff\nf 1// 2//1 3\n",
         NULL},
        {"usemtl photo\nmtllib\nmtllib .\nmtllib ..\\..\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n",
         "."},
        {"mtllib odd.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n", "odd.png"},
    };
    write_image("photo.png", SIDE, false);
    scan_fixture_text("the library.mtl", library);
    scan_fixture_text("odd.png", "no image");
    scan_fixture_text("odd.mtl", "Kd 1 1 1\nmap_Kd x\nnewmtl a\nKd\nKd 1\nKd nan inf -1\nmap_Kd\n"
                                 "map_Kd -s\nmap_Kd -s 1 1\nmap_Kd odd.png\nnewmtl a\nnewmtl\n");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        scan_fixture_text("wrong.obj", cases[i].text);
        opened mesh = open_mesh("wrong.obj", NULL);
        assert_int_equal(mesh.info.point_count, 3);
        assert_int_equal(mesh.missing[0] != '\0', cases[i].missing != NULL);
        if (cases[i].missing)
            assert_non_null(strstr(mesh.missing, cases[i].missing));
        close_mesh(&mesh);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(images_lie_on_faces),      cmocka_unit_test(images_of_ply_files),
        cmocka_unit_test(fine_images_are_averaged), cmocka_unit_test(materials_colour_faces),
        cmocka_unit_test(images_by_vertex),         cmocka_unit_test(renamed),
        cmocka_unit_test(images_of_other_machines), cmocka_unit_test(faults_cost_colours_alone),
        cmocka_unit_test(faces_have_colours),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

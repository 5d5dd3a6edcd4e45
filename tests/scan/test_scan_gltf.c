/* Tests glTF: a square in all its ways of storing, placed by nodes; colours; files that are wrong.
 */
#include "formats/image/image.h"
#include "formats/scan/gltf/gltf.h"
#include "formats/scan/gltf/gltf_material.h"
#include "tests/fixtures/draco_square.h"
#include "tests/fixtures/scan/scan_fixture.h"

#include <math.h>
#include <meshoptimizer.h>

/* The buffer of the square: corners as floats, then as bytes, indices of two triangles, colours of
 * corners in linear light, places in an image. */
typedef struct square_buffer {
    float corners[4][3];
    int8_t bytes[4][4];
    uint16_t indices[6];
    uint16_t unused;
    float colours[4][3];
    float places[4][2];
} square_buffer;

static const square_buffer square = {
    .corners = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
    .bytes = {{0, 0, 0, 0}, {127, 0, 0, 0}, {127, 127, 0, 0}, {0, 127, 0, 0}},
    .indices = {0, 1, 2, 0, 2, 3},
    .colours = {{0, 0, 0}, {1, 1, 1}, {0.2140411f, 0, 0}, {0, 1, 0}},
    .places = {{0, 1}, {1, 1}, {1, 0}, {0, 0}},
};

#define VIEW(member)                                                                               \
    "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", offsetof(square_buffer, member),       \
        sizeof square.member

/* Four corners, with those at the places of `count` indices replaced by corners. Offsets in bytes,
 * of indices and corners. */
#define SPARSE(view, count, index, corner)                                                         \
    ",{" view "\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"sparse\":{\"count\":" count  \
    ",\"indices\":{\"bufferView\":2,\"byteOffset\":" index ",\"componentType\":5123},\"values\":{" \
    "\"bufferView\":0,\"byteOffset\":" corner "}}}"
#define OF_CORNERS "\"bufferView\":0,"

/* Writes a file of the square. nodes, primitive: JSON. */
static void write_square(const char *path, const char *nodes, const char *primitive,
                         const char *more)
{
    char views[5][96], json[4096];
    snprintf(views[0], sizeof views[0], VIEW(corners));
    snprintf(views[1], sizeof views[1],
             "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"byteStride\":4}",
             offsetof(square_buffer, bytes), sizeof square.bytes);
    snprintf(views[2], sizeof views[2], VIEW(indices));
    snprintf(views[3], sizeof views[3], VIEW(colours));
    snprintf(views[4], sizeof views[4], VIEW(places));
    snprintf(json, sizeof json,
             "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[%s],"
             "\"meshes\":[{\"primitives\":[{%s}]}],\"buffers\":[{\"uri\":\"the%%20square.bin\"}],"
             "\"bufferViews\":[%s,%s,%s,%s,%s],\"accessors\":["
             "{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
             "{\"bufferView\":1,\"componentType\":5120,\"normalized\":true,\"count\":4,\"type\":"
             "\"VEC3\"},"
             "{\"bufferView\":2,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"},"
             "{\"bufferView\":3,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
             "{\"bufferView\":4,\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"},"
             "{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"SCALAR\"}" SPARSE(
                 OF_CORNERS, "2", "2", "24") SPARSE("", "2", "2", "24") /* 6, 7: 1 and 2 */
             SPARSE(OF_CORNERS, "2", "4", "24")
                 SPARSE(OF_CORNERS, "2", "2", "36") /* 8: 2, then 0 */
             SPARSE(OF_CORNERS, "9", "2", "0") "]%s}",
             nodes, primitive, views[0], views[1], views[2], views[3], views[4], more);
    scan_fixture_text(path, json);
    scan_fixture_bytes("the square.bin", &square, sizeof square);
}

#define NODE "{\"mesh\":0}"
#define CORNERS "\"attributes\":{\"POSITION\":0}"
#define INDEXED CORNERS ",\"indices\":2"

/* The triangle's area vector times two. */
static stp_dvec3 turn(const stp_mesh *m, size_t t)
{
    const stp_dvec3 *p = m->positions;
    const uint32_t *c = m->triangles[t];
    return stp_dvec3_cross(stp_dvec3_sub(p[c[1]], p[c[0]]), stp_dvec3_sub(p[c[2]], p[c[0]]));
}

static void ways_of_storing(void **state)
{
    (void)state;
    static const struct {
        const char *primitive;
        size_t triangles;
    } ways[] = {
        {INDEXED, 2},
        {"\"attributes\":{\"POSITION\":1},\"indices\":2", 2}, /* quantised, with a stride */
        {CORNERS ",\"mode\":6", 2},                           /* a fan */
        {CORNERS ",\"mode\":5", 2},                           /* a strip: 0 1 2, 2 1 3 */
        {CORNERS, 1},                                         /* three vertices are one triangle */
    };
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        write_square("square.gltf", NODE, ways[i].primitive, "");
        stp_mesh *mesh = scan_fixture_mesh("square.gltf");
        assert_int_equal(mesh->triangle_count, ways[i].triangles);
        assert_int_equal(mesh->vertex_count, ways[i].triangles == 2 ? 4 : 3);
        for (size_t t = 0; t < mesh->triangle_count; t++)
            assert_float_equal(fabs(turn(mesh, t).z), 1.0, 1e-6);
        assert_float_equal(mesh->positions[2].x, 1.0, 1e-6);
        assert_float_equal(mesh->positions[2].y, 1.0, 1e-6);
        stp_mesh_destroy(&mesh);
    }
}

static void put_word(uint8_t *at, size_t word)
{
    for (int i = 0; i < 4; i++)
        at[i] = (uint8_t)(word >> 8 * i);
}

/* The same in one file: header, JSON, an unknown chunk, the buffer. */
static void one_binary_file(void **state)
{
    (void)state;
    static uint8_t file[8192];
    size_t json_size, at = 20;
    write_square("square.gltf", NODE, INDEXED, "");
    char *json = (char *)scan_fixture_load("square.gltf", &json_size);
    char *uri = strstr(json, "\"uri\":\"the%20square.bin\"");
    assert_non_null(uri);
    memset(uri, ' ', strcspn(uri, "}"));
    put_word(file, 0x46546c67); /* glTF */
    put_word(file + 4, 2);
    put_word(file + 12, json_size);
    put_word(file + 16, 0x4e4f534a); /* JSON */
    memcpy(file + at, json, json_size);
    at += json_size;
    put_word(file + at, 4);
    put_word(file + at + 4, 0x3f3f3f3f);
    at += 12;
    put_word(file + at, sizeof square);
    put_word(file + at + 4, 0x004e4942); /* BIN */
    memcpy(file + at + 8, &square, sizeof square);
    at += 8 + sizeof square;
    put_word(file + 8, at);
    assert_int_equal(remove("the square.bin"), 0);
    scan_fixture_bytes("square.bytes", file, at); /* its content tells the format */
    stp_mesh *mesh = scan_fixture_mesh("square.bytes");
    assert_int_equal(mesh->triangle_count, 2);
    assert_float_equal(mesh->positions[2].y, 1.0, 1e-6);
    stp_mesh_destroy(&mesh);
    scan_fixture_bytes("cut.glb", file, at - 1);
    scan_fixture_fails("cut.glb", NULL, STP_CORRUPT, "within a chunk");
    free(json);
}

/* Twice as large, turned about x, moved; then mirrored. Faces keep the side that they show. */
static void nodes_place(void **state)
{
    (void)state;
    write_square("placed.gltf",
                 "{\"children\":[1],\"translation\":[10,20,30]},{\"children\":[2],\"rotation\":"
                 "[0.70710678,0,0,0.70710678]},{\"mesh\":0,\"matrix\":[2,0,0,0, 0,2,0,0, 0,0,2,0, "
                 "1,0,0,1]}",
                 INDEXED, "");
    stp_mesh *mesh = scan_fixture_mesh("placed.gltf");
    const double expected[4][3] = {{11, 20, 30}, {13, 20, 30}, {13, 20, 32}, {11, 20, 32}};
    for (int i = 0; i < 4; i++) {
        assert_float_equal(mesh->positions[i].x, expected[i][0], 1e-6);
        assert_float_equal(mesh->positions[i].y, expected[i][1], 1e-6);
        assert_float_equal(mesh->positions[i].z, expected[i][2], 1e-6);
    }
    assert_float_equal(turn(mesh, 0).y, -4.0, 1e-5);
    stp_mesh_destroy(&mesh);
    write_square("mirror.gltf", "{\"mesh\":0,\"scale\":[-1,1,1]}", INDEXED, "");
    mesh = scan_fixture_mesh("mirror.gltf");
    assert_float_equal(mesh->positions[1].x, -1.0, 1e-6);
    assert_float_equal(turn(mesh, 0).z, 1.0, 1e-6);
    stp_mesh_destroy(&mesh);
}

static void vertices_have_colours(void **state)
{
    (void)state;
    stp_scan_info info;
    write_square(
        "colours.gltf", NODE,
        "\"attributes\":{\"POSITION\":0,\"COLOR_0\":3,\"NORMAL\":0},\"mode\":0,\"material\":0",
        ",\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0.5,1,1]}}]");
    stp_point *points = scan_fixture_read("colours.gltf", NULL, &info);
    assert_int_equal(info.point_count, 4);
    assert_int_equal(info.attributes, STP_POINT_HAS_NORMAL | STP_POINT_HAS_COLOUR);
    assert_true(info.y_up && !info.heights);
    assert_int_equal(points[1].rgb[0], 65535);
    assert_in_range(points[1].rgb[1], 48190, 48200); /* half of the light: 188 of 255 */
    assert_in_range(points[2].rgb[0], 32760, 32775); /* 0.214 of the light is half of the number */
    assert_int_equal(points[3].rgb[0], 0);
    scan_fixture_normal(&points[1], 1.0, 0.0, 0.0);
    free(points);
}

/* An image of 64 x 64: the left half is red, the right half blue, and its upper half is green. */
static void write_colours(void)
{
    stp_error err = {0};
    static uint8_t texels[64 * 64][4];
    for (int i = 0; i < 64 * 64; i++)
        memcpy(texels[i],
               i < 64 * 32   ? (uint8_t[]){0, 255, 0, 255}
               : i % 64 < 32 ? (uint8_t[]){255, 0, 0, 255}
                             : (uint8_t[]){0, 0, 255, 255},
               4);
    const stp_image image = {64, 64, texels[0]};
    assert_int_equal(stp_image_save(&image, "colours.png", true, &err), STP_OK);
}

/* The image's colours are the square's, beside the file. */
static void images_give_colours(void **state)
{
    (void)state;
    write_colours();
    write_square("image.gltf", NODE, /* images win over colours of vertices */
                 "\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":4,\"COLOR_0\":3},\"indices\":2,"
                 "\"material\":0",
                 ",\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}],"
                 "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"colours.png\"}]");
    stp_scan_info info;
    const stp_scan_params params = {.sample_count = 4000};
    stp_point *points = scan_fixture_read("image.gltf", &params, &info);
    size_t count = 4000, wrong = 0;
    assert_int_equal(info.point_count, count);
    for (size_t i = 0; i < count; i++) {
        const stp_point *p = &points[i];
        const int expected = p->position.y > 0.5 ? 1 : p->position.x < 0.5 ? 0 : 2;
        wrong += p->rgb[expected] != 65535 && fabs(p->position.x - 0.5) > 0.05 &&
                 fabs(p->position.y - 0.5) > 0.05;
    }
    assert_int_equal(wrong, 0);
    free(points);
}

/* The image one width to the right of the square ends there, or is mirrored; its factor takes a
 * half of the blue. */
static void images_go_on(void **state)
{
    (void)state;
    static const int modes[2] = {33071, 33648};
    write_colours();
    for (int m = 0; m < 2; m++) {
        char more[600];
        snprintf(more, sizeof more,
                 ",\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,0.2140411,1],"
                 "\"baseColorTexture\":{\"index\":0,\"extensions\":{\"KHR_texture_transform\":{"
                 "\"offset\":[1,0]}}}}}],\"samplers\":[{\"wrapS\":%d}],"
                 "\"textures\":[{\"source\":0,\"sampler\":0}],"
                 "\"images\":[{\"uri\":\"colours.png\"}]",
                 modes[m]);
        write_square("image.gltf", NODE,
                     "\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":4},\"indices\":2,"
                     "\"material\":0",
                     more);
        stp_scan_info info;
        const stp_scan_params params = {.sample_count = 1000};
        stp_point *points = scan_fixture_read("image.gltf", &params, &info);
        for (size_t i = 0; i < 1000; i++) {
            const stp_point *p = &points[i];
            const bool blue = m == 0 || p->position.x < 0.5;
            if (p->position.y > 0.45 || (m == 1 && fabs(p->position.x - 0.5) < 0.05))
                continue;
            assert_int_equal(p->rgb[0], blue ? 0 : 65535);
            assert_in_range(p->rgb[2], blue ? 32600 : 0, blue ? 32900 : 0);
        }
        free(points);
    }
}

/* Streams of meshoptimizer: corners, normals by its octahedral filter, and triangles. */
typedef struct meshopt_streams {
    uint8_t bytes[3][256];
    size_t size[3];
} meshopt_streams;

static meshopt_streams pack_square(void)
{
    static const float up[4][4] = {{0, 0, 1, 0}, {0, 0, 1, 0}, {0, 0, 1, 0}, {0, 0, 1, 0}};
    meshopt_streams s = {0};
    uint32_t indices[6];
    int8_t normals[4][4];
    for (int i = 0; i < 6; i++)
        indices[i] = square.indices[i];
    meshopt_encodeFilterOct(normals, 4, 4, 8, up[0]);
    s.size[0] = meshopt_encodeVertexBuffer(s.bytes[0], 256, square.corners, 4, 12);
    s.size[1] = meshopt_encodeVertexBuffer(s.bytes[1], 256, normals, 4, 4);
    s.size[2] = meshopt_encodeIndexBuffer(s.bytes[2], 256, indices, 6);
    assert_true(s.size[0] > 0 && s.size[1] > 0 && s.size[2] > 0);
    return s;
}

/* A view that has no bytes of its own. more: of its extension. */
static void put_view(char *json, size_t room, const meshopt_streams *s, int i, const char *more)
{
    const size_t at = strlen(json), begin = (size_t)i * sizeof s->bytes[0];
    snprintf(json + at, room - at,
             "%s{\"buffer\":1,\"byteLength\":48,\"extensions\":{\"EXT_meshopt_compression\":{"
             "\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,%s}}}",
             i > 0 ? "," : "", begin, s->size[i], more);
}

/* corners: what the extension of the first view says beside where its bytes are. */
static void write_meshopt(const char *path, const meshopt_streams *s, const char *corners)
{
    char json[4096] =
        "{\"asset\":{\"version\":\"2.0\"},\"extensionsRequired\":[\"EXT_meshopt_compression\"],"
        "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{"
        "\"attributes\":{\"POSITION\":0,\"NORMAL\":1},\"indices\":2}]}],"
        "\"buffers\":[{\"uri\":\"packed.bin\"},{\"byteLength\":48}],\"bufferViews\":[";
    put_view(json, sizeof json, s, 0, corners);
    put_view(json, sizeof json, s, 1,
             "\"byteStride\":4,\"count\":4,\"mode\":\"ATTRIBUTES\",\"filter\":\"OCTAHEDRAL\"");
    put_view(json, sizeof json, s, 2, "\"byteStride\":2,\"count\":6,\"mode\":\"TRIANGLES\"");
    const size_t at = strlen(json);
    snprintf(json + at, sizeof json - at,
             "],\"accessors\":["
             "{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
             "{\"bufferView\":1,\"componentType\":5120,\"normalized\":true,\"count\":4,\"type\":"
             "\"VEC3\"},"
             "{\"bufferView\":2,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}]}");
    scan_fixture_text(path, json);
    scan_fixture_bytes("packed.bin", s->bytes, sizeof s->bytes);
}

#define MESHOPT_CORNERS "\"byteStride\":12,\"count\":4,\"mode\":\"ATTRIBUTES\""

static void meshes_by_meshopt(void **state)
{
    (void)state;
    const meshopt_streams s = pack_square();
    write_meshopt("meshopt.gltf", &s, MESHOPT_CORNERS);
    stp_mesh *mesh = scan_fixture_mesh("meshopt.gltf");
    assert_int_equal(mesh->triangle_count, 2);
    assert_int_equal(mesh->vertex_count, 4);
    for (size_t t = 0; t < 2; t++)
        assert_float_equal(fabs(turn(mesh, t).z), 1.0, 1e-6);
    stp_mesh_destroy(&mesh);
    stp_scan_info info;
    stp_point *points = scan_fixture_read("meshopt.gltf", NULL, &info);
    assert_int_equal(info.point_count, 4);
    scan_fixture_normal(&points[2], 0.0, 0.0, 1.0);
    free(points);
}

/* Streams that are cut or flipped are refused or decoded; sizes that no stream has are refused. */
static void wrong_meshopt_streams(void **state)
{
    (void)state;
    static const char *const wrong[] = {
        "\"byteStride\":12,\"count\":4,\"mode\":\"SOUND\"",
        "\"byteStride\":10,\"count\":4,\"mode\":\"ATTRIBUTES\"",
        "\"byteStride\":0,\"count\":4,\"mode\":\"ATTRIBUTES\"",
        "\"byteStride\":260,\"count\":4,\"mode\":\"ATTRIBUTES\"",
        "\"byteStride\":12,\"count\":4000000000,\"mode\":\"ATTRIBUTES\"",
        "\"byteStride\":12,\"count\":5,\"mode\":\"ATTRIBUTES\",\"filter\":\"QUATERNION\"",
        "\"byteStride\":4,\"count\":4,\"mode\":\"TRIANGLES\"",
        "\"byteStride\":4,\"count\":6,\"mode\":\"TRIANGLES\"",
        "\"byteStride\":4,\"count\":6,\"mode\":\"INDICES\"",
    };
    meshopt_streams s = pack_square();
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        write_meshopt("wrong.gltf", &s, wrong[i]);
        scan_fixture_fails("wrong.gltf", NULL, STP_CORRUPT, "meshopt");
    }
    for (int i = 0; i < 3; i++)
        for (size_t cut = 0; cut < s.size[i]; cut++) {
            meshopt_streams changed = s;
            changed.size[i] = cut;
            write_meshopt("wrong.gltf", &changed, MESHOPT_CORNERS);
            scan_fixture_fails("wrong.gltf", NULL, STP_CORRUPT, "meshopt");
            changed = s;
            changed.bytes[i][cut] ^= (uint8_t)(1u << cut % 8);
            write_meshopt("wrong.gltf", &changed, MESHOPT_CORNERS);
            stp_scan *scan = NULL;
            const stp_status status = stp_scan_open(&scan, "wrong.gltf", NULL, NULL);
            assert_true(status == STP_OK || status == STP_CORRUPT);
            stp_scan_close(&scan);
        }
}

/* Vertices 1 and 2 of a sparse accessor are corners 2 and 3; the others are its own, or zero. */
static void sparse_accessors(void **state)
{
    (void)state;
    static const double wanted[2][4][2] = {{{0, 0}, {1, 1}, {0, 1}, {0, 1}},
                                           {{0, 0}, {1, 1}, {0, 1}, {0, 0}}};
    for (int i = 0; i < 2; i++) {
        write_square("sparse.gltf", NODE,
                     i == 0 ? "\"attributes\":{\"POSITION\":6},\"mode\":0"
                            : "\"attributes\":{\"POSITION\":7},\"mode\":0",
                     "");
        stp_scan_info info;
        stp_point *points = scan_fixture_read("sparse.gltf", NULL, &info);
        assert_int_equal(info.point_count, 4);
        for (int v = 0; v < 4; v++)
            scan_fixture_position(&points[v], wanted[i][v][0], wanted[i][v][1], 0.0);
        free(points);
    }
}

static void wrong_files_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *nodes, *primitive, *more, *message;
    } files[] = {
        {NODE, "\"attributes\":{\"POSITION\":19}", "", "there is no accessor 19"},
        {NODE, CORNERS ",\"indices\":0", "", "another kind"},
        {NODE, "\"attributes\":{\"POSITION\":4}", "", "another kind"},
        {NODE, CORNERS ",\"mode\":7", "", "unknown mode"},
        {NODE, CORNERS ",\"indices\":-1", "", "no whole number"},
        {"{\"mesh\":3}", CORNERS, "", "names no mesh"},
        {"{\"children\":[0]}", CORNERS, "", "no tree"},
        {"{\"matrix\":[1,2]}", CORNERS, "", "16 numbers"},
        {"{\"mesh\":0,\"children\":[1,1]},{}", CORNERS, "", "no tree"},
        {"{\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1,0]}", CORNERS, "", "16 numbers"},
        {NODE, CORNERS ",\"indices\":5", "", "no indices"},
        {NODE, "\"attributes\":{\"POSITION\":8}", "", "do not ascend"},
        {NODE, "\"attributes\":{\"POSITION\":9}", "", "values of a sparse accessor reach beyond"},
        {NODE, "\"attributes\":{\"POSITION\":10}", "", "indices of a sparse accessor reach beyond"},
        {NODE, CORNERS, ",\"extensionsRequired\":[\"EXT_other_compression\"]", "EXT_other"},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        write_square("wrong.gltf", files[i].nodes, files[i].primitive, files[i].more);
        scan_fixture_fails("wrong.gltf", NULL,
                           files[i].more[0] != '\0' ? STP_UNSUPPORTED : STP_CORRUPT,
                           files[i].message);
    }
    write_square("cut.gltf", NODE, INDEXED, "");
    scan_fixture_bytes("the square.bin", &square, 20);
    scan_fixture_fails("cut.gltf", NULL, STP_CORRUPT, "beyond its buffer");
    assert_int_equal(remove("the square.bin"), 0);
    scan_fixture_fails("cut.gltf", NULL, STP_NOT_FOUND, "the square.bin");
    scan_fixture_text("short.glb", "glTF");
    scan_fixture_fails("short.glb", NULL, STP_CORRUPT, "within its header");
    scan_fixture_text("json.gltf", "{\"asset\":");
    scan_fixture_fails("json.gltf", NULL, STP_FORMAT, "cut");
    /* version 1 has objects where version 2 has lists */
    scan_fixture_text("old.gltf",
                      "{\"asset\":{\"version\":\"1.0\"},\"buffers\":{\"a\":{},\"b\":{}}}");
    scan_fixture_fails("old.gltf", NULL, STP_UNSUPPORTED, "version 1.0");
    scan_fixture_text("objects.gltf",
                      "{\"asset\":{\"version\":\"2.0\"},\"buffers\":{\"a\":{},\"b\":{},\"c\":{}},"
                      "\"materials\":{\"a\":{},\"b\":{},\"c\":{}},\"nodes\":{\"a\":{}},"
                      "\"scenes\":[{\"nodes\":[0]}]}");
    scan_fixture_fails("objects.gltf", NULL, STP_CORRUPT, "no tree");
}

/* Writes a file whose primitive is a Draco stream. ids: its attributes, JSON. */
static void write_packed(const uint8_t *stream, size_t size, const char *ids)
{
    char json[1024];
    snprintf(
        json, sizeof json,
        "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],"
        "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],\"meshes\":[{\"primitives\":[{"
        "\"attributes\":{\"POSITION\":0,\"NORMAL\":0,\"COLOR_0\":1},\"indices\":2,\"extensions\":{"
        "\"KHR_draco_mesh_compression\":{\"bufferView\":0,\"attributes\":{%s}}}}]}],"
        "\"accessors\":[{\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
        "{\"componentType\":5121,\"normalized\":true,\"count\":4,\"type\":\"VEC4\"},"
        "{\"componentType\":5125,\"count\":6,\"type\":\"SCALAR\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":%zu}],\"buffers\":[{\"uri\":\"packed.bin\"}]"
        "}",
        ids, size);
    scan_fixture_text("packed.gltf", json);
    scan_fixture_bytes("packed.bin", stream, size);
}

#define PACKED_IDS "\"POSITION\":0,\"NORMAL\":1,\"COLOR_0\":2"

static void meshes_by_draco(void **state)
{
    (void)state;
    static const struct {
        const uint8_t *stream;
        size_t size;
    } streams[] = {{draco_square_edgebreaker, sizeof draco_square_edgebreaker},
                   {draco_square_sequential, sizeof draco_square_sequential}};
    for (int i = 0; i < 2; i++) {
        write_packed(streams[i].stream, streams[i].size, PACKED_IDS);
        stp_mesh *mesh = scan_fixture_mesh("packed.gltf");
        assert_int_equal(mesh->triangle_count, 2);
        assert_int_equal(mesh->vertex_count, 4);
        for (size_t t = 0; t < 2; t++)
            assert_float_equal(turn(mesh, t).z, 1.0, 1e-3);
        stp_mesh_destroy(&mesh);
        stp_scan_info info;
        stp_point *points = scan_fixture_read("packed.gltf", NULL, &info);
        assert_int_equal(info.point_count, 4);
        for (int p = 0; p < 4; p++) {
            int corner = 0; /* they may come in any order */
            while (corner < 4 &&
                   stp_dvec3_length(stp_dvec3_sub(
                       points[p].position, (stp_dvec3){square.corners[corner][0],
                                                       square.corners[corner][1], 0.0})) > 1e-3)
                corner++;
            assert_in_range(corner, 0, 3);
            assert_float_equal(points[p].normal.z, 1.0, 1e-2);
            const uint8_t red[] = {0, 255, 55, 0};
            const double is_red = corner < 4 ? red[corner] / 255.0 : -1.0;
            assert_int_equal(points[p].rgb[0], stp_gltf_srgb(is_red));
        }
        free(points);
    }
}

/* Of a stream that is cut, or whose bytes are wrong, either a mesh is read or a sentence says that
 * it cannot be. */
static void wrong_draco_streams(void **state)
{
    (void)state;
    uint8_t wrong[sizeof draco_square_edgebreaker];
    stp_error error = {0};
    for (size_t size = 0; size < sizeof wrong; size++) {
        write_packed(draco_square_edgebreaker, size, PACKED_IDS);
        scan_fixture_fails("packed.gltf", NULL, STP_CORRUPT, "a compressed mesh cannot be read");
    }
    for (size_t at = 0; at < sizeof wrong; at++) {
        stp_point_mesh mesh = {0};
        memcpy(wrong, draco_square_edgebreaker, sizeof wrong);
        wrong[at] ^= (uint8_t)(1u << at % 8);
        write_packed(wrong, sizeof wrong, PACKED_IDS);
        const stp_status status = stp_gltf_read(&mesh, "packed.gltf", &error);
        assert_true(status == STP_OK || status == STP_CORRUPT || status == STP_UNSUPPORTED ||
                    status == STP_LIMIT);
        stp_point_mesh_free(&mesh);
    }
    static const struct {
        size_t at;
        uint8_t byte;
        stp_status status;
        const char *message;
    } heads[] = {{5, 1, STP_UNSUPPORTED, "no mesh of version 2.2"},
                 {7, 0, STP_UNSUPPORTED, "no mesh of version 2.2"}, /* a point cloud */
                 {10, 0x80, STP_UNSUPPORTED, "without metadata"},
                 {14, 255, STP_LIMIT, "255 sets of attributes"}};
    for (int i = 0; i < 4; i++) {
        memcpy(wrong, draco_square_edgebreaker, sizeof wrong);
        wrong[heads[i].at] = heads[i].byte;
        write_packed(wrong, sizeof wrong, PACKED_IDS);
        scan_fixture_fails("packed.gltf", NULL, heads[i].status, heads[i].message);
    }
    write_packed(draco_square_sequential, sizeof draco_square_sequential, "\"POSITION\":7");
    scan_fixture_fails("packed.gltf", NULL, STP_CORRUPT, "lacks attribute 7");
    write_packed(draco_square_sequential, sizeof draco_square_sequential, "\"POSITION\":2");
    scan_fixture_fails("packed.gltf", NULL, STP_CORRUPT, "has 4 numbers");
}

#define NO_STREAM                                                                                  \
    INDEXED ",\"extensions\":{\"KHR_draco_mesh_compression\":{\"bufferView\":0,"                   \
            "\"attributes\":{\"POSITION\":0}}}"

/* A file that does not require Draco has its numbers once more: they are read if a stream is bad.
 */
static void numbers_once_more(void **state)
{
    (void)state;
    write_square("twice.gltf", NODE, NO_STREAM, "");
    stp_mesh *mesh = scan_fixture_mesh("twice.gltf");
    assert_int_equal(mesh->triangle_count, 2);
    stp_mesh_destroy(&mesh);
    write_square("once.gltf", NODE, NO_STREAM,
                 ",\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]");
    scan_fixture_fails("once.gltf", NULL, STP_CORRUPT, "it has no Draco stream");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ways_of_storing),       cmocka_unit_test(one_binary_file),
        cmocka_unit_test(nodes_place),           cmocka_unit_test(vertices_have_colours),
        cmocka_unit_test(images_give_colours),   cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(meshes_by_draco),       cmocka_unit_test(wrong_draco_streams),
        cmocka_unit_test(numbers_once_more),     cmocka_unit_test(sparse_accessors),
        cmocka_unit_test(images_go_on),          cmocka_unit_test(meshes_by_meshopt),
        cmocka_unit_test(wrong_meshopt_streams),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

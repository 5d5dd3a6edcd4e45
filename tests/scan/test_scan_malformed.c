/* Tests scans that are cut, damaged, hostile or of another kind: each must give one sentence and no
 * crash. */
#include "tests/fixtures/scan/scan_fixture.h"

#define XYZ "property float x\nproperty float y\nproperty float z\n"
#define ASCII "ply\nformat ascii 1.0\n"
#define BINARY "ply\nformat binary_little_endian 1.0\n"
#define FACES "property list uchar int vertex_indices\n"

static void headers(void **state)
{
    (void)state;
    const scan_malformed cases[] = {
        {"empty.ply", "", STP_EMPTY, "0 bytes"},
        {"magic.ply", "plx\nformat ascii 1.0\n", STP_CORRUPT, "line 1"},
        {"cut.ply", ASCII "element vertex 1\n" XYZ, STP_CORRUPT, "without end_header"},
        {"only-ply.ply", "ply", STP_CORRUPT, "without end_header"},
        {"no-format.ply", "ply\nelement vertex 0\n" XYZ "end_header\n", STP_CORRUPT, "no format"},
        {"version.ply", "ply\nformat ascii 2.0\nend_header\n", STP_UNSUPPORTED, "line 2"},
        {"encoding.ply", "ply\nformat binary_middle_endian 1.0\nend_header\n", STP_UNSUPPORTED,
         "binary_middle_endian"},
        {"keyword.ply", ASCII "elemnet vertex 0\n", STP_CORRUPT, "elemnet"},
        {"type.ply", ASCII "element vertex 0\nproperty float128 x\n", STP_CORRUPT, "float128"},
        {"no-vertex.ply", ASCII "element dot 1\n" XYZ "end_header\n0 0 0\n", STP_CORRUPT,
         "no element `vertex`"},
        {"no-z.ply",
         ASCII "element vertex 1\nproperty float x\nproperty float y\nend_header\n0 0\n",
         STP_CORRUPT, "`z`"},
        {"list-x.ply",
         ASCII "element vertex 1\nproperty list uchar float x\nproperty float y\nproperty float z\n"
               "end_header\n1 0 0 0\n",
         STP_CORRUPT, "`x`"},
        {"negative.ply", ASCII "element vertex -1\n" XYZ "end_header\n", STP_CORRUPT, "-1"},
        {"overflow.ply", ASCII "element vertex 18446744073709551616\n" XYZ "end_header\n",
         STP_CORRUPT, "18446744073709551616"},
        {"count-text.ply", ASCII "element vertex many\n" XYZ "end_header\n", STP_CORRUPT, "many"},
        {"twice.ply", ASCII "element vertex 1\n" XYZ "element vertex 1\n", STP_CORRUPT, "line 7"},
        {"early.ply", ASCII "property float x\n", STP_CORRUPT, "before any element"},
        {"nameless.ply", ASCII "element vertex 1\nproperty float\n", STP_CORRUPT, "without a name"},
        {"float-list.ply", ASCII "element vertex 1\nproperty list float int i\n", STP_CORRUPT,
         "length"},
    };
    scan_fixture_malformed(cases, sizeof cases / sizeof *cases);
}

static void counts(void **state)
{
    (void)state;
    const scan_malformed cases[] = {
        {"header-only.ply", BINARY "element vertex 5\n" XYZ "end_header\n", STP_CORRUPT,
         "declares 5 vertices, but the 0 bytes"},
        {"cut-binary.ply",
         BINARY "element vertex 3\n" XYZ "end_header\n123456789012345678901234567", STP_CORRUPT,
         "declares 3 vertices"},
        {"huge.ply", BINARY "element vertex 18446744073709551615\n" XYZ "end_header\n1234",
         STP_CORRUPT, "18446744073709551615"},
        {"huge-before.ply",
         BINARY "element camera 18446744073709551615\nproperty double a\nelement vertex 1\n" XYZ
                "end_header\n123456789012",
         STP_CORRUPT, "after 1 of 18446744073709551615 camera"},
        {"huge-ascii.ply", ASCII "element vertex 4000000000000\n" XYZ "end_header\n0 0 0\n",
         STP_CORRUPT, "4000000000000"},
        {"cut-ascii.ply", ASCII "element vertex 3\n" XYZ "end_header\n0 0 0.123456789\n1 1 1\n",
         STP_CORRUPT, "ends at line 9 after 2 of 3 vertices"},
        {"cut-line.ply", ASCII "element vertex 2\n" XYZ "end_header\n0.25 0.25 0.25\n1.25 1",
         STP_CORRUPT, "ends at line 9 after 1 of 2 vertices"},
        {"cut-before.ply",
         ASCII "element camera 2\nproperty float a\nelement vertex 1\n" XYZ "end_header\n1\n",
         STP_CORRUPT, "after 1 of 2 camera"},
    };
    scan_fixture_malformed(cases, sizeof cases / sizeof *cases);
}

static void values(void **state)
{
    (void)state;
    const scan_malformed cases[] = {
        {"token.ply", ASCII "element vertex 2\n" XYZ "end_header\n0 0 0\n1 abc 1\n", STP_CORRUPT,
         "line 9: `abc` is not a number"},
        {"hex.ply", ASCII "element vertex 1\n" XYZ "end_header\n0x10 0 0\n", STP_CORRUPT, "`0x10`"},
        {"comma.ply", ASCII "element vertex 1\n" XYZ "end_header\n0,5 0 0\n", STP_CORRUPT, "`0,5`"},
        {"fewer.ply", ASCII "element vertex 2\n" XYZ "end_header\n0.25 0.25\n0 0 0\n", STP_CORRUPT,
         "line 8 has fewer values"},
        {"more.ply", ASCII "element vertex 2\n" XYZ "end_header\n0 0 0\n0 0 0 7\n", STP_CORRUPT,
         "line 9 has more values"},
        {"list-negative.ply",
         ASCII "element l 1\nproperty list int int i\nelement vertex 1\n" XYZ
               "end_header\n-1\n0 0 0\n",
         STP_CORRUPT, "declares -1 entries"},
        {"list-long.ply",
         ASCII "element l 1\nproperty list int int i\nelement vertex 1\n" XYZ
               "end_header\n4 1 2 3\n0 0 0\n",
         STP_CORRUPT, "declares 4 entries where 3 fit"},
        {"list-huge.ply",
         BINARY "element l 1\nproperty list int double i\nelement vertex 1\n" XYZ
                "end_header\n\xff\xff\xff\x7f"
                "123456789012",
         STP_CORRUPT, "2147483647"},
        {"list-minus.ply",
         BINARY "element l 1\nproperty list char double i\nelement vertex 1\n" XYZ
                "end_header\n\xff"
                "123456789012",
         STP_CORRUPT, "declares -1 entries"},
    };
    scan_fixture_malformed(cases, sizeof cases / sizeof *cases);
}

static void faces(void **state)
{
    (void)state;
    const scan_malformed cases[] = {
        {"index.ply",
         ASCII "element vertex 3\n" XYZ "element face 1\n" FACES
               "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
         STP_CORRUPT, "names vertex 3, but there are 3"},
        {"index-negative.ply",
         ASCII "element vertex 3\n" XYZ "element face 1\n" FACES
               "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 -1 2\n",
         STP_CORRUPT, "names vertex -1"},
        {"index-part.ply",
         ASCII "element vertex 3\n" XYZ "element face 1\n" FACES
               "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 0.5 2\n",
         STP_CORRUPT, "line 13"},
        {"cut-face.ply",
         ASCII "element vertex 3\n" XYZ "element face 2\n" FACES
               "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
         STP_CORRUPT, "after 1 of 2 faces"},
        {"huge-faces.ply",
         ASCII "element vertex 3\n" XYZ "element face 9999999999999999\n" FACES
               "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
         STP_CORRUPT, "after 1 of 9999999999999999 faces"},
    };
    scan_fixture_malformed(cases, sizeof cases / sizeof *cases);
}

static void meshes(void **state)
{
    (void)state;
    const scan_malformed cases[] = {
        {"token.obj", "v 0 0 0\nv 1 x 0\n", STP_CORRUPT, "line 2: `x` is not a number"},
        {"short.obj", "v 0 0 0\nv 1 0\n", STP_CORRUPT, "line 2: vertex has 2 of 3 numbers"},
        {"index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 4\n", STP_CORRUPT, "line 5"},
        {"zero.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", STP_CORRUPT, "line 4"},
        {"relative.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -4\n", STP_CORRUPT, "`-4`"},
        {"slash.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 /2 3\n", STP_CORRUPT, "`/2`"},
        {"big.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n", STP_CORRUPT,
         "line 4"},
        {"normal.obj", "v 0 0 0\nvn 1 0\n", STP_CORRUPT, "line 2: normal has 2 of 3 numbers"},
        {"cut.off", "OFF\n3 1 0\n0.5 0.5 0.5\n1 0 0\n", STP_CORRUPT, "after 2 of 3 vertices"},
        {"cut-face.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", STP_CORRUPT,
         "after 1 of 2 faces"},
        {"huge.off", "OFF\n3 4000000000 0\n0 0 0\n1 0 0\n0 1 0\n", STP_CORRUPT, "line 2"},
        {"counts.off", "OFF\nthree 1 0\n", STP_CORRUPT, "line 2"},
        {"index.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", STP_CORRUPT, "line 6"},
        {"corners.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4000000000 0 1 2\n", STP_CORRUPT,
         "line 6"},
        {"four.off", "4OFF\n1 0 0\n0 0 0 0\n", STP_UNSUPPORTED, "line 1"},
        {"cut.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n",
         STP_CORRUPT, "without `endsolid`"},
        {"token.stl", "solid a\nouter loop\nvertex 0 0 o\n", STP_CORRUPT, "line 3: `o`"},
        {"two.stl", "solid a\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nendloop\nendsolid\n",
         STP_CORRUPT, "line 6: facet 1 does not have 3 corners"},
        {"nan.stl", "solid a\nouter loop\nvertex nan 0 0\n", STP_CORRUPT, "not finite"},
    };
    scan_fixture_malformed(cases, sizeof cases / sizeof *cases);
}

static void binary_stl(void **state)
{
    (void)state;
    unsigned char bytes[84 + 2 * 50] = {0};
    bytes[80] = 3;
    scan_fixture_bytes("short.stl", bytes, sizeof bytes);
    scan_fixture_fails("short.stl", NULL, STP_CORRUPT, "3 facets needs 234 bytes, but has 184");
    bytes[80] = 2;
    const float nan_bits = NAN;
    memcpy(bytes + 84 + 50 + 12, &nan_bits, sizeof nan_bits);
    scan_fixture_bytes("nan.stl", bytes, sizeof bytes);
    scan_fixture_fails("nan.stl", NULL, STP_CORRUPT, "facet 1 of 2");
}

static void other_formats(void **state)
{
    (void)state;
    const scan_malformed cases[] = {
        {"a.las", "LASF and more", STP_CORRUPT, "ends at byte 13, within its LAS header"},
        {"a.ply", "\x1f\x8b\x08 gzip", STP_UNSUPPORTED, "gunzip"},
        {"a.img", "EHFA_HEADER_TAG", STP_UNSUPPORTED, "gdal_translate"},
        {"a.grd", "DSAA\n2 2\n0 1\n0 1\n0 9\n1 2\n3\n", STP_CORRUPT, "ends in row 2"},
        {"a.drc", "DRACO\2\2", STP_UNSUPPORTED, "draco_decoder"},
        {"a.xyz", "ISO-10303-21;\nHEADER;\n", STP_UNSUPPORTED, "STL"},
        {"a.pcd", "\x89PNG\r\n", STP_CORRUPT, "the PNG is damaged"},
        {"a.jpg", "\xff\xd8\xff\xe0 JFIF", STP_UNSUPPORTED, "a picture (JPEG)"},
        {"a.vtk", "# vtk DataFile Version 2.0\n", STP_UNSUPPORTED, "a VTK file"},
        {"a.dat", "hello\n", STP_FORMAT,
         "supported are PLY, LAS, LAZ, COPC, EPT, PCD, E57, OBJ, OFF, STL, glTF, XYZ"},
    };
    scan_fixture_malformed(cases, sizeof cases / sizeof *cases);
    scan_fixture_bytes("a.stipple", "STIPPLE", 8);
    scan_fixture_fails("a.stipple", NULL, STP_UNSUPPORTED, "a chunk file of ours");
    scan_fixture_bytes("a.tif", "II*\0\10\0\0", 8);
    scan_fixture_fails("a.tif", NULL, STP_CORRUPT, "the TIFF is damaged");
    scan_fixture_fails("no such file.ply", NULL, STP_NOT_FOUND, "");
    scan_fixture_fails(".", NULL, STP_IO, "");
}

/* Each is named, and what to do with it. */
static void formats_of_others(void **state)
{
    (void)state;
    const scan_malformed cases[] = {
        {"a.wrl", "#VRML V2.0 utf8\n", STP_UNSUPPORTED, "a scene (VRML)"},
        {"a.ply", "version https://git-lfs.github.com/spec/v1\n", STP_UNSUPPORTED, "git lfs pull"},
        {"a.las", "<!doctype html>\n<html>", STP_UNSUPPORTED, "a web page"},
        {"a.xyz", "  <?xml version=\"1.0\"?>\n<COLLADA/>", STP_UNSUPPORTED, "is XML"},
        {"tileset.json", "{\"asset\":{\"version\":\"1.0\"},\"geometricError\":9}", STP_UNSUPPORTED,
         "a tileset (3D Tiles)"},
        {"metadata.json", "{\"version\":\"2.0\",\"hierarchy\":{\"firstChunkSize\":9}}",
         STP_UNSUPPORTED, "a cloud of Potree"},
        {"packed.ply", ASCII "element vertex 1\nproperty uint packed_position\nend_header\n7\n",
         STP_CORRUPT, "1 packed Gaussian splats need 1 records"},
        {"chunks.ply",
         ASCII "element chunk 99\n" XYZ "element vertex 1\n"
               "property uint packed_position\nend_header\n7\n",
         STP_CORRUPT, "lacks one of min_x"},
        {"nothing.ply",
         ASCII "element chunk 99\nelement vertex 1\nproperty uint packed_position\nend_header\n7\n",
         STP_CORRUPT, "lacks one of min_x"},
        {"half.ply", ASCII "element vertex 1\nproperty float packed_position\nend_header\n7\n",
         STP_CORRUPT, "has no number property `x`"},
        {"scan.fls", "\1\2\3", STP_UNSUPPORTED, "a scan (FARO)"},
        {"mesh.3mf", "PK\3\4", STP_UNSUPPORTED, "a mesh (3MF)"},
        {"scans.zip", "PK\3\4", STP_UNSUPPORTED, "unzip"},
    };
    scan_fixture_malformed(cases, sizeof cases / sizeof *cases);
    scan_fixture_bytes("a.bin", "CCB2\0\0\0", 8);
    scan_fixture_fails("a.bin", NULL, STP_UNSUPPORTED, "save its clouds");
    stp_scan_info info; /* names of points may begin as other formats do */
    free(scan_fixture_points("names.txt", "AC10 1 2 3\nAC11 4 5 6\n", &info));
    assert_int_equal(info.point_count, 2);
    free(scan_fixture_points("text.flt", "1 2 3\n4 5 6\n", &info));
    assert_int_equal(info.point_count, 2);
}

/* Byte order marks and line ends as editors and old systems write them. With a mark, an OBJ file
 * would lose its first vertex. */
static void marks_and_line_ends(void **state)
{
    (void)state;
#define MARK "\xef\xbb\xbf"
    const scan_malformed cases[] = {
        {"m.obj", MARK "v 0 0 0\nv 1 0 0\nv 0 1 0\n", STP_UNSUPPORTED, "byte order mark"},
        {"comment.obj", MARK "# a comment\nv 0 0 0\n", STP_UNSUPPORTED, "byte order mark"},
        {"m.ply", MARK ASCII "element vertex 1\n" XYZ "end_header\n0 0 0\n", STP_UNSUPPORTED,
         "byte order mark"},
        {"m.off", MARK "OFF\n1 0 0\n0 0 0\n", STP_UNSUPPORTED, "byte order mark"},
        {"m.stl", MARK "solid a\nendsolid a\n", STP_UNSUPPORTED, "byte order mark"},
        {"m.pcd", MARK "# .PCD v.7\n", STP_UNSUPPORTED, "byte order mark"},
        {"m.las", MARK "LASF", STP_UNSUPPORTED, "byte order mark"},
        {"alone.dat", MARK, STP_FORMAT, "no known format"},
        {"cr.obj", "v 0 0 0\rv 1 0 0\rv 0 1 0\r", STP_UNSUPPORTED, "in CR alone"},
        {"cr.ply", "ply\rformat binary_little_endian 1.0\relement vertex 1\r\n\n", STP_CORRUPT,
         "some lines end in CR"},
        {"cr.off", "OFF\r1 0 0\r0 0 0\r", STP_UNSUPPORTED, "in CR alone"},
        {"cr.stl", "solid a\rendsolid a\r", STP_UNSUPPORTED, "in CR alone"},
        {"cr.pcd", "# .PCD v.7\rVERSION .7\r", STP_UNSUPPORTED, "in CR alone"},
    };
    scan_fixture_malformed(cases, sizeof cases / sizeof *cases);
    stp_scan_info info;
    free(scan_fixture_points("both.obj", "v 0 0 0\r\nv 1 0 0\r\n", &info));
    assert_int_equal(info.point_count, 2);
    free(scan_fixture_points("one.obj", "# from a\rb\nv 0 0 0\nv 1 0 0\n", &info));
    assert_int_equal(info.point_count, 2);
#undef MARK
}

static void sampling_without_faces(void **state)
{
    (void)state;
    const stp_scan_params params = {.sample_count = 10};
    scan_fixture_text("points.ply", ASCII "element vertex 1\n" XYZ "end_header\n0 0 0\n");
    scan_fixture_fails("points.ply", &params, STP_INVALID_ARGUMENT, "no faces");
    scan_fixture_text("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    scan_fixture_fails("flat.obj", &params, STP_EMPTY, "positive area");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(headers),
        cmocka_unit_test(counts),
        cmocka_unit_test(values),
        cmocka_unit_test(faces),
        cmocka_unit_test(meshes),
        cmocka_unit_test(binary_stl),
        cmocka_unit_test(other_formats),
        cmocka_unit_test(formats_of_others),
        cmocka_unit_test(marks_and_line_ends),
        cmocka_unit_test(sampling_without_faces),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

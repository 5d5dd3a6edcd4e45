/* Tests lines as surveyors and their programs write them, and rows of heights alone. */
#include "tests/fixtures/scan/scan_fixture.h"

#include <png.h>

static void expect_first(const char *path, const char *text, double x, double y, double z)
{
    stp_scan_info info;
    stp_point *points = scan_fixture_points(path, text, &info);
    scan_fixture_position(&points[0], x, y, z);
    free(points);
}

/* Number, northing, easting, elevation, description. */
static void northing_comes_first(void **state)
{
    (void)state;
    static const char *const files[] = {
        "1,5000.25,6100.5,101.125,GP\n2,5001.5,6102.25,101.5,EP\n7,5002.5,6103.25,101.75,IRON "
        "PIN\n",
        "1 5000.25 6100.5 101.125 GP\n2 5001.5 6102.25 101.5\n3 5002.5 6103.25 101.75 EP\n"
        "4 5000.25 6100.5 101.125 IRON PIN\n5 5001.5 6102.25 101.5 EP\n",
        "A1\t5000.25\t6100.5\t101.125\tGP\nA2\t5001.5\t6102.25\t101.5\tEP\n"
        "A3\t5002.5\t6103.25\t101.75\tEP\n",
        "P,N,E,Z,D\n1,5000.25,6100.5,101.125,GP\n2,5001.5,6102.25,101.5,EP\n",
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++)
        expect_first("survey.txt", files[i], 6100.5, 5000.25, 101.125);
    stp_scan_info info;
    stp_point *points = scan_fixture_points("survey.txt", files[0], &info);
    stp_scan *scan = NULL;
    assert_int_equal(stp_scan_open(&scan, "survey.txt", NULL, NULL), STP_OK);
    const stp_scan_info *open = stp_scan_get_info(scan);
    bool told = false;
    for (uint32_t i = 0; i < open->note_count; i++)
        told = told || strcmp(open->notes[i].name, "order") == 0;
    assert_true(told);
    stp_scan_close(&scan);
    free(points);
}

static void easting_comes_first(void **state)
{
    (void)state;
    expect_first("utm.txt",
                 "1,412349.5,5412346.25,315.5,GP\n2,412350.5,5412347.25,315.75,GP\n"
                 "3,412351.5,5412348.25,315.25,GP\n",
                 412349.5, 5412346.25, 315.5);
    expect_first("krueger.txt",
                 "1,3512349.5,5412346.25,315.5,GP\n2,3512350.5,5412347.25,315.75,GP\n"
                 "3,3512351.5,5412348.25,315.25,GP\n",
                 3512349.5, 5412346.25, 315.5);
    expect_first("prefixed.txt",
                 "1,32412349.5,5412346.25,315.5,GP\n2,32412350.5,5412347.25,315.75,GP\n"
                 "3,32412351.5,5412348.25,315.25,GP\n",
                 32412349.5, 5412346.25, 315.5);
    expect_first("swiss.txt",
                 "1 2600349.5 1200346.25 515.5 GP\n2 2600350.5 1200347.25 515.75 GP\n"
                 "3 2600351.5 1200348.25 515.25 GP\n",
                 2600349.5, 1200346.25, 515.5);
    /* no surveyor's: names of objects, and what they do */
    expect_first("names.txt",
                 "car 1.5 2.5 0.5 moving\nman 2.5 3.5 0.25 moving\ntree 3.5 4.5 0.75 still\n", 1.5,
                 2.5, 0.5);
    expect_first("objects.txt",
                 "1 1.5 2.5 0.5 chair\n2 2.5 3.5 0.25 chair\n3 3.5 -4.5 0.75 table\n", 1.5, 2.5,
                 0.5);
    expect_first("four.txt", "1,5.25,6.5,1.125\n2,5.5,6.25,1.5\n3,5.75,6.75,1.25\n", 5.25, 6.5,
                 1.125);
}

/* Points of well-known text, alone and in tables. */
static void well_known_text(void **state)
{
    (void)state;
    static const char *const files[] = {
        "POINT(1.5 2.5 3.5)\nPOINT(4.5 5.5 6.5)\n",
        "Point Z (1.5 2.5 3.5)\nPoint Z (4.5 5.5 6.5)\n",
        "wkt_geom\n\"POINT Z (1.5 2.5 3.5)\"\n\"POINT Z (4.5 5.5 6.5)\"\n",
        "WKT,class\n\"POINTZ(1.5 2.5 3.5)\",6\n\"POINTZ(4.5 5.5 6.5)\",2\n",
        "WKT;class\nPOINT Z (1.5 2.5 3.5);ground\nPOINT Z (4.5 5.5 6.5);tree\n",
        "fid,geom\n1,\"POINT Z (1.5 2.5 3.5)\"\n2,\"POINT Z (4.5 5.5 6.5)\"\n",
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        stp_scan_info info;
        stp_point *points = scan_fixture_points("wkt.csv", files[i], &info);
        assert_int_equal(info.point_count, 2);
        scan_fixture_position(&points[0], 1.5, 2.5, 3.5);
        scan_fixture_position(&points[1], 4.5, 5.5, 6.5);
        free(points);
    }
}

/* Names of columns in other languages and of other programs. */
static void names(void **state)
{
    (void)state;
    static const char *const headers[] = {
        "XYZ[0][m],XYZ[1][m],XYZ[2][m]",
        "Local X,Local Y,Local Z",
        "Este,Norte,Cota",
        "Est,Nord,Quota",
        "utm_x,utm_y,utm_z",
        "World X;World Y;World Z",
    };
    char text[256];
    for (size_t i = 0; i < sizeof headers / sizeof *headers; i++) {
        snprintf(text, sizeof text, "%s\n1.5,2.5,3.5\n4.5,5.5,6.5\n", headers[i]);
        expect_first("names.csv", text, 1.5, 2.5, 3.5);
    }
    stp_scan_info info;
    stp_point *points = scan_fixture_points(
        "cc.txt", "//X Y Z Rf Gf Bf\n1.5 2.5 3.5 0 1 0\n4.5 5.5 6.5 1 0 0.5\n", &info);
    scan_fixture_rgb(&points[0], 0, 65535, 0);
    free(points);
    points =
        scan_fixture_points("riscan.csv",
                            "XYZ[0][m],XYZ[1][m],XYZ[2][m],Reflectance[dB],Deviation[],Red,"
                            "Green,Blue\n1.5,2.5,3.5,-9.5,2,0,255,0\n4.5,5.5,6.5,-7.5,3,255,0,9\n",
                            &info);
    scan_fixture_rgb(&points[0], 0, 65535, 0);
    free(points);
}

/* Depths point downwards, unless they are written below zero. */
static void depths(void **state)
{
    (void)state;
    expect_first("deep.csv", "X,Y,Depth (m)\n1.5,2.5,3.5\n4.5,5.5,6.5\n", 1.5, 2.5, -3.5);
    expect_first("below.csv", "X,Y,depth\n1.5,2.5,-3.5\n4.5,5.5,-6.5\n", 1.5, 2.5, -3.5);
    expect_first("both.csv", "X,Y,Z,depth\n1.5,2.5,3.5,7\n4.5,5.5,6.5,8\n", 1.5, 2.5, 3.5);
}

/* The content alone tells, whatever the name. */
static void unknown_endings(void **state)
{
    (void)state;
    expect_first("job.neu",
                 "1,5000.25,6100.5,101.125,GP\n2,5001.5,6102.25,101.5,EP\n"
                 "3,5002.5,6103.25,101.75,EP\n",
                 6100.5, 5000.25, 101.125);
    scan_fixture_text("log.dat", "1 2 3 a\n4 5 6 b\nand so on\n");
    scan_fixture_fails("log.dat", NULL, STP_FORMAT, "no known format");
}

/* UTF-16 by its characters alone, in both orders of bytes. */
static void wide_without_mark(void **state)
{
    (void)state;
    static const char text[] = "X Y Z R G B\n1.5 2.5 3.5 10 20 30\n4.5 5.5 6.5 40 50 60\n";
    for (size_t high = 0; high < 2; high++) {
        char wide[2 * sizeof text] = {0};
        stp_scan_info info;
        for (size_t i = 0; i + 1 < sizeof text; i++)
            wide[2 * i + 1 - high] = text[i];
        scan_fixture_bytes("wide.txt", wide, 2 * (sizeof text - 1));
        stp_point *points = scan_fixture_read("wide.txt", NULL, &info);
        assert_int_equal(info.point_count, 2);
        scan_fixture_position(&points[0], 1.5, 2.5, 3.5);
        scan_fixture_rgb(&points[1], 40 * 257, 50 * 257, 60 * 257);
        free(points);
    }
}

static void one_row_of_heights(void **state)
{
    (void)state;
    for (int tall = 0; tall < 2; tall++) {
        stp_scan_info info;
        scan_fixture_text("row.pgm",
                          tall ? "P2\n1 4\n255\n5\n6\n7\n8\n" : "P2\n4 1\n255\n8 7 6 5\n");
        stp_point *points = scan_fixture_read("row.pgm", NULL, &info);
        assert_int_equal(info.point_count, 4);
        assert_int_equal(info.raster.columns, 0);
        assert_int_equal(info.attributes & STP_POINT_HAS_NORMAL, 0);
        scan_fixture_position(&points[3], tall ? 0.0 : 3.0, 0.0, tall ? 8.0 : 5.0);
        free(points);
    }
}

/* Heights that were saved as a picture of colours; one pixel of another colour makes it one. */
static void grey_colours(void **state)
{
    (void)state;
    for (int coloured = 0; coloured < 2; coloured++) {
        unsigned char pixels[4 * 3 * 3] = {0};
        for (int i = 0; i < 36; i++)
            pixels[i] = (unsigned char)(10 * (i / 3));
        pixels[34] = (unsigned char)(pixels[34] + coloured);
        png_image png = {
            .version = PNG_IMAGE_VERSION, .width = 4, .height = 3, .format = PNG_FORMAT_RGB};
        assert_true(png_image_write_to_file(&png, "grey.png", 0, pixels, 0, NULL));
        if (coloured) {
            scan_fixture_fails("grey.png", NULL, STP_UNSUPPORTED, "a picture of colours");
            continue;
        }
        stp_scan_info info;
        stp_point *points = scan_fixture_read("grey.png", NULL, &info);
        assert_int_equal(info.point_count, 12);
        scan_fixture_position(&points[5], 1.0, 1.0, 50.0);
        free(points);
    }
}

static void write_matrix(int columns, bool smooth)
{
    FILE *file = fopen("matrix.txt", "w");
    assert_non_null(file);
    for (int j = 0; j < 30; j++)
        for (int i = 0; i < columns; i++)
            fprintf(file, "%d.%d%c", smooth ? i + j : i * i * 7919 % 31, j % 10,
                    i + 1 < columns ? ' ' : '\n');
    fclose(file);
}

/* A few columns of heights are no points; so many numbers of points are. */
static void matrices(void **state)
{
    (void)state;
    stp_scan_info info;
    write_matrix(40, true);
    scan_fixture_fails("matrix.txt", NULL, STP_UNSUPPORTED, "as a matrix of heights");
    write_matrix(40, false);
    free(scan_fixture_read("matrix.txt", NULL, &info));
    assert_int_equal(info.point_count, 30);
    write_matrix(12, true);
    free(scan_fixture_read("matrix.txt", NULL, &info));
    assert_int_equal(info.point_count, 30);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(northing_comes_first),
        cmocka_unit_test(easting_comes_first),
        cmocka_unit_test(names),
        cmocka_unit_test(depths),
        cmocka_unit_test(unknown_endings),
        cmocka_unit_test(well_known_text),
        cmocka_unit_test(wide_without_mark),
        cmocka_unit_test(one_row_of_heights),
        cmocka_unit_test(matrices),
        cmocka_unit_test(grey_colours),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

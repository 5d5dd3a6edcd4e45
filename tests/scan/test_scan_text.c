/* Tests lines of numbers: separators, headers, guessed and given columns, depths, odd files. */
#include "tests/fixtures/scan/scan_fixture.h"

#include <math.h>

/* Returns the text of a file's note; "" if there is none. */
static const char *note(const char *path, const stp_scan_params *params, const char *name)
{
    static char text[1024];
    stp_error err = {0};
    stp_scan *scan = NULL;
    if (stp_scan_open(&scan, path, params, &err) != STP_OK)
        fail_msg("%s", err.message);
    const stp_scan_info *info = stp_scan_get_info(scan);
    text[0] = '\0';
    for (uint32_t i = 0; i < info->note_count; i++)
        if (strcmp(info->notes[i].name, name) == 0)
            snprintf(text, sizeof text, "%s", info->notes[i].text);
    stp_scan_close(&scan);
    return text;
}

/* The reader must find these columns in this text. */
static void expect_columns(const char *text, const char *columns)
{
    scan_fixture_text("columns.txt", text);
    const char *found = note("columns.txt", NULL, "columns");
    if (strncmp(found, columns, strlen(columns)) != 0 || found[strlen(columns)] != ' ')
        fail_msg("%s: columns %s, expected %s", text, found, columns);
}

/* The same two points, written in every way. */
static void separators(void **state)
{
    (void)state;
    const char *const texts[] = {
        "1.5 -2 3e2 10 20 30\n4 5 6 70 80 255\n",
        "  1.5   -2\t3e2 10 20 30  \n\t4 5 6 70 80 255\n",
        "1.5\t-2\t3e2\t10\t20\t30\n4\t5\t6\t70\t80\t255\n",
        "1,5\t-2\t3e2\t10\t20\t30\n4,0\t5\t6\t70\t80\t255\n",
        "1.5,-2,3e2,10,20,30\n4,5,6,70,80,255\n",
        "1.5, -2, 3e2, 10, 20, 30,\n4 ,5 ,6 ,70 ,80 ,255 ,\n",
        "1.5;-2;3e2;10;20;30\n4;5;6;70;80;255;\n",
        "1,5; -2,0; 3e2; 10; 20; 30\n4;5;6;70;80;255\n",
        "x|y|z|r|g|b\n1.5 | -2 | 3e2 | 10 | 20 | 30\n4|5|6|70|80|255\n",
        "1.5D+00 -2.0d+0 3.0D+02 10 20 30\n4 5 6 70 80 255\n",
        "A; of 2024-01-02\nx;y;z;r;g;b\nm;m;m;;;\n1,5;-2;3e2;10;20;30\n4;5;6;70;80;255\n",
        "\"1.5\",\"-2\",\"3e2\",\"10\",\"20\",\"30\"\n4,5,6,70,80,255\n",
        "1.5 -2 3e2 10 20 30\r\n4 5 6 70 80 255\r\n\x1a",
        "\357\273\2771.5 -2 3e2 10 20 30\n4 5 6 70 80 255",
        "# a comment\n\n1.5 -2 3e2 10 20 30\n // another\n \t\r\n4 5 6 70 80 255\n\n#\n",
        "x y z r g b\n1.5 -2 3e2 10 20 30\n4 5 6 70 80 255\n",
        "\357\273\277X;Y;Z;R;G;B\r\n1,5;-2;3e2;10;20;30\r\n4;5;6;70;80;255",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        stp_scan_info info;
        stp_point *points = scan_fixture_points("separators.xyz", texts[i], &info);
        print_message("%zu: %s\n", i, info.format);
        assert_string_equal(info.format, "XYZ text");
        assert_int_equal(info.point_count, 2);
        assert_int_equal(info.attributes, STP_POINT_HAS_COLOUR);
        scan_fixture_position(&points[0], 1.5, -2, 300);
        scan_fixture_position(&points[1], 4, 5, 6);
        scan_fixture_rgb(&points[0], 10 * 257, 20 * 257, 30 * 257);
        scan_fixture_rgb(&points[1], 70 * 257, 80 * 257, 65535);
        free(points);
    }
}

static void headers(void **state)
{
    (void)state;
    expect_columns("X,Y,Z\n1,2,3\n", "x,y,z");
    expect_columns("Northing;Easting;Elevation (m)\n1;2;3\n", "y,x,z");
    expect_columns("id E N H\n1 2 3 4\n", "_,x,y,z");
    expect_columns("Hochwert;Rechtswert;H\xc3\xb6he [m]\n1;2;3\n", "y,x,z");
    expect_columns("Rechtswert;Hochwert;H\xf6he [m];R;G;B\n1,5;2,5;3;4;5;6\n",
                   "x,y,z,red,green,blue");
    expect_columns("X|Y|Z|Rot|Gr\xc3\xbcn|Blau|Intensit\xc3\xa4t\n1|2|3|4|5|6|7\n",
                   "x,y,z,red,green,blue,intensity");
    expect_columns("x y z classe\n1 2 3 sol\n1 2 3 mur\n", "x,y,z,_");
    expect_columns("x y z rouge vert bleu classe\n1 2 3 4 5 6 7\n", "x,y,z,red,green,blue,class");
    expect_columns("x y z Red Green Blue Alpha\n1 2 3 4 5 6 255\n", "x,y,z,red,green,blue,_");
    expect_columns("POINT_X;POINT_Y;POINT_Z;x_m\n1;2;3;4\n", "x,y,z,_");
    expect_columns("\"RGB:0\",\"RGB:1\",\"RGB:2\",\"Points:0\",\"Points:1\",\"Points:2\"\n"
                   "9,8,7,1,2,3\n",
                   "red,green,blue,x,y,z");
    expect_columns("x y z red green\n1 2 3 4 5\n", "x,y,z,_,_");
    expect_columns("//X Y Z R G B Scalar_Intensity\n1 2 3 4 5 6 7\n",
                   "x,y,z,red,green,blue,intensity");
    expect_columns("# exported today\n# x y z class\n1 2 3 4\n", "x,y,z,class");
    expect_columns("# three words only\n1 2 3 0.25\n2 2 3 0.5\n", "x,y,z,intensity");
    expect_columns("\"X\",\"Y\",\"Z\",\"Normal_X\",\"Normal-Y\",\"normal.z\"\n1,2,3,0,0,1\n",
                   "x,y,z,nx,ny,nz");
    expect_columns("x\ty\tz\tremark\n1\t2\t3\ta b\n1\t2\t3\t\n", "x,y,z,_");
    expect_columns("z,height,y,x,Reflectance,Intensity\n1,2,3,4,5,6\n", "z,_,y,x,_,intensity");
    scan_fixture_text("names.csv",
                      "GpsTime,X,Y,Z,Amplitude,Pulse width,Classification\n9,1,2,3,60000,7,8\n");
    assert_string_equal(note("names.csv", NULL, "left_out"), "GpsTime, Pulse width");
    stp_scan_info info;
    stp_point *points = scan_fixture_read("names.csv", NULL, &info);
    assert_int_equal(info.attributes, STP_POINT_HAS_INTENSITY | STP_POINT_HAS_CLASS);
    scan_fixture_position(&points[0], 1, 2, 3);
    scan_fixture_scalars(&points[0], 60000, 8);
    free(points);
}

static void by_content(void **state)
{
    (void)state;
    expect_columns("1 2 3\n", "x,y,z");
    expect_columns("1 2 3 40\n1 2 3 50\n", "x,y,z,intensity");
    expect_columns("1 2 3 4 5\n1 2 3 4 5\n", "x,y,z,_,_");
    expect_columns("1 2 3 4 5 6\n1 2 3 255 0 6\n", "x,y,z,red,green,blue");
    expect_columns("1 2 3 0.5 0.25 1\n1 2 3 0.1 0.2 0.3\n", "x,y,z,red,green,blue");
    expect_columns("1 2 3 0 0 1\n1 2 3 0.6 -0.8 0\n", "x,y,z,nx,ny,nz");
    expect_columns("1 2 3 4 -5 6\n", "x,y,z,_,_,_");
    expect_columns("1 2 3 900 4 5 6\n1 2 3 8 4 5 6\n", "x,y,z,intensity,red,green,blue");
    expect_columns("1 2 3 4 5 6 900\n1 2 3 4 5 6 7\n", "x,y,z,red,green,blue,intensity");
    expect_columns("1 2 3 4 5 6 255\n1 2 3 90 80 70 255\n", "x,y,z,red,green,blue,_");
    expect_columns("1 2 3 90 10 12 14\n1 2 3 80 100 103 101\n", "x,y,z,intensity,red,green,blue");
    expect_columns("1 2 3 10 12 14 90\n1 2 3 100 103 101 80\n", "x,y,z,red,green,blue,intensity");
    expect_columns("1 2 3 0.25 0 0 1\n1 2 3 0.5 1 0 0\n", "x,y,z,intensity,nx,ny,nz");
    expect_columns("1 2 3 -7 4 5 6\n", "x,y,z,intensity,red,green,blue");
    expect_columns("1 2 3 4 5 6 0 1 0\n1 2 3 4 5 6 0.6 0 0.8\n", "x,y,z,red,green,blue,nx,ny,nz");
    expect_columns("1 2 3 0 1 0 4 5 6\n", "x,y,z,nx,ny,nz,red,green,blue");
    expect_columns("1 2 3 -9 4 5 6 0 1 0\n", "x,y,z,intensity,red,green,blue,nx,ny,nz");
    expect_columns("1 2 3 4 5 6 0 1 0 0.5\n", "x,y,z,red,green,blue,nx,ny,nz,intensity");
    expect_columns("p1,1,2,3\np2,4,5,6\n", "_,x,y,z");
    expect_columns("1 2 3 nan\n1 2 3 7\n", "x,y,z,intensity");
    expect_columns("1 2.5 3.5 4 90\n2 3 5.5 7 80\n3 1.5 2 9 70\n", "_,x,y,z,intensity");
    expect_columns("1 2.5 3.5 4.1\n2 3 5.5 7\n3 1.5 2 9\n", "_,x,y,z");
    expect_columns("1 2.5 3.5 4\n2 3 5.5 7\n3 1.5 2 9\n", "x,y,z,intensity"); /* a profile */
    expect_columns("1 2 3.5 4\n2 3 5.5 7\n3 1 2 9\n", "x,y,z,intensity");     /* a row of a grid */
    expect_columns("1 2.5 3.5 4\n2 3 5.5 7\n4 1.5 2 9\n", "x,y,z,intensity");
    expect_columns("1.5e9 2.5 3.5 4 90\n1500000000.5 3 5.5 7 80\n1500000000.5 1.5 2 9 70\n",
                   "_,x,y,z,intensity");
    expect_columns("1700000000000 2 3 4\n1700000000007 3 5 7\n1700000000009 1 2 9\n", "_,x,y,z");
    expect_columns("3512345678 5412345678 99000 4\n3512345679 5412345678 99000 7\n"
                   "3512345680 5412345678 99000 9\n",
                   "x,y,z,intensity"); /* Gauss and Krueger's in millimetres */
    expect_columns("0 0 1.5 2.5 3.5 9 8 7\n1 0 1.5 2.25 3 9 8 7\n0 2 1.5 2.5 -3.5 9 8 7\n",
                   "_,_,x,y,z,red,green,blue"); /* FARO's rows and columns */
    expect_columns("7 0 1.5 2.5 3.5 9\n7 3 1.5 2.25 3.125 8\n9 2 1.5 2.5 -3.5 7\n",
                   "_,_,x,y,z,intensity");
    expect_columns("7 0 1.5 2.5 3.5 9\n7 3 1.5 2.25 3.125 8\n6 2 1.5 2.5 -3.5 7\n", "x,y,z,_,_,_");
    expect_columns("0 0 1.5 0.6 0.8 0\n1 0 1.5 0.8 0.6 0\n0 1 1.25 0.5 0.866 0.001\n",
                   "x,y,z,nx,ny,nz"); /* heights of a grid, and their normals */
    scan_fixture_text("left.xyz", "1 2 3 4 5\n1 2 3 4 5\n");
    assert_string_equal(note("left.xyz", NULL, "left_out"), "column 4, column 5");
}

/* Structure from motion by COLMAP: the comment names columns, the last is a list. */
static void lists_at_the_end(void **state)
{
    (void)state;
    stp_scan_info info;
    stp_point *points = scan_fixture_points(
        "points3D.txt",
        "# 3D point list with one line of data per point:\n"
        "#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n"
        "# Number of points: 3, mean track length: 2.6\n"
        "7 1 2 3 10 20 30 0.5 1 2 3 4\n9 4 5 6 70 80 255 0.25 1 2\n8 7 8 9 1 2 3 1 5 6 7 8 9 1\n",
        &info);
    assert_int_equal(info.point_count, 3);
    scan_fixture_position(&points[2], 7, 8, 9);
    scan_fixture_rgb(&points[1], 70 * 257, 80 * 257, 65535);
    free(points);
}

/* Marks of thousands, as Swiss surveyors write them. */
static void thousands(void **state)
{
    (void)state;
    stp_scan_info info;
    stp_point *points =
        scan_fixture_points("swiss.xyz", "2'600'000.25 1'200'000.5 431.125\n1 2 3\n", &info);
    scan_fixture_position(&points[0], 2600000.25, 1200000.5, 431.125);
    assert_true(info.coordinate_step == 0.001);
    free(points);
    scan_fixture_text("odd.xyz", "1 2 3\n1'20 2 3\n");
    scan_fixture_fails("odd.xyz", NULL, STP_CORRUPT, "`1'20`");
}

/* A colour in one piece, in every way that programs write one. */
static void packed_colours(void **state)
{
    (void)state;
    const char *const texts[] = {
        "1 2 3 #0a141e\n4 5 6 #4650FF\n",
        "1 2 3 0x0A141E\n4 5 6 0xff4650ff\n",
        "1,2,3,#0a141eff\n4,5,6,#4650ff80\n",
        "1 2 3 -16116706\n4 5 6 -12168961\n",
        "1 2 3 4278850590\n4 5 6 4282798335\n",
        "x y z hex\n1 2 3 0a141e\n4 5 6 4650ff\n",
        "x;y;z;Color\n1,0;2;3;660510\n4;5;6;4608255\n",
        "x y z rgb\n1 2 3 9.25571648671185e-40\n4 5 6 6.45754065471716e-39\n",
        "x y z rgb\n1 2 3 -16116706\n4 5 6 4282798335\n",
        "x y z rgb\n1 2 3 660510\n4 5 6 4608255\n7 8 9 nan\n",
        "x,y,z,rgb,n\n1,2,3,660510,1\n4,5,6,4608255,1\n7,8,9,,1\n",
        "x y z rgb\n1 2 3 -1.83537918e+38\n4 5 6 -2.63607699e+38\n",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        stp_scan_info info;
        print_message("%s", texts[i]);
        stp_point *points = scan_fixture_points("packed.xyz", texts[i], &info);
        assert_int_equal(info.attributes, STP_POINT_HAS_COLOUR);
        scan_fixture_position(&points[1], 4, 5, 6);
        scan_fixture_rgb(&points[1], 70 * 257, 80 * 257, 255 * 257);
        scan_fixture_rgb(&points[0], 10 * 257, 20 * 257, 30 * 257);
        free(points);
    }
    expect_columns("x y z color\n1 2 3 40\n1 2 3 65535\n", "x,y,z,intensity");
    expect_columns("x y z color r g b\n1 2 3 40 1 2 3\n", "x,y,z,_,red,green,blue");
    expect_columns("x y z color\n1 2 3 -1\n1 2 3 2\n", "x,y,z,intensity");
    expect_columns("x y z color\n1 2 3 0.25\n1 2 3 1.0\n", "x,y,z,intensity");
    expect_columns("x y z color\n1 2 3 red\n1 2 3 white\n", "x,y,z,_");
    expect_columns("x;y;z;color\n1;2;3;9 8 7\n1;2;3;0 0 0\n", "x,y,z,_");
    expect_columns("x y z hex\n1 2 3 112233\n1 2 3 001122\n", "x,y,z,colour");
    scan_fixture_text("bad.xyz", "1 2 3 #0a141e\n4 5 6 #46\n");
    scan_fixture_fails("bad.xyz", NULL, STP_CORRUPT, "`#46` in column 4 (colour) is not a number");
}

static void as_given(void **state)
{
    (void)state;
    const stp_scan_params params = {.columns = "_,z,y,x,-,I, class"};
    stp_scan_info info;
    scan_fixture_text("given.txt", "9 1 2 3 8 200 4 77 88\n9 4 5 6 8 100 5 77 88\n");
    stp_point *points = scan_fixture_read("given.txt", &params, &info);
    assert_int_equal(info.attributes, STP_POINT_HAS_INTENSITY | STP_POINT_HAS_CLASS);
    scan_fixture_position(&points[0], 3, 2, 1);
    scan_fixture_scalars(&points[0], 200 * 257, 4);
    scan_fixture_scalars(&points[1], 100 * 257, 5);
    free(points);
    assert_string_equal(note("given.txt", &params, "left_out"),
                        "column 1, column 5, column 8, column 9");
    assert_string_equal(note("given.txt", &params, "columns"),
                        "_,z,y,x,_,intensity,class (as given)");
    /* given columns overrule the header */
    scan_fixture_text("given.csv", "x,y,z\n1,2,3\n4,5,6\n");
    points = scan_fixture_read("given.csv", &(stp_scan_params){.columns = "y,x,z"}, &info);
    assert_int_equal(info.point_count, 2);
    scan_fixture_position(&points[0], 2, 1, 3);
    free(points);
    const struct {
        const char *columns, *text;
    } wrong[] = {
        {"x,y", "x, y and z"},
        {"x,y,z,r,g", "r, g and b"},
        {"x,y,z,nx", "nx, ny and nz"},
        {"x,y,z,tint", "`tint`"},
        {"x,y,z,rgb,colour", "twice"},
        {"x,y,z,x", "twice"},
        {"", "x, y and z"},
        {"x,,y,z", "``"},
        {"x,y,z,r,g,b", "names 6 columns, but the first point of given.csv has 3"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        stp_error err = {0};
        stp_scan *scan = NULL;
        const stp_scan_params p = {.columns = wrong[i].columns};
        assert_int_equal(stp_scan_open(&scan, "given.csv", &p, &err), STP_INVALID_ARGUMENT);
        if (!strstr(err.message, wrong[i].text))
            fail_msg("%s: %s", wrong[i].columns, err.message);
    }
    scan_fixture_text("given.obj", "v 0 0 0\n");
    scan_fixture_fails("given.obj", &params, STP_INVALID_ARGUMENT, "--columns");
}

/* A colour or intensity whose depth follows from the whole file. */
static void depths(void **state)
{
    (void)state;
    const struct {
        const char *text;
        unsigned red, intensity;
    } cases[] = {
        {"x y z r g b i\n0 0 0 51 0 0 51\n0 0 0 255 0 0 255\n", 51 * 257, 51 * 257},
        {"x y z r g b i\n0 0 0 51 0 0 51\n0 0 0 4096 0 0 4000\n", 51, 51},
        {"x y z r g b i\n0 0 0 51 0 0 51\n0 0 0 4000 0 0 4000\n", 816, 51}, /* 12 bits */
        {"x y z r g b i\n0 0 0 0.2 0 0 0.2\n0 0 0 1 0 0 1.0\n", 13107, 13107},
        {"x y z r g b i\n0 0 0 1.0 0 0 1.0\n0 0 0 0.0 0 0 0.0\n", 65535, 65535},
        {"x y z r g b i\n0 0 0 1 0 0 1\n0 0 0 0 0 0 0\n", 65535, 257},
        {"x y z r g b i\n0 0 0 0 0 0 -2048\n0 0 0 0 0 0 2047\n", 0, 0},
        {"x y z r g b i\n0 0 0 0 0 0 2047\n0 0 0 0 0 0 -1\n", 0, 65535},
        {"x y z r g b i\n0 0 0 0 0 0 0\n0 0 0 0 0 0 -5\n", 0, (2048 * 65535 + 2047) / 4095},
        {"x y z r g b i\n0 0 0 0 0 0 -15.5\n0 0 0 0 0 0 -20.5\n0 0 0 0 0 0 -0.5\n", 0, 16384},
        {"x y z r g b i\n0 0 0 0 0 0 500000\n0 0 0 0 0 0 2000000\n", 0, 16384},
        {"x y z r g b i\n0 0 0 nan 0 0 nan\n0 0 0 255 0 0 255\n", 0, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        stp_scan_info info;
        stp_point *points = scan_fixture_points("depth.txt", cases[i].text, &info);
        print_message("%zu\n", i);
        assert_int_equal(points[0].rgb[0], cases[i].red);
        assert_int_equal(points[0].intensity, cases[i].intensity);
        free(points);
    }
}

/* Colours that are all zero are none, with names and without. One value makes them colours. */
static void all_black_is_no_colour(void **state)
{
    (void)state;
    const struct {
        const char *text;
        uint32_t attributes;
    } cases[] = {
        {"1 2 3 0 0 0\n4 5 6 0 0 0\n", 0},
        {"1 2 3 0 0 0\n4 5 6 0 0 9\n", STP_POINT_HAS_COLOUR},
        {"x y z r g b i\n1 2 3 0 0 0 7\n", STP_POINT_HAS_INTENSITY},
        {"x y z r g b i\n1 2 3 1 0 0 7\n", STP_POINT_HAS_COLOUR | STP_POINT_HAS_INTENSITY},
        {"1 2 3 90 0 0 0\n4 5 6 70 0 0 0\n", STP_POINT_HAS_INTENSITY},
        {"x y z r g b i\n1 2 3 255 255 255 7\n", STP_POINT_HAS_INTENSITY}, /* white hides it */
        {"x y z r g b i\n1 2 3 255 255 254 7\n", STP_POINT_HAS_COLOUR | STP_POINT_HAS_INTENSITY},
        {"1 2 3 255 255 255\n", STP_POINT_HAS_COLOUR},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        stp_scan_info info;
        free(scan_fixture_points("black.txt", cases[i].text, &info));
        print_message("%zu\n", i);
        assert_int_equal(info.attributes, cases[i].attributes);
    }
}

/* Coordinates of a survey have a step; floats have none. */
static void coordinate_steps(void **state)
{
    (void)state;
    const struct {
        const char *text;
        double step;
    } cases[] = {
        {"636110.31 849345.05 512.1\n1 2 3\n", 0.01},
        {"636110.310000 849345.050000 512.100000\n", 0.01},
        {"1,25;2;3\n1,255;2;3\n", 0.001},
        {"1 2 3 0.12345\n", 1.0},
        {"100 20 30\n", 1.0},
        {"0.5 0.5 0.1234\n", 0.0},
        {"1e2 2 3\n", 0.0},
        {"x y z\nnan nan nan\n", 0.0},
        {"x y z\n", 0.0},
        {"2\n1.5 2 3\n1.5 2.25 3\n", 0.01},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        stp_scan_info info;
        free(scan_fixture_points("step.txt", cases[i].text, &info));
        if (info.coordinate_step != cases[i].step)
            fail_msg("%s: step %g", cases[i].text, info.coordinate_step);
    }
}

/* Deep values far behind the first lines must be found: 1 in 4096 lines, in a file of 12 MB. */
static void depth_of_large_file(void **state)
{
    (void)state;
    FILE *file = fopen("large.xyz", "w");
    assert_non_null(file);
    for (int i = 0; i < 600000; i++)
        fprintf(file, "%d 0 0.5 %d 0 0\n", i, i > 300000 && i % 97 == 0 ? 60000 : 200);
    assert_int_equal(fclose(file), 0);
    stp_scan_info info;
    stp_point *points = scan_fixture_read("large.xyz", NULL, &info);
    assert_int_equal(info.point_count, 600000);
    assert_int_equal(points[0].rgb[0], 200);
    scan_fixture_position(&points[599999], 599999, 0, 0.5);
    free(points);
}

static void values_that_are_none(void **state)
{
    (void)state;
    stp_scan_info info;
    stp_point *points =
        scan_fixture_points("nan.xyz", "nan 0 0\n1 2 3\n0 -inf 1e999\n1 -1.#IND 2\n", &info);
    assert_int_equal(info.point_count, 4);
    assert_true(isnan(points[0].position.x) && isinf(points[2].position.y));
    assert_true(isinf(points[2].position.z) && isnan(points[3].position.y));
    for (int i = 0; i < 4; i++)
        assert_int_equal(points[i].reject, STP_REJECT_NONE);
    scan_fixture_position(&points[1], 1, 2, 3);
    free(points);
    points = scan_fixture_points("normals.xyz",
                                 "x y z nx ny nz\n0 0 0 0 0 7\n0 0 0 0 0 0\n"
                                 "0 0 0 nan 0 1\n",
                                 &info);
    assert_int_equal(info.attributes, STP_POINT_HAS_NORMAL);
    scan_fixture_normal(&points[0], 0, 0, 1);
    scan_fixture_normal(&points[1], 0, 0, 0);
    scan_fixture_normal(&points[2], 0, 0, 0);
    free(points);
}

static void no_points(void **state)
{
    (void)state;
    const char *const texts[] = {"x y z r g b\n", "# only a comment\n", "\n \n", "\357\273\277",
                                 "//X,Y,Z\r\n"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        stp_scan_info info;
        free(scan_fixture_points("none.xyz", texts[i], &info));
        assert_int_equal(info.point_count, 0);
    }
    scan_fixture_text("empty.xyz", "");
    scan_fixture_fails("empty.xyz", NULL, STP_EMPTY, "0 bytes");
}

static void million_equal_lines(void **state)
{
    (void)state;
    const size_t count = 1000000, length = 12;
    char *text = malloc(count * length);
    assert_non_null(text);
    for (size_t i = 0; i < count; i++)
        memcpy(text + i * length, "1.5 2.5 3.5\n", length);
    scan_fixture_bytes("equal.xyz", text, count * length - 1);
    free(text);
    stp_scan_info info;
    stp_point *points = scan_fixture_read("equal.xyz", NULL, &info);
    assert_int_equal(info.point_count, count);
    for (size_t i = 0; i < count; i += 999)
        scan_fixture_position(&points[i], 1.5, 2.5, 3.5);
    free(points);
}

/* A line of 1 MiB: as a comment it is valid, as a point it is wrong, as the first line it is
 * refused. */
static void long_line(void **state)
{
    (void)state;
    const size_t size = (size_t)1 << 20;
    char *text = malloc(size + 64);
    assert_non_null(text);
    const int begin = sprintf(text, "1 2 3\n4 5 6\n#");
    memset(text + begin, '7', size);
    memcpy(text + begin + size, "\n7 8 9\n", 8);
    scan_fixture_text("comment.xyz", text);
    stp_scan_info info;
    stp_point *points = scan_fixture_read("comment.xyz", NULL, &info);
    assert_int_equal(info.point_count, 3);
    scan_fixture_position(&points[2], 7, 8, 9);
    free(points);
    text[begin - 1] = '7';
    scan_fixture_text("long.xyz", text);
    scan_fixture_fails("long.xyz", NULL, STP_CORRUPT, "line 3");
    memset(text + begin - 1, ' ', size);
    scan_fixture_text("blank.xyz", text);
    scan_fixture_fails("blank.xyz", NULL, STP_CORRUPT, "line 3 has 1 columns");
    scan_fixture_text("first.xyz", text + begin - 1);
    memset(text, '7', size);
    text[size] = '\0';
    scan_fixture_text("first.xyz", text);
    scan_fixture_fails("first.xyz", NULL, STP_LIMIT, "line 1");
    free(text);
}

static void malformed(void **state)
{
    (void)state;
    const scan_malformed cases[] = {
        {"word.xyz", "1 2 3\n4 five 6\n", STP_CORRUPT, "line 2: `five` in column 2 (y)"},
        {"few.xyz", "1 2 3\n4 5\n7 8 9\n", STP_CORRUPT, "line 2 has 2 columns"},
        {"more.xyz", "1 2 3\n\n4 5 6 7\n", STP_CORRUPT, "line 3 has more than the 3"},
        {"hole.csv", "1,2,3\n4,?,6\n", STP_CORRUPT, "line 2: `?` in column 2 (y)"},
        {"cut.xyz", "1 2 3 4\n4 5 6 7\n8 9 1", STP_CORRUPT, "ends at line 3, after 3 of 4"},
        {"cut.csv", "x,y,z,time\n1,2,3,4\n4,5,6\n7,8,9,1\n", STP_CORRUPT, "line 3 has 3 columns"},
        {"points.csv", "x;y;z\n1,5;2.5;3,5\n1,5,5;1;1\n", STP_CORRUPT, "`1,5,5`"},
        {"prose.txt", "It was a dark and stormy night.\n", STP_FORMAT, "`It was a dark"},
        {"names.csv", "id,lat,lon\n1,2,3\n", STP_FORMAT, "--columns"},
        {"header.csv", "x,y,z,r\n1,2,3\n1,2,3,4,5,6\n", STP_CORRUPT, "line 2 has 3 columns"},
        {"header2.csv", "x,y,z\n1,2,3,4\n", STP_CORRUPT, "names 3 columns, but line 2"},
        {"two.csv", "x,y,z\n1,2,3\nx,y,z\n1,2,3\n", STP_CORRUPT, "line 3: `x`"},
        {"two.xyz", "1 2\n3 4\n", STP_FORMAT, "2 numbers where a point needs three"},
        {"nul.xyz", "1 2 3\n\1\2\3\n", STP_FORMAT, "no known format"},
        {"old.xyz", "1 2 3\r4 5 6\r", STP_UNSUPPORTED, "CR alone"},
        {"wide.ply", "\377\376p\1", STP_UNSUPPORTED, "UTF-16"},
        {"titles.txt", "one\ntwo\nthree\n1 2 3\n", STP_FORMAT, "line 1, `one`"},
        {"hello.dat", "hello\n", STP_FORMAT, "no known format"},
    };
    scan_fixture_malformed(cases, sizeof cases / sizeof *cases);
    const char binary[] = "1 2 3\n4 5 6\n\0\0\0\0";
    scan_fixture_bytes("binary.xyz", binary, sizeof binary);
    scan_fixture_fails("binary.xyz", NULL, STP_FORMAT, "no known format");
}

/* The content decides the format; if it cannot, the name does. */
static void detected(void **state)
{
    (void)state;
    const struct {
        const char *name, *content, *format;
    } cases[] = {
        {"a.dat", "1 2 3\n4 5 6\n", "XYZ text"},
        {"b.dat", "x,y,z\n4,5,6\n", "XYZ text"},
        {"c.dat", "1\n4 5 6\n", "PTS"},
        {"d.xyz", "2\n4 5 6\n7 8 9\n", "PTS"},
        {"e.pts", "4 5 6\n7 8 9\n", "XYZ text"},
        {"f.pts", "0\n", "PTS"},
        {"g.dat", "0\n0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "PTX"},
        {"h.pts", "0\n5\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "PTX"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        stp_scan_info info;
        free(scan_fixture_points(cases[i].name, cases[i].content, &info));
        assert_string_equal(info.format, cases[i].format);
    }
    /* a file that is called a mesh is not read as points */
    scan_fixture_text("i.off", "0 0 0\n1 0 0\n0 1 0\n");
    scan_fixture_fails("i.off", NULL, STP_UNSUPPORTED, "OFF");
}

static void pts(void **state)
{
    (void)state;
    stp_scan_info info;
    stp_point *points = scan_fixture_points(
        "a.pts", "2\r\n1 2 3 -2048 10 20 30\r\n4 5 6 2047 40 50 60\r\n\r\n1\r\n7 8 9 0 70 80 90",
        &info);
    assert_string_equal(info.format, "PTS");
    assert_int_equal(info.point_count, 3);
    assert_int_equal(info.attributes, STP_POINT_HAS_COLOUR | STP_POINT_HAS_INTENSITY);
    scan_fixture_position(&points[2], 7, 8, 9);
    scan_fixture_rgb(&points[1], 40 * 257, 50 * 257, 60 * 257);
    scan_fixture_scalars(&points[0], 0, 0);
    scan_fixture_scalars(&points[1], 65535, 0);
    scan_fixture_scalars(&points[2], (2048 * 65535 + 2047) / 4095, 0);
    free(points);
    /* the format fixes the order, even if the numbers suggest another */
    points = scan_fixture_points("b.pts", "2\n1 2 3 10 12 14 90\n1 2 3 100 103 101 80\n", &info);
    scan_fixture_scalars(&points[0], 10 * 257, 0);
    scan_fixture_rgb(&points[0], 12 * 257, 14 * 257, 90 * 257);
    free(points);
    const stp_scan_params params = {.columns = "x,y,z,r,g,b,i"};
    points = scan_fixture_read("b.pts", &params, &info);
    scan_fixture_scalars(&points[0], 90 * 257, 0);
    free(points);
    points = scan_fixture_points("c.pts", "0\n1\n1 2 3\n0\n", &info);
    assert_int_equal(info.point_count, 1);
    scan_fixture_position(&points[0], 1, 2, 3);
    free(points);
}

static void wrong_pts(void **state)
{
    (void)state;
    const struct {
        const char *content, *text;
    } cases[] = {
        {"3\n1 2 3\n4 5 6\n", "line 1 declares 3 points, but 2 follow until the end at line 3"},
        {"1\n1 2 3\n4 5 6\n", "line 3: expected the number of points"},
        {"3\n1 2 3\n4 5 6\n1\n7 8 9\n", "2 follow until the next number at line 4"},
        {"18446744073709551615\n1 2 3\n", "line 1"},
        {"18446744073709551614\n1 2 3\n", "declares 18446744073709551614 points, but 1 follow"},
        {"1\n1 2 3\n18446744073709551614\n1 2 3\n", "line 3"},
        {"2\n1 2 3\n4 5\n", "ends at line 3, after 2 of 3"},
        {"2\n1 2 3\n4 x 6\n", "line 3: `x`"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        scan_fixture_text("wrong.pts", cases[i].content);
        scan_fixture_fails("wrong.pts", NULL, STP_CORRUPT, cases[i].text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(separators),
        cmocka_unit_test(headers),
        cmocka_unit_test(by_content),
        cmocka_unit_test(lists_at_the_end),
        cmocka_unit_test(thousands),
        cmocka_unit_test(packed_colours),
        cmocka_unit_test(as_given),
        cmocka_unit_test(depths),
        cmocka_unit_test(all_black_is_no_colour),
        cmocka_unit_test(coordinate_steps),
        cmocka_unit_test(depth_of_large_file),
        cmocka_unit_test(values_that_are_none),
        cmocka_unit_test(no_points),
        cmocka_unit_test(million_equal_lines),
        cmocka_unit_test(long_line),
        cmocka_unit_test(malformed),
        cmocka_unit_test(detected),
        cmocka_unit_test(pts),
        cmocka_unit_test(wrong_pts),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

/* Tests lines of numbers as other programs write them: brackets, decimal commas, UTF-16, times. */
#include "tests/fixtures/scan/scan_fixture.h"

static void expect_two(const char *name, const char *text, uint32_t attributes)
{
    stp_scan_info info;
    print_message("%s: %s\n", name, text);
    stp_point *points = scan_fixture_points(name, text, &info);
    assert_int_equal(info.point_count, 2);
    assert_int_equal(info.attributes, attributes);
    scan_fixture_position(&points[0], 1.5, -2.25, 3);
    scan_fixture_position(&points[1], 4, 5, 6.125);
    free(points);
}

static void brackets(void **state)
{
    (void)state;
    expect_two("a.txt", "(1.5, -2.25, 3)\n(4, 5, 6.125)\n", 0);
    expect_two("b.txt", "[[1.5,-2.25,3],\n [4,5,6.125]]\n", 0);
    expect_two("c.txt", "[[ 1.5 -2.25 3. ]\n [ 4. 5. 6.125]\n]\n", 0);
    expect_two("d.txt", "[\n{1,5; -2,25; 3}\n{4; 5; 6,125}\n]\n", 0);
    expect_two("k.txt", "# X Y Z (m)\n1.5 -2.25 3\n4 5 6.125\n", 0);
    expect_two("l.txt", "X (m) Y [m] Z (m)\n1.5 -2.25 3\n4 5 6.125\n", 0);
    expect_two("m.txt", "X (m) Y (m) Z (m) rgb\n1.5 -2.25 3 #ff0000\n4 5 6.125 #00ff00\n",
               STP_POINT_HAS_COLOUR);
    expect_two("e.csv", "X [m],Y (m),Z (in m)\n1.5,-2.25,3\n4,5,6.125\n", 0);
}

/* Words in brackets, as years and units, are words; points in a row and words between are told. */
static void brackets_of_others(void **state)
{
    (void)state;
    stp_error err = {0};
    stp_scan *scan = NULL;
    expect_two("a.txt", "Survey (2019)\nX Y Z\n1.5 -2.25 3\n4 5 6.125\n", 0);
    expect_two("b.txt",
               "x y z nx ny nz\n[m] [m] [m] [1] [1] [1]\n"
               "1.5 -2.25 3 0 0 1\n4 5 6.125 0 1 0\n",
               STP_POINT_HAS_NORMAL);
    expect_two("c.txt", "(1.5, -2.25, 3) (0, 0, 1)\n(4, 5, 6.125) (0, 1, 0)\n",
               STP_POINT_HAS_NORMAL);
    scan_fixture_text("d.txt", "X (m) Y (m) Z (m) mark\n1.5 -2.25 3 8\n4 5 6.125 9\n");
    assert_int_equal(stp_scan_open(&scan, "d.txt", NULL, &err), STP_OK);
    assert_int_equal(stp_scan_get_info(scan)->note_count, 2);
    assert_string_equal(stp_scan_get_info(scan)->notes[1].text, "mark");
    stp_scan_close(&scan);
    const scan_malformed cases[] = {
        {"e.json", "[[1,2,3],[4,5,6],[7,8,9]]", STP_UNSUPPORTED, "line 1 has several points"},
        {"f.txt", "(1,2,3),(4,5,6)\n", STP_UNSUPPORTED, "line 1 has several points"},
        {"g.txt", "v=(1, 2, 3) n=(0, 0, 1)\nv=(4, 5, 6) n=(0, 0, 1)\n", STP_UNSUPPORTED,
         "line 1 has a word before"},
        {"h.txt", "P(1, 2, 3, 4)\nP(5, 6, 7, 8)\n", STP_UNSUPPORTED, "line 1 has a word before"},
    };
    scan_fixture_malformed(cases, sizeof cases / sizeof *cases);
}

static void decimal_commas(void **state)
{
    (void)state;
    expect_two("f.xyz", "1,5 -2,25 3\n4,0 5 6,125\n", 0);
    expect_two("g.xyz", "1,5 -2,25 3 255 0 1\n4,0 5 6,125 7 8 9\n", STP_POINT_HAS_COLOUR);
    expect_two("h.txt", "1.5, -2.25, 3\n4, 5, 6.125\n", 0);
}

/* A time that does not fall leaves one number: the intensity. */
static void times(void **state)
{
    (void)state;
    stp_scan_info info;
    free(scan_fixture_points("t.xyz", "1 2 3 9 0.5\n4 5 6 7 0.5\n7 8 9 8 0.75\n", &info));
    assert_int_equal(info.attributes, STP_POINT_HAS_INTENSITY);
    free(scan_fixture_points("u.xyz", "1 2 3 70000 9\n4 5 6 70001 7\n7 8 9 70002 8\n", &info));
    assert_int_equal(info.attributes, STP_POINT_HAS_INTENSITY);
    free(scan_fixture_points("v.xyz", "1 2 3 9 0\n4 5 6 7 1\n7 8 9 8 2\n", &info));
    assert_int_equal(info.attributes, 0); /* numbers of scan lines, perhaps */
    stp_point *points = scan_fixture_points("w.xyz", "1 2 3 0.5\n4 5 6 0.75\n7 8 9 1\n", &info);
    assert_int_equal(info.attributes, STP_POINT_HAS_INTENSITY); /* alone, it may rise */
    assert_int_equal(points[2].intensity, 65535);
    scan_fixture_position(&points[2], 7, 8, 9);
    free(points);
}

/* Long enough that the reader's block ends within. */
static void utf_16(void **state)
{
    (void)state;
    enum { LINES = 90000, BYTES = 2000000 };
    char *text = malloc(BYTES), *wide = malloc(2 * (size_t)BYTES + 2);
    assert_true(text && wide);
    for (int first = 0; first < 2; first++) { /* the high byte */
        int length = snprintf(text, BYTES, "x;y;h\xf6he\r\n");
        for (int i = 0; i < LINES; i++)
            length += snprintf(text + length, (size_t)(BYTES - length), "%d;1,5;%d\r\n", i, -i);
        wide[first] = (char)0xff;
        wide[1 - first] = (char)0xfe;
        for (int i = 0; i < length; i++) {
            wide[2 + 2 * i + first] = text[i];
            wide[3 + 2 * i - first] = 0;
        }
        stp_scan_info info;
        scan_fixture_bytes("wide.csv", wide, 2 * (size_t)length + 2);
        stp_point *points = scan_fixture_read("wide.csv", NULL, &info);
        assert_int_equal(info.point_count, LINES);
        for (int i = 0; i < LINES; i++)
            scan_fixture_position(&points[i], i, 1.5, -i);
        free(points);
    }
    scan_fixture_bytes("mesh.txt", "\xff\xfev\0 \0001\0 \0002\0 \0003\0\n", 18);
    scan_fixture_fails("mesh.txt", NULL, STP_UNSUPPORTED, "OBJ as text in UTF-16");
    free(text);
    free(wide);
}

/* Cells may be empty or say that there is no number, as tables of pandas and microscopes have them.
 */
static void missing_cells(void **state)
{
    (void)state;
    const char *const texts[] = {
        "x,y,z,i\n1.5,-2.25,3,1\n7,8,,2\n4,5,6.125,\n", "1.5,-2.25,3\n,,\n4,5,6.125\n",
        "x;y;z\n1,5;-2,25;3\n1;1;No Data\n4;5;6,125\n", "1.5 -2.25 3\n1 1 ***\n4 5 6.125\n",
        "1.5 -2.25 3\n1 NULL 1\n4 5 6.125\n",           "1.5\t-2.25\t3\n1\t1\tn/a\n4\t5\t6.125\n",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        stp_scan_info info;
        print_message("%s", texts[i]);
        stp_point *points = scan_fixture_points("missing.csv", texts[i], &info);
        assert_int_equal(info.point_count, 3);
        scan_fixture_position(&points[0], 1.5, -2.25, 3);
        assert_false(stp_dvec3_finite(points[1].position));
        scan_fixture_position(&points[2], 4, 5, 6.125);
        free(points);
    }
}

/* Reads 200 lines in which the letters A to F stand for the numbers i, i % 7, i * 31 % 256,
 * i * 17 % 256, i % 3 and i * 13 % 30 of line i. */
static void expect_order(const char *format, const char *order)
{
    static char text[32768];
    size_t used = 0;
    stp_error err = {0};
    stp_scan *scan = NULL;
    for (int i = 0; i < 200; i++)
        for (const char *at = format; *at; at++) {
            const int numbers[] = {i, i % 7, i * 31 % 256, i * 17 % 256, i % 3, i * 13 % 30};
            if (*at >= 'A' && *at <= 'F')
                used += (size_t)sprintf(text + used, "%d", numbers[*at - 'A']);
            else
                text[used++] = *at;
        }
    text[used] = '\0';
    scan_fixture_text("order.txt", text);
    assert_int_equal(stp_scan_open(&scan, "order.txt", NULL, &err), STP_OK);
    const stp_scan_note *note = &stp_scan_get_info(scan)->notes[0];
    if (strncmp(note->text, order, strlen(order)) != 0 || note->text[strlen(order)] != ' ')
        fail_msg("%s: %s, expected %s", format, note->text, order);
    stp_scan_close(&scan);
}

/* Classes, returns and flags beside intensities are no colours, and times no coordinates. */
static void numbers_without_names(void **state)
{
    (void)state;
    expect_order("A.5 B.25 C.5 D B\n", "x,y,z,intensity,class"); /* LAStools: xyzic */
    expect_order("A.5 B.25 C.5 D B E E\n", "x,y,z,intensity,_,_,_");
    expect_order("A.5 B.25 C.5 E B E\n", "x,y,z,_,_,_");
    expect_order("A.5 B.25 C.5 D C D B\n", "x,y,z,red,green,blue,class");
    expect_order("A.5 B.25 C.5 B\n", "x,y,z,class");
    expect_order("A.5 B.25 C.5 200 100 20\n", "x,y,z,red,green,blue");
    expect_order("A.5 B.25 C.5 C D F\n", "x,y,z,red,green,blue"); /* bricks */
    expect_order("A.5 B.25 C.5 F F F\n", "x,y,z,red,green,blue"); /* a dark room */
    expect_order("A.5 B.25 C.5 200 100 5\n", "x,y,z,red,green,blue");
    expect_order("A0 4100000 C.5 D.25 C.5 B\n", "x,y,z,_,_,class");
    expect_order("A.5 B.25 C.5 D 1 1\n", "x,y,z,intensity,_,_");
    expect_order("% x y z r g b\nA.5 B.25 C.5 D C D\n", "x,y,z,red,green,blue");
    expect_order("!X\tY\tZ\tcode\nA.5\tB.25\tC.5\tB\n", "x,y,z,_");
    expect_order("A.515625 B.25 C.5 B.125 D\n", "_,x,y,z,intensity");
    expect_order("A.515625 B.25 C.5 E\n", "x,y,z,class");
    expect_order("A.515625 0.5 C.5 B.125 D\n", "x,y,z,_,_");
    expect_order("A.515 B.25 C.5 B.125 D\n", "x,y,z,_,_");
}

/* CloudCompare writes names, then the number of points. */
static void names_before_a_number(void **state)
{
    (void)state;
    expect_two("a.txt", "//X Y Z R G B i\n2\n1.5 -2.25 3 1 2 3 9\n4 5 6.125 4 5 6 8\n",
               STP_POINT_HAS_COLOUR | STP_POINT_HAS_INTENSITY);
    expect_two("a.pts", "//X Y Z nx ny nz\n2\n1.5 -2.25 3 0 0 1\n4 5 6.125 0 1 0\n",
               STP_POINT_HAS_NORMAL);
    scan_fixture_text("cut.txt", "//X Y Z\n3\n1.5 -2.25 3\n4 5 6.125\n");
    scan_fixture_fails("cut.txt", NULL, STP_CORRUPT, "line 2 declares 3 points, but 2 follow");
}

/* What gdal2xyz writes where a grid has no sample. */
static void heights_that_are_none(void **state)
{
    (void)state;
    stp_scan_info info;
    stp_point *points = scan_fixture_points("none.xyz", "0 0 5\n1 0 -9999\n2 0 4.5\n", &info);
    assert_int_equal(points[0].reject, STP_REJECT_NONE);
    assert_int_equal(points[1].reject, STP_REJECT_INVALID);
    free(points);
    points = scan_fixture_points("deep.xyz", "0 0 5\n1 0 -9999\n2 0 -9998\n", &info);
    assert_int_equal(points[1].reject, STP_REJECT_NONE);
    free(points);
}

/* The first three columns of a matrix are no coordinates. */
static void matrices(void **state)
{
    (void)state;
    char text[2048] = "";
    for (int i = 0; i < 140; i++)
        sprintf(text + strlen(text), "%d.5%s", i, i % 70 == 69 ? "\n" : ",");
    scan_fixture_text("matrix.csv", text);
    scan_fixture_fails("matrix.csv", NULL, STP_UNSUPPORTED, "70 numbers, as a matrix of heights");
    const stp_scan_params params = {.columns = "x,y,z"};
    stp_scan_info info;
    free(scan_fixture_read("matrix.csv", &params, &info));
    assert_int_equal(info.point_count, 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(brackets),
        cmocka_unit_test(brackets_of_others),
        cmocka_unit_test(decimal_commas),
        cmocka_unit_test(times),
        cmocka_unit_test(utf_16),
        cmocka_unit_test(missing_cells),
        cmocka_unit_test(matrices),
        cmocka_unit_test(numbers_without_names),
        cmocka_unit_test(names_before_a_number),
        cmocka_unit_test(heights_that_are_none),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

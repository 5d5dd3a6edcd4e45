/* Tests LAS files that are cut, damaged or hostile: each must give one sentence that names the
 * place, and no crash. */
#include "tests/fixtures/scan/las_fixture.h"

#include <math.h>

/* A good file: LAS 1.4, format 7, coordinate systems before and after three points. */
static void good(las_file *f)
{
    las_begin(f, 4, 7, 36);
    las_add_vlr(f, "LASF_Projection", 2112, "WKT", 3);
    las_set_count(f, 3);
    for (int i = 0; i < 3; i++)
        las_put(f, las_add_point(f, i, 0, 0) + 30, 2, 4711);
    las_add_evlr(f, "LASF_Spec", 9, "data", 4);
}

enum {
    VLR = 375,
    POINTS = VLR + 54 + 3,
    EVLR = POINTS + 3 * 36,
    END = EVLR + 60 + 4,
};

static void a_good_file(void **state)
{
    (void)state;
    las_file f;
    stp_scan_info info;
    good(&f);
    assert_int_equal(f.size, END);
    las_save(&f, "good.las");
    free(scan_fixture_read("good.las", NULL, &info));
    assert_int_equal(info.point_count, 3);
}

typedef struct lie {
    size_t at, bytes;
    uint64_t value;
    stp_status status;
    const char *text;
} lie;

static void check(const lie *l)
{
    las_file f;
    good(&f);
    las_put(&f, l->at, l->bytes, l->value);
    las_save(&f, "lie.las");
    scan_fixture_fails("lie.las", NULL, l->status, l->text);
}

static void numbers_that_lie(void **state)
{
    (void)state;
    const lie lies[] = {
        {24, 1, 2, STP_VERSION, "byte 24 of the LAS header says version 2.4"},
        {25, 1, 6, STP_VERSION, "version 1.6"},
        {25, 1, 5, STP_CORRUPT, "expected at least 393 for LAS 1.5"},
        {94, 2, 374, STP_CORRUPT,
         "byte 94 of the LAS header gives a header size of 374, expected at least 375 for LAS 1.4"},
        {94, 2, 0, STP_CORRUPT, "header size of 0"},
        {94, 2, 65535, STP_CORRUPT, "ends at byte 604, within its LAS header of 65535 bytes"},
        {94, 2, END, STP_CORRUPT, "byte 96 of the LAS header gives the offset to the points"},
        {96, 4, 374, STP_CORRUPT,
         "byte 96 of the LAS header gives the offset to the points as 374, expected 375 (the "
         "header's end) to 604 (the file's)"},
        {96, 4, END + 1, STP_CORRUPT, "the offset to the points as 605"},
        {96, 4, 0xffffffff, STP_CORRUPT, "the offset to the points as 4294967295"},
        {96, 4, END, STP_CORRUPT,
         "declares 3 points, but the 0 bytes from byte 604 on hold 0: the file was cut"},
        {104, 1, 11, STP_UNSUPPORTED, "byte 104 of the LAS header says point format 11"},
        {104, 1, 0x3f, STP_UNSUPPORTED, "point format 63"},
        {104, 1, 10, STP_CORRUPT,
         "a record length of 36, expected at least 67 for point format 10"},
        {105, 2, 0, STP_CORRUPT,
         "byte 105 of the LAS header gives a record length of 0, expected at least 36 for point "
         "format 7"},
        {105, 2, 35, STP_CORRUPT, "a record length of 35"},
        {105, 2, 65535, STP_CORRUPT,
         "declares 3 points, but the 108 bytes from byte 432 on hold 0"},
        {247, 8, 4, STP_CORRUPT, "declares 4 points, but the 108 bytes from byte 432 on hold 3"},
        {247, 8, UINT64_MAX, STP_CORRUPT, "declares 18446744073709551615 points"},
        {247, 8, ((uint64_t)1 << 63) / 18 + 1, STP_CORRUPT, "points, but the 108 bytes"},
        {247, 8, 0, STP_CORRUPT,
         "declares no points, but the 108 bytes from byte 432 on would hold"},
        {100, 4, 2, STP_CORRUPT,
         "byte 432: the header of variable length record 2 of 2 needs 54 bytes, but there are 0 "
         "until byte 432, the points' begin"},
        {100, 4, 0xffffffff, STP_CORRUPT, "variable length record 2 of 4294967295"},
        {VLR + 20, 2, 4, STP_CORRUPT,
         "byte 429: the content of variable length record 1 of 1 needs 4 bytes, but there are 3"},
        {VLR + 20, 2, 65535, STP_CORRUPT, "needs 65535 bytes"},
        {235, 8, EVLR - 1, STP_CORRUPT, "declares 3 points, but the 107 bytes from byte 432 on"},
        {235, 8, 0, STP_CORRUPT,
         "byte 235 of the LAS header gives the offset to the extended records as 0, expected 432 "
         "(the points' begin) to 604 (the file's end)"},
        {235, 8, END + 1, STP_CORRUPT, "the offset to the extended records as 605"},
        {235, 8, UINT64_MAX, STP_CORRUPT, "as 18446744073709551615"},
        {235, 8, END, STP_CORRUPT, "the header of extended variable length record 1 of 1"},
        {243, 4, 2, STP_CORRUPT,
         "byte 604: the header of extended variable length record 2 of 2 needs 60 bytes, but there "
         "are 0 until byte 604, the file's end"},
        {EVLR + 20, 8, 5, STP_CORRUPT, "the content of extended variable length record 1 of 1"},
        {EVLR + 20, 8, UINT64_MAX, STP_CORRUPT, "needs 18446744073709551615 bytes"},
    };
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++)
        check(&lies[i]);
}

static void transforms(void **state)
{
    (void)state;
    const struct {
        size_t at;
        double value;
        const char *text;
    } cases[] = {
        {131, -INFINITY, "byte 131 of the LAS header gives x a scale of -inf"},
        {139, -1e300, "gives y an offset"},
        {147, NAN, "gives z a scale of"},
        {131, INFINITY, "gives x a scale of inf"},
        {131, 1e300, "with which (scale 1e+300) coordinates are not finite"},
        {155, NAN, "byte 155 of the LAS header gives x an offset of"},
        {163, INFINITY, "gives y an offset of inf"},
        {171, -INFINITY, "gives z an offset of -inf"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        las_file f;
        good(&f);
        las_put_double(&f, cases[i].at, cases[i].value);
        las_save(&f, "transform.las");
        scan_fixture_fails("transform.las", NULL, STP_CORRUPT, cases[i].text);
    }
}

/* Cuts after each byte: reading may never succeed, and the message must name the place. */
static void every_cut(void **state)
{
    (void)state;
    las_file f;
    good(&f);
    for (size_t size = 0; size < END; size++) {
        f.size = size;
        las_save(&f, "cut.las");
        if (size == 0)
            scan_fixture_fails("cut.las", NULL, STP_EMPTY, "0 bytes");
        else if (size < 4)
            scan_fixture_fails("cut.las", NULL, STP_FORMAT, "no known format");
        else if (size < 375)
            scan_fixture_fails("cut.las", NULL, STP_CORRUPT, "within its LAS header");
        else if (size < POINTS)
            scan_fixture_fails("cut.las", NULL, STP_CORRUPT, "the offset to the points as 432");
        else if (size < EVLR)
            scan_fixture_fails("cut.las", NULL, STP_CORRUPT, "declares 3 points");
        else
            scan_fixture_fails("cut.las", NULL, STP_CORRUPT, "extended");
    }
}

static void cut_points_are_counted(void **state)
{
    (void)state;
    las_file f;
    las_begin(&f, 2, 3, 34);
    las_set_count(&f, 10);
    for (int i = 0; i < 10; i++)
        las_add_point(&f, 0, 0, 0);
    f.size -= 34 * 2 + 1;
    las_save(&f, "short.las");
    scan_fixture_fails("short.las", NULL, STP_CORRUPT,
                       "declares 10 points, but the 271 bytes from byte 227 on hold 7");
}

/* An absurdly long record that the reader would keep, and one of the same length that it skips. */
static void long_records(void **state)
{
    (void)state;
    enum { LONG = 1 << 21 };
    las_file f;
    stp_scan_info info;
    for (int i = 0; i < 2; i++) {
        good(&f);
        if (i == 0) {
            memset(f.bytes + EVLR + 2, 0, 16);
            memcpy(f.bytes + EVLR + 2, "LASF_Projection", 15);
            memset(f.bytes + VLR + 2, 0, 16); /* otherwise the first record would count */
            las_put(&f, EVLR + 18, 2, 2112);
        }
        las_put(&f, EVLR + 20, 8, LONG);
        unsigned char *bytes = calloc(EVLR + 60 + LONG, 1);
        assert_non_null(bytes);
        memcpy(bytes, f.bytes, END);
        scan_fixture_bytes("long.las", bytes, EVLR + 60 + LONG);
        free(bytes);
        if (i == 0)
            scan_fixture_fails("long.las", NULL, STP_LIMIT, "a record of 2097152 bytes");
        else
            free(scan_fixture_read("long.las", NULL, &info));
    }
}

static void no_faces(void **state)
{
    (void)state;
    las_file f;
    const stp_scan_params params = {.sample_count = 10};
    good(&f);
    las_save(&f, "faces.las");
    scan_fixture_fails("faces.las", &params, STP_INVALID_ARGUMENT, "no faces");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_good_file),
        cmocka_unit_test(numbers_that_lie),
        cmocka_unit_test(transforms),
        cmocka_unit_test(every_cut),
        cmocka_unit_test(cut_points_are_counted),
        cmocka_unit_test(long_records),
        cmocka_unit_test(no_faces),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

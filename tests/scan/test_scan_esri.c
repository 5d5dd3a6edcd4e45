/* Tests what ESRI ASCII grids leave unsaid: that cells are degrees, and what commas are. */
#include "tests/fixtures/scan/scan_fixture.h"

/* ESRI grids name no system; seconds of arc are degrees, lengths are not. */
static void seconds_of_arc(void **state)
{
    (void)state;
    static const struct {
        const char *header;
        bool degrees;
    } cases[] = {
        {"xllcorner 7.5\nyllcorner 47\ncellsize 0.000277777778\n", true},
        {"xllcorner -70\nyllcorner -30,5\ncellsize 0,000833333333\n", true},
        {"xllcorner 8\nyllcorner 47\ncellsize 0.008333333333333333\n", true},
        {"xllcorner 8\nyllcorner 47\ncellsize 0.0000925925926\n", true},
        {"xllcorner 8\nyllcorner 47\ncellsize 0.01\n", false},
        {"xllcorner 8\nyllcorner 47\ncellsize 0.00025\n", false},
        {"xllcorner 8\nyllcorner 47\ncellsize 0.000283\n", false},
        {"xllcorner 0\nyllcorner 0\ncellsize 0.000277777778\n", false},
        {"xllcorner 500000\nyllcorner 5600000\ncellsize 0.000277777778\n", false},
        {"cellsize 0.000277777778\n", false},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char header[256];
        stp_scan_info info;
        snprintf(header, sizeof header, "ncols 3\nnrows 2\n%s1 2 3\n4 5 6\n", cases[i].header);
        free(scan_fixture_points("grid.asc", header, &info));
        print_message("%s", cases[i].header);
        assert_int_equal((info.attributes & STP_POINT_HAS_NORMAL) == 0, cases[i].degrees);
    }
}

/* Decimals after commas, as German programs write them. */
static void commas(void **state)
{
    (void)state;
    stp_scan_info info;
    stp_point *points = scan_fixture_points(
        "comma.asc", "ncols 2\nnrows 2\nxllcenter 1,5\nyllcenter 2\ncellsize 0,5\n1,25 2\n3 4,5\n",
        &info);
    scan_fixture_position(&points[0], 1.5, 2.5, 1.25);
    scan_fixture_position(&points[3], 2.0, 2.0, 4.5);
    free(points);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(seconds_of_arc),
        cmocka_unit_test(commas),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

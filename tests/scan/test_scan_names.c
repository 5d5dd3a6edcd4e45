/* Tests what PLY and PCD fields mean by their names, and the ranges of intensities. */
#include "tests/fixtures/scan/scan_fixture.h"

#include <math.h>

#define FIELDS 8

/* Reads two points with the fields, in PLY and in PCD. */
static void read_both(const char *const *fields, size_t count, const char *first,
                      const char *second, stp_point points[2][2], uint32_t attributes[2])
{
    char ply[1024] = "ply\nformat ascii 1.0\nelement vertex 2\n", pcd[1024] = "VERSION 0.7\nFIELDS";
    static const char *const lines[] = {"\nSIZE", "\nTYPE", "\nCOUNT"};
    static const char *const words[] = {" 4", " F", " 1"};
    for (size_t i = 0; i < count; i++) {
        sprintf(ply + strlen(ply), "property float %s\n", fields[i]);
        sprintf(pcd + strlen(pcd), " %s", fields[i]);
    }
    for (size_t k = 0; k < 3; k++) {
        sprintf(pcd + strlen(pcd), "%s", lines[k]);
        for (size_t i = 0; i < count; i++)
            sprintf(pcd + strlen(pcd), "%s", words[k]);
    }
    sprintf(ply + strlen(ply), "end_header\n%s\n%s\n", first, second);
    sprintf(pcd + strlen(pcd), "\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n%s\n%s\n", first,
            second);
    const struct {
        const char *name, *text;
    } files[2] = {{"names.ply", ply}, {"names.pcd", pcd}};
    for (size_t k = 0; k < 2; k++) {
        stp_scan_info info;
        stp_point *p = scan_fixture_points(files[k].name, files[k].text, &info);
        assert_int_equal(info.point_count, 2);
        memcpy(points[k], p, 2 * sizeof *p);
        attributes[k] = info.attributes;
        free(p);
    }
}

/* The names of intensities that scanners and their programs write. */
static void names_of_intensity(void **state)
{
    (void)state;
    static const char *const names[] = {
        "intensity", "scalar_Intensity", "reflectance", "Reflectivity", "scalar_Reflectance",
        "remission", "scalar_Amplitude", "gray",        "luminance"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        const char *const fields[] = {"x", "y", "z", names[i]};
        stp_point points[2][2];
        uint32_t attributes[2];
        read_both(fields, 4, "1 2 3 51", "4 5 6 255", points, attributes);
        for (size_t k = 0; k < 2; k++) {
            assert_int_equal(attributes[k], STP_POINT_HAS_INTENSITY);
            assert_int_equal(points[k][0].intensity, 51 * 257);
            assert_int_equal(points[k][1].intensity, 65535);
        }
    }
}

/* In a file with several names of the same meaning the preferred one is read, wherever it stands.
 */
static void preferred_names(void **state)
{
    (void)state;
    static const char *const fields[FIELDS] = {"height", "gray",      "x",     "y",
                                               "z",      "intensity", "label", "Classification"};
    stp_point points[2][2];
    uint32_t attributes[2];
    read_both(fields, FIELDS, "9 1 1 2 3 51 8 2", "9 1 4 5 6 255 8 6", points, attributes);
    for (size_t k = 0; k < 2; k++) {
        assert_int_equal(attributes[k], STP_POINT_HAS_INTENSITY | STP_POINT_HAS_CLASS);
        assert_true(points[k][1].position.z == 6);
        assert_int_equal(points[k][0].intensity, 51 * 257);
        assert_int_equal(points[k][1].class_id, 6);
    }
}

/* Decibels, and the 12 bits of Leica's scanners, reach below zero. */
static void negative_intensities(void **state)
{
    (void)state;
    static const struct {
        const char *first, *second;
        double low, high, values[2];
    } cases[] = {
        {"0 0 0 -21.5", "1 1 1 3.25", -21.5, 3.25, {-21.5, 3.25}},
        {"0 0 0 -1024", "1 1 1 512", -2048, 2047, {-1024, 512}},
        {"0 0 0 -5000", "1 1 1 70000", -5000, 70000, {-5000, 70000}},
        {"0 0 0 -2.5", "1 1 1 nan", -2.5, 0, {-2.5, -2.5}},
        {"0 0 0 1000", "1 1 1 131070", 0, 131070, {1000, 131070}},
    };
    static const char *const fields[] = {"x", "y", "z", "reflectance"};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        stp_point points[2][2];
        uint32_t attributes[2];
        read_both(fields, 4, cases[i].first, cases[i].second, points, attributes);
        for (size_t k = 0; k < 2; k++)
            for (size_t j = 0; j < 2; j++)
                assert_int_equal(points[k][j].intensity,
                                 lround((cases[i].values[j] - cases[i].low) * 65535.0 /
                                        (cases[i].high - cases[i].low)));
    }
}

/* Some programs name the element of vertices otherwise. */
static void elements_of_vertices(void **state)
{
    (void)state;
    static const char *const names[] = {"vertices", "point", "points"};
    char text[256];
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        stp_scan_info info;
        snprintf(text, sizeof text,
                 "ply\nformat ascii 1.0\nelement %s 1\nproperty float x\nproperty float y\n"
                 "property float z\nend_header\n1 2 3\n",
                 names[i]);
        stp_point *points = scan_fixture_points("named.ply", text, &info);
        assert_int_equal(info.point_count, 1);
        scan_fixture_position(&points[0], 1.0, 2.0, 3.0);
        free(points);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_of_intensity),
        cmocka_unit_test(preferred_names),
        cmocka_unit_test(negative_intensities),
        cmocka_unit_test(elements_of_vertices),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

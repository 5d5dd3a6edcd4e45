/* Tests real LAS files: counts and boxes against their own headers, which this test reads itself,
 * and against another reader's figures. Skips unless STIPPLE_SCANS names a folder of scans: the
 * project may not distribute them. */
#include "tests/fixtures/scan/las_fixture.h"

#include <math.h>

typedef struct real_las {
    const char *name, *format;
    uint64_t points;                      /* points and boxes: found by another reader */
    const char *wkt, *geokeys, *left_out; /* parts of notes, NULL: no such note */
    double min[3], max[3];
    unsigned rgb_8[3]; /* of the first point; all files have 8 bits, stored in either way */
    unsigned intensity, class_id;
    bool colour;
} real_las;

static const real_las scans[] = {
    {"autzen/autzen-10.65M-rgb-pf2.las",
     "LAS 1.2 point format 2",
     10653336,
     NULL,
     NULL,
     "point source ID",
     {635577.79, 848882.15, 406.14},
     {639003.73, 853537.66, 615.26},
     {133, 137, 97},
     33410,
     0,
     true},
    {"lidar/autzen_trim_7.las",
     "LAS 1.4 point format 7",
     110000,
     "PROJCS[\"NAD_1983_HARN_Lambert_Conformal_Conic\"",
     NULL,
     "scanner channel, scan angle, user data, point source ID, GPS time",
     {636001.76, 848935.2, 406.26},
     {637179.22, 849497.9, 520.51},
     {84, 102, 93},
     1028,
     1,
     true},
    {"tree/tls-spruce-83k.las",
     "LAS 1.2 point format 0",
     83392,
     NULL,
     NULL,
     "point source ID",
     {-1.2443, -1.242, -0.247043},
     {1.2457, 1.248, 16.692957},
     {0, 0, 0},
     0,
     0,
     false},
    {"odd/pdal_1.2-with-color.las",
     "LAS 1.2 point format 3",
     1065,
     NULL,
     NULL,
     "GPS time",
     {635619.85, 848899.7, 406.59},
     {638982.55, 853535.43, 586.38},
     {68, 77, 88},
     36751,
     1,
     true},
    {"odd/pdal_extrabytes.las",
     "LAS 1.4 point format 3",
     1065,
     NULL,
     NULL,
     "extra bytes (27 a point: Colors, Reserved, Flags, Intensity, Time)",
     {635619.85, 848899.7, 406.59},
     {638982.55, 853535.43, 586.38},
     {68, 77, 88},
     36751,
     1,
     true},
    {"odd/pdal_epsg_4326.las",
     "LAS 1.2 point format 0",
     5380,
     NULL,
     "GeographicTypeGeoKey=4326\nGeogCitationGeoKey=WGS 84\n",
     "point source ID",
     {-94.6834654, 31.0367341, 39.0810002},
     {-94.6606311, 31.0473291, 78.1190002},
     {0, 0, 0},
     65535,
     0,
     false},
    {"odd/pdal_no-points.las",
     "LAS 1.2 point format 3",
     0,
     NULL,
     "GeographicTypeGeoKey=4269\n",
     "GPS time",
     {0.0, 0.0, 0.0},
     {0.0, 0.0, 0.0},
     {0, 0, 0},
     0,
     0,
     false},
};

/* The content of the file's own header, read here by the standard's table. */
typedef struct own_header {
    uint64_t points;
    double scale[3], min[3], max[3];
} own_header;

static double double_at(const las_file *f, size_t at)
{
    const uint64_t bits = las_get(f, at, 8);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static own_header read_own(const char *path)
{
    las_file f = {0};
    own_header out = {0};
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_true(fread(f.bytes, 1, 375, file) == 375);
    fclose(file);
    out.points = f.bytes[25] >= 4 ? las_get(&f, 247, 8) : las_get(&f, 107, 4);
    for (size_t axis = 0; axis < 3; axis++) {
        out.scale[axis] = double_at(&f, 131 + 8 * axis);
        out.max[axis] = double_at(&f, 179 + 16 * axis);
        out.min[axis] = double_at(&f, 187 + 16 * axis);
    }
    return out;
}

static void check_box(const char *path, const stp_dbox *box, const double *min, const double *max,
                      const double *tolerance)
{
    const double low[3] = {box->min.x, box->min.y, box->min.z};
    const double high[3] = {box->max.x, box->max.y, box->max.z};
    for (int axis = 0; axis < 3; axis++)
        if (!(fabs(low[axis] - min[axis]) <= tolerance[axis] &&
              fabs(high[axis] - max[axis]) <= tolerance[axis]))
            fail_msg("%s: axis %d is %.12g to %.12g, expected %.12g to %.12g", path, axis,
                     low[axis], high[axis], min[axis], max[axis]);
}

static void check_note(const char *path, const char *name, const char *part)
{
    char text[4096];
    las_note(path, name, text, sizeof text);
    if (part ? !strstr(text, part) : text[0] != '\0')
        fail_msg("%s: note %s is `%s`, expected %s", path, name, text, part ? part : "none");
}

/* Checks points as they come, without keeping them. */
static void check_points(const real_las *expected, const char *path, const own_header *own)
{
    stp_error err = {0};
    stp_scan *scan = NULL;
    static stp_point points[4096];
    stp_dbox box = stp_dbox_empty();
    uint64_t total = 0;
    if (stp_scan_open(&scan, path, NULL, &err) != STP_OK)
        fail_msg("%s", err.message);
    const stp_scan_info *info = stp_scan_get_info(scan);
    assert_string_equal(info->format, expected->format);
    assert_int_equal((info->attributes & STP_POINT_HAS_COLOUR) != 0, expected->colour);
    assert_true(info->coordinate_step == fmin(own->scale[0], fmin(own->scale[1], own->scale[2])));
    for (size_t count = 1; count > 0; total += count) {
        if (stp_scan_read(scan, points, 4096, &count, &err) != STP_OK)
            fail_msg("%s", err.message);
        for (size_t i = 0; i < count; i++) {
            assert_int_equal(points[i].reject, STP_REJECT_NONE);
            stp_dbox_add(&box, points[i].position);
        }
        if (total == 0 && count > 0) {
            const unsigned *rgb = expected->rgb_8;
            scan_fixture_rgb(&points[0], rgb[0] * 257, rgb[1] * 257, rgb[2] * 257);
            scan_fixture_scalars(&points[0], expected->intensity, expected->class_id);
        }
    }
    stp_scan_close(&scan);
    assert_int_equal(total, expected->points);
    assert_int_equal(total, own->points);
    if (total > 0) {
        /* other programs wrote the headers from their own doubles */
        const double near[3] = {1e-6, 1e-6, 1e-6};
        check_box(path, &box, own->min, own->max, own->scale);
        check_box(path, &box, expected->min, expected->max, near);
    }
}

static void all_scans(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof scans / sizeof *scans; i++) {
        char path[4096];
        if (!scan_fixture_real(scans[i].name, path))
            continue;
        const own_header own = read_own(path);
        check_points(&scans[i], path, &own);
        check_note(path, "wkt", scans[i].wkt);
        check_note(path, "geokeys", scans[i].geokeys);
        check_note(path, "left_out", scans[i].left_out);
        check_note(path, "counts", NULL);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(all_scans)};
    if (!scan_fixture_has_real())
        return 77;
    return cmocka_run_group_tests(tests, NULL, NULL);
}

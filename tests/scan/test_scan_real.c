/* Tests real scans: counts, boxes, attributes. Skips unless STIPPLE_SCANS names a folder of scans:
 * the project may not distribute them. */
#include "tests/fixtures/scan/scan_fixture.h"

#include <math.h>

typedef struct real_scan {
    const char *name;
    uint64_t points, faces;
    uint32_t attributes;
    bool normals_from_faces;
    uint64_t not_finite;
    double min[3], max[3];
} real_scan;

static const real_scan scans[] = {
    {"stanford-dragon/dragon_vrip.ply",
     437645,
     871414,
     STP_POINT_HAS_NORMAL,
     true,
     0,
     {-0.108324, 0.0527295, -0.0504143},
     {0.0965662, 0.197173, 0.0412075}},
    {"stanford/bunny_raw10_362k_n_bigendian.ply",
     362272,
     0,
     STP_POINT_HAS_NORMAL,
     false,
     0,
     {-0.114276901, 0.0231542587, -0.0693002567},
     {0.0613698773, 0.187940001, 0.0591165163}},
    {"stanford/bun_zipper.ply",
     35947,
     69451,
     STP_POINT_HAS_NORMAL | STP_POINT_HAS_INTENSITY,
     true,
     0,
     {-0.0946899, 0.0329874, -0.0618736},
     {0.0610091, 0.187321, 0.0587997}},
    {"stanford/bun000.ply",
     40256,
     0,
     0,
     false,
     0,
     {-0.09475, 0.0357363, -0.0586982},
     {0.061, 0.18794, 0.0587228}},
    {"lion/lion_takanawa_342k_rgb_n.ply",
     341989,
     0,
     STP_POINT_HAS_NORMAL | STP_POINT_HAS_COLOUR,
     false,
     0,
     {-4.98500013, 1.03900003, -3.44499993},
     {-0.789000134, 6.72350001, 1.12350004}},
    {"objects/armadillo.obj",
     43243,
     86482,
     STP_POINT_HAS_NORMAL,
     true,
     0,
     {-0.435275, -0.573402, -0.379481},
     {0.403342, 0.426549, 0.38333}},
    {"meshlab-rangemaps/lato315.ply",
     62702,
     120995,
     STP_POINT_HAS_NORMAL | STP_POINT_HAS_STATION,
     true,
     0,
     {-80.3301239, -75.5983734, -854.662109},
     {79.2648773, 55.968998, -750.438232}},
    {"lidar/CSite2_orig-utm.pcd",
     486800,
     0,
     0,
     false,
     0,
     {513449.688, 5402650, 248.410004},
     {513870.312, 5403283, 482.630005}},
    {"open3d/fragment.pcd",
     113662,
     0,
     STP_POINT_HAS_NORMAL | STP_POINT_HAS_COLOUR,
     false,
     0,
     {1.15198874, 0.815272868, 0.726409078},
     {3.51953125, 2.76171875, 1.53042805}},
    {"grids/milk_cartoon_all_small_clorox.pcd",
     307200,
     0,
     STP_POINT_HAS_COLOUR,
     false,
     65793,
     {-1.06079996, -0.869233429, 0.500999987},
     {1.15249395, 0.219668597, 2.06299996}},
    {"odd/ColouredCubeFloat.e57",
     7680,
     0,
     STP_POINT_HAS_COLOUR,
     false,
     0,
     {-0.5, -0.5, -0.5},
     {0.5, 0.5, 0.5}},
    {"odd/bunny_nan_inf_dup.ply",
     42947,
     0,
     0,
     false,
     300,
     {-0.0946898982, 0.0329874009, -0.0618735999},
     {0.0610091016, 0.187321007, 0.0587996989}},
    {"odd/pdal_autzen.pts",
     10,
     0,
     STP_POINT_HAS_COLOUR | STP_POINT_HAS_INTENSITY,
     false,
     0,
     {636102.840012, 848968.800003, 427.919998},
     {636126.400009, 849345.199997, 512.139999}},
    {"odd/pdal_simple_binary.ply", 3, 0, 0, false, 0, {-1, 0, 0}, {1, 1, 0}},
    {"odd/pdal_simple_text.ply", 3, 0, 0, false, 0, {-1, 0, 0}, {1, 1, 0}},
    {"tree/eztree_oak_large.obj",
     30104,
     22566,
     STP_POINT_HAS_NORMAL,
     false,
     0,
     {-49.93116, 0, -44.82801},
     {47.86684, 102.02321, 53.87133}},
};

static void check_near(const char *name, double value, double expected)
{
    if (!(fabs(value - expected) <= 1e-8 * fmax(fabs(expected), 1.0)))
        fail_msg("%s: box has %.17g, expected %.17g", name, value, expected);
}

static void check_scan(const real_scan *expected, const char *path)
{
    stp_scan_info info;
    stp_point *points = scan_fixture_read(path, NULL, &info);
    stp_dbox box = stp_dbox_empty();
    uint64_t not_finite = 0;
    for (uint64_t i = 0; i < info.point_count; i++) {
        if (stp_dvec3_finite(points[i].position))
            stp_dbox_add(&box, points[i].position);
        else
            not_finite++;
    }
    free(points);
    assert_int_equal(info.point_count, expected->points);
    assert_int_equal(info.face_count, expected->faces);
    assert_int_equal(info.attributes, expected->attributes);
    assert_int_equal(info.normals_from_faces, expected->normals_from_faces);
    assert_int_equal(not_finite, expected->not_finite);
    check_near(path, box.min.x, expected->min[0]);
    check_near(path, box.min.y, expected->min[1]);
    check_near(path, box.min.z, expected->min[2]);
    check_near(path, box.max.x, expected->max[0]);
    check_near(path, box.max.y, expected->max[1]);
    check_near(path, box.max.z, expected->max[2]);
}

static void all_scans(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof scans / sizeof *scans; i++) {
        char path[4096];
        if (scan_fixture_real(scans[i].name, path))
            check_scan(&scans[i], path);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(all_scans)};
    if (!scan_fixture_has_real())
        return 77;
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Tests the normals of a noisy statue of 1 M samples, k = 16, against the true ones: they must be
 * at least as good as CGAL's on the same points. Skips without CGAL. */
#include "tests/fixtures/surface_fixture.h"

#ifdef WITH_CGAL
#include "tools/bench/cgal/cgal_shim.h"

#include <string.h>

enum { NEIGHBOURS = 16 };

static double cgal_mean_error(const surface_cloud *s)
{
    size_t count = s->cloud.count;
    double(*positions)[3] = calloc(count, sizeof *positions);
    double(*normals)[3] = calloc(count, sizeof *normals);
    double sum = 0.0;
    assert_true(positions && normals);
    for (size_t i = 0; i < count; i++)
        memcpy(positions[i], &s->cloud.points[i].position, sizeof positions[i]);
    assert_int_equal(cgal_pca_normals((const double(*)[3])positions, count, NEIGHBOURS, normals),
                     0);
    for (size_t i = 0; i < count; i++) {
        stp_dvec3 truth = stp_dvec3_from_float(s->truth[s->cloud.points[i].source].normal);
        sum += acos(fmin(1.0, fabs(normals[i][0] * truth.x + normals[i][1] * truth.y +
                                   normals[i][2] * truth.z))) *
               180.0 / M_PI;
    }
    free(positions);
    free(normals);
    return sum / (double)count;
}

static void no_worse_than_cgal(void **state)
{
    (void)state;
    surface_cloud s = surface_scan(GEN_STATUE, 1000000u, 0.1, 0);
    surface_prepare(&s, NEIGHBOURS);
    double ours = surface_mean_error(&s), cgal = cgal_mean_error(&s);
    print_message("mean error of the normals: stipple %.3f, CGAL %.3f degrees\n", ours, cgal);
    assert_true(cgal > 0.1);
    assert_true(ours <= cgal);
    surface_clear(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(no_worse_than_cgal)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
#else
int main(void)
{
    return 77;
}
#endif

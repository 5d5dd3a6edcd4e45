/* Tests that points scattered in a volume get small spacings beside a surface, and that all other
 * points keep theirs. */
#include "base/random.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/surface/scattered.h"
#include "preprocess/surface/surface.h"
#include "tests/fixtures/cloud_fixture.h"

#include <math.h>

#define SURFACE 40000u
#define FLOATERS 2000u
#define COUNT (SURFACE + FLOATERS)

static stp_dvec3 random_place(uint32_t i)
{
    return (stp_dvec3){stp_random_unit(1, i), stp_random_unit(2, i), stp_random_unit(3, i)};
}

/* A place on a cube of side 1 at the origin. */
static stp_dvec3 cube_place(uint32_t i)
{
    stp_dvec3 p = random_place(i);
    double *const axes[] = {&p.x, &p.y, &p.z};
    *axes[i % 3] = i / 3 % 2;
    return p;
}

/* Finds spacings, then limits them. before: by source, the spacings that were found; free it with
 * free(). */
static float *limit(stp_cloud *cloud)
{
    stp_pool *pool = NULL;
    stp_error err = {0};
    stp_graph *none = NULL;
    const stp_surface_params params = {.k = 16};
    float *before = calloc(cloud->count, sizeof *before);
    assert_non_null(before);
    assert_int_equal(stp_pool_create(&pool, 2, &err), STP_OK);
    assert_int_equal(stp_cloud_sort(cloud, pool, &err), STP_OK);
    assert_int_equal(stp_surface_find(&none, cloud, &params, NULL, pool, NULL, &err), STP_OK);
    for (uint32_t i = 0; i < cloud->count; i++)
        before[cloud->points[i].source] = cloud->points[i].spacing;
    assert_int_equal(stp_scattered_limit(cloud, &err), STP_OK);
    stp_pool_destroy(&pool);
    return before;
}

/* A plane of side 1, and floaters in the unit cube above it. given: normals are given, as files of
 * photogrammetry have them. The plane's spacing is 1/200. */
static void floaters_above_a_plane(void **state)
{
    (void)state;
    for (int given = 0; given < 2; given++) {
        stp_cloud cloud = cloud_fixture_make(COUNT);
        for (uint32_t i = 0; i < COUNT; i++) {
            cloud.points[i].position = random_place(i);
            if (i < SURFACE)
                cloud.points[i].position.z = 0.001 * stp_random_unit(4, i);
            cloud.points[i].given = given ? STP_GIVEN_INPUT : STP_GIVEN_NOT;
            cloud.points[i].normal.z = given ? 1.0f : 0.0f;
        }
        float *before = limit(&cloud);
        double plates = 0.0, area = 0.0;
        for (uint32_t i = 0; i < COUNT; i++) {
            const stp_cloud_point *p = &cloud.points[i];
            if (p->source < SURFACE) {
                assert_true(p->spacing == before[p->source] && p->spacing < 0.01f);
                continue;
            }
            assert_true(p->spacing <= before[p->source]);
            plates += before[p->source] * before[p->source];
            area += p->spacing * p->spacing;
        }
        /* They hid the plane several times over. */
        assert_true(plates > 5.0);
        assert_true(area < 0.5);
        free(before);
        stp_cloud_clear(&cloud);
    }
}

/* So few floaters in a dense cube that most of their neighbours are on its faces: whoever stands
 * inside has them before his eyes. */
static void few_floaters_within_a_room(void **state)
{
    (void)state;
    const uint32_t floaters = 40;
    stp_cloud cloud = cloud_fixture_make(COUNT);
    double plates = 0.0, area = 0.0;
    for (uint32_t i = 0; i < COUNT; i++)
        cloud.points[i].position = i < COUNT - floaters ? cube_place(i) : random_place(i);
    float *before = limit(&cloud);
    for (uint32_t i = 0; i < COUNT; i++) {
        const stp_cloud_point *p = &cloud.points[i];
        if (p->source < COUNT - floaters) {
            assert_true(p->spacing == before[p->source]);
            continue;
        }
        plates += before[p->source] * before[p->source];
        area += p->spacing * p->spacing;
    }
    if (area > 0.5 * plates)
        fail_msg("discs of %g where %g stood before", area, plates);
    free(before);
    stp_cloud_clear(&cloud);
}

/* Where a cube has six times as wide spacings as another one, only points at its corners get
 * smaller ones, one in 30, and in a cloud that is scattered as a whole none does. */
static void surfaces_and_volumes_stay(void **state)
{
    (void)state;
    for (int volume = 0; volume < 2; volume++) {
        stp_cloud cloud = cloud_fixture_make(COUNT);
        uint32_t changed = 0;
        for (uint32_t i = 0; i < COUNT; i++)
            cloud.points[i].position = volume ? random_place(i) : cube_place(i);
        for (uint32_t i = SURFACE; i < COUNT && !volume; i++)
            cloud.points[i].position =
                stp_dvec3_scale(stp_dvec3_add(cube_place(i), (stp_dvec3){2.0, 0.0, 0.0}), 1.3);
        float *before = limit(&cloud);
        for (uint32_t i = 0; i < COUNT; i++)
            changed += cloud.points[i].spacing != before[cloud.points[i].source];
        if (changed > (volume ? 0 : FLOATERS / 30))
            fail_msg("%u spacings changed (volume %d)", changed, volume);
        free(before);
        stp_cloud_clear(&cloud);
    }
}

/* Too few points for a surface are dots. */
static void few_points_are_dots(void **state)
{
    (void)state;
    for (uint32_t count = 2; count <= STP_SCATTERED_FEW + 1; count++) {
        stp_cloud cloud = cloud_fixture_make(count);
        for (uint32_t i = 0; i < count; i++)
            cloud.points[i].position = (stp_dvec3){i, i % 2, 0};
        float *before = limit(&cloud);
        const float part = count <= STP_SCATTERED_FEW ? STP_SCATTERED_FEW_PART : 1.0f;
        for (uint32_t i = 0; i < count; i++)
            assert_true(cloud.points[i].spacing == part * before[cloud.points[i].source]);
        free(before);
        stp_cloud_clear(&cloud);
    }
}

/* One point, and all at one place. */
static void odd_clouds(void **state)
{
    (void)state;
    for (uint32_t count = 1; count <= 1000; count *= 10) {
        stp_cloud cloud = cloud_fixture_make(count);
        float *before = limit(&cloud);
        for (uint32_t i = 0; i < count; i++)
            assert_true(cloud.points[i].spacing == 0.0f);
        free(before);
        stp_cloud_clear(&cloud);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(floaters_above_a_plane),
        cmocka_unit_test(few_floaters_within_a_room),
        cmocka_unit_test(surfaces_and_volumes_stay),
        cmocka_unit_test(few_points_are_dots),
        cmocka_unit_test(odd_clouds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

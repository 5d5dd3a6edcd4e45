/* Tests joining layers: points move onto the surface that their layers share, against known
 * surfaces. */
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/surface/join_layers.h"
#include "tests/fixtures/cloud_fixture.h"
#include "tests/fixtures/size.h"
#include "tests/fixtures/surface_fixture.h"

#include <string.h>

#define NEIGHBOURS 16u
#define POINTS TEST_SIZE(200000u, 60000u)

static stp_joined_layers join(surface_cloud *s, uint32_t unit_points)
{
    stp_error err = {0};
    stp_joined_layers joined;
    const stp_surface_params params = {.k = NEIGHBOURS, .unit_points = unit_points};
    assert_int_equal(stp_layers_join(&joined, &s->cloud, &params, s->pool, NULL, &err), STP_OK);
    return joined;
}

/* The root mean square of the points' distances from the true surface, in mean spacings. */
static double height_of(const surface_cloud *s)
{
    double sum = 0.0, spacing = 0.0;
    for (uint32_t i = 0; i < s->cloud.count; i++) {
        const stp_cloud_point *p = &s->cloud.points[i];
        const gen_hit *hit = &s->truth[p->source];
        double height = stp_dvec3_dot(stp_dvec3_sub(p->position, hit->position),
                                      stp_dvec3_from_float(hit->normal));
        sum += height * height;
        spacing += (double)p->spacing;
    }
    return sqrt(sum / (double)s->cloud.count) / (spacing / (double)s->cloud.count);
}

static void check_noise(gen_shape shape, double noise, double most)
{
    surface_cloud s = surface_scan(shape, POINTS, noise, 0);
    surface_prepare(&s, NEIGHBOURS);
    double before = height_of(&s), normals = surface_mean_error(&s);
    stp_joined_layers joined = join(&s, 0);
    surface_cloud found = {.cloud = s.cloud, .truth = s.truth};
    stp_error err = {0};
    stp_graph *none = NULL;
    const stp_surface_params params = {.k = NEIGHBOURS};
    assert_int_equal(stp_surface_find(&none, &s.cloud, &params, NULL, s.pool, NULL, &err), STP_OK);
    found.cloud = s.cloud;
    double after = height_of(&found), joined_normals = surface_mean_error(&found);
    print_message("shape %d, noise %.2f: %.3f -> %.3f spacings off, normals %.2f -> %.2f degrees; "
                  "moved %.3g at most, %.3g on average\n",
                  (int)shape, noise, before, after, normals, joined_normals, joined.greatest,
                  joined.mean);
    assert_true(after <= most * before);
    assert_true(joined_normals <= 1.05 * normals);
    surface_clear(&s);
}

static void noise_goes(void **state)
{
    (void)state;
    check_noise(GEN_SPHERE, 0.3, 0.4);
    check_noise(GEN_BUMPY, 0.3, 0.4);
    check_noise(GEN_TORUS, 0.3, 0.6);
}

/* Points of a smooth surface without noise must stay. */
static void true_points_stay(void **state)
{
    (void)state;
    static const gen_shape shapes[] = {GEN_SPHERE, GEN_TORUS, GEN_TERRAIN};
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        surface_cloud s = surface_scan(shapes[i], POINTS, 0.0, 0);
        surface_prepare(&s, NEIGHBOURS);
        double spacing = 0.0;
        for (uint32_t p = 0; p < s.cloud.count; p++)
            spacing += (double)s.cloud.points[p].spacing / (double)s.cloud.count;
        stp_joined_layers joined = join(&s, 0);
        print_message("shape %d moved by %.4f, at most %.4f spacings\n", (int)shapes[i],
                      joined.mean / spacing, joined.greatest / spacing);
        assert_true(joined.mean <= 0.02 * spacing);
        surface_clear(&s);
    }
}

/* Two scans of one surface; the second is off by a part of the spacing. */
static void two_scans_become_one(void **state)
{
    (void)state;
    surface_cloud s = surface_scan(GEN_SPHERE, POINTS, 0.0, 0);
    surface_prepare(&s, NEIGHBOURS);
    for (uint32_t i = 0; i < s.cloud.count; i++) {
        stp_cloud_point *p = &s.cloud.points[i];
        if (p->source % 2 == 0)
            p->position = stp_dvec3_scale(p->position, 1.0 + 0.5 * (double)p->spacing);
    }
    double before = height_of(&s);
    stp_error err = {0};
    stp_cloud_unsort(&s.cloud);
    assert_int_equal(stp_cloud_sort(&s.cloud, s.pool, &err), STP_OK);
    join(&s, 0);
    /* the joined surface lies between the two, a quarter of a spacing from the first */
    double inner = 0.0, outer = 0.0, count = 0.0;
    for (uint32_t i = 0; i < s.cloud.count; i++) {
        const stp_cloud_point *p = &s.cloud.points[i];
        double r = stp_dvec3_length(p->position);
        *(p->source % 2 == 0 ? &outer : &inner) += r;
        count += 0.5;
    }
    double gap = (outer - inner) / count, were = before * sqrt(2.0);
    double spacing = 0.0;
    for (uint32_t i = 0; i < s.cloud.count; i++)
        spacing += (double)s.cloud.points[i].spacing / (double)s.cloud.count;
    print_message("layers %.3f -> %.3f spacings apart\n", were, gap / spacing);
    assert_true(gap <= 0.1 * were * spacing);
    surface_clear(&s);
}

/* Units of any size must give the same result, and every point must still be there. */
static void units_agree(void **state)
{
    (void)state;
    surface_cloud a = surface_scan(GEN_BUMPY, POINTS, 0.3, 0);
    surface_cloud b = surface_scan(GEN_BUMPY, POINTS, 0.3, 0);
    surface_prepare(&a, NEIGHBOURS);
    surface_prepare(&b, NEIGHBOURS);
    stp_joined_layers one = join(&a, 0), other = join(&b, POINTS);
    assert_memory_equal(&one, &other, sizeof one);
    assert_int_equal(a.cloud.count, b.cloud.count);
    uint64_t sum = 0;
    for (uint32_t i = 0; i < a.cloud.count; i++) {
        const stp_cloud_point *p = &a.cloud.points[i], *q = &b.cloud.points[i];
        assert_int_equal(p->source, q->source);
        assert_memory_equal(&p->position, &q->position, sizeof p->position);
        sum += p->source;
    }
    assert_int_equal(sum, (uint64_t)POINTS * (POINTS - 1) / 2);
    surface_clear(&a);
    surface_clear(&b);
}

/* Points at one place, points on a line, too few points. */
static void nothing_to_join(void **state)
{
    (void)state;
    for (uint32_t count = 0; count < 40; count += 13) {
        surface_cloud s = {.cloud = cloud_fixture_make(count)};
        for (uint32_t i = 0; i < count; i++)
            s.cloud.points[i].position.x = i % 2 ? 1.0 : 0.5 * (count > 20 ? i : 0);
        surface_prepare(&s, NEIGHBOURS);
        stp_joined_layers joined = join(&s, 0);
        assert_true(joined.greatest == 0.0 && joined.mean == 0.0);
        assert_int_equal(s.cloud.count, count);
        surface_clear(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_goes),           cmocka_unit_test(true_points_stay),
        cmocka_unit_test(two_scans_become_one), cmocka_unit_test(units_agree),
        cmocka_unit_test(nothing_to_join),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

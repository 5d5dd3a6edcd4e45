/* Tests normals of noisy surfaces against the true ones, by the mean angle and the 95th percentile.
 *
 * For the bumpy ball, the bounds are what a second-order fit over 32 neighbours reaches (CGAL's
 * jets). For the box, whose edges must stay, and the statue, whose folds are narrower than its
 * spacing, they are what plane fits over the 16 nearest points reached before planes grew.
 *
 * The test judges two or fewer noises of each surface; with the argument --every, as in
 * long_prep_normals_every, all of them. */
#include "base/random.h"
#include "base/sort.h"
#include "tests/fixtures/surface_fixture.h"

#include <string.h>

enum { COUNT = 250000, NEIGHBOURS = 16 };

static bool every_noise;

typedef struct bounds {
    double noise, mean_deg, most_deg; /* most_deg: 95th percentile */
} bounds;

static void judge(surface_cloud *s, const char *name, bounds b)
{
    const uint32_t count = (uint32_t)s->cloud.count;
    double *errors = calloc(count, sizeof *errors);
    assert_non_null(errors);
    surface_prepare(s, NEIGHBOURS);
    for (uint32_t i = 0; i < count; i++) {
        const stp_cloud_point *p = &s->cloud.points[i];
        double cosine = fabs((double)glms_vec3_dot(p->normal, s->truth[p->source].normal));
        errors[i] = acos(fmin(1.0, cosine)) * 180.0 / M_PI;
    }
    stp_sort_doubles(errors, count);
    double mean = surface_mean_error(s), most = errors[count / 20 * 19];
    print_message("%s, noise %.1f: mean %.3f (at most %.3f), 95 in a hundred within %.3f (%.3f)\n",
                  name, b.noise, mean, b.mean_deg, most, b.most_deg);
    assert_true(mean <= b.mean_deg && most <= b.most_deg);
    free(errors);
    surface_clear(s);
}

/* The six faces of a cube, with noise along their normals. */
static surface_cloud box_scan(double noise)
{
    surface_cloud s = {.cloud = {.count = COUNT, .capacity = COUNT}};
    const double sigma = noise * sqrt(6.0 / COUNT);
    s.truth = calloc(COUNT, sizeof *s.truth);
    s.cloud.points = calloc(COUNT, sizeof *s.cloud.points);
    assert_true(s.truth && s.cloud.points);
    for (uint32_t i = 0; i < COUNT; i++) {
        const unsigned face = i % 6, axis = face / 2;
        const double side = face % 2 ? 0.5 : -0.5;
        const double normal =
            sqrt(-2.0 * log(1.0 - stp_random_unit(1, i))) * cos(2.0 * M_PI * stp_random_unit(2, i));
        double p[3];
        p[axis] = side + sigma * normal;
        p[(axis + 1) % 3] = stp_random_unit(3, i) - 0.5;
        p[(axis + 2) % 3] = stp_random_unit(4, i) - 0.5;
        s.truth[i].normal.raw[axis] = side > 0.0 ? 1.0f : -1.0f;
        s.cloud.points[i] = (stp_cloud_point){.position = {p[0], p[1], p[2]}, .source = i};
    }
    return s;
}

static void bumpy_ball(void **state)
{
    (void)state;
    const bounds all[] = {{0.0, 0.34, 0.81}, {0.1, 0.85, 1.69}, {0.3, 1.8, 4.9}, {0.6, 3.3, 6.6}};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        if (!every_noise && i % 2 == 0)
            continue;
        surface_cloud s = surface_scan(GEN_BUMPY, COUNT, all[i].noise, 0);
        judge(&s, "bumpy", all[i]);
    }
}

static void box_with_edges(void **state)
{
    (void)state;
    const bounds all[] = {{0.0, 0.853, 1.55}, {0.1, 1.77, 2.90}, {0.3, 3.92, 8.36}};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        if (!every_noise && i == 1)
            continue;
        surface_cloud s = box_scan(all[i].noise);
        judge(&s, "box", all[i]);
    }
}

static void statue_with_folds(void **state)
{
    (void)state;
    const bounds all[] = {{0.0, 12.21, 51.2}, {0.1, 12.78, 52.8}, {0.3, 16.03, 61.7}};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        if (!every_noise && i != 2)
            continue;
        surface_cloud s = surface_scan(GEN_STATUE, COUNT, all[i].noise, 0);
        judge(&s, "statue", all[i]);
    }
}

/* Gives the points their true normals, turned by about deviation_deg. */
static void give_normals(surface_cloud *s, double deviation_deg)
{
    for (uint32_t i = 0; i < s->cloud.count; i++) {
        stp_cloud_point *p = &s->cloud.points[i];
        const double size =
            sqrt(-2.0 * log(1.0 - stp_random_unit(21, i))) * tan(deviation_deg * M_PI / 180.0);
        const double angle = 2.0 * M_PI * stp_random_unit(22, i);
        const vec3s n = glms_vec3_normalize(s->truth[p->source].normal);
        const vec3s u = glms_vec3_normalize(glms_vec3_ortho(n)), w = glms_vec3_cross(n, u);
        const vec3s off = glms_vec3_add(glms_vec3_scale(u, (float)(size * cos(angle))),
                                        glms_vec3_scale(w, (float)(size * sin(angle))));
        p->given = STP_GIVEN_INPUT;
        p->normal = glms_vec3_normalize(glms_vec3_add(n, off));
    }
}

/* Normals from the input: true ones stay, whatever the noise of the positions; noisy ones are
 * averaged. */
static void given_normals(void **state)
{
    (void)state;
    for (int i = 0; i < 5; i++) {
        if (!every_noise && i % 2 != 0)
            continue;
        surface_cloud s = i < 2   ? surface_scan(GEN_BUMPY, COUNT, 0.3 * i, 0)
                          : i < 4 ? surface_scan(GEN_STATUE, COUNT, 0.1 * (i - 2), 0)
                                  : box_scan(0.3);
        give_normals(&s, 0.0);
        surface_prepare(&s, NEIGHBOURS);
        for (uint32_t p = 0; p < COUNT; p++) {
            const vec3s truth = s.truth[s.cloud.points[p].source].normal;
            const vec3s n = glms_vec3_normalize(truth);
            assert_true(glms_vec3_distance(s.cloud.points[p].normal, n) < 1e-6f);
        }
        surface_clear(&s);
    }
    surface_cloud s = surface_scan(GEN_BUMPY, COUNT, 0.3, 0);
    give_normals(&s, 8.0);
    const double before = surface_mean_error(&s);
    surface_prepare(&s, NEIGHBOURS);
    const double after = surface_mean_error(&s);
    print_message("given normals: %.2f degrees off, averaged %.2f\n", before, after);
    assert_true(before > 8.0 && after < 0.5 * before);
    surface_clear(&s);
}

int main(int argc, char **argv)
{
    every_noise = argc > 1 && strcmp(argv[1], "--every") == 0;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bumpy_ball), cmocka_unit_test(box_with_edges),
        cmocka_unit_test(statue_with_folds), cmocka_unit_test(given_normals)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

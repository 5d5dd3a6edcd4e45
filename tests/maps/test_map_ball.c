/* Tests the smallest ball around points against all balls through pairs, triples and quadruples,
 * and the cone of normals against that ball and against the corners of its hull. */
#include "base/random.h"
#include "preprocess/maps/parts/ball.h"
#include "preprocess/maps/parts/normal_cone.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>

#define COUNT 14u

static stp_dvec3 at(const vec3s *points, size_t i)
{
    return stp_dvec3_from_float(points[i]);
}

static double reach(const vec3s *points, size_t count, stp_dvec3 centre)
{
    double most = 0.0;
    for (size_t i = 0; i < count; i++)
        most = fmax(most, stp_dvec3_length(stp_dvec3_sub(at(points, i), centre)));
    return most;
}

/* The point in the plane of three points that is equally far from all. Solved by bisectors, unlike
 * the code that is tested. */
static bool bisect(stp_dvec3 a, stp_dvec3 b, stp_dvec3 c, stp_dvec3 *out)
{
    const stp_dvec3 u = stp_dvec3_sub(b, a), v = stp_dvec3_sub(c, a);
    const double uu = stp_dvec3_dot(u, u), uv = stp_dvec3_dot(u, v), vv = stp_dvec3_dot(v, v);
    const double det = uu * vv - uv * uv;
    if (!(fabs(det) > 1e-12 * uu * vv))
        return false;
    const double s = 0.5 * vv * (uu - uv) / det, t = 0.5 * uu * (vv - uv) / det;
    *out = stp_dvec3_add(a, stp_dvec3_add(stp_dvec3_scale(u, s), stp_dvec3_scale(v, t)));
    return true;
}

/* The centre of four points' sphere: from the middle of three along their normal. */
static bool sphere(const vec3s *p, const size_t i[4], stp_dvec3 *out)
{
    stp_dvec3 middle;
    const stp_dvec3 a = at(p, i[0]), b = at(p, i[1]), c = at(p, i[2]), d = at(p, i[3]);
    if (!bisect(a, b, c, &middle))
        return false;
    const stp_dvec3 n =
        stp_dvec3_normalize(stp_dvec3_cross(stp_dvec3_sub(b, a), stp_dvec3_sub(c, a)));
    const stp_dvec3 far = stp_dvec3_sub(d, middle), near = stp_dvec3_sub(a, middle);
    const double height = stp_dvec3_dot(far, n);
    if (!(fabs(height) > 1e-9))
        return false;
    const double along = (stp_dvec3_dot(far, far) - stp_dvec3_dot(near, near)) / (2.0 * height);
    *out = stp_dvec3_add(middle, stp_dvec3_scale(n, along));
    return true;
}

/* The least radius of all balls through two, three or four of the points that hold all of them. */
static double by_force(const vec3s *p, size_t count)
{
    double least = reach(p, count, at(p, 0));
    size_t i[4];
    stp_dvec3 centre;
    for (i[0] = 0; i[0] < count; i[0]++)
        for (i[1] = i[0] + 1; i[1] < count; i[1]++) {
            centre = stp_dvec3_scale(stp_dvec3_add(at(p, i[0]), at(p, i[1])), 0.5);
            least = fmin(least, reach(p, count, centre));
            for (i[2] = i[1] + 1; i[2] < count; i[2]++) {
                if (bisect(at(p, i[0]), at(p, i[1]), at(p, i[2]), &centre))
                    least = fmin(least, reach(p, count, centre));
                for (i[3] = i[2] + 1; i[3] < count; i[3]++)
                    if (sphere(p, i, &centre))
                        least = fmin(least, reach(p, count, centre));
            }
        }
    return least;
}

static float random_side(uint64_t seed, uint64_t i)
{
    return (float)(2.0 * stp_random_unit(seed, i) - 1.0);
}

/* Points of several kinds: anywhere, on a sphere, in a cap of it, on a line, few different ones,
 * nearly equal ones. */
static vec3s point_of(unsigned kind, uint64_t seed, uint64_t i)
{
    vec3s p = {
        {random_side(seed, 3 * i), random_side(seed, 3 * i + 1), random_side(seed, 3 * i + 2)}};
    if (kind == 1)
        return glms_vec3_normalize(p);
    if (kind == 2)
        return glms_vec3_normalize((vec3s){{p.x, p.y, 1.5f}});
    if (kind == 3)
        return (vec3s){{p.x, 2.0f * p.x, -p.x}};
    if (kind == 4)
        return (vec3s){{roundf(p.x), roundf(p.y), roundf(p.z)}};
    if (kind == 5)
        return (vec3s){{1.0f + 1e-6f * p.x, 1.0f + 1e-6f * p.y, 1.0f}};
    return p;
}

static void test_smallest(void **state)
{
    (void)state;
    for (unsigned round = 0; round < 120; round++) {
        vec3s points[COUNT];
        const size_t count = 1 + round % COUNT;
        for (size_t i = 0; i < count; i++)
            points[i] = point_of(round % 6, round, i);
        const stp_smallest_ball ball = stp_ball_around(points, count);
        const double least = by_force(points, count), most = reach(points, count, ball.centre);
        if (most > ball.radius || ball.radius > least * (1.0 + 1e-7) + 1e-12)
            fail_msg("round %u: radius %.12g, reaches %.12g, by force %.12g", round, ball.radius,
                     most, least);
    }
}

/* Many points, so that pivoting takes several passes: the ball of a sphere's points is the sphere,
 * and that of a cap is as wide as the cap. */
static void test_many(void **state)
{
    enum { MANY = 20000 };
    vec3s *points = malloc(MANY * sizeof *points);
    (void)state;
    assert_non_null(points);
    for (uint64_t i = 0; i < MANY; i++)
        points[i] = point_of(1, 9, i);
    stp_smallest_ball ball = stp_ball_around(points, MANY);
    assert_true(fabs(ball.radius - 1.0) < 1e-3);
    for (uint64_t i = 0; i < MANY; i++) { /* within 30 degrees of x */
        const double a = M_PI / 6.0 * (double)i / MANY, b = 3.0 * (double)i;
        points[i] = (vec3s){{(float)cos(a), (float)(sin(a) * cos(b)), (float)(sin(a) * sin(b))}};
    }
    ball = stp_ball_around(points, MANY);
    assert_true(fabs(ball.radius - 0.5) < 1e-3);
    const stp_normal_cone cone = stp_normal_cone_of(points, MANY);
    assert_true(cone.axis.x > 0.99999);
    assert_true(fabs(acos(cone.cosine) - M_PI / 6.0) < 2e-3);
    free(points);
}

static void test_corners(void **state)
{
    (void)state;
    for (unsigned round = 0; round < 40; round++) {
        enum { NORMALS = 500 };
        vec3s normals[NORMALS], *corners = NULL;
        uint32_t count = 0;
        stp_error err = {0};
        const uint32_t all = round == 0 ? 1 : round == 1 ? 2 : NORMALS;
        for (uint32_t i = 0; i < all; i++)
            normals[i] = point_of(2, round, round == 2 ? 0 : i);
        const stp_normal_cone cone = stp_normal_cone_of(normals, all);
        assert_int_equal(stp_normal_cone_corners(normals, all, &cone, &corners, &count, &err),
                         STP_OK);
        assert_true(count >= 1 && count <= all && (all < NORMALS || count < 60));
        const stp_normal_cone same = stp_normal_cone_of(corners, count);
        assert_true(fabs(same.cosine - cone.cosine) < 1e-6);
        assert_true(stp_dvec3_dot(same.axis, cone.axis) > 1.0 - 1e-9);
        free(corners);
    }
}

static void test_no_cone(void **state)
{
    const vec3s both[] = {{{1.0f, 0.0f, 0.0f}}, {{-1.0f, 0.0f, 0.0f}}};
    const stp_normal_cone cone = stp_normal_cone_of(both, 2);
    (void)state;
    assert_true(cone.cosine == -1.0);
    assert_true(stp_dvec3_length(cone.axis) == 0.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_smallest),
        cmocka_unit_test(test_many),
        cmocka_unit_test(test_corners),
        cmocka_unit_test(test_no_cone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

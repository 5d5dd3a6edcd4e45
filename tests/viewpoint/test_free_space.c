/* Tests rays through free space: leaps must end where steps of half a voxel end, to the last bit.
 */
#include "preprocess/viewpoint/free_space.h"

#include "base/random.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

enum { COUNT = 3000, RAYS = 20000 };

static double unit(unsigned seed, size_t i)
{
    return stp_random_unit(seed, i);
}

/* A hollow ball, a box without a lid, and a wavy ground. */
static stp_dvec3 point(int shape, size_t i)
{
    const double x = 2.0 * unit(1, i) - 1.0, y = 2.0 * unit(2, i) - 1.0, z = 2.0 * unit(3, i) - 1.0;
    if (shape == 0)
        return stp_dvec3_normalize((stp_dvec3){x, y, z});
    if (shape == 2)
        return (stp_dvec3){5e5 + x, y, 0.2 * sin(3.0 * x)};
    const stp_dvec3 faces[] = {{-1.0, y, z}, {1.0, y, z}, {x, -1.0, z}, {x, 1.0, z}, {x, y, -1.0}};
    return faces[i % 5];
}

/* One step after the other. */
static stp_space_hit step_cast(const stp_space *s, stp_dvec3 from, stp_dvec3 direction)
{
    stp_space_hit hit = {0};
    for (double d = 0.0; !hit.solid; d += 0.5 * s->side) {
        const stp_dvec3 at = stp_dvec3_add(from, stp_dvec3_scale(direction, d));
        const stp_dvec3 v = stp_dvec3_scale(stp_dvec3_sub(at, s->origin), 1.0 / s->side);
        if (!(v.x >= 0.0 && v.y >= 0.0 && v.z >= 0.0 && v.x < s->size[0] && v.y < s->size[1] &&
              v.z < s->size[2]))
            break;
        hit.distance = d;
        hit.voxel = stp_space_at(s, (int)v.x, (int)v.y, (int)v.z);
        hit.solid = s->count[hit.voxel] > 0;
    }
    return hit;
}

/* Middles of voxels, corners of voxels, anywhere, a little outside. */
static stp_dvec3 begin(const stp_space *s, size_t i)
{
    double at[3];
    for (int axis = 0; axis < 3; axis++) {
        const double v = s->size[axis] * (1.02 * unit(4u + (unsigned)axis, i) - 0.01);
        at[axis] = i % 3 == 0 ? floor(v) + 0.5 : i % 3 == 1 ? floor(v) : v;
    }
    return stp_dvec3_add(s->origin, stp_dvec3_scale((stp_dvec3){at[0], at[1], at[2]}, s->side));
}

static void leaps_are_steps(void **state)
{
    (void)state;
    static const stp_dvec3 axes[] = {{1.0, 0.0, 0.0}, {0.0, -1.0, 0.0}, {0.0, 0.0, 1.0}};
    for (int shape = 0; shape < 3; shape++) {
        stp_cloud cloud = {.count = COUNT, .capacity = COUNT};
        stp_space s;
        size_t solid = 0;
        cloud.points = calloc(COUNT, sizeof *cloud.points);
        assert_non_null(cloud.points);
        for (size_t i = 0; i < COUNT; i++)
            cloud.points[i].position = point(shape, i);
        assert_int_equal(stp_space_create(&s, &cloud, 0, NULL, NULL), STP_OK);
        for (size_t i = 0; i < RAYS; i++) {
            const stp_dvec3 from = begin(&s, i);
            const stp_dvec3 way =
                i % 4 == 0 ? axes[i / 4 % 3] : stp_space_direction((int)(i % 997), 997);
            const stp_space_hit a = step_cast(&s, from, way), b = stp_space_cast(&s, from, way);
            assert_true(a.solid == b.solid && a.distance == b.distance && a.voxel == b.voxel);
            solid += a.solid;
        }
        assert_true(solid > RAYS / 20 && solid < RAYS - RAYS / 20);
        stp_space_clear(&s);
        free(cloud.points);
    }
}

/* The cost from a voxel to a point: steps along one, two and three axes cost 8, 11 and 14. */
static int cost(const stp_space *s, const int at[3], stp_dvec3 point)
{
    const stp_dvec3 v = stp_dvec3_scale(stp_dvec3_sub(point, s->origin), 1.0 / s->side);
    const int off[3] = {abs(at[0] - (int)v.x), abs(at[1] - (int)v.y), abs(at[2] - (int)v.z)};
    int most = off[0] > off[1] ? off[0] : off[1];
    most = off[2] > most ? off[2] : most;
    return 8 * most + 3 * (off[0] + off[1] + off[2] - most);
}

static void room_is_the_least_cost(void **state)
{
    (void)state;
    stp_cloud_point two[2] = {{.position = {0.0, 0.0, 0.0}}, {.position = {1.0, 0.7, 0.4}}};
    const stp_cloud cloud = {.points = two, .count = 2, .capacity = 2};
    stp_space s;
    assert_int_equal(stp_space_create(&s, &cloud, 0, NULL, NULL), STP_OK);
    int at[3];
    for (at[2] = 0; at[2] < s.size[2]; at[2]++)
        for (at[1] = 0; at[1] < s.size[1]; at[1]++)
            for (at[0] = 0; at[0] < s.size[0]; at[0]++) {
                const int a = cost(&s, at, two[0].position), b = cost(&s, at, two[1].position);
                assert_int_equal(s.room[stp_space_at(&s, at[0], at[1], at[2])], a < b ? a : b);
            }
    stp_space_clear(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(leaps_are_steps),
                                       cmocka_unit_test(room_is_the_least_cost)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

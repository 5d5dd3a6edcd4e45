/* Tests the tree of boxes over runs of points: searches must miss nothing. */
#include "base/random.h"
#include "preprocess/cloud/box_tree.h"
#include "preprocess/cloud/cloud_cells.h"
#include "tests/fixtures/cloud_fixture.h"

#define NEIGHBOURS 12u

static void sort(stp_cloud *cloud)
{
    stp_pool *pool = NULL;
    assert_int_equal(stp_pool_create(&pool, 2, NULL), STP_OK);
    assert_int_equal(stp_cloud_sort(cloud, pool, NULL), STP_OK);
    stp_pool_destroy(&pool);
}

/* Compares with a search of all points, one by one. */
static void check_nearest(const stp_cloud *cloud, uint32_t self)
{
    stp_nearest_list expected = {.capacity = NEIGHBOURS}, found = {.capacity = NEIGHBOURS};
    stp_nearest_list bounded = {.capacity = NEIGHBOURS};
    for (uint32_t i = 0; i < cloud->count; i++) {
        stp_dvec3 d = stp_dvec3_sub(cloud->points[i].position, cloud->points[self].position);
        double squared = stp_dvec3_dot(d, d);
        if (squared == 0.0 || stp_cloud_repeats(cloud, i))
            continue;
        stp_nearest_list_insert(&expected, squared, i, cloud->points[i].source);
        if (i % 3 == 0) /* begins with a few in the list */
            stp_nearest_list_insert(&bounded, squared, i, cloud->points[i].source);
    }
    stp_box_tree_nearest(cloud, self, &found);
    stp_box_tree_nearest(cloud, self, &bounded);
    assert_int_equal(found.count, expected.count);
    assert_int_equal(bounded.count, expected.count);
    for (unsigned i = 0; i < expected.count; i++) {
        assert_int_equal(found.place[i], expected.place[i]);
        assert_int_equal(bounded.place[i], expected.place[i]);
    }
}

typedef struct seen {
    const stp_cloud *cloud;
    stp_dbox box;
    uint64_t next;
    uint32_t inside, visits, most;
} seen;

static bool meets(void *context, const stp_dbox *box)
{
    return stp_dbox_meet(&((seen *)context)->box, box);
}

static bool visit(void *context, uint64_t begin, uint64_t end)
{
    seen *s = context;
    assert_true(begin >= s->next && end > begin && end <= s->cloud->count);
    s->next = end;
    for (uint64_t i = begin; i < end; i++) {
        stp_dbox point = {s->cloud->points[i].position, s->cloud->points[i].position};
        s->inside += stp_dbox_meet(&s->box, &point);
    }
    return ++s->visits < s->most;
}

/* Every point inside a box must lie in a visited leaf. */
static void check_walk(const stp_cloud *cloud, stp_dbox box)
{
    seen s = {.cloud = cloud, .box = box, .most = UINT32_MAX};
    uint32_t inside = 0;
    for (uint32_t i = 0; i < cloud->count; i++) {
        stp_dbox point = {cloud->points[i].position, cloud->points[i].position};
        inside += stp_dbox_meet(&box, &point);
    }
    assert_true(stp_box_tree_walk(cloud, meets, visit, &s));
    assert_int_equal(s.inside, inside);
    seen one = {.cloud = cloud, .box = box, .most = 1};
    assert_int_equal(stp_box_tree_walk(cloud, meets, visit, &one), s.visits == 0);
    assert_int_equal(one.visits, s.visits > 0);
}

static void check(stp_cloud *cloud, uint32_t stride)
{
    sort(cloud);
    for (uint32_t i = 0; i < cloud->count; i += stride)
        check_nearest(cloud, i);
    for (unsigned i = 0; i < 5 && cloud->count > 0; i++) {
        stp_dvec3 p = cloud->points[(uint64_t)cloud->count * i / 5].position;
        stp_dvec3 size = {0.1 * i, 0.2 * i, 0.1};
        check_walk(cloud, (stp_dbox){stp_dvec3_sub(p, size), stp_dvec3_add(p, size)});
    }
    stp_cloud_clear(cloud);
}

/* Sizes around the number of points in a leaf and in a node. */
static void all_sizes(void **state)
{
    (void)state;
    const uint32_t counts[] = {0, 1, 2, 13, 255, 256, 257, 4096, 4097, 70000};
    for (size_t n = 0; n < sizeof counts / sizeof *counts; n++) {
        stp_cloud cloud = cloud_fixture_make(counts[n]);
        for (uint32_t i = 0; i < cloud.count; i++)
            cloud.points[i].position = (stp_dvec3){stp_random_unit(1, i), stp_random_unit(2, i),
                                                   i % 5 ? 0.0 : 9.0 * stp_random_unit(3, i)};
        check(&cloud, counts[n] / 40 + 1);
    }
}

/* Thousands of points at each of a few places, and ties between all of them. */
static void piles(void **state)
{
    (void)state;
    stp_cloud cloud = cloud_fixture_make(40000);
    for (uint32_t i = 0; i < cloud.count; i++)
        cloud.points[i].position = (stp_dvec3){i % 3, i / 3 % 3, i % 1000 == 0 ? 1.0 : 0.0};
    check(&cloud, 997);
    cloud = cloud_fixture_make(5000); /* a single place has no neighbours */
    check(&cloud, 499);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(all_sizes), cmocka_unit_test(piles)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

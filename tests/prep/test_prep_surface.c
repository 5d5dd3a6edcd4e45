/* Tests that the results of units equal those of the whole cloud at once, found with one index over
 * all points. */
#include "base/random.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/cloud/nearest_list.h"
#include "preprocess/cloud/place_list.h"
#include "preprocess/surface/normals.h"
#include "preprocess/surface/spacing.h"
#include "tests/fixtures/cloud_fixture.h"
#include "tests/fixtures/surface_fixture.h"

#include <string.h>

static bool every; /* with the argument --every, as in long_prep_surface: larger clouds */

static uint32_t size_of(uint32_t whole, uint32_t part)
{
    return every ? whole : part;
}

#define NEIGHBOURS 16u

/* A copy of the results and the graphs. */
typedef struct findings {
    stp_cloud_point *points;
    uint32_t *sheets;
    uint8_t *marks;
    stp_graph *graphs;
} findings;

static void *copy_of(const void *array, size_t bytes)
{
    void *copy = malloc(bytes);
    assert_non_null(copy);
    memcpy(copy, array, bytes);
    return copy;
}

static findings find(stp_cloud *cloud, stp_pool *pool, uint32_t unit_points)
{
    stp_error err = {0};
    findings f = {0};
    const stp_dvec3 station = {0.0, 0.0, 3.0};
    const stp_surface_params params = {
        .k = NEIGHBOURS, .pieces = true, .stations = &station, .unit_points = unit_points};
    assert_int_equal(stp_surface_find(&f.graphs, cloud, &params, NULL, pool, NULL, &err), STP_OK);
    f.points = copy_of(cloud->points, cloud->count * sizeof *f.points);
    f.sheets = copy_of(cloud->sheets, cloud->count * sizeof *f.sheets);
    f.marks = copy_of(cloud->marks, cloud->count * sizeof *f.marks);
    return f;
}

static void findings_clear(findings *f, const stp_cloud *cloud)
{
    free(f->points);
    free(f->sheets);
    free(f->marks);
    stp_surface_clear(&f->graphs, cloud);
}

static void assert_same_graph(const stp_graph *a, const stp_graph *b)
{
    assert_int_equal(a->piece_count, b->piece_count);
    assert_int_equal(a->edge_count, b->edge_count);
    assert_int_equal(a->kept_count, b->kept_count);
    for (size_t e = 0; e < a->edge_count; e++) {
        assert_int_equal(a->edges[e].own, b->edges[e].own);
        assert_int_equal(a->edges[e].other, b->edges[e].other);
        assert_int_equal(a->edges[e].rank, b->edges[e].rank);
        assert_int_equal(a->edges[e].turned, b->edges[e].turned);
        assert_int_equal(a->edges[e].narrow, b->edges[e].narrow);
    }
    if (a->kept_count == 0)
        return;
    assert_memory_equal(a->kept, b->kept, a->kept_count * sizeof *a->kept);
    const uint8_t *a_list = a->lists, *b_list = b->lists;
    for (uint32_t i = 0; i < a->kept_count; i++) {
        uint64_t a_places[NEIGHBOURS], b_places[NEIGHBOURS];
        a_list = stp_place_list_next(a_list, a->kept[i], NEIGHBOURS, a_places);
        b_list = stp_place_list_next(b_list, b->kept[i], NEIGHBOURS, b_places);
        assert_memory_equal(a_places, b_places, sizeof a_places);
    }
}

/* Runs each cell alone, some together, and all at once; takes the cloud. */
static void check_units(stp_cloud *cloud)
{
    stp_pool *pool = NULL;
    stp_error err = {0};
    assert_int_equal(stp_pool_create(&pool, 3, &err), STP_OK);
    assert_int_equal(stp_cloud_sort(cloud, pool, &err), STP_OK);
    assert_true(cloud->cell_count > 2);
    findings all = find(cloud, pool, UINT32_MAX);
    const uint32_t sizes[] = {0, (uint32_t)cloud->count / 2};
    for (size_t i = 0; i < 2; i++) {
        findings some = find(cloud, pool, sizes[i]);
        assert_memory_equal(some.points, all.points, cloud->count * sizeof *all.points);
        assert_memory_equal(some.sheets, all.sheets, cloud->count * sizeof *all.sheets);
        assert_memory_equal(some.marks, all.marks, cloud->count);
        for (uint32_t c = 0; c < cloud->cell_count; c++)
            assert_same_graph(&some.graphs[c], &all.graphs[c]);
        findings_clear(&some, cloud);
    }
    findings_clear(&all, cloud);
    stp_cloud_clear(cloud);
    stp_pool_destroy(&pool);
}

static void units_of_a_surface(void **state)
{
    (void)state;
    surface_cloud s = surface_scan(GEN_STATUE, size_of(250000, 150000), 0.2, every ? 2 : 0);
    for (uint32_t i = 0; i < s.cloud.count; i++)
        s.cloud.points[i].station = i % 3 != 0;
    check_units(&s.cloud);
    free(s.truth);
}

/* Leaves in a volume: rings have half as many points as a cell. */
static void units_of_a_volume(void **state)
{
    (void)state;
    stp_cloud cloud = cloud_fixture_make(size_of(200000, 140000));
    for (uint32_t i = 0; i < cloud.count; i++)
        cloud.points[i].position =
            (stp_dvec3){stp_random_unit(1, i), stp_random_unit(2, i), stp_random_unit(3, i)};
    check_units(&cloud);
}

/* A dense plate, a sparse one across it, repeated places, and a few far points. */
static void units_of_uneven_density(void **state)
{
    (void)state;
    stp_cloud cloud = cloud_fixture_make(size_of(220000, 150000));
    for (uint32_t i = 0; i < cloud.count; i++) {
        uint32_t j = i % 7 == 0 ? i / 2 : i;
        double u = stp_random_unit(1, j), v = stp_random_unit(2, j);
        cloud.points[i].position = (stp_dvec3){0.02 * u, 0.02 * v, 0.0};
        if (j % 10 == 0)
            cloud.points[i].position = (stp_dvec3){0.001, 4.0 * u - 2.0, 4.0 * v - 2.0};
        if (j % 20000 == 0)
            cloud.points[i].position = (stp_dvec3){500.0 * u, 700.0 * v, 900.0};
    }
    check_units(&cloud);
}

/* More points at one place than a cell holds, among others. */
static void units_of_a_pile(void **state)
{
    (void)state;
    stp_cloud cloud = cloud_fixture_make(size_of(200000, 150000));
    for (uint32_t i = 0; i < cloud.count; i++)
        if (i % 3 == 0)
            cloud.points[i].position =
                (stp_dvec3){stp_random_unit(1, i) - 0.5, stp_random_unit(2, i) - 0.5, 0.0};
    check_units(&cloud);
}

/* Fills lists with the test's own index over all points: searches in floats, decides in doubles. */
static void index_all(stp_unit *out, const stp_cloud *cloud)
{
    enum { ASKED = 3 * NEIGHBOURS };
    uint32_t count = (uint32_t)cloud->count;
    float *points = calloc(count, 3 * sizeof *points);
    *out = (stp_unit){.whole = cloud,
                      .cloud = {.count = count, .capacity = count},
                      .neighbours = {.k = NEIGHBOURS},
                      .ring_count = STP_UNIT_RINGS};
    out->cloud.points = calloc(count, sizeof *out->cloud.points);
    out->neighbours.indices = calloc((size_t)count * NEIGHBOURS, sizeof(uint32_t));
    assert_true(points && out->cloud.points && out->neighbours.indices);
    for (uint32_t i = 0; i < count; i++) {
        out->cloud.points[i].position = cloud->points[i].position;
        points[3 * i] = (float)cloud->points[i].position.x;
        points[3 * i + 1] = (float)cloud->points[i].position.y;
        points[3 * i + 2] = (float)cloud->points[i].position.z;
    }
    for (unsigned r = 0; r <= STP_UNIT_RINGS; r++)
        out->ring_end[r] = count;
    stp_kd_tree *tree = stp_kd_tree_create(points, count);
    assert_non_null(tree);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t found[ASKED];
        float squared[ASKED];
        stp_nearest_list list = {.capacity = NEIGHBOURS};
        assert_true(stp_kd_tree_nearest(tree, points + 3 * i, ASKED, found, squared));
        for (unsigned n = 0; n < ASKED; n++) {
            const stp_cloud_point *p = &cloud->points[found[n]];
            stp_dvec3 d = stp_dvec3_sub(p->position, cloud->points[i].position);
            if (found[n] != i)
                stp_nearest_list_insert(&list, stp_dvec3_dot(d, d), found[n], p->source);
        }
        for (unsigned n = 0; n < NEIGHBOURS; n++)
            out->neighbours.indices[(size_t)i * NEIGHBOURS + n] = (uint32_t)list.place[n];
        out->cloud.points[i].spacing =
            (float)sqrt(list.squared[NEIGHBOURS - 1] * M_PI / NEIGHBOURS);
    }
    stp_kd_tree_destroy(tree);
    free(points);
}

/* Every normal must be within a tenth of a degree of one global index's result, and every spacing
 * (so every radius) within a thousandth. */
static void as_by_one_index(void **state)
{
    (void)state;
    stp_error err = {0};
    surface_cloud s = surface_scan(GEN_STATUE, size_of(300000, 150000), 0.1, 0);
    stp_unit all;
    stp_normal_errors errors = {{0}};
    surface_prepare(&s, NEIGHBOURS);
    index_all(&all, &s.cloud);
    assert_int_equal(stp_normals_estimate(&all, NULL, &errors, &err), STP_OK);
    double worst_cosine = 1.0, worst_spacing = 0.0;
    for (uint32_t i = 0; i < s.cloud.count; i++) {
        const stp_cloud_point *p = &s.cloud.points[i], *q = &all.cloud.points[i];
        double cosine = stp_dvec3_dot(stp_dvec3_normalize(stp_dvec3_from_float(p->normal)),
                                      stp_dvec3_normalize(stp_dvec3_from_float(q->normal)));
        worst_cosine = fmin(worst_cosine, fabs(cosine));
        worst_spacing = fmax(worst_spacing, fabs((double)p->spacing / (double)q->spacing - 1.0));
    }
    print_message("at most %.4f degrees and %.4f %% of the spacing apart\n",
                  acos(fmin(1.0, worst_cosine)) * 180.0 / M_PI, 100.0 * worst_spacing);
    assert_true(worst_cosine >= cos(0.1 * M_PI / 180.0));
    assert_true(worst_spacing <= 0.001);
    stp_unit_clear(&all);
    surface_clear(&s);
}

int main(int argc, char **argv)
{
    every = argc > 1 && strcmp(argv[1], "--every") == 0;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(units_of_a_surface),      cmocka_unit_test(units_of_a_volume),
        cmocka_unit_test(units_of_uneven_density), cmocka_unit_test(units_of_a_pile),
        cmocka_unit_test(as_by_one_index),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Tests that verify accepts what prep writes: small random mixtures, through prep and as trees of
 * small chunks. long_prep_mixtures.c tries larger ones. */
#include "preprocess/cloud/cloud_cells.h"
#include "tests/fixtures/mixture_fixture.h"
#include "tests/fixtures/size.h"

#include "preprocess/surface/surface.h"

#include <unistd.h>

#define OUT "test_prep_mixtures.stipple"

enum { MIXTURES = TEST_SIZE(50, 20), EXTREMES = TEST_SIZE(80, 40), TREES = TEST_SIZE(30, 10) };

static void small_mixtures_are_sound(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= MIXTURES; seed++) {
        if (!mixture_wanted(seed))
            continue;
        mixture m = mixture_make(seed, 1.0, 2000.0);
        mixture_try(&m, OUT);
    }
}

static void extreme_numbers_are_sound_or_refused(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= EXTREMES; seed++) {
        if (!mixture_wanted(seed))
            continue;
        mixture m = mixture_make_extreme(seed, -40.0, seed % 2 ? 15.0 : 20.0);
        m.params.outliers = STP_OUTLIERS_KEEP; /* otherwise all may be dropped */
        mixture_try(&m, OUT);
    }
}

/* A leaf with one far point among others: its patch vertex's lattice is coarser than the leaf is
 * wide. */
static void surveys_are_sound(void **state)
{
    (void)state;
    for (uint64_t seed = 4; seed <= 5; seed++) {
        if (!mixture_wanted(seed))
            continue;
        mixture m = mixture_make_survey(seed, 200000, 100);
        mixture_try(&m, OUT);
    }
}

static void points_at_one_place_are_sound(void **state)
{
    (void)state;
    mixture m = {.words = "all points at four places", .size = 1.0};
    m.cloud = prep_cloud_make(70000);
    for (size_t i = 0; i < m.cloud.count; i++)
        m.cloud.points[i].position = (stp_dvec3){5e5 + (double)(i % 4), 4e6, i % 4 == 2};
    mixture_try(&m, OUT);
}

/* ---- trees of small chunks ---- */

/* Sorts the points into cells of cell_points. */
static stp_cloud cloud_of(const mixture *m, uint32_t cell_points, stp_pool *pool)
{
    stp_error err = {0};
    stp_cloud cloud;
    assert_int_equal(stp_cloud_create(&cloud, 0, m->cloud.count, NULL, &err), STP_OK);
    for (size_t i = 0; i < m->cloud.count; i++) {
        const stp_point *p = &m->cloud.points[i];
        cloud.points[cloud.count++] = (stp_cloud_point){.position = p->position,
                                                        .normal = p->normal,
                                                        .source = (uint32_t)i,
                                                        .rgb = {p->rgb[0], p->rgb[1], p->rgb[2]},
                                                        .class_id = p->class_id};
    }
    assert_int_equal(stp_cloud_sort(&cloud, pool, &err), STP_OK);
    free(cloud.cells);
    cloud.cell_count = (uint32_t)((cloud.count + cell_points - 1) / cell_points);
    cloud.cells = calloc(cloud.cell_count, sizeof *cloud.cells);
    assert_non_null(cloud.cells);
    for (uint32_t c = 0; c < cloud.cell_count; c++) {
        const uint64_t begin = (uint64_t)c * cell_points, left = cloud.count - begin;
        const uint64_t count = left < cell_points ? left : cell_points;
        cloud.cells[c] =
            (stp_cell){begin, begin + count, stp_points_box(cloud.points + begin, count)};
    }
    return cloud;
}

static char *no_metadata(void *context, const stp_tree_stats *stats)
{
    (void)context;
    (void)stats;
    return strdup("{}");
}

static void write_small_tree(const mixture *m, uint32_t cell_points)
{
    stp_error err = {0};
    stp_pool *pool = NULL;
    stp_graph *graphs = NULL;
    stp_chunk_writer *writer = NULL;
    stp_tree_stats stats;
    stp_orientation found;
    const double lambda = m->params.lambda > 0.0 ? m->params.lambda : 1.7;
    const stp_surface_params surface = {.k = 8, .pieces = true};
    const stp_orient_params orient = {.mode = STP_ORIENT_PROPAGATE};
    const stp_chunk_writer_params out = {.force = true,
                                         .codec = m->params.codec,
                                         .attributes = STP_HAS_COLOUR | STP_HAS_FITS,
                                         .lambda = lambda};
    const stp_tree_params tree = {.lambda = lambda,
                                  .resolution = {.precision = m->params.precision},
                                  .codec = m->params.codec};
    assert_int_equal(stp_pool_create(&pool, 2, &err), STP_OK);
    stp_cloud cloud = cloud_of(m, cell_points, pool);
    assert_int_equal(stp_surface_find(&graphs, &cloud, &surface, NULL, pool, NULL, &err), STP_OK);
    assert_int_equal(stp_orientation_find(&cloud, 8, &graphs, &orient, pool, &found, &err), STP_OK);
    stp_surface_clear(&graphs, &cloud);
    assert_int_equal(stp_chunk_writer_create(&writer, OUT, &out, &err), STP_OK);
    if (stp_tree_write(&writer, &cloud, &tree, no_metadata, NULL, pool, NULL, &stats, &err) !=
        STP_OK)
        fail_msg("mixture %" PRIu64 " (%s): %s", m->seed, m->words, err.message);
    stp_cloud_clear(&cloud);
    stp_pool_destroy(&pool);
}

/* Three tiers of points that prep would put into one chunk. */
static void deep_trees_are_sound(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= TREES; seed++) {
        if (!mixture_wanted(seed))
            continue;
        mixture m = mixture_make(seed, 100.0, 1000.0);
        write_small_tree(&m, 1 + (uint32_t)(m.cloud.count / (2 + mixture_choice(&m, 98))));
        mixture_assert_sound(&m, OUT, 0);
        free(m.cloud.points);
    }
}

static int remove_output(void **state)
{
    (void)state;
    unlink(OUT);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(small_mixtures_are_sound),
        cmocka_unit_test(extreme_numbers_are_sound_or_refused), cmocka_unit_test(surveys_are_sound),
        cmocka_unit_test(points_at_one_place_are_sound), cmocka_unit_test(deep_trees_are_sound)};
    return cmocka_run_group_tests(tests, NULL, remove_output);
}

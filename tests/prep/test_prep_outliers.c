/* Tests outliers: planted points and groups must be found, and surfaces of uneven density left
 * alone. */
#include "formats/chunk/sample/sample.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/cloud/outliers.h"
#include "tests/fixtures/cloud_fixture.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/statue_kept.h"
#include "tools/gen/sampler.h"

#define OUT "test_prep_outliers.stipple"
#define OTHER "test_prep_outliers_other.stipple"
#define NEIGHBOURS 16u

/* Returns a mark by source: 1 for an outlier. *count is the reported number. */
static uint8_t *find(stp_cloud *cloud, unsigned threads, uint32_t *count)
{
    stp_error err = {0};
    stp_pool *pool = NULL;
    uint64_t found = 0, marked = 0;
    uint8_t *marks = calloc(cloud->count, 1);
    assert_non_null(marks);
    assert_int_equal(stp_pool_create(&pool, threads, &err), STP_OK);
    assert_int_equal(stp_cloud_sort(cloud, pool, &err), STP_OK);
    assert_int_equal(
        stp_outliers_find(cloud, NEIGHBOURS, STP_OUTLIER_DISTANCE, pool, NULL, &found, &err),
        STP_OK);
    for (uint32_t i = 0; i < cloud->count; i++) {
        marks[cloud->points[i].source] = (cloud->marks[i] & STP_MARK_OUTLIER) != 0;
        marked += (cloud->marks[i] & STP_MARK_OUTLIER) != 0;
    }
    assert_int_equal(marked, found);
    if (count)
        *count = (uint32_t)found;
    stp_pool_destroy(&pool);
    return marks;
}

static uint32_t count_marks(const uint8_t *marks, uint32_t begin, uint32_t end)
{
    uint32_t count = 0;
    for (uint32_t i = begin; i < end; i++)
        count += marks[i];
    return count;
}

/* Fills a square with random points; `low` is its low corner and `step` its spacing. */
static void fill_square(stp_cloud *cloud, uint32_t begin, uint32_t end, stp_dvec3 low, double step,
                        uint64_t seed)
{
    double width = step * sqrt((double)(end - begin));
    for (uint32_t i = begin; i < end; i++)
        cloud->points[i].position =
            stp_dvec3_add(low, (stp_dvec3){width * stp_random_unit(seed, i),
                                           width * stp_random_unit(seed + 1, i), 0.0});
}

/* A dense square beside a sparse one, with points over both, some of the local spacings away. */
static void uneven_halves(void **state)
{
    (void)state;
    enum { DENSE = 30000, SPARSE = 10000, SURFACE = DENSE + SPARSE, FAR = 40 };
    static const double steps[] = {1.0, 3.0, 8.0, 30.0};
    for (size_t s = 0; s < sizeof steps / sizeof *steps; s++) {
        double step = steps[s], dense = sqrt(DENSE), sparse = step * sqrt(SPARSE);
        stp_cloud cloud = cloud_fixture_make(SURFACE + 2 * FAR);
        fill_square(&cloud, 0, DENSE, (stp_dvec3){-dense, 0.0, 0.0}, 1.0, 1);
        fill_square(&cloud, DENSE, SURFACE, (stp_dvec3){0.0, 0.0, 0.0}, step, 11);
        for (uint32_t i = 0; i < FAR; i++) {
            double x = 0.1 + 0.8 * stp_random_unit(21, i), y = 0.1 + 0.8 * stp_random_unit(22, i);
            double height = 7.0 + 20.0 * stp_random_unit(23, i);
            cloud.points[SURFACE + i].position = (stp_dvec3){-x * dense, y * dense, height};
            cloud.points[SURFACE + FAR + i].position =
                (stp_dvec3){x * sparse, y * sparse, step * height};
        }
        uint8_t *marks = find(&cloud, 2, NULL);
        assert_int_equal(count_marks(marks, SURFACE, SURFACE + 2 * FAR), 2 * FAR);
        assert_true(count_marks(marks, 0, DENSE) <= DENSE / 10000);
        assert_true(count_marks(marks, DENSE, SURFACE) <= SPARSE / 5000);
        free(marks);
        stp_cloud_clear(&cloud);
    }
}

/* The least distance to any of the first `count` points. */
static double distance_to(const stp_cloud *cloud, uint32_t count, stp_dvec3 p)
{
    double least = INFINITY;
    for (uint32_t i = 0; i < count; i++) {
        stp_dvec3 d = stp_dvec3_sub(cloud->points[i].position, p);
        least = fmin(least, stp_dvec3_dot(d, d));
    }
    return sqrt(least);
}

/* Puts the cloud's first `count` points on the statue, with noise of 0.3 spacings. */
static void fill_statue(stp_cloud *cloud, uint32_t count)
{
    gen_surface surface;
    gen_sampler *sampler = NULL;
    stp_pool *pool = NULL;
    stp_error err = {0};
    stp_point *points = calloc(count, sizeof *points);
    assert_non_null(points);
    statue_kept_init(&surface, GEN_STATUE, count, 1);
    gen_sampler_params params = {.surface = &surface,
                                 .point_count = count,
                                 .seed = 1,
                                 .noise_spacings = 0.3,
                                 .random_order = true};
    assert_int_equal(stp_pool_create(&pool, 2, &err), STP_OK);
    assert_int_equal(gen_sampler_create(&sampler, &params, pool, &err), STP_OK);
    gen_sampler_fill(sampler, 0, count, points, NULL);
    for (uint32_t i = 0; i < count; i++)
        cloud->points[i].position = points[i].position;
    gen_sampler_destroy(&sampler);
    stp_pool_destroy(&pool);
    free(points);
}

/* A statue with a scanner's noise, and random points in its box and around it. */
static void statue_with_planted_points(void **state)
{
    (void)state;
    enum { COUNT = 60000, FAR = 60 };
    stp_cloud cloud = cloud_fixture_make(COUNT + FAR);
    stp_dbox box = stp_dbox_empty();
    fill_statue(&cloud, COUNT);
    for (uint32_t i = 0; i < COUNT; i++)
        stp_dbox_add(&box, cloud.points[i].position);
    stp_dvec3 size = stp_dvec3_sub(box.max, box.min);
    double spacing = sqrt((size.x * size.y + size.y * size.z + size.z * size.x) / COUNT);
    for (uint32_t i = COUNT, turn = 0; i < COUNT + FAR; turn++) {
        stp_dvec3 p = {box.min.x + size.x * (1.4 * stp_random_unit(5, turn) - 0.2),
                       box.min.y + size.y * (1.4 * stp_random_unit(6, turn) - 0.2),
                       box.min.z + size.z * (1.4 * stp_random_unit(7, turn) - 0.2)};
        if (distance_to(&cloud, COUNT, p) > 6.0 * spacing)
            cloud.points[i++].position = p;
    }
    uint8_t *marks = find(&cloud, 2, NULL);
    assert_int_equal(count_marks(marks, COUNT, COUNT + FAR), FAR);
    assert_int_equal(count_marks(marks, 0, COUNT), 0);
    free(marks);
    stp_cloud_clear(&cloud);
}

/* Dense groups over the surface: groups of up to 16 points must be found. */
static void small_groups(void **state)
{
    (void)state;
    enum { SURFACE = 20000, GROUPS = 5, MOST = 60 };
    static const uint32_t sizes[] = {2, 5, 16, 17, MOST};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        uint32_t size = sizes[s], count = SURFACE + GROUPS * size;
        stp_cloud cloud = cloud_fixture_make(count);
        double width = sqrt(SURFACE);
        fill_square(&cloud, 0, SURFACE, (stp_dvec3){0.0, 0.0, 0.0}, 1.0, 1);
        for (uint32_t i = SURFACE; i < count; i++) {
            double group = (double)((i - SURFACE) / size);
            cloud.points[i].position =
                (stp_dvec3){width * (0.1 + 0.2 * group) + stp_random_unit(3, i),
                            width / 2.0 + stp_random_unit(4, i), 12.0 + stp_random_unit(5, i)};
        }
        uint8_t *marks = find(&cloud, 2, NULL);
        assert_int_equal(count_marks(marks, SURFACE, count),
                         size <= NEIGHBOURS ? count - SURFACE : 0);
        assert_int_equal(count_marks(marks, 0, SURFACE), 0);
        free(marks);
        stp_cloud_clear(&cloud);
    }
}

/* Duplicates are one position: they make no other point an outlier, and are outliers together. */
static void duplicates(void **state)
{
    (void)state;
    enum {
        PLACES = 5000,
        TIMES = 5,
        SURFACE = PLACES * TIMES,
        PILE = 1000,
        COUNT = SURFACE + PILE
    };
    stp_cloud cloud = cloud_fixture_make(COUNT);
    for (uint32_t i = 0; i < SURFACE; i++)
        cloud.points[i].position = (stp_dvec3){70.0 * stp_random_unit(1, i % PLACES),
                                               70.0 * stp_random_unit(2, i % PLACES), 0.0};
    for (uint32_t i = SURFACE; i < COUNT; i++) /* rays without a return */
        cloud.points[i].position = (stp_dvec3){0.0, 0.0, -40.0};
    uint8_t *marks = find(&cloud, 2, NULL);
    assert_int_equal(count_marks(marks, 0, SURFACE), 0);
    assert_int_equal(count_marks(marks, SURFACE, COUNT), PILE);
    free(marks);
    stp_cloud_clear(&cloud);
}

/* Spots ten thousand times as dense as the surface that they lie on. */
static void piles_on_a_surface(void **state)
{
    (void)state;
    enum { SURFACE = 20000, PILES = 20, SIZE = 100, COUNT = SURFACE + PILES * SIZE };
    stp_cloud cloud = cloud_fixture_make(COUNT);
    double width = sqrt(SURFACE);
    fill_square(&cloud, 0, SURFACE, (stp_dvec3){0.0, 0.0, 0.0}, 1.0, 1);
    for (uint32_t i = SURFACE; i < COUNT; i++) {
        uint32_t pile = (i - SURFACE) / SIZE;
        cloud.points[i].position =
            (stp_dvec3){width * stp_random_unit(7, pile) + 1e-4 * stp_random_unit(3, i),
                        width * stp_random_unit(8, pile) + 1e-4 * stp_random_unit(4, i), 0.0};
    }
    uint8_t *marks = find(&cloud, 2, NULL);
    assert_int_equal(count_marks(marks, 0, COUNT), 0);
    free(marks);
    stp_cloud_clear(&cloud);
}

/* Noise, scan lines and a volume must have no outliers of their own. */
static void other_shapes(void **state)
{
    (void)state;
    enum { COUNT = 40000, LINES = 100 };
    for (int shape = 0; shape < 3; shape++) {
        stp_cloud cloud = cloud_fixture_make(COUNT);
        for (uint32_t i = 0; i < COUNT; i++) {
            double x = stp_random_unit(1, i), y = stp_random_unit(2, i), z = stp_random_unit(3, i);
            if (shape == 0) /* four spacings thick */
                cloud.points[i].position = (stp_dvec3){200.0 * x, 200.0 * y, 4.0 * z};
            else if (shape == 1)
                cloud.points[i].position =
                    (stp_dvec3){0.05 * (i / LINES) + 0.01 * x, i % LINES, 0.0};
            else
                cloud.points[i].position = (stp_dvec3){x, y, z};
        }
        uint8_t *marks = find(&cloud, 2, NULL);
        assert_int_equal(count_marks(marks, 0, COUNT), 0);
        free(marks);
        stp_cloud_clear(&cloud);
    }
}

static prep_cloud wavy_with_planted(uint32_t count, uint32_t far)
{
    prep_cloud cloud = prep_cloud_wavy(count, (stp_dvec3){500.0, 0.0, -30.0}, 10.0);
    for (uint32_t i = 0; i < far; i++) { /* spread over the order, on a wider sphere */
        double z = 2.0 * (i + 0.5) / far - 1.0, a = 2.4 * i, across = sqrt(1.0 - z * z);
        stp_dvec3 d = {15.0 * across * cos(a), 15.0 * across * sin(a), 15.0 * z};
        cloud.points[(size_t)(i * (count / far) + 3)].position =
            stp_dvec3_add((stp_dvec3){500.0, 0.0, -30.0}, d);
        cloud.points[(size_t)(i * (count / far) + 3)].intensity = 65535;
    }
    return cloud;
}

/* The order of the input and the number of threads must not matter. */
static void order_and_threads(void **state)
{
    (void)state;
    enum { COUNT = 80000, FAR = 25 };
    prep_cloud points = wavy_with_planted(COUNT, FAR);
    uint8_t *first = NULL;
    for (unsigned turn = 0; turn < 3; turn++) {
        stp_cloud cloud = cloud_fixture_make(COUNT);
        for (uint32_t i = 0; i < COUNT; i++) {
            uint32_t from = turn == 2 ? COUNT - 1 - i : i;
            cloud.points[i].position = points.points[from].position;
            cloud.points[i].source = from;
        }
        uint8_t *marks = find(&cloud, 1 + turn, NULL);
        assert_int_equal(count_marks(marks, 0, COUNT), FAR);
        if (first)
            assert_memory_equal(marks, first, COUNT);
        else
            first = calloc(COUNT, 1);
        assert_non_null(first);
        memcpy(first, marks, COUNT);
        free(marks);
        stp_cloud_clear(&cloud);
    }
    free(first);
    free(points.points);
}

/* Both files must hold the same samples, with the same flags except `ignored` ones. */
static void assert_same_samples(const char *path, const char *other, uint8_t ignored)
{
    stp_chunk_file *a = prep_open_verified(path), *b = prep_open_verified(other);
    assert_int_equal(stp_chunk_file_get_info(a)->chunk_count,
                     stp_chunk_file_get_info(b)->chunk_count);
    for (uint32_t id = 0; id < stp_chunk_file_get_info(a)->chunk_count; id++) {
        stp_chunk_entry entry, entry_b;
        stp_chunk *x = prep_chunk(a, id, &entry), *y = prep_chunk(b, id, &entry_b);
        assert_memory_equal(&entry.origin, &entry_b.origin, sizeof entry.origin);
        assert_int_equal(x->patch_count, y->patch_count);
        assert_memory_equal(x->patches, y->patches, x->patch_count * sizeof *x->patches);
        for (int l = 0; l < STP_LEVEL_COUNT; l++) {
            for (uint32_t i = 0; i < x->level_begin[l][x->patch_count]; i++) {
                x->samples[l][i].flags &= (uint8_t)~ignored;
                y->samples[l][i].flags &= (uint8_t)~ignored;
            }
            assert_memory_equal(x->samples[l], y->samples[l],
                                x->level_begin[l][x->patch_count] * sizeof(stp_sample));
        }
        stp_chunk_destroy(&x);
        stp_chunk_destroy(&y);
    }
    stp_chunk_file_close(&a);
    stp_chunk_file_close(&b);
}

typedef struct rejected_list {
    prep_cloud *cloud;
    uint64_t places[256];
    size_t count;
} rejected_list;

static stp_status read_listed(void *context, stp_point *points, size_t capacity, size_t *count,
                              stp_error *err)
{
    rejected_list *list = context;
    return prep_cloud_read(list->cloud, points, capacity, count, err);
}

static stp_status note_rejected(void *context, uint64_t place, stp_reject reason, stp_error *err)
{
    rejected_list *list = context;
    (void)err;
    assert_int_equal(reason, STP_REJECT_OUTLIER);
    assert_true(list->count < 256);
    list->places[list->count++] = place;
    return STP_OK;
}

/* After drop, the file must equal that of a cloud without these points, and prep must say which
 * they were. */
static void drop_is_as_without(void **state)
{
    (void)state;
    enum { COUNT = 100000, FAR = 40, EVERY = COUNT / FAR };
    prep_cloud cloud = wavy_with_planted(COUNT, FAR);
    for (uint32_t i = 0; i < COUNT; i++)
        if (i % EVERY != 3)
            cloud.points[i].intensity /= 2; /* only outliers have the greatest values */
    rejected_list list = {.cloud = &cloud};
    const stp_prep_file file = {.name = "planted"};
    stp_prep_source source = {.context = &list,
                              .read = read_listed,
                              .rejected = note_rejected,
                              .point_count = COUNT,
                              .attributes = STP_POINT_HAS_COLOUR | STP_POINT_HAS_CLASS |
                                            STP_POINT_HAS_INTENSITY,
                              .files = &file,
                              .file_count = 1};
    stp_prep_params params = {.force = true, .outliers = STP_OUTLIERS_DROP};
    stp_prep_stats stats, clean;
    stp_error err = {0};
    stp_pool *pool = NULL;
    assert_int_equal(stp_pool_create(&pool, 2, &err), STP_OK);
    assert_int_equal(stp_prep_run(OUT, &source, &params, pool, NULL, &stats, &err), STP_OK);
    stp_pool_destroy(&pool);
    assert_int_equal(stats.points_in, COUNT);
    assert_int_equal(stats.points_out, COUNT - FAR);
    assert_int_equal(stats.rejected[STP_REJECT_OUTLIER], FAR);
    assert_int_equal(list.count, FAR);
    for (uint32_t i = 0; i < FAR; i++)
        assert_int_equal(list.places[i], i * EVERY + 3);
    uint32_t kept = 0;
    for (uint32_t i = 0; i < COUNT; i++)
        if (i % EVERY != 3)
            cloud.points[kept++] = cloud.points[i];
    cloud.count = kept;
    assert_int_equal(prep_cloud_run(&cloud, OTHER, 1, NULL, &clean, &err), STP_OK);
    assert_int_equal(stats.intensity_max, clean.intensity_max);
    assert_same_samples(OUT, OTHER, 0);
    free(cloud.points);
}

/* Mark must change the flag alone: the planted points have it, and the file says that some points
 * do. */
static void mark_is_a_flag(void **state)
{
    (void)state;
    enum { COUNT = 100000, FAR = 40, EVERY = COUNT / FAR };
    prep_cloud cloud = wavy_with_planted(COUNT, FAR);
    stp_prep_params params = {.outliers = STP_OUTLIERS_MARK};
    stp_prep_stats stats;
    stp_error err = {0};
    uint32_t marked = 0;
    assert_int_equal(prep_cloud_run(&cloud, OTHER, 2, NULL, &stats, &err), STP_OK);
    assert_int_equal(prep_cloud_run(&cloud, OUT, 2, &params, &stats, &err), STP_OK);
    assert_int_equal(stats.points_out, COUNT);
    assert_int_equal(stats.outlier_count, FAR);
    assert_same_samples(OUT, OTHER, STP_SAMPLE_OUTLIER);
    stp_chunk_file *file = prep_open_verified(OUT);
    assert_true(stp_chunk_file_get_info(file)->attributes & STP_HAS_OUTLIERS);
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry;
        stp_chunk *chunk = prep_chunk(file, id, &entry);
        for (uint32_t i = 0; entry.child_count == 0 && i < entry.sample_count[0]; i++) {
            const stp_sample *s = &chunk->samples[0][i];
            bool planted = prep_number_of(s) % EVERY == 3;
            assert_int_equal((s->flags & STP_SAMPLE_OUTLIER) != 0, planted);
            marked += planted;
        }
        stp_chunk_destroy(&chunk);
    }
    assert_int_equal(marked, FAR);
    stp_chunk_file_close(&file);
    free(cloud.points);
}

/* A few points are no surface that one of them could be far from, however they lie. */
static void tiny_clouds(void **state)
{
    (void)state;
    static const size_t counts[] = {1, 2, 5, 16};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
        prep_cloud cloud = prep_cloud_make(counts[c]);
        stp_prep_params params = {.outliers = STP_OUTLIERS_DROP};
        stp_prep_stats stats;
        stp_error err = {0};
        for (size_t i = 0; i < counts[c]; i++)
            cloud.points[i].position = (stp_dvec3){pow(3.0, (double)i), i % 2 ? 1.0 : 0.0, 0.0};
        assert_int_equal(prep_cloud_run(&cloud, OUT, 2, &params, &stats, &err), STP_OK);
        assert_int_equal(stats.points_out, counts[c]);
        for (size_t i = 0; i < counts[c]; i++) /* and all at one place */
            cloud.points[i].position = (stp_dvec3){1.0, 2.0, 3.0};
        assert_int_equal(prep_cloud_run(&cloud, OUT, 2, &params, &stats, &err), STP_OK);
        assert_int_equal(stats.points_out, counts[c]);
        free(cloud.points);
    }
    remove(OUT);
    remove(OTHER);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(uneven_halves),      cmocka_unit_test(statue_with_planted_points),
        cmocka_unit_test(small_groups),       cmocka_unit_test(duplicates),
        cmocka_unit_test(piles_on_a_surface), cmocka_unit_test(other_shapes),
        cmocka_unit_test(order_and_threads),  cmocka_unit_test(drop_is_as_without),
        cmocka_unit_test(mark_is_a_flag),     cmocka_unit_test(tiny_clouds),
    };
    return cmocka_run_group_tests_name("outliers", tests, NULL, NULL);
}

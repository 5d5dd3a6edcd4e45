/* Tests prep as a whole: every point once, errors that grow towards the root, the same bytes,
 * awkward inputs. */
#include "preprocess/tree/chunk_build.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/size.h"

#include <unistd.h>

#define OUT "test_prep.stipple"

/* The spacing by its definition: sqrt(pi / k) times the distance to the k-th nearest other
 * position. For clouds in which equal distances are equal positions. */
static double spacing_of(const prep_cloud *cloud, size_t self, unsigned k)
{
    double nearest[64];
    unsigned count = 0;
    for (size_t i = 0; i < cloud->count; i++) {
        stp_dvec3 d = stp_dvec3_sub(cloud->points[i].position, cloud->points[self].position);
        double squared = stp_dvec3_dot(d, d);
        if (!(squared > 0.0) || (count == k && squared >= nearest[k - 1]))
            continue;
        bool repeated = false;
        for (unsigned j = 0; j < count; j++)
            repeated |= nearest[j] == squared;
        if (repeated)
            continue;
        unsigned at = count < k ? count++ : k - 1;
        for (; at > 0 && nearest[at - 1] > squared; at--)
            nearest[at] = nearest[at - 1];
        nearest[at] = squared;
    }
    return count ? sqrt(nearest[count - 1] * M_PI / count) : 0.0;
}

/* How far a point may move: 1/32 of its spacing; if all points are equal, a float's precision. */
static double position_error(const prep_cloud *cloud, size_t number)
{
    double spacing = spacing_of(cloud, number, 16);
    return spacing > 0.0 ? spacing / 32.0
                         : ldexp(stp_dvec3_length(cloud->points[number].position), -23);
}

/* Compares level 0 of the leaves with the input: each valid point must be there once, with
 * everything that it had. The distance of every stride-th point from its place is compared with its
 * spacing. */
static void assert_holds(stp_chunk_file *file, const prep_cloud *cloud, size_t valid, size_t stride)
{
    uint8_t *seen = calloc(cloud->count, 1);
    size_t found = 0;
    assert_non_null(seen);
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry;
        stp_chunk *chunk = prep_chunk(file, id, &entry);
        for (uint32_t p = 0; entry.child_count == 0 && p < chunk->patch_count; p++) {
            for (uint32_t i = chunk->level_begin[0][p]; i < chunk->level_begin[0][p + 1]; i++) {
                const stp_sample *s = &chunk->samples[0][i];
                uint32_t number = prep_number_of(s);
                assert_in_range(number, 0, cloud->count - 1);
                assert_int_equal(seen[number], 0);
                seen[number] = 1;
                found++;
                const stp_point *point = &cloud->points[number];
                assert_int_equal(s->intensity, point->intensity / 257);
                if (number % stride != 0)
                    continue;
                stp_dvec3 at =
                    stp_dvec3_add(entry.origin, stp_sample_position(s, &chunk->patches[p]));
                double off = stp_dvec3_length(stp_dvec3_sub(at, point->position));
                assert_true(off <= position_error(cloud, number));
            }
        }
        stp_chunk_destroy(&chunk);
    }
    assert_int_equal(found, valid);
    free(seen);
}

static void every_point_is_stored_once(void **state)
{
    (void)state;
    prep_cloud cloud = prep_cloud_wavy(150000, (stp_dvec3){500000.0, 4000000.0, -30.0}, 10.0);
    stp_prep_stats stats;
    stp_error err = {0};
    cloud.points[7].position.x = NAN;
    cloud.points[70000].position.y = INFINITY;
    cloud.points[149999].position.z = -INFINITY;
    assert_int_equal(prep_cloud_run(&cloud, OUT, 2, NULL, &stats, &err), STP_OK);
    assert_int_equal(stats.points_in, 150000);
    assert_int_equal(stats.points_out, 149997);
    assert_int_equal(stats.rejected[STP_REJECT_NOT_FINITE], 3);
    stp_chunk_file *file = prep_open_verified(OUT);
    assert_int_equal(stp_chunk_file_get_info(file)->point_count, 149997);
    assert_true(stp_chunk_file_get_info(file)->depth >= 2);
    assert_holds(file, &cloud, 149997, 997);
    stp_chunk_file_close(&file);
    free(cloud.points);
}

/* Errors grow upwards in a patch, and from a child's patch to every patch of the parent that it
 * refines. */
static void errors_grow_towards_the_root(void **state)
{
    (void)state;
    prep_cloud cloud = prep_cloud_wavy(200000, (stp_dvec3){0.0, 0.0, 0.0}, 1.0);
    stp_prep_stats stats;
    assert_int_equal(prep_cloud_run(&cloud, OUT, 2, NULL, &stats, NULL), STP_OK);
    stp_chunk_file *file = prep_open_verified(OUT);
    size_t inner = 0;
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry, child;
        stp_chunk *chunk = prep_chunk(file, id, &entry);
        for (uint32_t p = 0; p < chunk->patch_count; p++) {
            const stp_patch *patch = &chunk->patches[p];
            for (int l = 1; l < STP_LEVEL_COUNT; l++) {
                assert_true(patch->error[l] >= patch->error[l - 1]);
                assert_true(patch->tangential_error[l] >= patch->tangential_error[l - 1]);
                assert_true(patch->colour_error[l] >= patch->colour_error[l - 1]);
            }
        }
        stp_chunk_destroy(&chunk);
        for (uint32_t c = 0; c < entry.child_count; c++, inner++) {
            stp_error err = {0};
            assert_int_equal(stp_chunk_file_entry(file, entry.first_child + c, &child, &err), 0);
            assert_true(entry.error[0] >= child.error[3]);
            assert_true(entry.tangential_error[0] >= child.tangential_error[3]);
        }
    }
    assert_true(inner > 1);
    stp_chunk_file_close(&file);
    free(cloud.points);
}

/* A merged disc must cover the centres that it replaces and have a colour between theirs. */
static void check_merged(const stp_chunk *chunk, uint32_t p, int level)
{
    const stp_patch *patch = &chunk->patches[p];
    double step = ldexp(1.0, patch->exponent);
    unsigned count = patch->counts[level], finer = patch->counts[level - 1];
    for (unsigned j = 0; j < count; j++) {
        const stp_sample *s = &chunk->samples[level][chunk->level_begin[level][p] + j];
        unsigned begin = stp_level_children_begin(j, count, finer);
        unsigned end = stp_level_children_begin(j + 1, count, finer);
        int low[3] = {255, 255, 255}, high[3] = {0, 0, 0};
        assert_in_range(end - begin, 1, 4);
        for (unsigned i = begin; i < end; i++) {
            const stp_sample *c = &chunk->samples[level - 1][chunk->level_begin[level - 1][p] + i];
            stp_dvec3 d =
                stp_dvec3_sub(stp_sample_position(c, patch), stp_sample_position(s, patch));
            /* the merged centre is rounded after the choice of its radius; a vertex is rounded to a
             * coarser lattice, by at most 1/32 of its own spacing */
            double rounding = level == 3 ? stp_sample_radius(s, patch) / 32.0 : step;
            assert_true(stp_dvec3_length(d) <= stp_sample_radius(s, patch) + rounding);
            for (int k = 0; k < 3; k++) {
                low[k] = c->rgb[k] < low[k] ? c->rgb[k] : low[k];
                high[k] = c->rgb[k] > high[k] ? c->rgb[k] : high[k];
            }
        }
        for (int k = 0; k < 3; k++)
            assert_in_range(s->rgb[k], low[k], high[k]);
    }
}

/* A bound's centre is the patch vertex, 512 steps from the origin along each axis, or a power of
 * two times that. */
static void check_middle(const stp_chunk *chunk, uint32_t p)
{
    const stp_patch *patch = &chunk->patches[p];
    const unsigned middle = patch->bound_centre[0];
    assert_true(middle >= 512 && (middle & (middle - 1)) == 0);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(patch->bound_centre[i], middle);
        assert_int_equal(chunk->samples[STP_LEVEL_COUNT - 1][p].position[i], middle);
    }
}

static void patches_are_well_built(void **state)
{
    (void)state;
    size_t inner_count = 0;
    prep_cloud cloud = prep_cloud_wavy(100000, (stp_dvec3){3.0, 5.0, 7.0}, 3.0);
    stp_prep_stats stats;
    assert_int_equal(prep_cloud_run(&cloud, OUT, 2, NULL, &stats, NULL), STP_OK);
    stp_chunk_file *file = prep_open_verified(OUT);
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry;
        stp_chunk *chunk = prep_chunk(file, id, &entry);
        for (uint32_t p = 0; p < chunk->patch_count; p++) {
            check_middle(chunk, p);
            assert_true(chunk->patches[p].counts[0] <=
                        (entry.child_count ? STP_ABOVE_SAMPLES : STP_PATCH_SAMPLES));
            inner_count += entry.child_count > 0;
            for (int level = 1; level < STP_LEVEL_COUNT; level++)
                check_merged(chunk, p, level);
        }
        stp_chunk_destroy(&chunk);
    }
    stp_chunk_file_close(&file);
    assert_true(inner_count > 10);
    free(cloud.points);
}

static void threads_do_not_change_the_bytes(void **state)
{
    (void)state;
    static const unsigned threads[] = {1, 2, 4};
    prep_cloud cloud = prep_cloud_wavy(TEST_SIZE(300000, 150000), (stp_dvec3){1.0, 2.0, 3.0}, 1.0);
    uint8_t *first = NULL;
    size_t first_size = 0;
    for (int i = 0; i < 3; i++) {
        stp_prep_stats stats;
        size_t size = 0;
        assert_int_equal(prep_cloud_run(&cloud, OUT, threads[i], NULL, &stats, NULL), STP_OK);
        uint8_t *bytes = prep_file_bytes(OUT, &size);
        if (!first) {
            first = bytes;
            first_size = size;
            continue;
        }
        assert_int_equal(size, first_size);
        assert_memory_equal(bytes, first, size);
        free(bytes);
    }
    free(first);
    free(cloud.points);
}

/* Awkward inputs must be stored completely and verify. */
static stp_prep_stats assert_works(prep_cloud *cloud)
{
    stp_prep_stats stats;
    stp_error err = {0};
    if (prep_cloud_run(cloud, OUT, 2, NULL, &stats, &err) != STP_OK)
        fail_msg("%s", err.message);
    stp_chunk_file *file = prep_open_verified(OUT);
    assert_holds(file, cloud, cloud->count, SIZE_MAX);
    stp_chunk_file_close(&file);
    return stats;
}

static uint8_t flags_of_first(void)
{
    stp_chunk_file *file = prep_open_verified(OUT);
    stp_chunk_entry entry;
    stp_chunk *chunk = prep_chunk(file, 0, &entry);
    uint8_t flags = chunk->samples[0][0].flags;
    stp_chunk_destroy(&chunk);
    stp_chunk_file_close(&file);
    return flags;
}

static void one_point_and_three(void **state)
{
    (void)state;
    for (size_t count = 1; count <= 3; count++) {
        prep_cloud cloud = prep_cloud_make(count);
        for (size_t i = 0; i < count; i++)
            cloud.points[i].position = (stp_dvec3){1e6 + (double)(i % 2), (double)(i / 2), 5.0};
        stp_prep_stats stats = assert_works(&cloud);
        assert_int_equal(stats.orientation, STP_ORIENTATION_UNKNOWN);
        assert_int_equal(flags_of_first(), 0); /* two neighbours define no normal */
        free(cloud.points);
    }
}

static void no_valid_point_is_an_error(void **state)
{
    (void)state;
    prep_cloud cloud = prep_cloud_make(5);
    stp_prep_stats stats;
    stp_error err = {0};
    for (size_t i = 0; i < 5; i++)
        cloud.points[i].position.x = i % 2 ? NAN : INFINITY;
    unlink(OUT);
    assert_int_equal(prep_cloud_run(&cloud, OUT, 2, NULL, &stats, &err), STP_EMPTY);
    assert_int_equal(access(OUT, F_OK), -1);
    cloud.count = 0;
    assert_int_equal(prep_cloud_run(&cloud, OUT, 2, NULL, &stats, &err), STP_EMPTY);
    assert_int_equal(access(OUT, F_OK), -1);
    free(cloud.points);
}

static void all_points_equal(void **state)
{
    (void)state;
    prep_cloud cloud = prep_cloud_make(TEST_SIZE(1000000, 150000));
    for (size_t i = 0; i < cloud.count; i++)
        cloud.points[i].position = (stp_dvec3){3.25, -1e5, 0.1};
    assert_works(&cloud);
    assert_int_equal(flags_of_first(), 0);
    free(cloud.points);
}

/* Sparse points with a fine precision, as in surveys: every bound must have a code. Positions must
 * be as precise as asked, or to a ten thousandth of the disc if the precision asked is too fine. */
static void precision_far_below_the_spacing(void **state)
{
    (void)state;
    const double precisions[] = {1.0, 5e-3, 1e-3, 1e-6, 1e-12};
    for (size_t n = 0; n < sizeof precisions / sizeof *precisions; n++) {
        prep_cloud cloud = prep_cloud_make(1000);
        for (size_t i = 0; i < cloud.count; i++)
            cloud.points[i].position =
                (stp_dvec3){6e5 + 2000.0 * stp_random_unit(3, i),
                            8e5 + 3000.0 * stp_random_unit(4, i), 400.0 * stp_random_unit(5, i)};
        const stp_prep_params params = {.precision = precisions[n]};
        stp_prep_stats stats;
        stp_error err = {0};
        if (prep_cloud_run(&cloud, OUT, 2, &params, &stats, &err) != STP_OK)
            fail_msg("%s", err.message);
        stp_chunk_file *file = prep_open_verified(OUT);
        stp_chunk_entry entry;
        stp_chunk *chunk = prep_chunk(file, 0, &entry);
        for (uint32_t p = 0; p < chunk->patch_count; p++)
            for (uint32_t i = chunk->level_begin[0][p]; i < chunk->level_begin[0][p + 1]; i++) {
                const stp_sample *s = &chunk->samples[0][i];
                stp_dvec3 at = stp_sample_position(s, &chunk->patches[p]);
                at = stp_dvec3_sub(stp_dvec3_add(at, entry.origin),
                                   cloud.points[prep_number_of(s)].position);
                double radius = stp_sample_radius(s, &chunk->patches[p]);
                assert_true(stp_dvec3_length(at) <= fmax(precisions[n], 1e-4 * radius));
            }
        stp_chunk_destroy(&chunk);
        stp_chunk_file_close(&file);
        free(cloud.points);
    }
}

/* The stored byte must span the range that the input uses. */
static void intensities_are_of_their_range(void **state)
{
    (void)state;
    prep_cloud cloud = prep_cloud_wavy(5000, (stp_dvec3){0.0, 0.0, 0.0}, 1.0);
    for (size_t i = 0; i < cloud.count; i++)
        cloud.points[i].intensity = (uint16_t)(i % 1001); /* ten bits of sixteen */
    stp_prep_stats stats;
    stp_error err = {0};
    assert_int_equal(prep_cloud_run(&cloud, OUT, 2, NULL, &stats, &err), STP_OK);
    assert_int_equal(stats.intensity_max, 1000);
    stp_chunk_file *file = prep_open_verified(OUT);
    stp_chunk_entry entry;
    stp_chunk *chunk = prep_chunk(file, 0, &entry);
    assert_int_equal(entry.sample_count[0], cloud.count);
    for (uint32_t i = 0; i < entry.sample_count[0]; i++) {
        const stp_sample *s = &chunk->samples[0][i];
        double exact = cloud.points[prep_number_of(s)].intensity * 255.0 / 1000.0;
        assert_true(fabs(s->intensity - exact) <= 0.5);
    }
    stp_chunk_destroy(&chunk);
    stp_chunk_file_close(&file);
    free(cloud.points);
}

/* Reflectors must not leave everything else a few of 255 steps. They are white, too. */
static void bright_few_leave_the_steps(void **state)
{
    (void)state;
    prep_cloud cloud = prep_cloud_wavy(5000, (stp_dvec3){0.0, 0.0, 0.0}, 1.0);
    for (size_t i = 0; i < cloud.count; i++)
        cloud.points[i].intensity = i % 500 == 7 ? 60000 : (uint16_t)(i % 1001);
    stp_prep_stats stats;
    stp_error err = {0};
    assert_int_equal(prep_cloud_run(&cloud, OUT, 2, NULL, &stats, &err), STP_OK);
    assert_int_equal(stats.intensity_greatest, 60000);
    assert_in_range(stats.intensity_max, 1900, 2002); /* twice what 99 % reach */
    stp_chunk_file *file = prep_open_verified(OUT);
    stp_chunk_entry entry;
    stp_chunk *chunk = prep_chunk(file, 0, &entry);
    for (uint32_t i = 0; i < entry.sample_count[0]; i++) {
        const stp_sample *s = &chunk->samples[0][i];
        const double exact =
            cloud.points[prep_number_of(s)].intensity * 255.0 / stats.intensity_max;
        assert_true(fabs(s->intensity - fmin(exact, 255.0)) <= 0.5);
    }
    stp_chunk_destroy(&chunk);
    stp_chunk_file_close(&file);
    free(cloud.points);
}

static void points_on_a_line(void **state)
{
    (void)state;
    prep_cloud cloud = prep_cloud_make(100000);
    for (size_t i = 0; i < cloud.count; i++)
        cloud.points[i].position = (stp_dvec3){0.001 * (double)i, 0.002 * (double)i, 0.0};
    assert_works(&cloud);
    assert_int_equal(flags_of_first(), 0); /* a line has no normal */
    free(cloud.points);
}

static void points_on_a_plane(void **state)
{
    (void)state;
    prep_cloud cloud = prep_cloud_make(100000);
    for (size_t i = 0; i < cloud.count; i++)
        cloud.points[i].position = (stp_dvec3){stp_random_unit(3, i), stp_random_unit(4, i), -2.0};
    stp_prep_stats stats = assert_works(&cloud);
    assert_int_equal(stats.orientation, STP_ORIENTATION_UNKNOWN); /* open: nothing says which way */
    stp_chunk_file *file = prep_open_verified(OUT);
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry;
        stp_chunk *chunk = prep_chunk(file, id, &entry);
        for (uint32_t i = 0; i < chunk->level_begin[0][chunk->patch_count]; i++) {
            assert_int_equal(chunk->samples[0][i].flags, STP_SAMPLE_HAS_NORMAL);
            assert_true(fabsf(stp_normal_decode(chunk->samples[0][i].normal).z) > 0.9999f);
        }
        stp_chunk_destroy(&chunk);
    }
    stp_chunk_file_close(&file);
    free(cloud.points);
}

/* Piles of duplicates on a surface must be kept, and no normal may be lost to them. */
static void duplicates_are_kept(void **state)
{
    (void)state;
    prep_cloud cloud = prep_cloud_wavy(60000, (stp_dvec3){0.0, 0.0, 0.0}, 1.0);
    for (size_t i = 0; i < cloud.count; i++)
        cloud.points[i].position = cloud.points[i % 3000].position;
    assert_works(&cloud);
    stp_chunk_file *file = prep_open_verified(OUT);
    stp_chunk_entry entry;
    stp_chunk *chunk = prep_chunk(file, 0, &entry);
    for (uint32_t i = 0; i < chunk->level_begin[0][chunk->patch_count]; i++)
        assert_true(chunk->samples[0][i].flags & STP_SAMPLE_HAS_NORMAL);
    stp_chunk_destroy(&chunk);
    stp_chunk_file_close(&file);
    free(cloud.points);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_point_is_stored_once),
        cmocka_unit_test(errors_grow_towards_the_root),
        cmocka_unit_test(patches_are_well_built),
        cmocka_unit_test(threads_do_not_change_the_bytes),
        cmocka_unit_test(one_point_and_three),
        cmocka_unit_test(no_valid_point_is_an_error),
        cmocka_unit_test(all_points_equal),
        cmocka_unit_test(precision_far_below_the_spacing),
        cmocka_unit_test(intensities_are_of_their_range),
        cmocka_unit_test(bright_few_leave_the_steps),
        cmocka_unit_test(points_on_a_line),
        cmocka_unit_test(points_on_a_plane),
        cmocka_unit_test(duplicates_are_kept),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Tests triangles through prep and back: every triangle once, no cracks, errors against dense
 * samples, awkward triangles, the same bytes. */
#include "tests/fixtures/line_fixture.h"

#include "formats/chunk/measure/patch_bounds.h"
#include "formats/chunk/measure/triangles.h"

#include <unistd.h>

#define OUT "test_triangles.stipple"

static stp_status run_triangles(const stp_triangle_set *set, prep_cloud *points, unsigned threads,
                                const stp_prep_params *params, stp_prep_stats *stats,
                                stp_error *err)
{
    return prep_shapes_run(points, NULL, set, OUT, threads, params, stats, err);
}

/* A number of a triangle that depends on its sense, but not on where it begins. */
static uint64_t turned(uint64_t a, uint64_t b, uint64_t c)
{
    return a * a * b + b * b * c + c * c * a;
}

/* Level 0 of all patches of triangles must have each triangle of the set once, and each vertex at
 * one place. */
static void assert_holds(stp_chunk_file *file, const stp_triangle_set *set, double off)
{
    stp_dvec3 *places = calloc(set->vertex_count, sizeof *places);
    uint8_t *seen = calloc(set->vertex_count, 1);
    uint64_t count = 0, sum = 0, wanted = 0;
    assert_non_null(places);
    assert_non_null(seen);
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry;
        stp_chunk *chunk = prep_chunk(file, id, &entry);
        for (uint32_t p = 0; p < chunk->patch_count; p++) {
            const stp_patch *patch = &chunk->patches[p];
            uint32_t begin = chunk->level_begin[0][p];
            for (unsigned i = 0; patch->flags & STP_PATCH_TRIANGLES && i < patch->counts[0]; i++) {
                const stp_sample *s = &chunk->samples[0][begin + i];
                uint32_t v = prep_number_of(s);
                stp_dvec3 at = stp_dvec3_add(entry.origin, stp_sample_position(s, patch));
                assert_in_range(v, 0, set->vertex_count - 1);
                assert_true(stp_dvec3_length(stp_dvec3_sub(at, set->vertices[v].position)) <= off);
                if (seen[v])
                    assert_true(stp_dvec3_equal(at, places[v]));
                seen[v] = 1;
                places[v] = at;
                if (i % 3 == 2)
                    sum += turned(prep_number_of(s - 2), prep_number_of(s - 1), v);
            }
            count += patch->flags & STP_PATCH_TRIANGLES ? patch->counts[0] / 3u : 0;
        }
        stp_chunk_destroy(&chunk);
    }
    for (uint64_t t = 0; t < set->triangle_count; t++)
        wanted += turned(set->triangles[t][0], set->triangles[t][1], set->triangles[t][2]);
    assert_int_equal(count, set->triangle_count);
    assert_int_equal(sum, wanted);
    free(places);
    free(seen);
}

static void every_triangle_comes_back(void **state)
{
    (void)state;
    stp_triangle_set set = triangle_set_grid(150, (stp_dvec3){300000.0, 5e6, 0.0});
    stp_prep_stats stats;
    stp_error err = {0};
    if (run_triangles(&set, NULL, 2, NULL, &stats, &err) != STP_OK)
        fail_msg("%s", err.message);
    assert_int_equal(stats.triangles.triangles, set.triangle_count);
    stp_chunk_file *file = prep_open_verified(OUT);
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    assert_int_equal(info->point_count, 3 * set.triangle_count);
    assert_int_equal(info->version_major, 2);
    assert_true(info->attributes & STP_HAS_TRIANGLES);
    assert_true(info->chunk_count > 2);
    assert_holds(file, &set, 0.001);
    stp_chunk_file_close(&file);
    const stp_prep_params precise = {.precision = 1e-4};
    assert_int_equal(run_triangles(&set, NULL, 2, &precise, &stats, &err), STP_OK);
    file = prep_open_verified(OUT);
    assert_holds(file, &set, 1e-4);
    stp_chunk_file_close(&file);
    stp_triangle_set_clear(&set);
}

/* The least distance from p across a normal to the triangle, by dense samples. */
static double across_to(stp_dvec3 p, stp_dvec3 normal, const stp_dvec3 t[3])
{
    enum { DENSE = 40 };
    double least = INFINITY;
    for (int i = 0; i <= DENSE; i++)
        for (int j = 0; i + j <= DENSE; j++) {
            double a = (double)i / DENSE, b = (double)j / DENSE;
            stp_dvec3 at =
                stp_dvec3_add(stp_dvec3_scale(t[0], 1.0 - a - b),
                              stp_dvec3_add(stp_dvec3_scale(t[1], a), stp_dvec3_scale(t[2], b)));
            stp_dvec3 d = stp_dvec3_sub(p, at);
            double height = stp_dvec3_dot(d, normal);
            least = fmin(least, sqrt(fmax(0.0, stp_dvec3_dot(d, d) - height * height)));
        }
    return least;
}

static double longest_side(const stp_dvec3 t[3])
{
    double longest = 0.0;
    for (int k = 0; k < 3; k++)
        longest = fmax(longest, stp_dvec3_length(stp_dvec3_sub(t[k], t[(k + 1) % 3])));
    return longest;
}

/* Tests that a disc lies over the triangles whose corners it covers. */
static void check_disc(const stp_chunk *chunk, uint32_t p, int level, unsigned j)
{
    const stp_patch *patch = &chunk->patches[p];
    const uint8_t *counts = patch->counts;
    const stp_disc disc =
        stp_disc_from_sample(&chunk->samples[level][chunk->level_begin[level][p] + j], patch);
    const double error = stp_error_decode(patch->error[level], patch->exponent);
    const double aside = stp_error_decode(patch->tangential_error[level], patch->exponent);
    unsigned first = stp_covered_begin(counts, level, j, 0) / 3;
    unsigned end = (stp_covered_begin(counts, level, j + 1, 0) + 2) / 3;
    stp_dvec3 points[STP_DISC_POINTS], t[3];
    double least[STP_DISC_POINTS];
    const unsigned count = stp_disc_points(&disc, points);
    for (unsigned i = 0; i < count; i++)
        least[i] = INFINITY;
    for (; first < end; first++) {
        for (unsigned k = 0; k < 3; k++) {
            t[k] = stp_sample_position(&chunk->samples[0][chunk->level_begin[0][p] + 3 * first + k],
                                       patch);
            double height = stp_dvec3_dot(stp_dvec3_sub(t[k], disc.centre), disc.normal);
            assert_true(fabs(height) <= error * (1.0 + 1e-6));
        }
        for (unsigned i = 0; i < count; i++)
            least[i] = fmin(least[i], across_to(points[i], disc.normal, (const stp_dvec3 *)t) -
                                          longest_side((const stp_dvec3 *)t) / 40.0);
    }
    for (unsigned i = 0; i < count; i++)
        assert_true(least[i] <= aside * (1.0 + 1e-6));
}

/* Tests that a disc of level 1 is the mean of the corners that it covers, to within its rounding:
 * then the last of them costs next to nothing. */
static void check_mean(const stp_chunk *chunk, uint32_t p, unsigned j)
{
    const stp_patch *patch = &chunk->patches[p];
    const unsigned first = stp_covered_begin(patch->counts, 1, j, 0);
    const unsigned end = stp_covered_begin(patch->counts, 1, j + 1, 0);
    const stp_sample *corners = chunk->samples[0] + chunk->level_begin[0][p];
    stp_dvec3 off = stp_sample_position(&chunk->samples[1][chunk->level_begin[1][p] + j], patch);
    for (unsigned i = first; i < end; i++)
        off = stp_dvec3_sub(
            off, stp_dvec3_scale(stp_sample_position(&corners[i], patch), 1.0 / (end - first)));
    assert_true(stp_dvec3_length(off) <= ldexp(0.8661, patch->exponent)); /* half a diagonal */
}

/* stp_triangles_fault must find each contradiction. */
static void assert_refuted(stp_chunk *chunk, uint32_t p)
{
    stp_patch *patch = &chunk->patches[p], kept = *patch;
    stp_sample *last = &chunk->samples[3][chunk->level_begin[3][p]], sample = *last;
    assert_null(stp_triangles_fault(chunk, p));
    patch->error[3] = 1;
    assert_non_null(strstr(stp_triangles_fault(chunk, p), "perpendicular error"));
    *patch = kept;
    patch->tangential_error[3] = 0;
    assert_non_null(strstr(stp_triangles_fault(chunk, p), "tangential error"));
    *patch = kept;
    patch->colour_error[3] = 0;
    assert_non_null(strstr(stp_triangles_fault(chunk, p), "colour error"));
    *patch = kept;
    last->radius = (uint8_t)(last->radius - 16);
    assert_non_null(strstr(stp_triangles_fault(chunk, p), "does not reach"));
    *last = sample;
    last->flags |= STP_KIND_TUBE << STP_SAMPLE_KIND_SHIFT;
    assert_non_null(strstr(stp_triangles_fault(chunk, p), "no surface"));
    *last = sample;
}

static void discs_hold_their_errors(void **state)
{
    (void)state;
    stp_triangle_set set = triangle_set_grid(20, (stp_dvec3){0.0, 0.0, 0.0});
    stp_prep_stats stats;
    assert_int_equal(run_triangles(&set, NULL, 2, NULL, &stats, NULL), STP_OK);
    stp_chunk_file *file = prep_open_verified(OUT);
    stp_chunk_entry entry;
    stp_chunk *chunk = prep_chunk(file, 0, &entry);
    assert_int_equal(entry.child_count, 0);
    print_message("%llu triangles in %u patches\n", (unsigned long long)set.triangle_count,
                  chunk->patch_count);
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        for (int l = 1; l < STP_LEVEL_COUNT; l++)
            for (unsigned j = 0; j < chunk->patches[p].counts[l]; j++)
                check_disc(chunk, p, l, j);
        for (unsigned j = 0; j < chunk->patches[p].counts[1]; j++)
            check_mean(chunk, p, j);
    }
    assert_refuted(chunk, 0);
    stp_chunk_destroy(&chunk);
    stp_chunk_file_close(&file);
    stp_triangle_set_clear(&set);
}

/* Triangles that are degenerate, huge or not finite, or name no vertex; with points beside them;
 * and a set without a valid one. */
static void awkward_triangles(void **state)
{
    (void)state;
    stp_triangle_set set = triangle_set_grid(8, (stp_dvec3){0.0, 0.0, 0.0});
    prep_cloud cloud = prep_cloud_wavy(5000, (stp_dvec3){5.0, 5.0, 0.0}, 2.0);
    stp_prep_stats stats;
    stp_error err = {0};
    set.triangles[0][2] = set.triangles[0][1];
    set.triangles[1][0] = set.triangles[1][1] = set.triangles[1][2];
    set.triangles[2][1] = 12345;
    set.vertices[80].position.z = (double)NAN;
    set.vertices[40].position.x = 1e5;
    set.vertices[41].radius = 0.5f;
    set.vertices[42].radius = NAN;
    if (run_triangles(&set, &cloud, 2, NULL, &stats, &err) != STP_OK)
        fail_msg("%s", err.message);
    assert_int_equal(stats.triangles.rejected, 2);
    assert_int_equal(stats.triangles.triangles, set.triangle_count - 2);
    stp_chunk_file *file = prep_open_verified(OUT);
    assert_int_equal(stp_chunk_file_get_info(file)->point_count,
                     5000 + 3 * (set.triangle_count - 2));
    stp_chunk_file_close(&file);
    for (uint64_t v = 0; v < set.vertex_count; v++)
        set.vertices[v].position.x = (double)NAN;
    assert_int_equal(run_triangles(&set, NULL, 2, NULL, &stats, &err), STP_EMPTY);
    free(cloud.points);
    stp_triangle_set_clear(&set);
    unlink(OUT);
}

/* A small mesh in a large model. */
static void small_triangles_in_a_large_model(void **state)
{
    (void)state;
    stp_triangle_set set = triangle_set_grid(30, (stp_dvec3){0.0, 0.0, 0.0});
    prep_cloud cloud = prep_cloud_wavy(3000, (stp_dvec3){5e5, 5e5, 0.0}, 1e5);
    stp_prep_stats stats;
    stp_error err = {0};
    for (uint64_t v = 0; v < set.vertex_count; v++)
        set.vertices[v].position = stp_dvec3_scale(set.vertices[v].position, 1e-4);
    if (run_triangles(&set, &cloud, 2, NULL, &stats, &err) != STP_OK)
        fail_msg("%s", err.message);
    stp_chunk_file *file = prep_open_verified(OUT);
    assert_holds(file, &set, 1e-5);
    stp_chunk_file_close(&file);
    free(cloud.points);
    stp_triangle_set_clear(&set);
}

static uint64_t hash_of(const char *path)
{
    uint64_t hash = 1469598103934665603u;
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    for (int c = fgetc(file); c != EOF; c = fgetc(file))
        hash = (hash ^ (unsigned)c) * 1099511628211u;
    fclose(file);
    return hash;
}

static void threads_give_the_same_bytes(void **state)
{
    (void)state;
    stp_triangle_set set = triangle_set_grid(200, (stp_dvec3){0.0, 0.0, 0.0});
    stp_prep_stats stats;
    uint64_t hash[2];
    for (unsigned i = 0; i < 2; i++) {
        assert_int_equal(run_triangles(&set, NULL, i ? 4 : 1, NULL, &stats, NULL), STP_OK);
        hash[i] = hash_of(OUT);
    }
    assert_int_equal(hash[0], hash[1]);
    stp_triangle_set_clear(&set);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_triangle_comes_back),
        cmocka_unit_test(discs_hold_their_errors),
        cmocka_unit_test(awkward_triangles),
        cmocka_unit_test(small_triangles_in_a_large_model),
        cmocka_unit_test(threads_give_the_same_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

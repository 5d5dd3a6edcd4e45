/* Tests lines through prep and back: every vertex once, in order, joined exactly; nested levels;
 * awkward polylines; the same bytes. */
#include "tests/fixtures/line_fixture.h"
#include "tests/fixtures/size.h"

#include <unistd.h>

#define OUT "test_lines.stipple"

/* Finds all vertices of the set in the file, along the strips, at most `off` away. Vertices that
 * are not finite are not looked for. */
static void assert_holds(stp_chunk_file *file, const stp_line_set *set, double off)
{
    line_patches all = line_patches_read(file);
    uint8_t *found = calloc(set->vertex_count, 1), *joined = calloc(set->vertex_count, 1);
    assert_non_null(found);
    assert_non_null(joined);
    for (size_t p = 0; p < all.count; p++) {
        const line_patch *patch = &all.list[p];
        const unsigned count = patch->patch.counts[0];
        uint32_t first = prep_number_of(&patch->samples[0][0]);
        for (unsigned i = 0; i < count; i++) {
            const stp_sample *s = &patch->samples[0][i];
            uint32_t number = prep_number_of(s);
            assert_int_equal(number, first + i);
            assert_in_range(number, 0, set->vertex_count - 1);
            const stp_line_vertex *v = &set->vertices[number];
            stp_dvec3 d = stp_dvec3_sub(line_position(patch, 0, i), v->position);
            assert_true(stp_dvec3_length(d) <= off);
            assert_int_equal(s->intensity, 255);
            double radius = stp_sample_radius(s, &patch->patch);
            assert_true(radius >= (double)v->radius * 0.999);
            assert_true(radius <= (double)v->radius * 1.05 + ldexp(1.0, patch->patch.exponent));
            bool again = i == 0 && patch->patch.flags & STP_PATCH_CONTINUES;
            joined[number] = (uint8_t)(joined[number] + again);
            found[number] = (uint8_t)(found[number] + !again);
        }
    }
    for (uint64_t i = 0; i < set->vertex_count; i++) {
        assert_int_equal(found[i], stp_dvec3_finite(set->vertices[i].position));
        assert_in_range(joined[i], 0, 1);
    }
    free(found);
    free(joined);
    free(all.list);
}

/* Each strip that continues another must begin exactly where that one ends, in the world. */
static void assert_joined(stp_chunk_file *file, const stp_line_set *set, uint64_t joints)
{
    line_patches all = line_patches_read(file);
    stp_dvec3 *ends = calloc(set->vertex_count, sizeof *ends);
    double *radii = calloc(set->vertex_count, sizeof *radii);
    uint64_t count = 0;
    assert_non_null(ends);
    assert_non_null(radii);
    for (size_t p = 0; p < all.count; p++) {
        const line_patch *patch = &all.list[p];
        const unsigned last = patch->patch.counts[0] - 1u;
        if (patch->patch.flags & STP_PATCH_CONTINUED) {
            ends[prep_number_of(&patch->samples[0][last])] = line_position(patch, 0, last);
            radii[prep_number_of(&patch->samples[0][last])] =
                stp_sample_radius(&patch->samples[0][last], &patch->patch);
        }
    }
    for (size_t p = 0; p < all.count; p++) {
        const line_patch *patch = &all.list[p];
        if (!(patch->patch.flags & STP_PATCH_CONTINUES))
            continue;
        uint32_t number = prep_number_of(&patch->samples[0][0]);
        assert_true(stp_dvec3_equal(ends[number], line_position(patch, 0, 0)));
        assert_true(radii[number] == stp_sample_radius(&patch->samples[0][0], &patch->patch));
        count++;
    }
    assert_int_equal(count, joints);
    free(radii);
    free(ends);
    free(all.list);
}

static void every_vertex_comes_back(void **state)
{
    (void)state;
    static const stp_line_kind kinds[] = {STP_LINE_RIBBON, STP_LINE_TUBE};
    for (int k = 0; k < 2; k++) {
        stp_line_set set =
            line_set_helices(40, 1000, (stp_dvec3){500000.0, 4e6, 20.0}, 3.0, 0.02, kinds[k]);
        stp_prep_stats stats;
        stp_error err = {0};
        if (line_set_run(&set, NULL, OUT, 2, NULL, &stats, &err) != STP_OK)
            fail_msg("%s", err.message);
        assert_int_equal(stats.lines.strips, 40);
        assert_int_equal(stats.lines.vertices, 40000);
        assert_int_equal(stats.lines.segments, 40 * 999);
        stp_chunk_file *file = prep_open_verified(OUT);
        const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
        assert_int_equal(info->point_count, stats.lines.samples);
        assert_int_equal(info->version_major, 2);
        assert_true(info->attributes & STP_HAS_LINES);
        assert_holds(file, &set, 0.02 / 4.0);
        assert_joined(file, &set, stats.lines.samples - 40000);
        stp_chunk_file_close(&file);
        stp_line_set_clear(&set);
    }
}

/* Lines over several chunks beside points must give a tree of both. */
static void lines_stand_beside_points(void **state)
{
    (void)state;
    stp_line_set set =
        line_set_helices(200, 1500, (stp_dvec3){-2.0, -2.0, -2.0}, 1.0, 0.01, STP_LINE_TUBE);
    prep_cloud cloud = prep_cloud_wavy(100000, (stp_dvec3){0.0, 0.0, 0.0}, 1.0);
    stp_prep_stats stats;
    stp_error err = {0};
    if (line_set_run(&set, &cloud, OUT, 2, NULL, &stats, &err) != STP_OK)
        fail_msg("%s", err.message);
    assert_int_equal(stats.points_out, 100000);
    stp_chunk_file *file = prep_open_verified(OUT);
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    assert_true(info->chunk_count > 6);
    assert_int_equal(info->point_count, 100000 + stats.lines.samples);
    assert_holds(file, &set, 0.01 / 4.0);
    assert_joined(file, &set, stats.lines.samples - set.vertex_count);
    stp_chunk_file_close(&file);
    free(cloud.points);
    stp_line_set_clear(&set);
}

static void threads_give_the_same_bytes(void **state)
{
    (void)state;
    stp_line_set set =
        line_set_helices(60, 2000, (stp_dvec3){0.0, 0.0, 0.0}, 1.0, 0.01, STP_LINE_RIBBON);
    prep_cloud cloud = prep_cloud_wavy(70000, (stp_dvec3){0.0, 0.0, 0.0}, 1.0);
    stp_prep_stats stats;
    size_t size[2];
    uint8_t *bytes[2];
    for (unsigned i = 0; i < 2; i++) {
        assert_int_equal(line_set_run(&set, &cloud, OUT, i ? 5 : 1, NULL, &stats, NULL), STP_OK);
        bytes[i] = prep_file_bytes(OUT, &size[i]);
    }
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(bytes[0], bytes[1], size[0]);
    free(bytes[0]);
    free(bytes[1]);
    free(cloud.points);
    stp_line_set_clear(&set);
}

/* Strips of one vertex, of no length, with all vertices at one place, without width, or not
 * finite. */
static void awkward_lines(void **state)
{
    (void)state;
    stp_line_set set = line_set_make(1 + 2 + 200 + 100 + 9, 5);
    stp_prep_stats stats;
    stp_error err = {0};
    uint64_t at = 0;
    static const uint64_t counts[] = {1, 2, 200, 100, 9};
    for (uint64_t s = 0; s < 5; s++) {
        set.strips[s] = (stp_line_strip){at, counts[s], s % 2 ? STP_LINE_TUBE : STP_LINE_RIBBON};
        for (uint64_t i = 0; i < counts[s]; i++, at++) {
            stp_line_vertex *v = &set.vertices[at];
            v->position = (stp_dvec3){(double)s, 0.0, 0.0};
            v->radius = s == 3 ? 0.0f : 0.1f;
            if (s == 3) /* a line without width */
                v->position.y = 0.01 * (double)i;
            if (s == 4)
                v->position.y = i == 3 || i == 8 ? (double)NAN : (double)i;
        }
    }
    set.vertices[0].radius = 0.25f;
    if (line_set_run(&set, NULL, OUT, 2, NULL, &stats, &err) != STP_OK)
        fail_msg("%s", err.message);
    assert_int_equal(stats.lines.rejected, 2);
    assert_int_equal(stats.lines.strips, 6);
    assert_int_equal(stats.lines.vertices, set.vertex_count - 2);
    stp_chunk_file *file = prep_open_verified(OUT);
    assert_holds(file, &set, 0.1 / 4.0);
    stp_chunk_file_close(&file);

    for (uint64_t i = 0; i < set.vertex_count; i++)
        set.vertices[i].position.x = (double)INFINITY;
    assert_int_equal(line_set_run(&set, NULL, OUT, 2, NULL, &stats, &err), STP_EMPTY);
    set.strip_count = 0;
    assert_int_equal(line_set_run(&set, NULL, OUT, 2, NULL, &stats, &err), STP_EMPTY);
    set.strip_count = 1;
    set.vertices[0].position = (stp_dvec3){0.0, 0.0, 0.0};
    assert_int_equal(line_set_run(&set, NULL, OUT, 2, NULL, &stats, &err), STP_OK);
    file = prep_open_verified(OUT);
    assert_int_equal(stp_chunk_file_get_info(file)->point_count, 1);
    stp_chunk_file_close(&file);
    stp_line_set_clear(&set);
    unlink(OUT);
}

/* Lines of very different lengths and widths, far from the origin. */
static void lattices_meet(void **state)
{
    (void)state;
    enum { COUNT = 4000 };
    stp_line_set set = line_set_make(COUNT, 1);
    stp_prep_stats stats;
    stp_error err = {0};
    stp_dvec3 p = {1e6, -2e6, 30.0};
    set.strips[0] = (stp_line_strip){0, COUNT, STP_LINE_TUBE};
    for (uint64_t i = 0; i < COUNT; i++) {
        double step = pow(10.0, 4.0 * stp_random_unit(1, i / 50) - 3.0);
        p = stp_dvec3_add(p, (stp_dvec3){step, step * stp_random_unit(2, i), 0.0});
        set.vertices[i].position = p;
        set.vertices[i].radius = (float)(0.3 * step);
    }
    if (line_set_run(&set, NULL, OUT, 2, NULL, &stats, &err) != STP_OK)
        fail_msg("%s", err.message);
    stp_chunk_file *file = prep_open_verified(OUT);
    assert_joined(file, &set, stats.lines.samples - COUNT);
    stp_chunk_file_close(&file);
    stp_line_set_clear(&set);
}

/* A lone hair among points that lie a million times its length apart. */
static void small_lines_in_a_large_model(void **state)
{
    (void)state;
    stp_line_set set = line_set_make(200, 100);
    prep_cloud cloud = prep_cloud_wavy(3000, (stp_dvec3){5e5, 5e5, 0.0}, 1e5);
    stp_prep_stats stats;
    stp_error err = {0};
    for (uint64_t i = 0; i < 200; i++) {
        set.vertices[i].position = (stp_dvec3){1e-3 * (double)i, 1e-4 * (double)(i % 2), 0.0};
        set.vertices[i].radius = 1e-5f;
        set.strips[i / 2] = (stp_line_strip){i / 2 * 2, 2, STP_LINE_TUBE};
    }
    if (line_set_run(&set, &cloud, OUT, 2, NULL, &stats, &err) != STP_OK)
        fail_msg("%s", err.message);
    stp_chunk_file *file = prep_open_verified(OUT);
    assert_holds(file, &set, 1e-5);
    stp_chunk_file_close(&file);
    free(cloud.points);
    stp_line_set_clear(&set);
}

static void precision_is_kept(void **state)
{
    (void)state;
    stp_line_set set =
        line_set_helices(3, 500, (stp_dvec3){1000.0, 0.0, 0.0}, 5.0, 0.5, STP_LINE_TUBE);
    const stp_prep_params params = {.precision = 0.0005};
    stp_prep_stats stats;
    assert_int_equal(line_set_run(&set, NULL, OUT, 2, &params, &stats, NULL), STP_OK);
    stp_chunk_file *file = prep_open_verified(OUT);
    assert_holds(file, &set, 0.0005);
    stp_chunk_file_close(&file);
    stp_line_set_clear(&set);
}

static void a_long_strip(void **state)
{
    (void)state;
    const uint64_t count = TEST_SIZE(1000000u, 20000u);
    stp_line_set set =
        line_set_helices(1, count, (stp_dvec3){0.0, 0.0, 0.0}, 100.0, 0.1, STP_LINE_TUBE);
    stp_prep_stats stats;
    assert_int_equal(line_set_run(&set, NULL, OUT, 2, NULL, &stats, NULL), STP_OK);
    assert_int_equal(stats.lines.vertices, count);
    stp_chunk_file *file = prep_open_verified(OUT);
    assert_holds(file, &set, 0.05 / 4.0);
    assert_joined(file, &set, stats.lines.samples - count);
    stp_chunk_file_close(&file);
    stp_line_set_clear(&set);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_vertex_comes_back),
        cmocka_unit_test(lines_stand_beside_points),
        cmocka_unit_test(threads_give_the_same_bytes),
        cmocka_unit_test(awkward_lines),
        cmocka_unit_test(lattices_meet),
        cmocka_unit_test(small_lines_in_a_large_model),
        cmocka_unit_test(precision_is_kept),
        cmocka_unit_test(a_long_strip),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Tests that a repaired model, of either version, keeps the promise of its errors. The errors of
 * each chunk's patch vertices must be covered by the chunk above, both perpendicular and tangential
 * errors; verify checks only the first.
 *
 * Each segment is damaged in one of the two versions; with the argument --every, as in
 * long_repair_model, in both. */
#include "tests/fixtures/repair_fixture.h"

#include "tests/fixtures/prep_fixture.h"

#define POINTS 150000

static bench *model_bench(int format)
{
    bench *b = calloc(1, sizeof *b);
    assert_non_null(b);
    stp_prep_stats stats;
    const stp_prep_params params = {.format = format};
    const char *path = fixture_path("sound.stipple");
    prep_cloud cloud = prep_cloud_wavy(POINTS, (stp_dvec3){3.0, 4.0, 5.0}, 2.0);
    assert_int_equal(prep_cloud_run(&cloud, path, 2, &params, &stats, NULL), STP_OK);
    free(cloud.points);
    b->bytes = fixture_read_file(path, &b->size);
    b->damaged = malloc(b->size);
    assert_non_null(b->damaged);
    memcpy(b->damaged, b->bytes, b->size);
    assert_int_equal(stp_pool_create(&b->pool, 2, NULL), STP_OK);
    return b;
}

static stp_dvec3 place(const stp_chunk *chunk, const stp_chunk_entry *e, uint32_t p, int level,
                       uint32_t i)
{
    return stp_dvec3_add(e->origin,
                         stp_sample_position(&chunk->samples[level][i], &chunk->patches[p]));
}

static double stored(const stp_patch *patch, const uint8_t *errors, int level)
{
    return stp_error_decode(errors[level], patch->exponent);
}

/* Compares every sample of those of the parent's patches that name the child with the patch vertex
 * at its place. */
static unsigned assert_held(const stp_chunk *parent, const stp_chunk_entry *above, uint32_t index,
                            const stp_chunk *child, const stp_chunk_entry *below)
{
    unsigned compared = 0;
    for (uint32_t p = 0; p < parent->patch_count; p++)
        for (uint32_t i = parent->level_begin[0][p];
             parent->patches[p].child == index && i < parent->level_begin[0][p + 1]; i++) {
            const stp_patch *patch = &parent->patches[p];
            stp_dvec3 at = place(parent, above, p, 0, i);
            for (uint32_t v = 0; v < child->patch_count; v++) {
                const stp_patch *vertex = &child->patches[v];
                stp_dvec3 to = place(child, below, v, 3, v);
                if (!stp_dvec3_equal(at, to))
                    continue;
                compared++;
                assert_true(stored(patch, patch->error, 0) * 1.000001 >=
                            stored(vertex, vertex->error, 3));
                assert_true(stored(patch, patch->tangential_error, 0) * 1.000001 >=
                            stored(vertex, vertex->tangential_error, 3));
            }
        }
    return compared;
}

static void assert_all_held(const char *path)
{
    stp_chunk_file *file = prep_open_verified(path);
    uint32_t count = stp_chunk_file_get_info(file)->chunk_count;
    for (uint32_t id = 0; id < count; id++) {
        stp_chunk_entry above, below;
        stp_chunk *parent = prep_chunk(file, id, &above);
        for (uint32_t c = 0; c < above.child_count; c++) {
            stp_chunk *child = prep_chunk(file, above.first_child + c, &below);
            assert_true(assert_held(parent, &above, c, child, &below) >= child->patch_count);
            stp_chunk_destroy(&child);
        }
        stp_chunk_destroy(&parent);
    }
    stp_chunk_file_close(&file);
}

static bool every;

static void repair_each_segment(int format)
{
    bench *b = model_bench(format);
    uint32_t count = stp_get_u32(b->bytes + 16);
    assert_true(count > 2);
    assert_all_held(fixture_path("sound.stipple"));
    for (uint32_t id = 0; id < count; id++)
        for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
            size_t size = 0, at;
            if (!every && (id + (uint32_t)s + (uint32_t)format) % 2 != 0)
                continue;
            memcpy(b->damaged, b->bytes, b->size);
            at = (size_t)(segment(b, id, s, &size) - b->damaged);
            memset(b->damaged + at + size / 3, 0, size / 3);
            repair(b);
            assert_int_equal(b->result.whole, id == 0);
            assert_all_held(output_path());
        }
    stp_pool_destroy(&b->pool);
    free(b->bytes);
    free(b->damaged);
    free(b);
}

static void test_errors_held(void **state)
{
    (void)state;
    repair_each_segment(1);
}

static void test_errors_held_in_blocks(void **state)
{
    (void)state;
    repair_each_segment(2);
}

int main(int argc, char **argv)
{
    every = argc > 1 && strcmp(argv[1], "--every") == 0;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_errors_held),
        cmocka_unit_test(test_errors_held_in_blocks),
    };
    return cmocka_run_group_tests_name("repaired model", tests, NULL, fixture_remove_folder);
}

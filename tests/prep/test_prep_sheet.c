/* Tests two sides one sample spacing apart with opposed normals: no merged sample may hold both. */
#include "tests/fixtures/model_fixture.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/size.h"

#define OUT "test_prep_sheet.stipple"

enum { COUNT = TEST_SIZE(300000, 150000) };

/* Counts the patch's merged samples whose level-0 samples are of both sides. */
static size_t mixed_of_patch(const stp_chunk *chunk, uint32_t p, size_t *merged)
{
    const stp_patch *patch = &chunk->patches[p];
    const stp_sample *samples = chunk->samples[0] + chunk->level_begin[0][p];
    unsigned sides[STP_PATCH_SAMPLES] = {0}; /* bits: the sides under each sample of a level */
    size_t mixed = 0;
    for (unsigned i = 0; i < patch->counts[0]; i++)
        sides[i] = samples[i].class_id; /* 1 or 2, as gen writes it */
    for (int level = 1; level < STP_LEVEL_COUNT; level++) {
        unsigned count = patch->counts[level], finer = patch->counts[level - 1];
        for (unsigned j = 0; j < count; j++) {
            unsigned held = 0;
            for (unsigned i = stp_level_children_begin(j, count, finer);
                 i < stp_level_children_begin(j + 1, count, finer); i++)
                held |= sides[i];
            sides[j] = held;
            mixed += held == 3;
        }
        *merged += count;
    }
    return mixed;
}

static size_t count_mixed(const model_recipe *recipe)
{
    size_t mixed = 0, merged = 0;
    model_fixture_build(OUT, recipe);
    stp_chunk_file *file = prep_open_verified(OUT);
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry;
        stp_chunk *chunk = prep_chunk(file, id, &entry);
        for (uint32_t p = 0; entry.child_count == 0 && p < chunk->patch_count; p++)
            mixed += mixed_of_patch(chunk, p, &merged);
        stp_chunk_destroy(&chunk);
    }
    print_message("%zu of %zu merged samples hold both sides\n", mixed, merged);
    assert_true(merged > recipe->point_count / 4);
    stp_chunk_file_close(&file);
    return mixed;
}

static void true_normals_part_the_sides(void **state)
{
    (void)state;
    assert_int_equal(count_mixed(&(model_recipe){
                         .shape = GEN_SHEET, .point_count = COUNT, .true_normals = true}),
                     0);
}

static void positions_part_the_sides(void **state)
{
    (void)state;
    assert_int_equal(count_mixed(&(model_recipe){.shape = GEN_SHEET, .point_count = COUNT}), 0);
}

/* With noise of a fifth of half the gap, one point in 40,000 lies nearer to the other side. */
static void noisy_positions_part_nearly_all(void **state)
{
    (void)state;
    const model_recipe recipe = {.shape = GEN_SHEET, .point_count = COUNT, .noise_spacings = 0.1};
    assert_true(count_mixed(&recipe) < 20);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(true_normals_part_the_sides),
        cmocka_unit_test(positions_part_the_sides),
        cmocka_unit_test(noisy_positions_part_nearly_all),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

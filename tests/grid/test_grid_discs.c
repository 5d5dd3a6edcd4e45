/* Tests how wide the merged discs of grids of heights are: where no sample is missing, little wider
 * than their cells ask; above leaves of a grid with holes, as wide as those of scattered points. */
#include "tests/fixtures/hole_fixture.h"

#define OUT "test_grid_discs.stipple"

static bool nothing(int column, int row)
{
    (void)column;
    (void)row;
    return false;
}

/* The greatest radius of the vertices of patches over the spacing of these; of leaves, and above.
 */
static void measure(hole_mask *missing, double widest[2])
{
    stp_prep_stats stats;
    prep_cloud cloud = hole_cloud(missing);
    widest[0] = widest[1] = 0.0;
    assert_int_equal(prep_cloud_run(&cloud, OUT, 2, NULL, &stats, NULL), STP_OK);
    assert_true(stats.keeps_grid);
    stp_chunk_file *file = prep_open_verified(OUT);
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry;
        stp_chunk *chunk = prep_chunk(file, id, &entry);
        const int above = entry.child_count > 0;
        for (uint32_t p = 0; p < chunk->patch_count; p++) {
            const stp_patch *patch = &chunk->patches[p];
            const double radius = stp_radius_decode(patch->radius[3], patch->exponent);
            if (patch->counts[0] == STP_PATCH_SAMPLES)
                widest[above] = fmax(widest[above], radius / (above ? 64.0 : 8.0));
        }
        stp_chunk_destroy(&chunk);
    }
    stp_chunk_file_close(&file);
    free(cloud.points);
}

static void discs_are_as_wide_as_cells_ask(void **state)
{
    double whole[2], holed[2];
    (void)state;
    measure(nothing, whole);
    measure(hole_discs, holed);
    print_message("whole: %.2f, above %.2f spacings; with holes %.2f and %.2f\n", whole[0],
                  whole[1], holed[0], holed[1]);
    assert_true(whole[0] < 1.25 && whole[1] < 1.25);
    /* holes under a disc above leaves are found by its rim alone */
    assert_true(holed[0] < 1.25 && holed[1] > 1.35);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(discs_are_as_wide_as_cells_ask)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

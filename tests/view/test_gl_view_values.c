/* Tests which sample of a grid of heights was clicked: its column and row in the image, its height,
 * and which of its neighbours are missing. */
#include "runtime/cut/model.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/support/check.h"
#include "tools/view/view_values.h"

enum { COLUMNS = 300, ROWS = 40 }; /* two leaves */

static bool is_missing(int column, int row)
{
    return (column == 100 && row == 20) || (column == 101 && row == 20);
}

static double height(int column, int row)
{
    return 0.25 * column - 0.5 * row;
}

static stp_model *open_grid(void)
{
    stp_prep_stats stats;
    stp_model *model = NULL;
    prep_cloud cloud = prep_cloud_make((size_t)COLUMNS * ROWS);
    cloud.raster = (stp_scan_raster){COLUMNS, ROWS, 1000.0, 5000.0, 2.0, 3.0};
    for (int i = 0; i < COLUMNS * ROWS; i++) {
        const int column = i % COLUMNS, row = i / COLUMNS;
        cloud.points[i].position =
            (stp_dvec3){1000.0 + 2.0 * column, 5000.0 - 3.0 * row, height(column, row)};
        cloud.points[i].normal = (vec3s){{0.0f, 0.0f, 1.0f}};
        cloud.points[i].reject = is_missing(column, row) ? STP_REJECT_INVALID : STP_REJECT_NONE;
    }
    check_ok(prep_cloud_run(&cloud, "view_values.stipple", 2,
                            &(stp_prep_params){.codec = STP_CODEC_DRACO, .precision = 1e-3}, &stats,
                            err));
    free(cloud.points);
    check_ok(stp_model_open(&model, "view_values.stipple", err));
    return model;
}

/* What is found at a place of the map, in the leaf that has it. */
static view_grid_sample click(const stp_model *model, double x, double y, double z, int level)
{
    view_values found;
    stp_pick pick = {
        .hit = true, .position = {x, y, z}, .chunk = STP_PICK_NO_CHUNK, .level = level};
    for (uint32_t id = 0; id < model->info->chunk_count; id++) {
        const stp_chunk_entry *e = &model->entries[id];
        if (pick.chunk == STP_PICK_NO_CHUNK && e->child_count == 0 &&
            x >= e->origin.x + (double)e->box_min.x && x <= e->origin.x + (double)e->box_max.x)
            pick.chunk = id;
    }
    view_values_find(&found, model, &pick);
    assert_int_equal(found.count, 0); /* no attributes */
    return found.grid;
}

static void expect(const stp_model *model, int column, int row, unsigned told, unsigned missing)
{
    /* a little beside the sample */
    const view_grid_sample s =
        click(model, 1000.0 + 2.0 * column + 0.4, 5000.0 - 3.0 * row - 0.6, height(column, row), 0);
    assert_true(s.known);
    assert_int_equal(s.column, column);
    assert_int_equal(s.row, row);
    assert_true(fabs(s.height - height(column, row)) < 1e-3);
    assert_int_equal(s.told, told);
    assert_int_equal(s.missing, missing);
}

static void a_sample_knows_its_place_and_its_neighbours(void **state)
{
    stp_model *model = open_grid();
    (void)state;
    expect(model, 50, 10, 8, 0);
    expect(model, 99, 19, 8, 1);
    expect(model, 102, 21, 8, 1);
    expect(model, 100, 21, 8, 2);
    expect(model, 270, 12, 8, 0);
    expect(model, 255, 12, 5, 0); /* the next column is in another leaf */
    expect(model, 0, 0, 3, 0);    /* nothing is beyond the corner */
    assert_false(click(model, 1100.0, 4970.0, 7.5, 1).known);
    stp_model_close(&model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sample_knows_its_place_and_its_neighbours),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

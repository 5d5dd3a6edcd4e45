/* Tests which sample of a grid of heights, or pixel of a depth image, was clicked: its column and
 * row in the image, its height or depth, and which of its neighbours are missing. */
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
    cloud.raster = (stp_scan_raster){
        .columns = COLUMNS, .rows = ROWS, .x = 1000.0, .y = 5000.0, .dx = 2.0, .dy = 3.0};
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

enum { WIDTH = 160, HEIGHT = 120, IMAGE = WIDTH * HEIGHT };

static const stp_dvec3 station = {3.0, -2.0, 1.0};

/* Where a camera that looks along z sees a pixel, x to the left if it is mirrored. */
static stp_dvec3 seen_at(int column, int row, bool mirrored)
{
    const double z = 4.0 + 0.004 * column + 0.01 * row, x = (column - 80.0) / 150.0 * z;
    return stp_dvec3_add(station, (stp_dvec3){mirrored ? -x : x, (row - 55.0) / 150.0 * z, z});
}

static stp_model *open_image(bool mirrored)
{
    stp_prep_stats stats;
    stp_model *model = NULL;
    stp_pool *pool = NULL;
    prep_cloud cloud = prep_cloud_make(IMAGE);
    for (int i = 0; i < IMAGE; i++) {
        const int column = i % WIDTH, row = i / WIDTH;
        cloud.points[i].position = seen_at(column, row, mirrored);
        cloud.points[i].station = 1;
        cloud.points[i].reject = is_missing(column, row) ? STP_REJECT_INVALID : STP_REJECT_NONE;
    }
    const stp_prep_file file = {
        .name = "an image", .point_count = IMAGE, .grid = {WIDTH, HEIGHT}, .station_count = 1};
    const stp_prep_source source = {.context = &cloud,
                                    .read = prep_cloud_read,
                                    .point_count = IMAGE,
                                    .attributes = STP_POINT_HAS_STATION,
                                    .stations = &station,
                                    .station_count = 1,
                                    .files = &file,
                                    .file_count = 1};
    check_ok(stp_pool_create(&pool, 2, err));
    check_ok(stp_prep_run("view_image.stipple", &source,
                          &(stp_prep_params){.codec = STP_CODEC_DRACO, .force = true}, pool, NULL,
                          &stats, err));
    stp_pool_destroy(&pool);
    free(cloud.points);
    check_ok(stp_model_open(&model, "view_image.stipple", err));
    return model;
}

static void a_pixel_knows_its_place_and_its_depth(void **state)
{
    static const int places[][4] = {/* column, row, neighbours told and missing */
                                    {50, 10, 8, 0},
                                    {99, 19, 8, 1},
                                    {100, 21, 8, 2},
                                    {159, 60, 5, 0},
                                    {0, 0, 3, 0}};
    (void)state;
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        stp_model *model = open_image(mirrored);
        for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
            const int *p = places[i];
            const stp_dvec3 at = seen_at(p[0], p[1], mirrored);
            const view_grid_sample s = click(model, at.x, at.y, at.z, 0);
            assert_true(s.known && s.is_depth);
            assert_int_equal(s.column, p[0]);
            assert_int_equal(s.row, p[1]);
            assert_true(fabs(s.height - (at.z - station.z)) < 2e-3);
            assert_int_equal(s.told, p[2]);
            assert_int_equal(s.missing, p[3]);
        }
        stp_model_close(&model);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sample_knows_its_place_and_its_neighbours),
        cmocka_unit_test(a_pixel_knows_its_place_and_its_depth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

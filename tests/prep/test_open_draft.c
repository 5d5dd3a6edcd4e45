/* Tests drafts of grids: of every so manieth column and row, over the whole extent, as a grid of
 * its own. */
#include "tests/fixtures/prep_fixture.h"
#include "tools/open/open_draft.h"

#include <cJSON.h>

#include <math.h>

enum { COLUMNS = 900, ROWS = 700, STEP = 4 /* ceil(sqrt(900 * 700 / 60,000)) */ };

static double height_at(double column, double row)
{
    return 40.0 * sin(column / 90.0) * cos(row / 70.0);
}

/* PFM has the last row first. */
static void write_grid(const char *path)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fprintf(file, "Pf\n%d %d\n-1\n", COLUMNS, ROWS);
    for (int row = ROWS - 1; row >= 0; row--)
        for (int column = 0; column < COLUMNS; column++)
            fwrite(&(float){(float)height_at(column, row)}, sizeof(float), 1, file);
    fclose(file);
}

static void make_draft(const char *scan, const char *path, const char *where)
{
    stp_error error = {0};
    bool made = false;
    const prep_paths scans = {.list = &(char *){(char *)scan}, .count = 1};
    remove(path);
    if (open_draft_make(&made, &scans, path, where, &(cli_common){.quiet = true}, &error) != STP_OK)
        fail_msg("%s", error.message);
    assert_true(made);
}

/* Each sample is one of the grid's, at its place. */
static void take_sample(void *context, const stp_chunk_entry *entry, const stp_patch *patch,
                        const stp_sample *sample)
{
    bool(*seen)[COLUMNS / STEP] = context;
    const stp_dvec3 at = stp_dvec3_add(entry->origin, stp_sample_position(sample, patch));
    const int column = (int)lround(at.x), row = ROWS - 1 - (int)lround(at.y);
    assert_true(fabs(at.x - column) < 0.05 * STEP);
    assert_true(fabs(at.y - (ROWS - 1 - row)) < 0.05 * STEP);
    assert_true(column % STEP == 0 && row % STEP == 0 && !seen[row / STEP][column / STEP]);
    assert_true(fabs(at.z - height_at(column, row)) < 0.05 * STEP);
    seen[row / STEP][column / STEP] = true;
}

static void every_so_manieth_column_and_row(void **state)
{
    (void)state;
    static bool seen[ROWS / STEP][COLUMNS / STEP];
    write_grid("draft.pfm");
    make_draft("draft.pfm", "draft.stipple", NULL);
    stp_chunk_file *file = prep_open_verified("draft.stipple");
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    cJSON *metadata = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    assert_true(cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(metadata, "grid")));
    cJSON_Delete(metadata);
    prep_visit_points(file, take_sample, seen);
    for (int i = 0; i < ROWS / STEP * (COLUMNS / STEP); i++)
        assert_true(seen[i / (COLUMNS / STEP)][i % (COLUMNS / STEP)]);
    stp_chunk_file_close(&file);
}

/* With a condition a draft has those of some points that fulfil it. */
static void with_a_condition(void **state)
{
    (void)state;
    write_grid("draft.pfm");
    make_draft("draft.pfm", "where.stipple", "z>20");
    stp_chunk_file *file = prep_open_verified("where.stipple");
    const uint64_t count = stp_chunk_file_get_info(file)->point_count;
    assert_true(count > 1000 && count < COLUMNS * ROWS / 10);
    stp_chunk_file_close(&file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_so_manieth_column_and_row),
                                       cmocka_unit_test(with_a_condition)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

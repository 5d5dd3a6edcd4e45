/* Tests marks, profiles and the dialog for files without a window: files of marks come back or are
 * refused, what the dialog lists of a folder and of the files opened last is as its headers say,
 * and the profile's thread finds and writes what `stipple profile` does, and ends when told. */
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/support/check.h"
#include "tools/profile/profile_write.h"
#include "tools/view/dialog/view_folder.h"
#include "tools/view/dialog/view_recent.h"
#include "tools/view/kept/view_marked.h"
#include "tools/view/view_profile.h"

#include <sys/stat.h>
#include <unistd.h>

static void write_text(const char *path, const char *text)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static void marks_come_back(void **state)
{
    (void)state;
    static view_marked kept, read;
    assert_int_equal(setenv("XDG_STATE_HOME", "/proc/none", 1), 0); /* not the user's own */
    check_ok(view_marked_load(&kept, NULL, "m.stipple", err));
    assert_int_equal(kept.count, 0);
    for (int i = 0; i < VIEW_MARKED_LIMIT; i++)
        assert_true(view_marked_add(&kept, (stp_dvec3){456000.125 + i, 5428000.001, 0.1}));
    assert_false(view_marked_add(&kept, (stp_dvec3){0}));
    snprintf(kept.items[0].name, sizeof kept.items[0].name, "north \"gate\" \xc3\xa9");
    view_marked_remove(&kept, 5);
    view_marked_remove(&kept, 1000);
    check_ok(view_marked_save(&kept, "m.stipple", err));
    assert_string_equal(kept.path, "m.stipple.marks.json");
    check_ok(view_marked_load(&read, NULL, "m.stipple", err));
    assert_int_equal(read.count, VIEW_MARKED_LIMIT - 1);
    assert_string_equal(read.items[0].name, kept.items[0].name);
    for (size_t i = 0; i < read.count; i++)
        assert_true(stp_dvec3_equal(read.items[i].position, kept.items[i].position));
}

/* A file that the user gives need not be there yet; marks go to no other file. */
static void a_given_file(void **state)
{
    (void)state;
    static view_marked kept, read;
    check_ok(view_marked_load(&kept, "given.json", "none.stipple", err));
    assert_int_equal(kept.count, 0);
    assert_true(view_marked_add(&kept, (stp_dvec3){1.0, 2.0, 3.0}));
    check_ok(view_marked_save(&kept, "none.stipple", err));
    assert_int_not_equal(access("none.stipple.marks.json", F_OK), 0);
    check_ok(view_marked_load(&read, "given.json", "none.stipple", err));
    assert_int_equal(read.count, 1);
    check_ok(view_marked_load(&kept, "no-such-folder/given.json", "none.stipple", err));
    stp_error error = {0};
    assert_true(view_marked_save(&kept, "none.stipple", &error) != STP_OK);
    assert_true(strlen(error.message) > 20);
}

static void wrong_marks_are_refused(void **state)
{
    (void)state;
    static const char *const wrong[] = {
        "",
        "[]",
        "{\"marks\": {}}",
        "{\"marks\": [1]}",
        "{\"marks\": [{\"name\": \"a\"}]}",
        "{\"marks\": [{\"position\": [1, 2]}]}",
        "{\"marks\": [{\"position\": [1, 2, 3, 4]}]}",
        "{\"marks\": [{\"position\": [1, 2, null]}]}",
        "{\"marks\": [{\"position\": [1, 2, 1e999]}]}",
    };
    static view_marked kept;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        stp_error error = {0};
        write_text("wrong.json", wrong[i]);
        assert_true(view_marked_load(&kept, "wrong.json", "m.stipple", &error) != STP_OK);
        assert_int_equal(kept.count, 0);
        assert_non_null(strstr(error.message, "wrong.json"));
        assert_null(strchr(error.message, '\n'));
    }
}

/* ---- profiles ---- */

enum { SIDE = 120 };

static stp_chunk_file *open_slope(const char *path)
{
    stp_prep_stats stats;
    stp_chunk_file *file = NULL;
    prep_cloud cloud = prep_cloud_make(SIDE * SIDE);
    for (int i = 0; i < SIDE * SIDE; i++)
        cloud.points[i].position = (stp_dvec3){i % SIDE, i / SIDE, 0.25 * (i % SIDE)};
    check_ok(prep_cloud_run(&cloud, path, 2, NULL, &stats, err));
    free(cloud.points);
    check_ok(stp_chunk_file_open(&file, path, err));
    return file;
}

static stp_status wait_for(view_profile *p)
{
    stp_error error = {0};
    stp_status status = STP_OK;
    int turns = 0;
    while (!view_profile_poll(p, &status, &error)) {
        usleep(1000);
        assert_true(++turns < 60000);
    }
    return status;
}

static void expect_same_files(const char *a, const char *b)
{
    size_t sizes[2];
    uint8_t *bytes[2] = {prep_file_bytes(a, &sizes[0]), prep_file_bytes(b, &sizes[1])};
    assert_int_equal(sizes[0], sizes[1]);
    assert_memory_equal(bytes[0], bytes[1], sizes[0]);
    free(bytes[0]);
    free(bytes[1]);
}

static void write_profile(const profile *p, const char *path, bool chart)
{
    stp_output *output = NULL;
    check_ok(stp_output_create(&output, path, true, err));
    check_ok(chart ? profile_write_svg(p, output, err) : profile_write_csv(p, output, err));
    check_ok(stp_output_commit(&output, err));
    stp_output_destroy(&output);
}

static void a_profile_is_that_of_the_command(void **state)
{
    (void)state;
    static view_profile p;
    static const char *const names[2][2] = {{"own.csv", "other.csv"}, {"own.svg", "other.svg"}};
    stp_chunk_file *file = open_slope("slope.stipple");
    const profile_line line = {.from = {10.0, 60.0}, .to = {110.0, 60.0}};
    profile found = {0};
    stp_error error = {0};
    check_ok(profile_find(&found, file, &line, NULL, err));
    check_ok(view_profile_begin(&p, &file, 1, &line, err));
    assert_int_equal(view_profile_begin(&p, &file, 1, &line, &error),
                     STP_LIMIT); /* one at a time */
    assert_int_equal(wait_for(&p), STP_OK);
    assert_int_equal(p.found.count, found.count);
    assert_memory_equal(p.found.points, found.points, found.count * sizeof *found.points);
    assert_true(p.cell_count > VIEW_PROFILE_ROWS / 2 && p.cell_count <= found.count);
    for (size_t i = 0; i < p.cell_count; i++) /* a slope: as far up as along */
        assert_true(abs(p.cells[i].row * (VIEW_PROFILE_COLUMNS - 1) -
                        p.cells[i].column * (VIEW_PROFILE_ROWS - 1)) < 2 * VIEW_PROFILE_COLUMNS);
    for (int chart = 0; chart < 2; chart++) {
        check_ok(view_profile_save(&p, names[chart][0], chart != 0, err));
        assert_int_equal(wait_for(&p), STP_OK);
        write_profile(&found, names[chart][1], chart != 0);
        expect_same_files(names[chart][0], names[chart][1]);
    }
    /* an existing file is not replaced; the profile stays */
    check_ok(view_profile_save(&p, names[0][0], false, err));
    assert_int_equal(wait_for(&p), STP_EXISTS);
    assert_int_equal(p.state, VIEW_PROFILE_READY);
    view_profile_forget(&p, NULL);
    assert_int_equal(p.state, VIEW_PROFILE_NONE);
    profile_clear(&found);
    stp_chunk_file_close(&file);
}

/* A line beside one of two models has the other's points; beside both it says so. A model that is
 * closed while its profile is made ends the job. */
static void several_models_and_early_ends(void **state)
{
    (void)state;
    static view_profile p;
    stp_chunk_file *files[2] = {open_slope("slope.stipple"), open_slope("other.stipple")};
    const profile_line line = {.from = {10.0, 60.0}, .to = {110.0, 60.0}},
                       beside = {.from = {1000.0, 0.0}, .to = {1010.0, 0.0}};
    check_ok(view_profile_begin(&p, files, 1, &line, err));
    assert_int_equal(wait_for(&p), STP_OK);
    const size_t one = p.found.count;
    check_ok(view_profile_begin(&p, files, 2, &line, err));
    assert_int_equal(wait_for(&p), STP_OK);
    assert_int_equal(p.found.count, 2 * one);
    for (size_t i = 1; i < p.found.count; i++)
        assert_true(p.found.points[i - 1].distance <= p.found.points[i].distance);
    check_ok(view_profile_begin(&p, files, 2, &beside, err));
    assert_int_equal(wait_for(&p), STP_EMPTY);
    assert_int_equal(p.state, VIEW_PROFILE_NONE);
    for (int i = 0; i < 20; i++) {
        check_ok(view_profile_begin(&p, files, 2, &line, err));
        usleep((useconds_t)(200 * i));
        view_profile_forget(&p, i % 2 != 0 ? files[1] : NULL);
        assert_int_equal(p.state, VIEW_PROFILE_NONE);
    }
    stp_chunk_file_close(&files[0]);
    stp_chunk_file_close(&files[1]);
}

static void a_folder_is_listed(void **state)
{
    static const char *const files[] = {"b.LAZ", "a.stipple", ".hidden.ply", "notes.md", "h.tif"};
    static const char *const listed[] = {"sub/", "a.stipple", "b.LAZ", "h.tif"};
    view_folder folder = {0};
    stp_error error = {0};
    char path[64];
    (void)state;
    assert_int_equal(mkdir("listed", 0777), 0);
    assert_int_equal(mkdir("listed/sub", 0777), 0);
    assert_int_equal(mkdir("listed/.git", 0777), 0);
    for (int i = 0; i < 5; i++) {
        snprintf(path, sizeof path, "listed/%s", files[i]);
        write_text(path, "x");
    }
    assert_int_equal(symlink("nowhere", "listed/c.ply"), 0); /* leads to no file */
    check_ok(view_folder_list(&folder, "listed", err));
    assert_int_equal(folder.count, 4);
    for (int i = 0; i < 4; i++)
        assert_string_equal(folder.names[i], listed[i]);
    check_ok(view_folder_list(&folder, "listed/sub", err));
    assert_int_equal(folder.count, 0);
    assert_int_equal(view_folder_list(&folder, "listed/none", &error), STP_IO);
    assert_int_equal(folder.count, 0);
    view_folder_clear(&folder);
}

/* The newest first, each once, no more than the limit; no address with a password or a key. */
static void recent_files_are_listed(void **state)
{
    char *here = realpath(".", NULL), folder[4096], name[32];
    view_recent recent;
    (void)state;
    assert_non_null(here);
    snprintf(folder, sizeof folder, "%s/state", here);
    assert_int_equal(setenv("XDG_STATE_HOME", folder, 1), 0);
    view_recent_load(&recent);
    assert_int_equal(recent.count, 0);
    for (int i = 0; i < VIEW_RECENT_LIMIT + 3; i++) {
        snprintf(name, sizeof name, "recent%d.ply", i);
        write_text(name, "x");
        view_recent_note(name);
    }
    view_recent_note("https://user:word@example.org/a.laz");
    view_recent_note("https://example.org/a.laz?key=1");
    view_recent_note("none.ply");
    view_recent_note("recent5.ply");
    view_recent_note("https://example.org/a.laz");
    view_recent_note("recent5.ply");
    view_recent_load(&recent);
    assert_int_equal(recent.count, VIEW_RECENT_LIMIT);
    snprintf(folder, sizeof folder, "%s/recent5.ply", here);
    assert_string_equal(recent.paths[0], folder);
    assert_string_equal(recent.paths[1], "https://example.org/a.laz");
    snprintf(folder, sizeof folder, "%s/recent%d.ply", here, VIEW_RECENT_LIMIT + 2);
    assert_string_equal(recent.paths[2], folder);
    for (size_t i = 1; i < recent.count; i++)
        assert_string_not_equal(recent.paths[i], recent.paths[0]);
    view_recent_clear(&recent);
    write_text("state/stipple/recent.json", "{\"files\": [3, \"/a\", {}]}");
    view_recent_load(&recent);
    assert_int_equal(recent.count, 1);
    view_recent_clear(&recent);
    write_text("state/stipple/recent.json", "[");
    view_recent_load(&recent);
    assert_int_equal(recent.count, 0);
    free(here);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(marks_come_back),
        cmocka_unit_test(a_given_file),
        cmocka_unit_test(wrong_marks_are_refused),
        cmocka_unit_test(a_profile_is_that_of_the_command),
        cmocka_unit_test(several_models_and_early_ends),
        cmocka_unit_test(a_folder_is_listed),
        cmocka_unit_test(recent_files_are_listed),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

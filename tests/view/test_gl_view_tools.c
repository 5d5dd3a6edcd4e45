/* Tests the parts of the viewer that need no window: bookmarks, recorded paths, moving on the
 * ground. */
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/support/check.h"
#include "tools/view/kept/view_bookmarks.h"
#include "tools/view/kept/view_record.h"
#include "tools/view/kept/view_smooth.h"
#include "tools/view/panels/view_legend.h"
#include "tools/view/view_measure.h"
#include "tools/view/view_move.h"

#include <sys/stat.h>
#include <unistd.h>

static stp_camera camera_at(double x)
{
    return (stp_camera){.eye = {456000.125 + x, 5428000.0, 300.0},
                        .look = {456010.0, 5428000.001, 290.0},
                        .up = {0.0, 0.0, 1.0},
                        .fovy_deg = 40.0};
}

static void write_text(const char *path, const char *text)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static void kept_views_come_back(void **state)
{
    (void)state;
    static view_bookmarks kept, read;
    stp_camera camera = camera_at(0.0);
    unlink("kept.stipple.views.json");
    assert_int_equal(setenv("XDG_STATE_HOME", "/proc/none", 1), 0); /* not the user's own */
    check_ok(view_bookmarks_load(&kept, "kept.stipple", err));
    assert_int_equal(kept.count, 0);
    for (int i = 0; i < VIEW_BOOKMARKS_LIMIT; i++)
        assert_true(view_bookmarks_add(&kept, &camera));
    assert_false(view_bookmarks_add(&kept, &camera)); /* the limit */
    camera.height = 12.5;
    kept.items[1].camera = camera;
    snprintf(kept.items[0].name, sizeof kept.items[0].name, "north \"gate\" \xc3\xa9");
    view_bookmarks_remove(&kept, 5);
    view_bookmarks_remove(&kept, 1000);
    check_ok(view_bookmarks_save(&kept, "kept.stipple", err));
    assert_string_equal(kept.path, "kept.stipple.views.json");
    check_ok(view_bookmarks_load(&read, "kept.stipple", err));
    assert_int_equal(read.count, VIEW_BOOKMARKS_LIMIT - 1);
    assert_string_equal(read.items[0].name, kept.items[0].name);
    for (size_t i = 0; i < read.count; i++) {
        const stp_camera *a = &read.items[i].camera, *b = &kept.items[i].camera;
        assert_true(a->eye.x == b->eye.x && a->look.y == b->look.y && a->up.z == b->up.z);
        assert_true(a->fovy_deg == b->fovy_deg && a->height == b->height);
    }
}

static void wrong_files_of_views_are_refused(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "",
        "[]",
        "{}",
        "{\"views\": 3}",
        "{\"views\": [{}]}",
        "{\"views\": [3]}",
        "{\"views\": [{\"eye\": [0,0], \"look\": [0,0,1], \"up\": [0,1,0]}]}",
        "{\"views\": [{\"eye\": [0,0,1], \"look\": [0,0,1], \"up\": [0,1,0]}]}",
        "{\"views\": [{\"eye\": [0,0,1e999], \"look\": [0,0,1], \"up\": [0,1,0]}]}",
    };
    static view_bookmarks kept;
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        stp_error err = {0};
        write_text("wrong.stipple.views.json", texts[i]);
        assert_true(view_bookmarks_load(&kept, "wrong.stipple", &err) != STP_OK);
        assert_int_equal(kept.count, 0);
        assert_true(strlen(err.message) > 10);
    }
    unlink("wrong.stipple.views.json");
}

/* If bookmarks cannot be written beside the model, they go to the folder of states and are found
 * there. */
static void unwritable_places_lead_elsewhere(void **state)
{
    (void)state;
    static view_bookmarks kept, read;
    char here[VIEW_PATH_BYTES - 16], folder[VIEW_PATH_BYTES];
    assert_non_null(getcwd(here, sizeof here));
    snprintf(folder, sizeof folder, "%s/states", here);
    assert_int_equal(setenv("XDG_STATE_HOME", folder, 1), 0);
    stp_camera camera = camera_at(1.0);
    view_bookmarks_add(&kept, &camera);
    check_ok(view_bookmarks_save(&kept, "no-such-folder/m.stipple", err));
    assert_non_null(strstr(kept.path, "/states/stipple/m.stipple-"));
    check_ok(view_bookmarks_load(&read, "no-such-folder/m.stipple", err));
    assert_int_equal(read.count, 1);
    unlink(kept.path);
    check_ok(view_bookmarks_save(&kept, "https://example.org/m.stipple", err));
    assert_non_null(strstr(kept.path, "/states/stipple/m.stipple-"));
    unlink(kept.path);
    assert_int_equal(setenv("XDG_STATE_HOME", "/proc/none", 1), 0);
    stp_error err = {0};
    kept.path[0] = '\0';
    assert_true(view_bookmarks_save(&kept, "no-such-folder/m.stipple", &err) != STP_OK);
    assert_true(strlen(err.message) > 10);
}

/* Records a move, a rest and a move: the path must rest too. */
static void a_recorded_rest_is_one(void **state)
{
    (void)state;
    view_record record = {0};
    stp_path *path = NULL;
    double time_s = 100.0;
    view_record_begin(&record, time_s);
    for (int i = 0; i <= 400; i++, time_s += 0.02) {
        double moved = i < 100 ? i : i < 300 ? 100.0 : i - 200.0;
        stp_camera camera = camera_at(0.01 * moved);
        check_ok(view_record_note(&record, &camera, time_s, err));
    }
    stp_camera last = camera_at(2.0);
    unlink("recorded.path.json");
    check_ok(view_record_end(&record, &last, "recorded.path.json", time_s, err));
    assert_false(record.on);
    stp_camera base = camera_at(0.0);
    check_ok(stp_path_load(&path, "recorded.path.json", &base, err));
    check_near(stp_path_duration_s(path), time_s - 100.0 + 2.0 * VIEW_SMOOTH_EASE_S, 1e-9);
    for (double t = 3.1; t < 4.9; t += 0.1)
        check_near(stp_path_camera(path, t + VIEW_SMOOTH_EASE_S).eye.x, camera_at(1.0).eye.x, 1e-6);
    check_near(stp_path_camera(path, 1.0 + VIEW_SMOOTH_EASE_S).eye.x, camera_at(0.5).eye.x, 0.1);
    check_near(stp_path_camera(path, 99.0).eye.x, last.eye.x, 0.0);
    stp_path_destroy(&path);
    unlink("recorded.path.json");
    view_record_begin(&record, 0.0); /* ended at once: one keyframe */
    check_ok(view_record_end(&record, &last, "recorded.path.json", 0.0, err));
    last.height = 3.0;
    view_record_begin(&record, 0.0);
    check_ok(view_record_note(&record, &base, 0.0, err));
    assert_int_equal(view_record_note(&record, &last, 1.0, NULL), STP_UNSUPPORTED);
    unlink("recorded.path.json"); /* the earlier recording is kept */
    check_ok(view_record_end(&record, &last, "recorded.path.json", 1.0, err));
    check_ok(stp_path_load(&path, "recorded.path.json", &base, err));
    check_near(stp_path_camera(path, 0.0).eye.x, base.eye.x, 0.0);
    stp_path_destroy(&path);
    view_record_destroy(&record);
    unlink("recorded.path.json");
}

/* Records a flight at even speed that begins 3 s after the recording and ends 2 s before it, with
 * some late frames. The path must have an even pace, eased ends and no dead time. */
static void a_recording_is_made_even(void **state)
{
    (void)state;
    view_record record = {0};
    stp_path *path = NULL;
    const stp_camera base = camera_at(0.0);
    stp_camera shown = base;
    view_record_begin(&record, 0.0);
    for (double t = 0.0; t < 15.0; t += 0.02) {
        const double moved = 0.5 * fmin(fmax(t - 3.0, 0.0), 10.0);
        const stp_camera camera = camera_at(moved);
        const bool late = (t > 5.0 && t < 5.4) || (t > 8.0 && t < 8.3); /* late frames */
        check_ok(view_record_note(&record, late ? &shown : &camera, t, err));
        if (!late)
            shown = camera;
    }
    const stp_camera last = camera_at(5.0);
    unlink("even.path.json");
    check_ok(view_record_end(&record, &last, "even.path.json", 15.0, err));
    check_ok(stp_path_load(&path, "even.path.json", &base, err));
    const double length_s = stp_path_duration_s(path);
    check_near(length_s, 10.0 + 2.0 * VIEW_SMOOTH_EASE_S, 0.15);
    double fastest = 0.0, slowest = INFINITY;
    for (double t = 1.0; t < length_s - 1.0; t += 0.1) {
        const double speed =
            (stp_path_camera(path, t + 0.05).eye.x - stp_path_camera(path, t - 0.05).eye.x) / 0.1;
        fastest = fmax(fastest, speed);
        slowest = fmin(slowest, speed);
    }
    assert_true(slowest > 0.4 && fastest < 0.6);
    check_near(stp_path_camera(path, 0.0).eye.x, base.eye.x, 1e-6);
    check_near(stp_path_camera(path, length_s).eye.x, last.eye.x, 1e-6);
    assert_true(stp_path_camera(path, 0.1).eye.x - base.eye.x < 0.03);
    assert_true(last.eye.x - stp_path_camera(path, length_s - 0.1).eye.x < 0.03);
    stp_path_destroy(&path);
    view_record_destroy(&record);
    unlink("even.path.json");
}

/* Records ten hours with a move at either end: the path may not have more keyframes than the
 * limit. */
static void a_long_recording_can_be_read(void **state)
{
    (void)state;
    view_record record = {0};
    stp_path *path = NULL;
    const stp_camera base = camera_at(0.0);
    view_record_begin(&record, 0.0);
    for (double t = 0.0; t < 2.0; t += 0.1) {
        const stp_camera camera = camera_at(t);
        check_ok(view_record_note(&record, &camera, t, err));
    }
    for (double t = 0.0; t < 2.0; t += 0.1) {
        const stp_camera camera = camera_at(2.0 + t);
        check_ok(view_record_note(&record, &camera, 36000.0 + t, err));
    }
    const stp_camera last = camera_at(4.0);
    unlink("long.path.json");
    check_ok(view_record_end(&record, &last, "long.path.json", 36002.0, err));
    check_ok(stp_path_load(&path, "long.path.json", &base, err));
    check_near(stp_path_camera(path, 1e9).eye.x, last.eye.x, 1e-6);
    stp_path_destroy(&path);
    view_record_destroy(&record);
    unlink("long.path.json");
}

/* ---- moving ---- */

static bool slope(void *context, stp_dvec3 position, stp_dvec3 up, double *height)
{
    (void)context;
    (void)up;
    *height = 0.25 * position.x;
    return position.x < 50.0;
}

static double nothing(void *context, int x, int y)
{
    (void)context;
    (void)x;
    (void)y;
    return 0.0;
}

static view_control walker(view_navigation navigation)
{
    view_control c = {.ball = {{0.0, 0.0, 0.0}, 100.0},
                      .camera = {.eye = {0.0, 0.0, 1.7},
                                 .look = {10.0, 0.0, 1.7},
                                 .up = {0.0, 0.0, 1.0},
                                 .fovy_deg = 45.0},
                      .ground = slope,
                      .depth = nothing,
                      .navigation = navigation};
    stp_error err = {0};
    assert_int_equal(stp_view_create(&c.view, &c.camera, &c.ball, 64, 64, &err), STP_OK);
    view_move_reset(&c);
    return c;
}

static void hold(view_control *c, int key, bool down)
{
    const stp_window_event event = {.kind = STP_WINDOW_KEY, .key = key, .down = down};
    assert_true(view_move_key(c, &event));
}

static void walking_keeps_to_the_ground(void **state)
{
    (void)state;
    view_control c = walker(VIEW_WALK);
    check_near(c.eye_height, 1.7, 1e-12);
    hold(&c, 'W', true);
    for (int i = 0; i < 200; i++)
        view_move_advance(&c, 0.02);
    check_near(c.camera.eye.x, 4.0 * c.speed, 1e-9);
    hold(&c, 'W', false);
    for (int i = 0; i < 200 && view_move_advance(&c, 0.02); i++)
        ;
    assert_false(view_move_advance(&c, 0.02)); /* at rest: nothing to draw */
    check_near(c.camera.eye.z, 0.25 * c.camera.eye.x + 1.7, 1e-9);
    check_near(c.camera.look.x - c.camera.eye.x, 10.0, 1e-9);
    c.camera.eye.x = c.camera.look.x = 60.0; /* no ground: the height stays */
    c.camera.look.x = 70.0;
    double height = c.camera.eye.z;
    hold(&c, 'D', true);
    view_move_advance(&c, 0.02);
    check_near(c.camera.eye.z, height, 0.0);
}

static void flying_goes_where_it_looks(void **state)
{
    (void)state;
    view_control c = walker(VIEW_FLY);
    const stp_dvec3 begin = c.camera.eye;
    hold(&c, 'W', true);
    hold(&c, 'E', true);
    assert_true(view_move_advance(&c, 0.1));
    check_near(c.camera.eye.x - begin.x, 0.1 * c.speed, 1e-9);
    check_near(c.camera.eye.z - begin.z, 0.1 * c.speed, 1e-9);
    hold(&c, STP_KEY_SHIFT, true);
    hold(&c, 'E', false);
    stp_dvec3 here = c.camera.eye;
    view_move_advance(&c, 0.1);
    check_near(c.camera.eye.x - here.x, 0.5 * c.speed, 1e-9);
    here = c.camera.eye;
    view_move_advance(&c, 1000.0); /* a stall is no leap */
    assert_true(c.camera.eye.x - here.x < 5.0 * c.speed);
    hold(&c, 'W', false);
    assert_false(view_move_advance(&c, 0.1));
    for (int i = 0; i < 500; i++)
        view_move_speed(&c, 1.0);
    assert_true(isfinite(c.speed) && c.speed <= 10.0 * c.ball.radius);
    c.navigation = VIEW_ORBIT;
    const stp_window_event event = {.kind = STP_WINDOW_KEY, .key = 'W', .down = true};
    assert_false(view_move_key(&c, &event));
}

/* Orthographic and back: things at the middle's depth keep their size. */
/* A held key repeats some 30 times a second, and frames may be slower: repeats must share a
 * frame. */
static void repeats_of_a_key_share_a_turn(void **state)
{
    (void)state;
    stp_window_event key = {.kind = STP_WINDOW_KEY, .key = 'W', .down = true};
    assert_true(view_control_ends_turn(&key));
    key.repeated = true;
    assert_false(view_control_ends_turn(&key));
    key.repeated = key.down = false;
    assert_true(view_control_ends_turn(&key));
    assert_true(view_control_ends_turn(&(stp_window_event){.kind = STP_WINDOW_PRESS}));
    assert_true(view_control_ends_turn(&(stp_window_event){.kind = STP_WINDOW_RELEASE}));
    assert_false(view_control_ends_turn(&(stp_window_event){.kind = STP_WINDOW_MOVE}));
}

static void projections_keep_sizes(void **state)
{
    (void)state;
    view_control c = walker(VIEW_ORBIT);
    c.camera = stp_camera_around(&c.ball, (stp_dvec3){0.3, -1.0, 0.6}, (stp_dvec3){0.0, 0.0, 1.0},
                                 50.0, 640, 480);
    const double depth = stp_dvec3_length(stp_dvec3_sub(c.camera.eye, c.ball.centre));
    double across[3];
    for (int i = 0; i < 3; i++) {
        stp_view view;
        stp_error err = {0};
        assert_int_equal(stp_view_create(&view, &c.camera, &c.ball, 640, 480, &err), STP_OK);
        stp_dvec3 right = stp_dvec3_add(c.ball.centre, stp_dvec3_scale(view.right, 10.0));
        across[i] = stp_view_project(&view, right).x - stp_view_project(&view, c.ball.centre).x;
        view_control_project(&c, i == 0);
    }
    check_near(across[1], across[0], 1e-6);
    check_near(across[2], across[0], 1e-6);
    check_near(stp_dvec3_length(stp_dvec3_sub(c.camera.eye, c.ball.centre)), depth, 1e-6);
}

static double nothing_drawn(void *context, int x, int y)
{
    (void)context;
    (void)x;
    (void)y;
    return 0.0;
}

/* At an empty pixel, a drag holds the model's middle if the eye is outside, and otherwise the place
 * that the camera looks at. */
static void empty_pixels_have_a_depth(void **state)
{
    (void)state;
    view_control c = walker(VIEW_ORBIT);
    const stp_dvec3 back = {0.0, -1.0, 0.0};
    c.depth = nothing_drawn;
    for (int outside = 0; outside < 2; outside++) {
        stp_error err = {0};
        double depth = 0.0;
        c.camera.eye = stp_dvec3_add(c.ball.centre,
                                     stp_dvec3_scale(back, (outside ? 3.0 : 0.01) * c.ball.radius));
        c.camera.look = stp_dvec3_add(c.camera.eye, stp_dvec3_scale(back, -0.4 * c.ball.radius));
        c.camera.up = (stp_dvec3){0.0, 0.0, 1.0};
        c.camera.fovy_deg = 70.0;
        assert_int_equal(stp_view_create(&c.view, &c.camera, &c.ball, 640, 480, &err), STP_OK);
        view_control_point(&c, 320.0, 240.0, &depth);
        check_near(depth, (outside ? 3.0 : 0.4) * c.ball.radius, 1e-9);
    }
}

static void intensities_are_as_in_the_scans(void **state)
{
    (void)state;
    char text[64];
    for (int number = 0; number <= 200; number++) { /* each number of 8 bits comes back */
        char expected[16];
        snprintf(expected, sizeof expected, "%d", number);
        view_format_intensity(200.0, floor(number * 255.0 / 200.0 + 0.5) / 255.0, text);
        assert_string_equal(text, expected);
    }
    view_format_intensity(51000.0, 110.0 / 255.0, text);
    assert_string_equal(text, "about 22000, in steps of 200");
    view_format_intensity(0.5, 110.0 / 255.0, text);
    assert_string_equal(text, "0.216");
    view_format_intensity(0.0, 110.0 / 255.0, text);
    assert_string_equal(text, "43 % of the greatest");
}

static void measured_lines_stay(void **state)
{
    (void)state;
    static view_measure m;
    for (int i = 0; i < VIEW_LINES_LIMIT; i++) {
        assert_true(view_measure_add(&m, (stp_dvec3){i, 0.0, 0.0}));
        assert_int_equal(m.line_count, i);
        assert_true(view_measure_add(&m, (stp_dvec3){i, 3.0, 4.0 + i}));
        assert_false(m.begun);
        assert_ptr_equal(view_measure_last(&m), m.lines[i]);
    }
    assert_int_equal(m.line_count, VIEW_LINES_LIMIT);
    assert_false(view_measure_add(&m, (stp_dvec3){0.0, 0.0, 0.0})); /* the bound */
    check_near(view_measure_length(m.lines[0]), 5.0, 1e-12);
    view_measure_remove(&m, 1);
    view_measure_remove(&m, VIEW_LINES_LIMIT - 2);
    assert_int_equal(m.line_count, VIEW_LINES_LIMIT - 2);
    check_near(m.lines[0][0].x, 0.0, 0.0);
    check_near(m.lines[1][0].x, 2.0, 0.0);
    assert_true(view_measure_add(&m, (stp_dvec3){0.0, 0.0, 0.0}));
    view_measure_remove(&m, 0);
    assert_true(m.begun); /* a line that was begun goes on */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kept_views_come_back),
        cmocka_unit_test(wrong_files_of_views_are_refused),
        cmocka_unit_test(unwritable_places_lead_elsewhere),
        cmocka_unit_test(a_recorded_rest_is_one),
        cmocka_unit_test(walking_keeps_to_the_ground),
        cmocka_unit_test(flying_goes_where_it_looks),
        cmocka_unit_test(a_recording_is_made_even),
        cmocka_unit_test(a_long_recording_can_be_read),
        cmocka_unit_test(repeats_of_a_key_share_a_turn),
        cmocka_unit_test(projections_keep_sizes),
        cmocka_unit_test(empty_pixels_have_a_depth),
        cmocka_unit_test(intensities_are_as_in_the_scans),
        cmocka_unit_test(measured_lines_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

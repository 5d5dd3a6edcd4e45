/* Tests first views as drawn: the camera from a file's metadata, its form in pictures of other
 * shapes, and a depth camera's image, which covers its own pixels. */
#include "tests/fixtures/chunk_reseal.h"
#include "tests/fixtures/first_view_fixture.h"
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/prep_fixture.h"

#define ORIGIN ((stp_dvec3){0.0, 0.0, 0.0})
#define Z_AXIS ((stp_dvec3){0.0, 0.0, 1.0})

/* Draws first.stipple from its first view, as large as the image, complete and with backs. Of the
 * finite positions, at least 0.99 must find their own pixel covered, and at most half may lie more
 * than half a pixel off its centre. */
static void expect_drawn(const stp_dvec3 *at, int width, int height)
{
    gl_fixture f = {0};
    stp_view view;
    const size_t pixels = (size_t)width * (size_t)height;
    uint8_t *rgba = malloc(4 * pixels);
    size_t count = 0, covered = 0, near = 0;
    gl_fixture_open(&f, "first.stipple", NULL);
    const stp_camera camera = stp_model_camera(f.model, STP_HOME_FIRST, width, height);
    const stp_ball ball = stp_model_ball(f.model);
    check_ok(stp_view_create(&view, &camera, &ball, width, height, err));
    assert_non_null(rgba);
    gl_fixture_draw(&f, &view, &(stp_draw_params){.every_sample = true, .cull = STP_CULL_NONE},
                    NULL, rgba);
    for (size_t i = 0; i < pixels; i++) {
        const int column = (int)i % width, row = height - 1 - (int)i / width; /* from below */
        if (!stp_dvec3_finite(at[i]))
            continue;
        const stp_dvec3 p = stp_view_project(&view, at[i]);
        count++;
        near += hypot(p.x - (column + 0.5), p.y - (row + 0.5)) < 0.5;
        covered += rgba[4 * (row * width + column) + 3] != 0;
    }
    print_message("%zu points: %.3f %% covered, %.3f %% within half a pixel\n", count,
                  100.0 * (double)covered / (double)count, 100.0 * (double)near / (double)count);
    assert_true(count > 0 && (double)covered >= 0.99 * (double)count);
    assert_true(2 * near > count);
    gl_fixture_close(&f);
    free(rgba);
}

static void images_cover_their_pixels(void **state)
{
    (void)state;
    positions p = depth_image(&depth_small, false, (stp_dvec3){103.0, -52.0, 7.5},
                              (stp_dvec3){0.6, 0.7, -0.3}, 2.1);
    depth_write("depth.pcd", &p, depth_small.height, "103 -52 7.5 0 1 0 0");
    assert_int_equal(first_prep("depth.pcd", 2).first.why, STP_FIRST_SCANNER);
    expect_drawn(p.at, (int)depth_small.width, (int)depth_small.height);
    free(p.at);
}

/* Images of real depth cameras, 640 x 480. */
static void real_images_cover_their_pixels(void **state)
{
    (void)state;
    static const char *const names[] = {"grids/office1.pcd",
                                        "grids/milk_cartoon_all_small_clorox.pcd"};
    char path[4096];
    if (!scan_fixture_has_real())
        skip();
    for (size_t i = 0; i < 2; i++) {
        stp_scan_info info;
        if (!scan_fixture_real(names[i], path))
            continue;
        stp_point *points = scan_fixture_read(path, NULL, &info);
        stp_dvec3 *at = malloc(info.point_count * sizeof *at);
        assert_non_null(at);
        for (size_t k = 0; k < info.point_count; k++)
            at[k] = points[k].position;
        const stp_first_camera first = first_prep(path, 2).first;
        assert_int_equal(first.why, STP_FIRST_SCANNER);
        assert_true(stp_dvec3_equal(first.eye, ORIGIN));
        expect_drawn(at, (int)info.grid.columns, (int)info.grid.rows);
        free(at);
        free(points);
    }
}

/* A narrower or flatter picture must show the whole image. */
static void pictures_of_other_shapes(void **state)
{
    (void)state;
    static const int sizes[][2] = {{160, 120}, {120, 160}, {400, 100}, {128, 128}};
    positions p = depth_image(&depth_small, false, ORIGIN, Z_AXIS, 0.0);
    stp_model *model = NULL;
    depth_write("depth.pcd", &p, depth_small.height, NULL);
    first_prep("depth.pcd", 2);
    check_ok(stp_model_open(&model, "first.stipple", err));
    const stp_ball ball = stp_model_ball(model);
    for (size_t s = 0; s < 4; s++) {
        const int width = sizes[s][0], height = sizes[s][1];
        const stp_camera camera = stp_model_camera(model, STP_HOME_FIRST, width, height);
        stp_view view;
        double most[2] = {0.0, 0.0};
        check_ok(stp_view_create(&view, &camera, &ball, width, height, err));
        for (size_t i = 0; i < p.count; i++)
            if (stp_dvec3_finite(p.at[i])) {
                const stp_dvec3 at = stp_view_project(&view, p.at[i]);
                most[0] = fmax(most[0], fabs(at.x / width - 0.5));
                most[1] = fmax(most[1], fabs(at.y / height - 0.5));
            }
        assert_true(most[0] < 0.502 && most[1] < 0.502);
        assert_true(fmax(most[0], most[1]) > 0.49);
        /* The view of the whole model must stay the default one. */
        const stp_dbox box = stp_model_box(model);
        const stp_camera whole = stp_model_camera(model, STP_HOME_WHOLE, width, height);
        const stp_camera old = stp_camera_default(&box, &ball, width, height);
        assert_true(stp_camera_equal(&whole, &old));
        assert_false(stp_camera_equal(&whole, &camera));
    }
    stp_model_close(&model);
    free(p.at);
}

/* A survey's room, and a few points at 0 0 0 as some writers leave them: the view from inside shows
 * the room, though the model's ball is a million times as large. */
static void rooms_with_strays_at_zero(void **state)
{
    (void)state;
    enum { WIDTH = 120, HEIGHT = 90 };
    positions p = room_scan(true);
    gl_fixture f = {0};
    stp_view view;
    uint8_t rgba[4 * WIDTH * HEIGHT];
    size_t covered = 0;
    for (size_t i = 0; i < p.count; i++)
        p.at[i] = stp_dvec3_add(p.at[i], (stp_dvec3){432000.0, 5412000.0, 300.0});
    for (size_t i = 0; i < 20; i++)
        positions_add(&p, 0.0, 0.0, 0.0);
    write_points("room.ply", &p, NULL);
    assert_int_equal(first_prep("room.ply", 2).first.why, STP_FIRST_INTERIOR);
    gl_fixture_open(&f, "first.stipple", NULL);
    const stp_camera camera = stp_model_camera(f.model, STP_HOME_FIRST, WIDTH, HEIGHT);
    const stp_ball ball = stp_model_ball(f.model);
    check_ok(stp_view_create(&view, &camera, &ball, WIDTH, HEIGHT, err));
    gl_fixture_draw(&f, &view, &(stp_draw_params){0}, NULL, rgba);
    for (size_t i = 0; i < sizeof rgba; i += 4)
        covered += rgba[i + 3] != 0;
    if (covered < 95 * WIDTH * HEIGHT / 100)
        fail_msg("only %zu of %d pixels show the room", covered, WIDTH * HEIGHT);
    gl_fixture_close(&f);
    free(p.at);
}

/* Replaces a text of the metadata by another of the same length. */
static void tamper(const char *from, const char *to)
{
    size_t size = 0, length = strlen(from);
    uint8_t *bytes = prep_file_bytes("first.stipple", &size);
    uint8_t *found = memmem(bytes, size, from, length);
    if (!found)
        fail_msg("no %s", from);
    assert_int_equal(length, strlen(to));
    memcpy(found, to, length);
    reseal(bytes, size, false);
    scan_fixture_bytes("wrong.stipple", bytes, size);
    free(bytes);
}

/* A file whose metadata is not JSON must be refused when it is opened. */
static void no_json(const char *from, const char *to)
{
    stp_model *model = NULL;
    stp_error failure = {0};
    tamper(from, to);
    assert_int_equal(stp_model_open(&model, "wrong.stipple", &failure), STP_CORRUPT);
    assert_non_null(strstr(failure.message, "not a JSON object"));
    assert_null(model);
}

/* An invalid first view is ignored. */
static void wrong_first_views(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"\"first_view\"", "\"first_vieW\""},
        {"\"eye\":[0, 0", "\"eye\":[\"\",0"},
        {"\"fovy_deg\":", "\"fovy-deg\":"}, /* an angle of zero */
        {"\"look\":[", "\"eye\" :["},
    };
    positions p = depth_image(&depth_small, false, ORIGIN, Z_AXIS, 0.0);
    depth_write("depth.pcd", &p, depth_small.height, NULL);
    first_prep("depth.pcd", 2);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        stp_model *model = NULL;
        tamper(cases[i][0], cases[i][1]);
        check_ok(stp_model_open(&model, "wrong.stipple", err));
        const stp_camera first = stp_model_camera(model, STP_HOME_FIRST, 64, 64);
        const stp_camera whole = stp_model_camera(model, STP_HOME_WHOLE, 64, 64);
        assert_true(stp_camera_equal(&first, &whole));
        stp_model_close(&model);
    }
    no_json("\"first_view\"", "\"first_view:");
    no_json("\"eye\":[0", "\"eye\":{0");
    free(p.at);
}

/* A tall wall from a scanner: z is up because the file says so. 0 0 0 says nothing. */
static void file_says_what_is_up(void **state)
{
    static const struct {
        const char *text;
        bool z_up;
    } cases[] = {{"\"up\":[0, 0, 1]", true},  {"\"up\":[0, 1, 0]", false},
                 {"\"up\":[1, 0, 0]", false}, {"\"up\":[0, 0, 2]", true},
                 {"\"up\":[0, 0, 0]", false}, {"\"up\":[0, 0,\"\"]", false},
                 {"\"uP\":[0, 0, 1]", false}};
    (void)state;
    FILE *file = fopen("wall.ptx", "w");
    assert_non_null(file);
    fputs("40\n40\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", file);
    for (int i = 0; i < 1600; i++)
        fprintf(file, "%g 3 %g 0.5\n", 0.1 * (i / 40), 0.5 * (i % 40));
    assert_int_equal(fclose(file), 0);
    first_prep("wall.ptx", 1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        stp_model *model = NULL;
        tamper(cases[0].text, cases[i].text);
        check_ok(stp_model_open(&model, "wrong.stipple", err));
        assert_true(stp_model_camera(model, STP_HOME_WHOLE, 64, 64).up.z ==
                    (cases[i].z_up ? 1.0 : 0.0));
        stp_model_close(&model);
    }
}

/* z is up if the box is flat or its x and y look like a map's; otherwise y is up. */
static void height_points_up(void **state)
{
    static const struct {
        stp_dvec3 middle, half;
        bool z_up;
    } cases[] = {
        {{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, false},
        {{0.0, 0.0, 0.0}, {3.0, 3.0, 1.0}, true},
        {{5e5, 5.4e6, 300.0}, {300.0, 300.0, 400.0}, true},
        {{5e5, -5.4e6, 300.0}, {300.0, 300.0, 400.0}, true},
        {{5e5, 0.0, 300.0}, {300.0, 300.0, 400.0}, false},
        {{10.0, 10.0, 0.0}, {1.0, 1.0, 1.0}, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const stp_dbox box = {stp_dvec3_sub(cases[i].middle, cases[i].half),
                              stp_dvec3_add(cases[i].middle, cases[i].half)};
        const stp_ball ball = {cases[i].middle, stp_dvec3_length(cases[i].half)};
        const stp_camera camera = stp_camera_default(&box, &ball, 64, 64);
        assert_true(camera.up.z == (cases[i].z_up ? 1.0 : 0.0));
        assert_true(camera.up.y == (cases[i].z_up ? 0.0 : 1.0));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(images_cover_their_pixels),
        cmocka_unit_test(real_images_cover_their_pixels),
        cmocka_unit_test(pictures_of_other_shapes),
        cmocka_unit_test(rooms_with_strays_at_zero),
        cmocka_unit_test(wrong_first_views),
        cmocka_unit_test(height_points_up),
        cmocka_unit_test(file_says_what_is_up),
    };
    stp_gl_context *context = gl_fixture_context();
    const int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

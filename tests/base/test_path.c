/* Tests camera paths: they pass through every keyframe, are smooth, the same backwards, closed if
 * asked for, and always valid. Tests their files too. */
#include "base/random.h"
#include "runtime/camera/path.h"
#include "tests/support/check.h"

#include <unistd.h>

#define FILE_NAME "test_path.json"

static double distance(stp_dvec3 a, stp_dvec3 b)
{
    return stp_dvec3_length(stp_dvec3_sub(a, b));
}

static stp_keyframe key_at(double time_s, stp_dvec3 eye, stp_dvec3 look)
{
    return (stp_keyframe){time_s,
                          {.eye = eye, .look = look, .up = {0.0, 0.0, 1.0}, .fovy_deg = 45.0}};
}

static stp_path *make(const stp_keyframe *keys, size_t count, bool loop)
{
    stp_path *path = NULL;
    stp_path_params params = {.keyframes = keys, .count = count, .loop = loop};
    check_ok(stp_path_create(&path, &params, err));
    return path;
}

static void expect_camera(stp_camera c, const stp_camera *expected, double within)
{
    check_near(distance(c.eye, expected->eye), 0.0, within);
    check_near(distance(c.look, expected->look), 0.0, within);
    check_near(c.fovy_deg, expected->fovy_deg, within);
    check_near(c.height, expected->height, within);
    stp_view a, b;
    const stp_ball ball = {.radius = 1.0};
    check_ok(stp_view_create(&a, &c, &ball, 1, 1, err));
    check_ok(stp_view_create(&b, expected, &ball, 1, 1, err));
    check_near(distance(a.right, b.right), 0.0, within);
    check_near(distance(a.up, b.up), 0.0, within);
}

/* A walk around a place, at uneven times, in a survey's coordinates. */
static size_t walk(stp_keyframe keys[6])
{
    const stp_dvec3 site = {456000.0, 5428000.0, 300.0};
    const double times[6] = {2.0, 3.0, 3.5, 5.0, 9.0, 9.25};
    for (int i = 0; i < 6; i++) {
        stp_dvec3 eye = {site.x + 20.0 * cos(0.7 * i), site.y + 20.0 * sin(0.7 * i),
                         site.z + 3.0 * i};
        keys[i] = key_at(times[i], eye, (stp_dvec3){site.x, site.y + 0.5 * i, site.z});
        keys[i].camera.fovy_deg = 30.0 + 5.0 * i;
    }
    return 6;
}

static void passes_through_keyframes(void **state)
{
    (void)state;
    stp_keyframe keys[6];
    size_t count = walk(keys);
    for (int loop = 0; loop < 2; loop++) {
        stp_path *path = make(keys, count, loop != 0);
        for (size_t i = 0; i < count; i++) {
            stp_camera c = stp_path_camera(path, keys[i].time_s);
            assert_memory_equal(&c, &keys[i].camera, sizeof c);
            /* the path approaches the keyframe from both sides */
            for (int side = -1; side <= 1; side += 2)
                if (loop || (i + (size_t)side) < count)
                    expect_camera(stp_path_camera(path, keys[i].time_s + side * 1e-9), &c, 1e-5);
        }
        stp_path_destroy(&path);
    }
}

static void is_smooth(void **state)
{
    (void)state;
    stp_keyframe keys[6];
    size_t count = walk(keys);
    stp_path *path = make(keys, count, true);
    const double h = 1e-4;
    for (size_t i = 0; i < count; i++) {
        double t = keys[i].time_s;
        stp_camera a = stp_path_camera(path, t - h), b = stp_path_camera(path, t),
                   c = stp_path_camera(path, t + h);
        stp_dvec3 before = stp_dvec3_sub(b.eye, a.eye), after = stp_dvec3_sub(c.eye, b.eye);
        check_near(distance(before, after) / h, 0.0, 0.1);
        assert_true(stp_dvec3_length(before) / h > 1.0);
        check_near((c.fovy_deg - 2.0 * b.fovy_deg + a.fovy_deg) / h, 0.0, 0.1);
    }
    stp_path_destroy(&path);
}

static void is_the_same_backwards(void **state)
{
    (void)state;
    stp_keyframe keys[6], turned[6];
    size_t count = walk(keys);
    for (size_t i = 0; i < count; i++) {
        turned[i] = keys[count - 1 - i];
        turned[i].time_s = 20.0 - turned[i].time_s;
    }
    stp_path *there = make(keys, count, false), *back = make(turned, count, false);
    for (int i = 0; i <= 500; i++) {
        double t = 2.0 + 7.25 * i / 500.0;
        stp_camera c = stp_path_camera(back, 20.0 - t);
        expect_camera(stp_path_camera(there, t), &c, 1e-8);
    }
    stp_path_destroy(&there);
    stp_path_destroy(&back);
}

static void loops_close(void **state)
{
    (void)state;
    stp_keyframe keys[7];
    size_t count = walk(keys);
    stp_path *path = make(keys, count, true);
    check_near(stp_path_duration_s(path), 7.25 + 7.25 / 5.0, 1e-12);
    for (int i = -20; i < 20; i++) {
        double t = 2.0 + 0.37 * i, duration = stp_path_duration_s(path);
        stp_camera c = stp_path_camera(path, t);
        expect_camera(stp_path_camera(path, t + duration), &c, 1e-6);
    }
    stp_path_destroy(&path);
    /* a path is closed if its last keyframe equals its first */
    keys[6] = keys[0];
    keys[6].time_s = 10.0;
    path = make(keys, 7, true);
    check_near(stp_path_duration_s(path), 8.0, 1e-12);
    uint64_t frames = 0;
    check_ok(stp_path_frame_count(path, 25.0, &frames, err));
    assert_int_equal(frames, 200);
    stp_camera first = stp_path_frame(path, 25.0, frames, 0);
    assert_memory_equal(&first, &keys[0].camera, sizeof first);
    stp_path_destroy(&path);
    stp_path_params params = {keys, 6, true, 60.0};
    check_ok(stp_path_create(&path, &params, err));
    check_near(stp_path_duration_s(path), 60.0, 0.0);
    stp_path_destroy(&path);
}

/* If all keyframes look at one place, so does the path between them. Between two equal keyframes
 * the eye rests. A straight way at even speed stays straight and even. */
static void does_not_swing(void **state)
{
    (void)state;
    const stp_dvec3 look = {1e6, -2e6, 5.0};
    stp_keyframe keys[5] = {key_at(0.0, (stp_dvec3){1e6 + 10.0, -2e6, 5.0}, look),
                            key_at(1.0, (stp_dvec3){1e6, -2e6 + 10.0, 6.0}, look),
                            key_at(2.0, (stp_dvec3){1e6, -2e6 + 10.0, 6.0}, look),
                            key_at(2.1, (stp_dvec3){1e6 - 10.0, -2e6, 7.0}, look),
                            key_at(9.0, (stp_dvec3){1e6 - 11.0, -2e6, 7.0}, look)};
    stp_path *path = make(keys, 5, false);
    for (int i = 0; i <= 900; i++) {
        stp_camera c = stp_path_camera(path, 0.01 * i);
        assert_memory_equal(&c.look, &look, sizeof look);
        assert_memory_equal(&c.up, &keys[0].camera.up, sizeof c.up);
        if (i >= 100 && i <= 200)
            assert_memory_equal(&c.eye, &keys[1].camera.eye, sizeof c.eye);
        if (i > 210)
            assert_true(c.eye.x <= 1e6 - 10.0 && c.eye.x >= 1e6 - 11.0 - 1e-9);
    }
    stp_path_destroy(&path);
    for (int i = 0; i < 5; i++)
        keys[i] = key_at(0.1 * i * i, (stp_dvec3){0.3 * i * i, 1.0, 0.0}, (stp_dvec3){5e3, 2, 0});
    path = make(keys, 5, false);
    for (int i = 0; i <= 160; i++)
        check_near(stp_path_camera(path, 0.01 * i).eye.x, 0.03 * i, 1e-12);
    stp_path_destroy(&path);
}

/* Eye and look change places; views cross the poles and turn around. No camera may be refused, and
 * none may jump. */
static void stays_valid(void **state)
{
    (void)state;
    const stp_ball ball = {.radius = 1.0};
    stp_keyframe keys[8];
    for (uint64_t trial = 0; trial < 400; trial++) {
        for (uint64_t k = 0; k < 8; k++) {
            double v[9];
            for (uint64_t i = 0; i < 9; i++)
                v[i] = floor(5.0 * stp_random_unit(trial, 20 * k + i)) - 2.0;
            keys[k] = key_at((double)k + 0.9 * stp_random_unit(trial, 20 * k + 10),
                             (stp_dvec3){v[0], v[1], v[2]}, (stp_dvec3){v[3], v[4], v[5]});
            if (trial % 2)
                keys[k].camera.up = (stp_dvec3){v[6], v[7], v[8]};
            stp_view view;
            if (stp_view_create(&view, &keys[k].camera, &ball, 1, 1, NULL) != STP_OK)
                keys[k].camera =
                    key_at(0.0, (stp_dvec3){v[0], v[1], 3.0}, (stp_dvec3){v[0], v[1] + 1.0, 1.0})
                        .camera;
        }
        stp_path *path = make(keys, 8, trial % 3 == 0);
        double begin = stp_path_begin_s(path), duration = stp_path_duration_s(path);
        for (int i = 0; i <= 1000; i++) {
            stp_camera c = stp_path_camera(path, begin + duration * i / 1000.0);
            stp_view view;
            check_ok(stp_view_create(&view, &c, &ball, 1, 1, err));
            stp_dvec3 back = stp_dvec3_sub(c.eye, c.look);
            assert_true(stp_dvec3_length(back) > 1e-3);
            assert_true(c.fovy_deg > 0.0 && c.fovy_deg < 180.0);
        }
        stp_path_destroy(&path);
    }
}

/* The eye crosses a pole from one side to the other: half a turn in a second, without a jump. */
static void crosses_the_pole(void **state)
{
    (void)state;
    stp_keyframe keys[2] = {key_at(0.0, (stp_dvec3){0, -1, 2}, (stp_dvec3){0, 0, 0}),
                            key_at(1.0, (stp_dvec3){0, 1, 2}, (stp_dvec3){0, 0, 0})};
    stp_path *path = make(keys, 2, false);
    stp_view last = {.width = 0};
    for (int i = 0; i <= 10000; i++) {
        stp_camera c = stp_path_camera(path, 1e-4 * i);
        stp_view view;
        check_ok(stp_view_create(&view, &c, &(stp_ball){.radius = 1.0}, 1, 1, err));
        if (i > 0)
            assert_true(distance(view.right, last.right) < 0.01);
        last = view;
    }
    /* eye and look are exchanged: the view turns around */
    keys[1] = key_at(1.0, (stp_dvec3){0, 0, 0}, (stp_dvec3){0, -1, 2});
    stp_path_destroy(&path);
    path = make(keys, 2, false);
    for (int i = 0; i <= 10000; i++) {
        stp_camera c = stp_path_camera(path, 1e-4 * i);
        stp_view view;
        check_ok(stp_view_create(&view, &c, &(stp_ball){.radius = 1.0}, 1, 1, err));
        if (i > 0)
            assert_true(distance(view.back, last.back) < 0.01);
        last = view;
    }
    stp_path_destroy(&path);
}

static void turns_tables(void **state)
{
    (void)state;
    const stp_camera start = {
        .eye = {3.0, 0.0, 4.0}, .look = {0.0, 0.0, 4.0}, .up = {0, 0, 2}, .fovy_deg = 40.0};
    stp_path *path = NULL;
    stp_turntable t = {.seconds = 4.0, .elevation_deg = 30.0, .has_elevation = true};
    check_ok(stp_path_create_turntable(&path, &t, &start, err));
    uint64_t frames = 0;
    check_ok(stp_path_frame_count(path, 10.0, &frames, err));
    assert_int_equal(frames, 40);
    stp_camera c = stp_path_frame(path, 10.0, frames, 10);
    check_near(c.eye.x, 0.0, 1e-12);
    check_near(c.eye.y, 3.0 * cos(3.14159265358979323846 / 6.0), 1e-12);
    check_near(c.eye.z, 4.0 + 1.5, 1e-12);
    stp_path_destroy(&path);
    t = (stp_turntable){.seconds = 2.0, .degrees = -90.0};
    check_ok(stp_path_create_turntable(&path, &t, &start, err));
    check_ok(stp_path_frame_count(path, 10.0, &frames, err));
    assert_int_equal(frames, 21);
    check_near(stp_path_frame(path, 10.0, frames, 20).eye.y, -3.0, 1e-12);
    stp_path_destroy(&path);
    t.seconds = 0.0;
    assert_int_equal(stp_path_create_turntable(&path, &t, &start, NULL), STP_INVALID_ARGUMENT);
    t = (stp_turntable){.seconds = 1.0, .elevation_deg = 90.0, .has_elevation = true};
    assert_int_equal(stp_path_create_turntable(&path, &t, &start, NULL), STP_INVALID_ARGUMENT);
}

static void counts_frames(void **state)
{
    (void)state;
    stp_keyframe keys[2] = {key_at(7.0, (stp_dvec3){0, -1, 2}, (stp_dvec3){0, 0, 0}),
                            key_at(8.0, (stp_dvec3){0, 1, 2}, (stp_dvec3){0, 0, 0})};
    uint64_t frames = 0;
    stp_path *path = make(keys, 1, true);
    check_ok(stp_path_frame_count(path, 30.0, &frames, err));
    assert_int_equal(frames, 1);
    stp_path_destroy(&path);
    path = make(keys, 2, false);
    check_ok(stp_path_frame_count(path, 30.0, &frames, err));
    assert_int_equal(frames, 31);
    stp_camera last = stp_path_frame(path, 30.0, frames, 30);
    expect_camera(last, &keys[1].camera, 1e-12);
    check_ok(stp_path_frame_count(path, 2.5, &frames, err)); /* 0, 0.4, 0.8, 1.2 s */
    assert_int_equal(frames, 4);
    assert_int_equal(stp_path_frame_count(path, 0.0, &frames, NULL), STP_INVALID_ARGUMENT);
    assert_int_equal(stp_path_frame_count(path, (double)NAN, &frames, NULL), STP_INVALID_ARGUMENT);
    assert_int_equal(stp_path_frame_count(path, 1e9, &frames, NULL), STP_LIMIT);
    stp_path_destroy(&path);
}

/* ---- files ---- */

static void write_file(const char *text)
{
    FILE *file = fopen(FILE_NAME, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static const stp_camera base = {.eye = {0, -5, 0}, .up = {0, 0, 1}, .fovy_deg = 33.0};

static void comes_back_from_a_file(void **state)
{
    (void)state;
    stp_keyframe keys[6];
    size_t count = walk(keys);
    keys[3].camera.eye.x += 1.0 / 3.0;
    for (int ortho = 0; ortho < 2; ortho++) {
        for (size_t i = 0; i < count && ortho; i++) {
            keys[i].camera.height = 0.1 * (double)(i + 1);
            keys[i].camera.fovy_deg = base.fovy_deg;
        }
        stp_path_params params = {keys, count, ortho != 0, ortho ? 11.0 : 0.0};
        stp_path *path = NULL;
        unlink(FILE_NAME);
        check_ok(stp_path_save(&params, FILE_NAME, false, err));
        assert_int_equal(stp_path_save(&params, FILE_NAME, false, NULL), STP_EXISTS);
        check_ok(stp_path_save(&params, FILE_NAME, true, err));
        check_ok(stp_path_load(&path, FILE_NAME, &base, err));
        check_near(stp_path_duration_s(path), ortho ? 11.0 : 7.25, 0.0);
        for (size_t i = 0; i < count; i++) {
            stp_camera c = stp_path_camera(path, keys[i].time_s);
            assert_memory_equal(&c, &keys[i].camera, sizeof c);
        }
        stp_path_destroy(&path);
    }
}

static void takes_what_is_left_out(void **state)
{
    (void)state;
    stp_path *path = NULL;
    write_file("{\"keyframes\": [{\"time\": 0, \"eye\": [1, 2, 3], \"look\": [0, 0, 0]},"
               "{\"time\": 1, \"eye\": [1, 2, 4], \"look\": [0, 0, 0], \"up\": [0, 1, 0],"
               " \"fovy_deg\": 50},"
               "{\"time\": 2, \"eye\": [1, 2, 5], \"look\": [0, 0, 0]}]}");
    check_ok(stp_path_load(&path, FILE_NAME, &base, err));
    check_near(stp_path_camera(path, 0.0).fovy_deg, 33.0, 0.0);
    check_near(stp_path_camera(path, 0.0).up.z, 1.0, 0.0);
    check_near(stp_path_camera(path, 2.0).fovy_deg, 50.0, 0.0);
    check_near(stp_path_camera(path, 2.0).up.y, 1.0, 0.0);
    stp_path_destroy(&path);
    write_file("{\"turntable\": {\"seconds\": 8, \"degrees\": 180}}");
    check_ok(stp_path_load(&path, FILE_NAME, &base, err));
    check_near(stp_path_camera(path, 8.0).eye.y, 5.0, 1e-12);
    stp_path_destroy(&path);
}

static void names_what_is_wrong(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"", "not a path"},
        {"[]", "not a path"},
        {"{}", "not a path"},
        {"{\"keyframes\": [", "not a path"},
        {"{\"keyframes\": [], \"turntable\": {}}", "both"},
        {"{\"keyframes\": {}}", "keyframes"},
        {"{\"keyframes\": []}", "without keyframes"},
        {"{\"keyframes\": [1]}", "keyframe 1"},
        {"{\"keyframes\": [{\"Time\": 0, \"eye\": [0, 0, 1], \"look\": [0, 0, 0]}]}", "\"time\""},
        {"{\"keyframes\": [{\"time\": 0, \"eye\": [0, 0, 1]}]}", "\"look\" is missing"},
        {"{\"keyframes\": [{\"time\": 0, \"eye\": [0, 1], \"look\": [0, 0, 0]}]}", "\"eye\""},
        {"{\"keyframes\": [{\"time\": 1e999, \"eye\": [0, 1, 0], \"look\": [0, 0, 0]}]}",
         "\"time\""},
        {"{\"keyframes\": [{\"time\": 0, \"eye\": [0, 0, 0], \"look\": [0, 0, 0]}]}",
         "keyframe 1: the camera's eye"},
        {"{\"keyframes\": [{\"time\": 0, \"eye\": [0, 0, 1], \"look\": [0, 0, 0]}]}",
         "keyframe 1: the camera's up"},
        {"{\"keyframes\": [{\"time\": 0, \"eye\": [0, 1, 0], \"look\": [0, 0, 0]},"
         "{\"time\": 0, \"eye\": [0, 1, 0], \"look\": [0, 0, 0]}]}",
         "keyframe 2: its time"},
        {"{\"keyframes\": [{\"time\": 0, \"eye\": [0, 1, 0], \"look\": [0, 0, 0]},"
         "{\"time\": 1, \"eye\": [0, 1, 0], \"look\": [0, 0, 0], \"height\": 1}]}",
         "keyframe 2: perspective"},
        {"{\"keyframes\": [{\"time\": 0, \"eye\": [0, 1, 0], \"look\": [0, 0, 0], \"height\": "
         "-1}]}",
         "\"height\" is -1"},
        {"{\"keyframes\": [{\"time\": 0, \"eye\": [1e17, 1, 0], \"look\": [0, 0, 0]}]}",
         "farthest of a path"},
        {"{\"keyframes\": [{\"time\": 0, \"eye\": [1e9, 1e-4, 0], \"look\": [1e9, 0, 0]}]}",
         "too near"},
        {"{\"keyframes\": [{\"time\": 1e10, \"eye\": [0, 1, 0], \"look\": [0, 0, 0]}]}",
         "keyframe 1: its time"},
        {"{\"keyframes\": [{\"time\": 0, \"eye\": [0, 1, 0], \"look\": [0, 0, 0]},"
         "{\"time\": 1e-7, \"eye\": [0, 1, 0], \"look\": [0, 0, 0]}]}",
         "or more after"},
        {"{\"loop\": 1, \"keyframes\": []}", "\"loop\""},
        {"{\"loop\": true, \"loop_seconds\": 1, \"keyframes\": ["
         "{\"time\": 0, \"eye\": [0, 1, 0], \"look\": [0, 0, 0]},"
         "{\"time\": 1, \"eye\": [0, 1, 0], \"look\": [0, 0, 0]}]}",
         "ends before"},
        {"{\"turntable\": 3}", "\"turntable\""},
        {"{\"turntable\": {}}", "\"seconds\""},
        {"{\"turntable\": {\"seconds\": -1}}", "-1 seconds"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        stp_path *path = NULL;
        stp_error error = {0};
        write_file(cases[i][0]);
        assert_int_not_equal(stp_path_load(&path, FILE_NAME, &base, &error), STP_OK);
        assert_null(path);
        if (strstr(error.message, cases[i][1]) == NULL ||
            strstr(error.message, FILE_NAME) != error.message)
            fail_msg("'%s' gives '%s'", cases[i][0], error.message);
    }
    unlink(FILE_NAME);
    stp_path *path = NULL;
    assert_int_equal(stp_path_load(&path, FILE_NAME, &base, NULL), STP_NOT_FOUND);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(passes_through_keyframes),
        cmocka_unit_test(is_smooth),
        cmocka_unit_test(is_the_same_backwards),
        cmocka_unit_test(loops_close),
        cmocka_unit_test(does_not_swing),
        cmocka_unit_test(stays_valid),
        cmocka_unit_test(crosses_the_pole),
        cmocka_unit_test(turns_tables),
        cmocka_unit_test(counts_frames),
        cmocka_unit_test(comes_back_from_a_file),
        cmocka_unit_test(takes_what_is_left_out),
        cmocka_unit_test(names_what_is_wrong),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

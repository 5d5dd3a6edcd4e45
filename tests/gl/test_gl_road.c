/* Tests which road is taken if none is asked for. A software driver takes one at once. Other
 * drivers take the faster of two after a trial, in which only streaming pictures count. */
#include "tests/fixtures/gl_model.h"

#include "runtime/draw/road.h"

static void software_needs_no_trial(void **state)
{
    (void)state;
    stp_road road;
    stp_road_begin(&road, true);
    assert_true(road.decided);
    assert_int_equal(stp_road_take(&road, true), STP_LOD_COMPUTE);
    stp_road_leave(&road, true);
    assert_int_equal(road.frame, 0);
    stp_road_end(&road);
}

static void waiting_pictures_do_not_try(void **state)
{
    (void)state;
    stp_road road;
    stp_road_begin(&road, false);
    for (int i = 0; i < 3 * STP_ROAD_TRIAL_FRAMES; i++) {
        assert_int_equal(stp_road_take(&road, false), STP_LOD_GEOMETRY);
        stp_road_leave(&road, true);
    }
    assert_false(road.decided);
    stp_road_end(&road);
}

/* Draws with the road taken, then makes `slow` the slower road; returns the road that stays. */
static stp_lod try_roads(gl_fixture *f, stp_lod slow)
{
    stp_road road;
    stp_view view;
    stp_camera camera = stp_camera_around(&f->model->ball, (stp_dvec3){0.4, 0.3, 1.0},
                                          (stp_dvec3){0.0, 0.0, 1.0}, 45.0, 400, 400);
    check_ok(stp_view_create(&view, &camera, &f->model->ball, 400, 400, err));
    int unfinished = 0, frames = 0, of[2] = {0, 0};
    stp_road_begin(&road, false);
    for (; !road.decided; frames++) {
        bool whole = frames % 3 != 1; /* incomplete frames do not count */
        stp_draw_params params = {.lod = stp_road_take(&road, true)};
        if (road.decided)
            break;
        for (int times = params.lod == slow ? 6 : 1; times > 0; times--)
            check_ok(stp_renderer_draw(f->renderer, &view, &params, NULL, err));
        unfinished += !whole;
        of[params.lod == STP_LOD_COMPUTE] += road.tries;
        stp_road_leave(&road, whole);
        assert_true(frames < 10 * STP_ROAD_TRIAL_FRAMES);
    }
    assert_true(unfinished > 0);
    assert_true(of[0] >= STP_ROAD_TRIAL_FRAMES / 2 && of[1] >= STP_ROAD_TRIAL_FRAMES / 2);
    assert_int_equal(stp_road_take(&road, true), road.lod);
    assert_int_equal(stp_road_take(&road, false), road.lod);
    stp_road_end(&road);
    return road.lod;
}

static void the_faster_stays(void **state)
{
    assert_int_equal(try_roads(*state, STP_LOD_GEOMETRY), STP_LOD_COMPUTE);
    assert_int_equal(try_roads(*state, STP_LOD_COMPUTE), STP_LOD_GEOMETRY);
}

static void what_is_taken_is_said(void **state)
{
    gl_fixture *f = *state;
    static const stp_lod asked[] = {STP_LOD_AUTO, STP_LOD_GEOMETRY, STP_LOD_COMPUTE, STP_LOD_CPU,
                                    STP_LOD_FULL};
    stp_camera camera = stp_camera_around(&f->model->ball, (stp_dvec3){0.4, 0.3, 1.0},
                                          (stp_dvec3){0.0, 0.0, 1.0}, 45.0, 64, 64);
    stp_view view;
    check_ok(stp_view_create(&view, &camera, &f->model->ball, 64, 64, err));
    for (size_t i = 0; i < sizeof asked / sizeof asked[0]; i++) {
        stp_draw_stats stats;
        const stp_draw_params params = {.lod = asked[i]};
        check_ok(stp_renderer_draw(f->renderer, &view, &params, &stats, err));
        stp_lod expected = asked[i] != STP_LOD_AUTO ? asked[i]
                           : stp_road_is_software() ? STP_LOD_COMPUTE
                                                    : STP_LOD_GEOMETRY;
        assert_int_equal(stats.lod, expected);
    }
}

static int enter(void **state)
{
    return gl_model_enter(state, &(model_recipe){.shape = GEN_BUMPY, .point_count = 100000});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(software_needs_no_trial),
        cmocka_unit_test(waiting_pictures_do_not_try),
        cmocka_unit_test(the_faster_stays),
        cmocka_unit_test(what_is_taken_is_said),
    };
    stp_gl_context *context = gl_fixture_context();
    int failed = cmocka_run_group_tests(tests, enter, gl_model_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

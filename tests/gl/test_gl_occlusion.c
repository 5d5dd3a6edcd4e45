/* Tests that what lies behind surfaces is left out and that no picture shows it: at rest, and of
 * those that wait, every byte is that of the picture without occlusion, on all roads. In a flight
 * through doors no frame has more than a few pixels open. */
#include "runtime/cut/occlusion.h"
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/support/views.h"

#include <unistd.h>

enum { WIDTH = 320, HEIGHT = 240, PIXELS = WIDTH * HEIGHT, FLIGHT = 60 };

static uint8_t with[4 * PIXELS], without[4 * PIXELS];
static float depth_with[PIXELS], depth_without[PIXELS];

/* Metres; the building is 25 x 10 x 6 and has twenty rooms (tools/gen/building.c). */
static const stp_dvec3 eyes[][2] = {
    {{2.5, 2.5, 1.6}, {25, 3, 1.6}},   {{7.5, 2.5, 1.6}, {5, 5, 1.2}}, {{12, 7, 1.6}, {0, 10, 1.2}},
    {{22, 3, 4.8}, {10, 3, 4.5}},      {{1, 1, 1.6}, {4, 4, 1}},       {{17, 8, 1.6}, {25, 5, 1.5}},
    {{12.5, 2.5, 4.6}, {12.5, 10, 4}}, {{3, 8, 4.6}, {3, 0, 4}},       {{23, 9, 1.6}, {15, 5, 1.3}},
    {{-4, -6, 3}, {12, 5, 2}},
};
enum { EYES = sizeof eyes / sizeof *eyes };

static stp_view eye_view(const gl_fixture *f, int i)
{
    return views_look(eyes[i][0], eyes[i][1], 60.0, &f->model->ball, WIDTH, HEIGHT);
}

static void assert_same_picture(void)
{
    assert_memory_equal(with, without, sizeof with);
    assert_memory_equal(depth_with, depth_without, sizeof depth_with);
}

/* Draws a view without and with occlusion, both waiting, each by a renderer of its own: the second
 * begins with what the eye before saw. Returns the samples of both. */
static void draw_both(const gl_fixture f[2], const stp_view *view, stp_draw_params params,
                      uint64_t samples[2], uint64_t *hidden)
{
    stp_draw_stats stats;
    params.occlusion = STP_OCCLUSION_OFF;
    gl_fixture_draw(&f[0], view, &params, &stats, without);
    check_ok(stp_renderer_read_depth(f[0].renderer, depth_without, err));
    assert_int_equal(stats.patches_hidden + stats.blocks_hidden, 0);
    samples[0] += stats.points_drawn;
    params.occlusion = STP_OCCLUSION_ON;
    for (int again = 0; again < 2; again++) {
        gl_fixture_draw(&f[1], view, &params, &stats, with);
        check_ok(stp_renderer_read_depth(f[1].renderer, depth_with, err));
        assert_false(stats.exposes);
        assert_same_picture();
    }
    samples[1] += stats.points_drawn;
    *hidden += stats.patches_hidden + stats.blocks_hidden;
}

/* Draws frames that do not wait until the view is at rest. */
static uint64_t rest(const gl_fixture *f, const stp_view *view, stp_draw_params params)
{
    stp_draw_stats stats = {.more = true};
    uint64_t hidden = 0;
    params.stream = true;
    for (int i = 0; i < 5000 && (stats.more || !stats.cut_complete); i++) {
        check_ok(stp_renderer_draw(f->renderer, view, &params, &stats, err));
        hidden += stats.patches_hidden;
        if (stats.chunks_loading > 0)
            usleep(1000);
    }
    assert_true(stats.cut_complete && !stats.more);
    check_ok(stp_renderer_read(f->renderer, with, err));
    check_ok(stp_renderer_read_depth(f->renderer, depth_with, err));
    return hidden;
}

static const stp_draw_params looks[] = {
    {.lod = STP_LOD_COMPUTE, .smooth_edges = true},
    {.lod = STP_LOD_GEOMETRY, .smooth_edges = true},
    {.lod = STP_LOD_CPU},
    {.lod = STP_LOD_COMPUTE, .reconstruct = STP_RECONSTRUCT_BOX, .threshold_px = 3.0},
    {.lod = STP_LOD_GEOMETRY, .threshold_px = 0.5, .edl = 1.0},
    {.lod = STP_LOD_FULL},
};
enum { LOOKS = sizeof looks / sizeof *looks };

static void open_both(gl_fixture f[2], const char *path)
{
    for (int i = 0; i < 2; i++)
        gl_fixture_open(&f[i], path, NULL);
}

static void close_both(gl_fixture f[2])
{
    for (int i = 0; i < 2; i++)
        gl_fixture_close(&f[i]);
}

static void inside_a_building(void **state)
{
    gl_fixture f[2] = {0};
    uint64_t samples[2] = {0}, hidden = 0;
    (void)state;
    open_both(f, "building.stipple");
    for (int k = 0; k < LOOKS; k++)
        for (int i = 0; i < EYES; i++)
            for (int step = 0; step < 2; step++) { /* aside: something comes to light */
                const stp_dvec3 eye =
                    stp_dvec3_add(eyes[i][0], (stp_dvec3){0.3 * step, 0.2 * step, 0.0});
                const stp_view view =
                    views_look(eye, eyes[i][1], 60.0, &f[0].model->ball, WIDTH, HEIGHT);
                draw_both(f, &view, looks[k], samples, &hidden);
            }
    printf("building: %.2f of the samples, %llu patches and blocks hidden\n",
           (double)samples[1] / (double)samples[0], (unsigned long long)hidden);
    assert_true(hidden > 0 && samples[1] < samples[0] * 3 / 5);
    close_both(f);
}

/* A view that comes to rest shows the picture without occlusion, from whatever the eye saw last. */
static void at_rest(void **state)
{
    gl_fixture f = {0};
    uint64_t hidden = 0;
    (void)state;
    gl_fixture_open(&f, "building.stipple", NULL);
    for (int i = 0; i < EYES; i++) {
        const stp_view view = eye_view(&f, i);
        stp_draw_params params = {.lod = i % 2 ? STP_LOD_GEOMETRY : STP_LOD_COMPUTE,
                                  .smooth_edges = true,
                                  .occlusion = STP_OCCLUSION_ON};
        hidden += rest(&f, &view, params);
        params.occlusion = STP_OCCLUSION_OFF;
        gl_fixture_draw(&f, &view, &params, NULL, without);
        check_ok(stp_renderer_read_depth(f.renderer, depth_without, err));
        assert_same_picture();
    }
    assert_true(hidden > 0);
    gl_fixture_close(&f);
}

/* Where little is hidden, pictures go without occlusion for a while, but not those of a view at
 * rest: what is hidden is not there, and would be drawn too coarse. */
static void stays_at_rest(void **state)
{
    gl_fixture f = {0};
    uint64_t hidden = 0;
    (void)state;
    for (int i = 0; i < 6; i++) {
        const stp_draw_params params = {.stream = true, .threshold_px = 0.5};
        gl_fixture_open(&f, "statue.stipple", NULL);
        const stp_view view = views_get(i, &f.model->ball, NULL, 0, WIDTH, HEIGHT);
        rest(&f, &view, params);
        for (int frame = 0; frame < 3; frame++) {
            stp_draw_stats stats;
            gl_fixture_draw(&f, &view, &params, &stats, without);
            assert_true(stats.cut_complete && !stats.more);
            assert_memory_equal(with, without, sizeof with);
            hidden += stats.patches_hidden;
        }
        gl_fixture_close(&f);
    }
    assert_true(hidden > 0);
}

/* A picture that takes several passes, since memory is short. */
static void in_passes(void **state)
{
    gl_fixture f = {0};
    (void)state;
    check_ok(stp_model_open(&f.model, "building.stipple", err));
    const stp_renderer_params small = {
        .model = f.model, .thread_count = 2, .gpu_memory_bytes = UINT64_C(5) << 19};
    check_ok(stp_renderer_create(&f.renderer, &small, err));
    for (int i = 0; i < 3; i++) {
        stp_draw_stats stats;
        const stp_view view = eye_view(&f, i);
        stp_draw_params params = {.threshold_px = 0.3, .occlusion = STP_OCCLUSION_OFF};
        gl_fixture_draw(&f, &view, &params, &stats, without);
        assert_true(stats.passes > 1);
        params.occlusion = STP_OCCLUSION_ON;
        for (int again = 0; again < 2; again++) {
            gl_fixture_draw(&f, &view, &params, &stats, with);
            assert_memory_equal(with, without, sizeof with);
        }
    }
    gl_fixture_close(&f);
}

static void around_a_statue(void **state)
{
    gl_fixture f[2] = {0};
    uint64_t samples[2] = {0}, hidden = 0;
    (void)state;
    open_both(f, "statue.stipple");
    for (int i = 0; i < VIEWS_DIRECTIONS; i++) {
        const stp_view view = views_get(i, &f[0].model->ball, NULL, 0, WIDTH, HEIGHT);
        draw_both(f, &view, looks[i % LOOKS], samples, &hidden);
    }
    close_both(f);
}

/* The share of pixels that are open although the picture that waits covers them. */
static double open_share(void)
{
    size_t open = 0;
    for (int i = 0; i < PIXELS; i++)
        open += without[4 * i + 3] != 0 && with[4 * i + 3] == 0;
    return (double)open / PIXELS;
}

/* Flies through doors, first with nothing loaded but the root, then with all that is needed, so
 * that what is open was left out wrongly. */
static void through_doors(void **state)
{
    gl_fixture cold = {0}, flies = {0}, waits = {0};
    double worst[2] = {0.0, 0.0};
    uint64_t hidden = 0;
    (void)state;
    gl_fixture_open(&cold, "building.stipple", NULL);
    gl_fixture_open(&flies, "building.stipple", NULL);
    gl_fixture_open(&waits, "building.stipple", NULL);
    for (int i = 0; i < 2 * FLIGHT; i++) {
        const double x = 1.0 + 0.05 * (i % FLIGHT), turn = 0.4 * sin(0.08 * (i % FLIGHT));
        const stp_view view =
            views_look((stp_dvec3){x, 2.5, 1.6}, (stp_dvec3){x + 1.0, 2.5 + turn, 1.6}, 60.0,
                       &flies.model->ball, WIDTH, HEIGHT);
        stp_draw_params params = {.lod = STP_LOD_COMPUTE, .occlusion = STP_OCCLUSION_OFF};
        stp_draw_stats stats;
        gl_fixture_draw(&waits, &view, &params, NULL, without);
        if (i < FLIGHT)
            gl_fixture_draw(&flies, &view, &params, NULL, with);
        params.stream = true;
        params.occlusion = STP_OCCLUSION_AUTO;
        gl_fixture_draw(i < FLIGHT ? &cold : &flies, &view, &params, &stats, with);
        hidden += i < FLIGHT ? 0 : stats.patches_hidden;
        worst[i / FLIGHT] = fmax(worst[i / FLIGHT], open_share());
    }
    printf("flights: at most %.4f and %.4f %% open\n", 100.0 * worst[0], 100.0 * worst[1]);
    assert_true(hidden > 0);
    assert_true(worst[0] <= 0.001 && worst[1] <= 0.001);
    gl_fixture_close(&cold);
    gl_fixture_close(&flies);
    gl_fixture_close(&waits);
}

/* ---- bounds ---- */

enum { COLUMNS = 10, ROWS = 8 };

/* What an eye at the origin hides that looks along -z at a wall 5 away in columns 2 to 7. */
static stp_occlusion wall(bool orthographic)
{
    stp_occlusion o = {0};
    const stp_gpu_frame frame = {
        .axis_right = {1.0f},
        .axis_up = {0.0f, 1.0f},
        .axis_back = {0.0f, 0.0f, 1.0f},
        .viewport = {8 * COLUMNS, 8 * ROWS, orthographic ? 8.0f : 40.0f, 0.1f},
        .centre = {4 * COLUMNS, 4 * ROWS},
        .modes = {orthographic}};
    check_ok(stp_occlusion_open(&o, &frame, (stp_dvec3){0}, err));
    for (int i = 0; i < COLUMNS * ROWS; i++)
        o.far[i] = i % COLUMNS >= 2 && i % COLUMNS <= 7 ? 5.0f : STP_OCCLUSION_NONE;
    stp_occlusion_close(&o);
    assert_true(stp_occlusion_is_of(&o, &frame, (stp_dvec3){0}));
    assert_false(stp_occlusion_is_of(&o, &frame, (stp_dvec3){0.0, 0.0, 1e-9}));
    stp_occlusion_aim(&o, (stp_dvec3){0}, 0.0f, false);
    return o;
}

/* Asks about a ball and about the box around it, which must agree where it is small. */
static bool hides(const stp_occlusion *o, float x, float y, float z, float radius)
{
    const float centre[3] = {x, y, z};
    const stp_occluded box = {{x - radius, y - radius, z - radius},
                              {x + radius, y + radius, z + radius}};
    const bool hidden = stp_occlusion_hides(o, centre, radius);
    assert_int_equal(stp_occlusion_hides_box(o, &box), hidden);
    return hidden;
}

static void bounds(void **state)
{
    (void)state;
    for (int flat = 0; flat < 2; flat++) {
        stp_occlusion o = wall(flat);
        const float far = flat ? 1.0f : 2.0f; /* how much farther 10 away is seen than 5 */
        assert_true(hides(&o, 0.0f, 0.0f, -10.0f, 0.5f));
        assert_false(hides(&o, 0.0f, 0.0f, -5.2f, 0.5f));  /* pokes through the wall */
        assert_false(hides(&o, 0.0f, 0.0f, -4.0f, 0.1f));  /* before it */
        assert_false(hides(&o, 0.0f, 0.0f, 10.0f, 0.5f));  /* behind the eye */
        assert_false(hides(&o, 0.0f, 0.0f, -0.3f, 0.25f)); /* reaches the near plane */
        assert_true(hides(&o, -2.8f * far, 0.0f, -10.0f, 0.1f));
        assert_false(hides(&o, -3.05f * far, 0.0f, -10.0f, 0.2f)); /* beside its left end */
        assert_false(hides(&o, 0.0f, 3.95f * far, -10.0f, 0.2f));  /* out of the picture in part */
        assert_false(hides(&o, 0.0f, 0.0f, -100.0f, 90.0f));
        assert_false(hides(&o, NAN, 0.0f, -10.0f, 0.1f));
        assert_false(hides(&o, 0.0f, 0.0f, -10.0f, INFINITY));
        /* By the same camera, what lies beside the picture does not count. */
        stp_occlusion_aim(&o, (stp_dvec3){0}, 0.0f, true);
        assert_true(hides(&o, 0.0f, 3.95f * far, -10.0f, 0.2f));
        assert_true(hides(&o, 0.0f, -3.95f * far, -10.0f, 0.2f));
        assert_false(hides(&o, 0.0f, 5.0f * far, -10.0f, 0.2f));  /* wholly */
        assert_false(hides(&o, -4.9f * far, 0.0f, -10.0f, 0.2f)); /* where no wall is */
        assert_false(hides(&o, NAN, 0.0f, -10.0f, 0.1f));
        stp_occlusion_aim(&o, (stp_dvec3){0}, 8.0f, false);
        assert_false(hides(&o, -2.8f * far, 0.0f, -10.0f, 0.1f));
        /* Asked from 5 farther back. */
        stp_occlusion_aim(&o, (stp_dvec3){0.0, 0.0, 5.0}, 0.0f, false);
        assert_false(hides(&o, 0.0f, 0.0f, -9.0f, 0.5f));
        assert_true(hides(&o, 0.0f, 0.0f, -11.0f, 0.5f));
        stp_occlusion_destroy(&o);
    }
    assert_false(stp_occlusion_hides(NULL, (float[3]){0.0f}, 1.0f));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounds),          cmocka_unit_test(inside_a_building),
        cmocka_unit_test(at_rest),         cmocka_unit_test(stays_at_rest),
        cmocka_unit_test(in_passes),       cmocka_unit_test(through_doors),
        cmocka_unit_test(around_a_statue),
    };
    stp_gl_context *context = gl_fixture_context();
    model_fixture_build(
        "building.stipple",
        &(model_recipe){.shape = GEN_BUILDING, .point_count = 500000, .true_normals = true});
    model_fixture_build("statue.stipple",
                        &(model_recipe){.shape = GEN_STATUE, .point_count = 60000});
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stp_gl_context_destroy(&context);
    return failed;
}

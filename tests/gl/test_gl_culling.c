/* Tests what is left out because nobody can see it. Culling must not uncover a pixel. If the eye is
 * inside, or looks through a clip box, nothing may be left out. Surfaces seen from behind are lit.
 *
 * Each direction is seen with one of two thresholds; with the argument --every, as in
 * long_gl_culling, with both. */
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/support/views.h"

enum { SIZE = 320, PIXELS = SIZE * SIZE };

static uint8_t seen_auto[4 * PIXELS], seen_none[4 * PIXELS];

/* Draws a view; returns the number of samples. The two shader roads must agree on it. */
static uint64_t draw_counted(const gl_fixture *f, const stp_view *view, stp_draw_params params,
                             uint8_t *rgba)
{
    stp_draw_stats computed, rasterised;
    params.lod = STP_LOD_COMPUTE;
    gl_fixture_draw(f, view, &params, &computed, rgba);
    params.lod = STP_LOD_GEOMETRY;
    gl_fixture_draw(f, view, &params, &rasterised, rgba);
    assert_int_equal(computed.points_drawn, rasterised.points_drawn);
    return rasterised.points_drawn;
}

/* Draws a view with AUTO and with NONE; returns the ratio of the numbers of samples. */
static double draw_both(const gl_fixture *f, const stp_view *view, stp_draw_params params)
{
    double drawn = (double)draw_counted(f, view, params, seen_auto);
    params.cull = STP_CULL_NONE;
    double all = (double)draw_counted(f, view, params, seen_none);
    return all > 0.0 ? drawn / all : 1.0;
}

/* Counts the pixels that NONE covers and AUTO does not. *inner counts those surrounded by covered
 * pixels. */
static size_t count_lost(size_t *covered, size_t *inner)
{
    size_t lost = 0;
    *covered = *inner = 0;
    for (int i = 0; i < PIXELS; i++) {
        int x = i % SIZE, y = i / SIZE;
        bool all = x > 0 && y > 0 && x + 1 < SIZE && y + 1 < SIZE;
        *covered += seen_none[4 * i + 3] != 0;
        if (seen_none[4 * i + 3] == 0 || seen_auto[4 * i + 3] != 0)
            continue;
        for (int d = 0; d < 9 && all; d++)
            all = seen_none[4 * ((y + d / 3 - 1) * SIZE + x + d % 3 - 1) + 3] != 0;
        *inner += all;
        lost++;
    }
    return lost;
}

static bool every_view;

static void closed_model(void **state)
{
    (void)state;
    static const double thresholds[] = {0.0, 1.0};
    gl_fixture f = {0};
    model_fixture_build("closed.stipple",
                        &(model_recipe){.shape = GEN_STATUE, .point_count = 400000});
    gl_fixture_open(&f, "closed.stipple", NULL);
    assert_true(f.model->info->attributes & STP_HAS_CLOSED);
    assert_int_equal(f.model->info->version_major, 2);
    for (int t = 0; t < 2; t++) {
        size_t lost = 0, all = 0, within = 0;
        double share = 0.0;
        int views = 0;
        for (int i = every_view ? 0 : t; i < VIEWS_DIRECTIONS; i += every_view ? 1 : 2) {
            size_t covered, inner;
            views++;
            stp_view view = views_get(i, &f.model->ball, NULL, 0, SIZE, SIZE);
            share += draw_both(&f, &view,
                               (stp_draw_params){.threshold_px = thresholds[t],
                                                 .every_sample = thresholds[t] <= 0.0});
            lost += count_lost(&covered, &inner);
            all += covered;
            within += inner;
        }
        share /= views;
        print_message("threshold %g: %zu of %zu pixels lost, %zu inside; %.3f of the samples\n",
                      thresholds[t], lost, all, within, share);
        assert_true(1000 * lost <= 2 * all); /* outlines, with so few pixels */
        assert_true(20000 * within <= all);
        assert_true(thresholds[t] > 0.0 || share <= 0.6); /* most patches are one point */
    }
    gl_fixture_close(&f);
}

/* The pictures must have the same bytes, and all samples are drawn. */
static void check_same(const gl_fixture *f, const stp_view *view, stp_draw_params params)
{
    assert_true(draw_both(f, view, params) == 1.0);
    assert_memory_equal(seen_auto, seen_none, sizeof seen_auto);
}

static void from_inside(void **state)
{
    (void)state;
    gl_fixture f = {0};
    model_fixture_build("sphere.stipple",
                        &(model_recipe){.shape = GEN_SPHERE, .point_count = 60000});
    gl_fixture_open(&f, "sphere.stipple", NULL);
    stp_ball ball = stp_model_ball(f.model);
    for (int i = 0; i < 3; i++) {
        size_t covered, inner;
        stp_view view;
        stp_camera camera = {.eye = ball.centre,
                             .look = stp_dvec3_add(ball.centre, (stp_dvec3){1.0, 0.2 * i, 0.1}),
                             .up = {0.0, 0.0, 1.0},
                             .fovy_deg = 80.0};
        camera.eye.x += 0.25 * i * ball.radius; /* of the box's corners */
        check_ok(stp_view_create(&view, &camera, &ball, SIZE, SIZE, err));
        check_same(&f, &view,
                   (stp_draw_params){.shade = STP_SHADE_LAMBERT, .colour = STP_COLOUR_NONE});
        count_lost(&covered, &inner);
        assert_true(10000 * covered >= 9995 * PIXELS);
        for (int p = 0; p < PIXELS; p++) /* the side that faces the eye is lit, front or back */
            assert_true(seen_auto[4 * p + 3] == 0 || seen_auto[4 * p] > 40);
    }
    stp_view whole = views_get(4, &ball, NULL, 0, SIZE, SIZE);
    stp_draw_params cut = {.clip = {true, stp_model_box(f.model)}};
    cut.clip.box.max.z = ball.centre.z;
    check_same(&f, &whole, cut);
    stp_draw_params hiding = {.hidden_classes = {1u << 9}};
    check_same(&f, &whole, hiding);
    gl_fixture_close(&f);
}

/* A plane with normals of its own must be as bright from behind as from the front. */
static void both_sides(void **state)
{
    (void)state;
    gl_fixture f = {0};
    double sum[2] = {0.0, 0.0};
    model_fixture_build(
        "plane.stipple",
        &(model_recipe){.shape = GEN_PLANE, .point_count = 40000, .true_normals = true});
    gl_fixture_open(&f, "plane.stipple", NULL);
    stp_ball ball = stp_model_ball(f.model);
    for (int side = 0; side < 2; side++) {
        stp_view view;
        stp_camera camera = stp_camera_around(&ball, (stp_dvec3){0.3, 0.2, side ? -1.0 : 1.0},
                                              (stp_dvec3){0.0, 1.0, 0.0}, 40.0, SIZE, SIZE);
        check_ok(stp_view_create(&view, &camera, &ball, SIZE, SIZE, err));
        gl_fixture_draw(&f, &view,
                        &(stp_draw_params){.shade = STP_SHADE_LAMBERT, .colour = STP_COLOUR_NONE},
                        NULL, seen_auto);
        size_t covered = 0;
        for (int p = 0; p < PIXELS; p++) {
            covered += seen_auto[4 * p + 3] != 0;
            sum[side] += seen_auto[4 * p];
        }
        assert_true(covered > PIXELS / 10);
        sum[side] /= (double)covered;
    }
    print_message("mean light: %.2f before, %.2f behind\n", sum[0], sum[1]);
    assert_true(fabs(sum[0] - sum[1]) < 1.0);
    gl_fixture_close(&f);
}

int main(int argc, char **argv)
{
    every_view = argc > 1 && strcmp(argv[1], "--every") == 0;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_model),
        cmocka_unit_test(from_inside),
        cmocka_unit_test(both_sides),
    };
    stp_gl_context *context = gl_fixture_context();
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

/* Tests colours of elevation: each pixel has the palette's colour for the height of its own
 * surface, not of the samples around it. Truth: a sphere far from the origin, and a large triangle.
 */
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/fixtures/sphere_ray.h"
#include "tests/fixtures/square_fixture.h"

enum { COUNT = 6000, SIZE = 300, PIXELS = SIZE * SIZE };

static const stp_ball sphere = {{500000.0, 4.5e6, 300.0}, 20.0};

static int open_model(void **state)
{
    static gl_fixture f;
    stp_prep_stats stats;
    if (scan_fixture_enter(state) != 0)
        return 1;
    prep_cloud cloud = prep_cloud_make(COUNT);
    for (int i = 0; i < COUNT; i++) { /* evenly, along a spiral */
        const double z = (2.0 * i + 1.0) / COUNT - 1.0, a = i * M_PI * (3.0 - sqrt(5.0));
        const double across = sqrt(1.0 - z * z);
        const stp_dvec3 out = {across * cos(a), across * sin(a), z};
        cloud.points[i].position =
            stp_dvec3_add(sphere.centre, stp_dvec3_scale(out, sphere.radius));
    }
    check_ok(prep_cloud_run(&cloud, "sphere.stipple", 2, NULL, &stats, err));
    free(cloud.points);
    gl_fixture_open(&f, "sphere.stipple", NULL);
    *state = &f;
    return 0;
}

static int close_model(void **state)
{
    gl_fixture_close(*state);
    return scan_fixture_leave(state);
}

/* Grey from the sphere's bottom to its top: a pixel's height is about a step of 8 bits. */
static stp_draw_params grey(void)
{
    return (stp_draw_params){
        .colour = STP_COLOUR_ELEVATION,
        .palette = STP_PALETTE_GREY,
        .shade = STP_SHADE_UNLIT,
        .colour_range = {sphere.centre.z - sphere.radius, sphere.centre.z + sphere.radius}};
}

/* The grey of the sphere at a pixel; NaN at its rim and beside it. */
static double true_grey(const stp_view *view, int i)
{
    double facing = 0.0;
    const double z = sphere_ray_z(view, &sphere, i % SIZE + 0.5, i / SIZE + 0.5, &facing);
    return facing > 0.4 ? 127.5 * ((z - sphere.centre.z) / sphere.radius + 1.0) : NAN;
}

/* All reconstructions that close gaps, all roads, both projections. The samples are 5 pixels apart,
 * so with a colour for each of them a third of the pixels would be off by more than 2. */
static void by_pixel(void **state)
{
    gl_fixture *f = *state;
    static uint8_t rgba[4 * PIXELS];
    static const stp_lod roads[] = {STP_LOD_GEOMETRY, STP_LOD_COMPUTE, STP_LOD_CPU, STP_LOD_FULL};
    for (int variant = 0; variant < STP_RECONSTRUCT_POINTS + 2; variant++) { /* gauss twice more */
        const stp_view view = ball_view(&f->model->ball, 0.6, variant % 2, SIZE);
        stp_draw_params params = grey();
        params.reconstruct =
            variant < STP_RECONSTRUCT_POINTS ? (stp_reconstruct)variant : STP_RECONSTRUCT_GAUSS;
        params.lod = roads[variant < STP_RECONSTRUCT_POINTS ? variant % 4
                                                            : variant - STP_RECONSTRUCT_POINTS + 2];
        gl_fixture_draw(f, &view, &params, NULL, rgba);
        size_t count = 0, off = 0;
        double sum = 0.0;
        for (int i = 0; i < PIXELS; i++) {
            const double expected = true_grey(&view, i), is = rgba[4 * i];
            if (isnan(expected) || rgba[4 * i + 3] == 0)
                continue;
            count++;
            off += fabs(is - expected) > 2.0;
            sum += is - expected;
        }
        print_message("reconstruction %d: %zu of %zu pixels off by more than 2, %.3f on average\n",
                      (int)params.reconstruct, off, count, sum / (double)count);
        assert_true(count > 15000);
        /* windows of 3 pixels smear over samples 5 pixels apart */
        assert_true(off <=
                    (params.reconstruct == STP_RECONSTRUCT_TEMPLATE3 ? count / 5 : count / 50));
        assert_true(fabs(sum) < 0.8 * (double)count);
    }
}

/* A pick has the pixel's colour, with and without an overlay. */
static void picked(void **state)
{
    gl_fixture *f = *state;
    static uint8_t rgba[4 * PIXELS];
    const stp_view view = ball_view(&f->model->ball, 0.6, false, SIZE);
    stp_draw_params params = grey();
    params.palette = STP_PALETTE_VIRIDIS;
    gl_fixture_draw(f, &view, &params, NULL, rgba);
    for (int i = 0; i < 50; i++) {
        const int x = 110 + 11 * i % 80, y = 110 + 17 * i % 80;
        stp_pick pick;
        check_ok(stp_renderer_pick(f->renderer, x, y, &pick, err));
        assert_true(pick.hit);
        for (int c = 0; c < 3; c++)
            if (abs(pick.rgb[c] - rgba[4 * (y * SIZE + x) + c]) > 4)
                fail_msg("at %d, %d: picked %d, drawn %d", x, y, pick.rgb[c],
                         rgba[4 * (y * SIZE + x) + c]);
    }
}

/* An overlay of levels is mixed into the height's colour, by its share. */
static void under_an_overlay(void **state)
{
    gl_fixture *f = *state;
    static uint8_t alone[4 * PIXELS], plain[4 * PIXELS], mixed[4 * PIXELS];
    const stp_view view = ball_view(&f->model->ball, 0.6, false, SIZE);
    stp_draw_params params = grey();
    params.shade = STP_SHADE_PHONG;
    gl_fixture_draw(f, &view, &params, NULL, plain);
    params.shade = STP_SHADE_CHUNK;
    params.overlay = 1.0;
    gl_fixture_draw(f, &view, &params, NULL, alone);
    params.overlay = 0.25;
    gl_fixture_draw(f, &view, &params, NULL, mixed);
    size_t wrong = 0;
    for (int i = 0; i < 4 * PIXELS; i++)
        wrong += fabs(0.75 * plain[i] + 0.25 * alone[i] - mixed[i]) > 2.0;
    assert_true(wrong < 20); /* highlights may be cut off at white */
}

/* One tilted square of two triangles, 200 pixels wide: grey in proportion to the height. */
static void on_a_large_triangle(void **state)
{
    (void)state;
    gl_fixture f = {0};
    static uint8_t rgba[4 * PIXELS];
    const stp_dvec3 corners[4] = {
        {-1.0, -1.0, 0.0}, {1.0, -1.0, 0.5}, {1.0, 1.0, 1.0}, {-1.0, 1.0, 0.5}};
    prep_cloud none = {0};
    stp_prep_stats stats;
    stp_triangle_set square = square_make(corners);
    check_ok(prep_shapes_run(&none, NULL, &square, "square.stipple", 2, NULL, &stats, err));
    stp_triangle_set_clear(&square);
    gl_fixture_open(&f, "square.stipple", NULL);
    const stp_camera camera = {.eye = {0.0, 0.0, 5.0},
                               .look = {0.0, 0.0, 0.0},
                               .up = {0.0, 1.0, 0.0},
                               .fovy_deg = 40.0,
                               .height = 3.0};
    stp_view view;
    check_ok(stp_view_create(&view, &camera, &f.model->ball, SIZE, SIZE, err));
    stp_draw_params params = grey();
    params.colour_range[0] = 0.0;
    params.colour_range[1] = 1.0;
    gl_fixture_draw(&f, &view, &params, NULL, rgba);
    size_t count = 0;
    for (int i = 0; i < PIXELS; i++) {
        const double x = (i % SIZE + 0.5 - 0.5 * SIZE) * 3.0 / SIZE;
        const double y = (i / SIZE + 0.5 - 0.5 * SIZE) * 3.0 / SIZE;
        if (fabs(x) > 0.97 || fabs(y) > 0.97)
            continue;
        count++;
        assert_int_equal(rgba[4 * i + 3], 255);
        assert_true(fabs(rgba[4 * i] - 255.0 * (0.5 + 0.25 * x + 0.25 * y)) <= 1.0);
    }
    assert_true(count > 30000);
    gl_fixture_close(&f);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(by_pixel),
        cmocka_unit_test(picked),
        cmocka_unit_test(under_an_overlay),
        cmocka_unit_test(on_a_large_triangle),
    };
    int failed = cmocka_run_group_tests(tests, open_model, close_model);
    stp_gl_context_destroy(&context);
    return failed;
}

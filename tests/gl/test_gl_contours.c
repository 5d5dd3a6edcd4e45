/* Tests contours on a unit sphere against the circles of equal z that rays find on it: a pixel of a
 * line lies near a circle, and a circle is drawn where it faces the eye. On a gentle slope they are
 * straight between far samples. Level ground at a contour's own height has none, even if it is
 * rough, and pictures without contours do not change. */
#include "tests/fixtures/gl_model.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/sphere_ray.h"

enum { SIZE = 300, PIXELS = SIZE * SIZE };

/* Half of the widest line and its soft edge, in pixels, and what a circle may be off. */
#define WIDEST (0.5 * 2.2 + 0.5)
#define OFF 1.0

static int open_model(void **state)
{
    return gl_model_enter(state, &(model_recipe){.shape = GEN_SPHERE, .point_count = 120000});
}

static const stp_ball unit = {{0.0, 0.0, 0.0}, 1.0};

/* How far a pixel is from the nearest circle, in pixels, by the slope of z there; INFINITY beyond
 * the outline. */
static double pixels_off(const stp_view *view, int i, double step, double base, double *facing)
{
    const double u = i % SIZE + 0.5, v = i / SIZE + 0.5;
    double unused;
    const double z = sphere_ray_z(view, &unit, u, v, facing),
                 right = sphere_ray_z(view, &unit, u + 0.5, v, &unused),
                 left = sphere_ray_z(view, &unit, u - 0.5, v, &unused),
                 above = sphere_ray_z(view, &unit, u, v + 0.5, &unused),
                 below = sphere_ray_z(view, &unit, u, v - 0.5, &unused);
    const double slope = hypot(right - left, above - below);
    if (isnan(z) || isnan(slope))
        return INFINITY;
    return fabs(remainder(z - base, step)) / slope;
}

static void check_circles(gl_fixture *f, int variant)
{
    static uint8_t plain[4 * PIXELS], lined[4 * PIXELS];
    const stp_view view = ball_view(&f->model->ball, 0.6, variant % 2, SIZE);
    const double step = 0.2, base = variant < 2 ? 0.0 : 12345.67;
    stp_draw_params params = {.shade = STP_SHADE_UNLIT,
                              .colour = STP_COLOUR_NONE,
                              .threshold_px = variant < 4 ? 1.0 : 0.0,
                              .every_sample = variant >= 4,
                              .lod = variant < 4 ? STP_LOD_AUTO : STP_LOD_COMPUTE};
    gl_fixture_draw(f, &view, &params, NULL, plain);
    params.contour_step = step;
    params.contour_base = base;
    gl_fixture_draw(f, &view, &params, NULL, lined);
    size_t dark = 0, far = 0, on = 0, missing = 0;
    for (int i = 0; i < PIXELS; i++) {
        double facing = 0.0;
        const double off = pixels_off(&view, i, step, base, &facing);
        const int drawn = plain[4 * i] - lined[4 * i];
        assert_int_equal(plain[4 * i + 3], lined[4 * i + 3]);
        assert_true(drawn >= 0);
        if (isinf(off) || facing < 0.35)
            continue; /* near the outline lines are closer together than they are wide */
        dark += drawn > 40;
        far += drawn > 40 && off > WIDEST + OFF;
        on += off < 0.25;
        missing += off < 0.25 && drawn < 40;
    }
    print_message("variant %d: %zu pixels of lines, %zu too far; %zu on circles, %zu missing\n",
                  variant, dark, far, on, missing);
    assert_true(dark > 1500 && on > 400);
    assert_true(far <= dark / 100);
    assert_true(missing <= on / 20);
}

static void circles(void **state)
{
    for (int variant = 0; variant < 6; variant++)
        check_circles(*state, variant);
}

/* ---- a gentle slope ---- */

enum { SLOPE_SIDE = 40 };
#define SLOPE 0.05
#define SLOPE_STEP 0.01

/* Samples lie unevenly on a square from -1 to 1. */
static void build_slope(const char *path)
{
    stp_prep_stats stats;
    prep_cloud cloud = prep_cloud_wavy(SLOPE_SIDE * SLOPE_SIDE, (stp_dvec3){0}, 1.0);
    for (int i = 0; i < SLOPE_SIDE * SLOPE_SIDE; i++) {
        const double x = i % SLOPE_SIDE + 0.6 * stp_random_unit(5, (uint64_t)i);
        const double y = i / SLOPE_SIDE + 0.6 * stp_random_unit(6, (uint64_t)i);
        cloud.points[i].position =
            (stp_dvec3){2.0 * x / SLOPE_SIDE - 1.0, 2.0 * y / SLOPE_SIDE - 1.0,
                        SLOPE * (2.0 * x / SLOPE_SIDE - 1.0)};
    }
    check_ok(prep_cloud_run(&cloud, path, 2, NULL, &stats, err));
    free(cloud.points);
}

/* The height where the ray through window coordinates meets the slope. */
static double slope_height(const stp_view *view, double u, double v)
{
    const stp_dvec3 a = stp_view_unproject(view, u, v, 1.0),
                    b = stp_view_unproject(view, u, v, 2.0);
    const double off_a = a.z - SLOPE * a.x, off_b = b.z - SLOPE * b.x;
    return a.z + (b.z - a.z) * off_a / (off_a - off_b);
}

/* Seen at a slant, samples are 6 to 12 pixels apart, and what lies between is interpolated: lines
 * must not waver. */
static void straight_lines_between_samples(void **state)
{
    (void)state;
    static uint8_t lined[4 * PIXELS];
    gl_fixture f = {0};
    build_slope("slope.stipple");
    gl_fixture_open(&f, "slope.stipple", NULL);
    for (int r = STP_RECONSTRUCT_GAUSS; r <= STP_RECONSTRUCT_SPLAT; r++) {
        const stp_camera camera = stp_camera_around(&f.model->ball, (stp_dvec3){-0.6, -0.7, 0.6},
                                                    (stp_dvec3){0.0, 0.0, 1.0}, 30.0, SIZE, SIZE);
        const stp_draw_params params = {.reconstruct = (stp_reconstruct)r,
                                        .shade = STP_SHADE_UNLIT,
                                        .colour = STP_COLOUR_NONE,
                                        .contour_step = SLOPE_STEP};
        size_t inked = 0, off[2] = {0, 0};
        stp_view view;
        check_ok(stp_view_create(&view, &camera, &f.model->ball, SIZE, SIZE, err));
        gl_fixture_draw(&f, &view, &params, NULL, lined);
        for (int i = 0; i < PIXELS; i++) {
            if (lined[4 * i + 3] == 0 || lined[4 * i] >= 204 - 60)
                continue;
            const double u = i % SIZE + 0.5, v = i / SIZE + 0.5, z = slope_height(&view, u, v);
            const double rise =
                hypot(slope_height(&view, u + 1.0, v) - z, slope_height(&view, u, v + 1.0) - z);
            const double away = fabs(remainder(z, SLOPE_STEP)) / rise;
            inked++;
            off[0] += away > WIDEST + OFF;
            off[1] += away > WIDEST + 2.0 * OFF;
        }
        print_message("slope, reconstruction %d: %zu pixels of lines, %zu off by more than a "
                      "pixel, %zu by two\n",
                      r, inked, off[0], off[1]);
        assert_true(inked > 2500);
        /* Windows of 3 pixels are the least smooth: over twelve slopes, up to 4 pixels. */
        assert_true(off[0] <= inked / 50 &&
                    off[1] <= (r == STP_RECONSTRUCT_TEMPLATE3 ? inked / 1000 : 0));
    }
    gl_fixture_close(&f);
}

/* ---- a lake in a slope ---- */

enum { LAKE_SIDE = 160 };
#define LAKE_STEP 50.0
#define LAKE_HEIGHT 1000.0
#define LAKE_RADIUS 40.0 /* in samples */

/* Rises by a step in 40 samples, except for the lake; rough: by so many steps at most. */
static double lake_height(int column, int row, double rough)
{
    const double away = hypot(column - 0.5 * LAKE_SIDE, row - 0.5 * LAKE_SIDE) - LAKE_RADIUS;
    const uint64_t index = (uint64_t)row * LAKE_SIDE + (uint64_t)column;
    const double noise = rough * LAKE_STEP * (2.0 * stp_random_unit(11, index) - 1.0);
    return LAKE_HEIGHT + noise + LAKE_STEP / 40.0 * fmax(0.0, away);
}

static void build_lake(const char *path, double rough)
{
    stp_prep_stats stats;
    prep_cloud cloud = prep_cloud_wavy(LAKE_SIDE * LAKE_SIDE, (stp_dvec3){0}, 1.0);
    for (int i = 0; i < LAKE_SIDE * LAKE_SIDE; i++) {
        const int column = i % LAKE_SIDE, row = i / LAKE_SIDE;
        cloud.points[i].position =
            (stp_dvec3){25.0 * column, 25.0 * row, lake_height(column, row, rough)};
    }
    check_ok(prep_cloud_run(&cloud, path, 2, NULL, &stats, err));
    free(cloud.points);
}

/* The pixels with ink on the lake, a rim of five samples apart, and beside it. All else is of one
 * grey. */
static void count_ink(const gl_fixture *f, const stp_view *view, const stp_draw_params *params,
                      size_t out[2], size_t *lake)
{
    static uint8_t lined[4 * PIXELS];
    static float depth[PIXELS];
    gl_fixture_draw(f, view, params, NULL, lined);
    check_ok(stp_renderer_read_depth(f->renderer, depth, err));
    out[0] = out[1] = *lake = 0;
    for (int i = 0; i < PIXELS; i++) {
        if (!(depth[i] > 0.0f))
            continue;
        const stp_dvec3 at =
            stp_view_unproject(view, i % SIZE + 0.5, i / SIZE + 0.5, (double)depth[i]);
        const double away = hypot(at.x / 25.0 - 0.5 * LAKE_SIDE, at.y / 25.0 - 0.5 * LAKE_SIDE);
        const bool inked = lined[4 * i] < 204 - 30;
        *lake += away < LAKE_RADIUS - 5.0;
        out[0] += inked && away < LAKE_RADIUS - 5.0;
        out[1] += inked && away > LAKE_RADIUS + 5.0;
    }
}

static void check_lake(const gl_fixture *f, double rough, stp_reconstruct reconstruct, bool near)
{
    stp_camera camera = stp_camera_around(&f->model->ball, (stp_dvec3){0.1, -0.2, 1.0},
                                          (stp_dvec3){0.0, 1.0, 0.0}, 40.0, SIZE, SIZE);
    const stp_draw_params params = {.reconstruct = reconstruct,
                                    .shade = STP_SHADE_UNLIT,
                                    .colour = STP_COLOUR_NONE,
                                    .contour_step = LAKE_STEP,
                                    .lod = near ? STP_LOD_COMPUTE : STP_LOD_AUTO};
    size_t ink[2], lake = 0;
    stp_view view;
    camera.fovy_deg = near ? 12.0 : 40.0; /* 6 pixels a sample, or 2 */
    check_ok(stp_view_create(&view, &camera, &f->model->ball, SIZE, SIZE, err));
    count_ink(f, &view, &params, ink, &lake);
    print_message("roughness %g, reconstruction %d: %zu of %zu pixels of the lake, %zu beside\n",
                  rough, (int)reconstruct, ink[0], lake, ink[1]);
    assert_true(lake > 2000);
    assert_true(ink[0] <= lake / 250);
    assert_true(near || ink[1] > 200);
}

/* A lake at the very height of a line has no ink, by any reconstruction, however rough and near;
 * the slope around it has its lines. */
static void no_lines_on_a_lake(void **state)
{
    (void)state;
    static const double roughness[] = {0.0, 0.02, 0.1};
    for (int k = 0; k < 3; k++) {
        gl_fixture f = {0};
        build_lake("lake.stipple", roughness[k]);
        gl_fixture_open(&f, "lake.stipple", NULL);
        check_lake(&f, roughness[k], STP_RECONSTRUCT_GAUSS, false);
        check_lake(&f, roughness[k], STP_RECONSTRUCT_GAUSS, true);
        for (int r = STP_RECONSTRUCT_BOX; k == 1 && r <= STP_RECONSTRUCT_SPLAT; r += 2)
            check_lake(&f, roughness[k], (stp_reconstruct)r, false);
        gl_fixture_close(&f);
    }
}

static void no_lines_on_a_level_plane(void **state)
{
    (void)state;
    static uint8_t plain[4 * PIXELS], lined[4 * PIXELS];
    gl_fixture f = {0};
    model_fixture_build("plane.stipple", &(model_recipe){.shape = GEN_PLANE, .point_count = 10000});
    gl_fixture_open(&f, "plane.stipple", NULL);
    const stp_view view = ball_view(&f.model->ball, 0.6, false, SIZE);
    stp_draw_params params = {.shade = STP_SHADE_UNLIT};
    gl_fixture_draw(&f, &view, &params, NULL, plain);
    params.contour_step = 0.1;
    gl_fixture_draw(&f, &view, &params, NULL, lined);
    /* two programs: NVIDIA's compiler rounds a few channels otherwise */
    for (size_t i = 0; i < sizeof plain; i++)
        assert_true(abs(plain[i] - lined[i]) <= 1);
    gl_fixture_close(&f);
}

static void wrong_steps(void **state)
{
    gl_fixture *f = *state;
    static const double wrong[][2] = {{-1.0, 0.0}, {NAN, 0.0}, {INFINITY, 0.0}, {1.0, NAN}};
    const stp_view view = ball_view(&f->model->ball, 0.6, false, SIZE);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        stp_error error = {0};
        const stp_draw_params params = {.contour_step = wrong[i][0], .contour_base = wrong[i][1]};
        assert_int_equal(stp_renderer_draw(f->renderer, &view, &params, NULL, &error),
                         STP_INVALID_ARGUMENT);
        assert_non_null(strstr(error.message, "contours"));
    }
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(circles), cmocka_unit_test(straight_lines_between_samples),
        cmocka_unit_test(no_lines_on_a_lake), cmocka_unit_test(no_lines_on_a_level_plane),
        cmocka_unit_test(wrong_steps)};
    int failed = cmocka_run_group_tests(tests, open_model, gl_model_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

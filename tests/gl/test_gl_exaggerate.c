/* Tests exaggerated heights: a picture with heights Z times as high is the picture of a model whose
 * points were moved, on every road and in both projections; the threshold holds in it; and what is
 * read from it is the model's own. */
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/fixtures/sphere_ray.h"
#include "tests/fixtures/square_fixture.h"

enum { COUNT = 60000, SIZE = 240, PIXELS = SIZE * SIZE };

static const stp_dvec3 centre = {500000.0, 4.5e6, 300.0};
static const double radius = 20.0;
static const stp_lod roads[] = {STP_LOD_GEOMETRY, STP_LOD_CPU, STP_LOD_COMPUTE, STP_LOD_FULL};
enum { ROADS = sizeof roads / sizeof *roads };

/* A ball of points with their normals, heights `times` as high. */
static void build(const char *path, double times)
{
    stp_prep_stats stats;
    prep_cloud cloud = prep_cloud_make(COUNT);
    for (int i = 0; i < COUNT; i++) {
        const double z = (2.0 * i + 1.0) / COUNT - 1.0, a = i * M_PI * (3.0 - sqrt(5.0));
        const double across = sqrt(1.0 - z * z);
        const stp_dvec3 out = {across * cos(a), across * sin(a), z};
        const stp_dvec3 moved = {out.x, out.y, out.z * times};
        stp_point *p = &cloud.points[i];
        p->position = stp_dvec3_add(centre, stp_dvec3_scale(moved, radius));
        p->normal = stp_dvec3_to_float(
            stp_dvec3_normalize((stp_dvec3){out.x, out.y, out.z / times + 1e-9}));
        p->rgb[0] = p->rgb[1] = p->rgb[2] = 50000;
    }
    check_ok(prep_cloud_run(&cloud, path, 2, NULL, &stats, err));
    free(cloud.points);
}

static int open_model(void **state)
{
    static gl_fixture f;
    if (scan_fixture_enter(state) != 0)
        return 1;
    build("ball.stipple", 1.0);
    gl_fixture_open(&f, "ball.stipple", NULL);
    *state = &f;
    return 0;
}

static int close_model(void **state)
{
    gl_fixture_close(*state);
    return scan_fixture_leave(state);
}

static stp_draw_params times(double z)
{
    return (stp_draw_params){.exaggerate = z, .exaggerate_about = centre.z};
}

static stp_view view_of(const gl_fixture *f, const stp_draw_params *params, bool orthographic)
{
    const stp_ball ball = stp_exaggerated_ball(params, &f->model->ball);
    return ball_view(&ball, 0.3, orthographic, SIZE);
}

/* How much two pictures differ: pixels that only one covers, and the mean difference of others. */
static void differ(const uint8_t *a, const uint8_t *b, size_t *apart, double *mean)
{
    size_t both = 0;
    double sum = 0.0;
    *apart = 0;
    for (int i = 0; i < PIXELS; i++) {
        const bool in_a = a[4 * i + 3] != 0, in_b = b[4 * i + 3] != 0;
        *apart += in_a != in_b;
        both += in_a && in_b;
        for (int c = 0; c < 3 && in_a && in_b; c++)
            sum += abs(a[4 * i + c] - b[4 * i + c]) / 3.0;
    }
    assert_true(both > PIXELS / 200);
    *mean = sum / (double)both;
}

/* Every sample and a threshold of 1 px, light from the camera and light that stands still. */
static void as_moved_before(void **state)
{
    gl_fixture *f = *state;
    static uint8_t rgba[4 * PIXELS], moved[4 * PIXELS];
    static const double heights[] = {4.0, 0.25};
    for (int k = 0; k < 2; k++) {
        gl_fixture other = {0};
        build("moved.stipple", heights[k]);
        gl_fixture_open(&other, "moved.stipple", NULL);
        for (int variant = 0; variant < 4; variant++) {
            stp_draw_params params = times(heights[k]), plain = {0};
            const stp_view view = view_of(f, &params, variant % 2);
            params.every_sample = plain.every_sample = variant < 2;
            params.light[2] = plain.light[2] = variant % 2 ? 1.0 : 0.0;
            gl_fixture_draw(&other, &view, &plain, NULL, moved);
            for (int r = variant % 2; r < ROADS; r += 2) {
                size_t apart = 0;
                double mean = 0.0;
                params.lod = roads[r];
                gl_fixture_draw(f, &view, &params, NULL, rgba);
                differ(rgba, moved, &apart, &mean);
                print_message("%g times, variant %d, road %d: %zu pixels apart, colours by %.2f\n",
                              heights[k], variant, r, apart, mean);
                assert_true(apart < 700); /* outlines: discs are stretched both ways */
                assert_true(mean < (variant < 2 ? 4.0 : 4.5)); /* each has levels of its own */
            }
        }
        gl_fixture_close(&other);
    }
}

/* Errors are stretched with the picture: no level is chosen whose error, so stretched, is greater
 * than the threshold, and the picture stays near that of every sample. As it is, the model needs
 * far fewer samples from there. */
static void threshold_holds(void **state)
{
    gl_fixture *f = *state;
    static uint8_t coarse[4 * PIXELS], finest[4 * PIXELS];
    stp_draw_stats stats, plain;
    stp_cut_measure measure;
    size_t apart = 0;
    double mean = 0.0;
    stp_draw_params params = times(8.0);
    stp_view view = view_of(f, &params, false);
    view.f *= 4.0; /* the middle of it */
    gl_fixture_draw(f, &view, &params, &stats, coarse);
    stp_renderer_measure(f->renderer, &measure);
    assert_true(measure.max_error_px <= 1.0 + 1e-5);
    params.every_sample = true;
    gl_fixture_draw(f, &view, &params, NULL, finest);
    differ(coarse, finest, &apart, &mean);
    params = (stp_draw_params){.lod = STP_LOD_AUTO};
    gl_fixture_draw(f, &view, &params, &plain, finest);
    print_message("%llu points, %zu pixels apart; %llu points as it is\n",
                  (unsigned long long)stats.points_drawn, apart,
                  (unsigned long long)plain.points_drawn);
    assert_true(apart < 300);
    assert_true(stats.points_drawn > 2 * plain.points_drawn);
}

/* Picks and normals are the model's; contours and colours follow its heights. */
static void reads_the_model(void **state)
{
    gl_fixture *f = *state;
    static uint8_t rgba[4 * PIXELS];
    static float normals[3 * PIXELS];
    for (int variant = 0; variant < 6; variant++) {
        stp_draw_params params = times(variant < 2 ? 3.0 : variant < 4 ? 0.4 : 0.0);
        params.colour = STP_COLOUR_ELEVATION;
        params.palette = STP_PALETTE_GREY;
        params.shade = STP_SHADE_UNLIT;
        params.keep_pixels = true;
        params.colour_range[0] = centre.z - radius;
        params.colour_range[1] = centre.z + radius;
        const stp_view view = view_of(f, &params, variant % 2);
        gl_fixture_draw(f, &view, &params, NULL, rgba);
        check_ok(stp_renderer_read_normals(f->renderer, normals, err));
        size_t hits = 0;
        double worst = 0.0;
        for (int i = 0; i < PIXELS; i += 31) {
            stp_pick pick;
            if (rgba[4 * i + 3] == 0)
                continue;
            check_ok(stp_renderer_pick(f->renderer, i % SIZE, i / SIZE, &pick, err));
            const stp_dvec3 out = stp_dvec3_sub(pick.position, centre);
            const stp_dvec3 seen = stp_view_project(&view, stp_exaggerated(&params, pick.position));
            const stp_dvec3 facing = stp_dvec3_normalize(
                stp_dvec3_sub(stp_unexaggerated(&params, view.eye), pick.position));
            if (stp_dvec3_dot(facing, stp_dvec3_normalize(out)) < 0.3)
                continue;
            hits++;
            worst = fmax(worst, fabs(stp_dvec3_length(out) - radius) / pick.radius);
            assert_true(fabs(stp_dvec3_length(out) - radius) < pick.radius);
            assert_true(fabs(seen.x - i % SIZE - 0.5) < 1.0 && fabs(seen.y - i / SIZE - 0.5) < 1.0);
            assert_true(stp_dvec3_dot(pick.normal, out) > 0.99 * stp_dvec3_length(out));
            const stp_dvec3 n = {(double)normals[3 * i], (double)normals[3 * i + 1],
                                 (double)normals[3 * i + 2]};
            assert_true(stp_dvec3_dot(n, out) > 0.99 * stp_dvec3_length(out));
            assert_true(fabs(127.5 * (out.z / radius + 1.0) - rgba[4 * i]) < 5.0);
            assert_true(pick.radius > 0.0 && pick.radius < 0.1 * radius);
        }
        print_message("%g times: positions off by %.2f radii at most\n", params.exaggerate, worst);
        assert_true(hits > 40);
    }
}

/* A box of the model's coordinates clips the same part, however high it is drawn. */
static void clipped(void **state)
{
    gl_fixture *f = *state;
    static uint8_t rgba[4 * PIXELS];
    stp_draw_params params = times(3.0);
    const stp_view view = view_of(f, &params, false);
    params.clip = (stp_clip){true,
                             {{centre.x - 30.0, centre.y - 30.0, centre.z + 5.0},
                              {centre.x + 30.0, centre.y + 30.0, centre.z + 10.0}}};
    gl_fixture_draw(f, &view, &params, NULL, rgba);
    size_t hits = 0;
    for (int i = 0; i < PIXELS; i += 7) {
        stp_pick pick;
        if (rgba[4 * i + 3] == 0)
            continue;
        check_ok(stp_renderer_pick(f->renderer, i % SIZE, i / SIZE, &pick, err));
        hits++;
        assert_true(pick.position.z > centre.z + 5.0 - pick.radius &&
                    pick.position.z < centre.z + 10.0 + pick.radius);
    }
    assert_true(hits > 50);
}

/* A square of two triangles, drawn and clipped as the moved one, but for the rim. */
static void triangles_too(void **state)
{
    (void)state;
    static uint8_t pictures[2][4 * PIXELS];
    for (int k = 0; k < 2; k++) { /* exaggerated, then moved before */
        const double z = k == 0 ? 1.0 : 3.0;
        const stp_dvec3 corners[4] = {
            {-1.0, -1.0, -0.5 * z}, {1.0, -1.0, 0.0}, {1.0, 1.0, 0.5 * z}, {-1.0, 1.0, 0.0}};
        gl_fixture f = {0};
        stp_prep_stats stats;
        stp_triangle_set square = square_make(corners);
        check_ok(prep_shapes_run(NULL, NULL, &square, "square.stipple", 2, NULL, &stats, err));
        stp_triangle_set_clear(&square);
        gl_fixture_open(&f, "square.stipple", NULL);
        const stp_camera camera = {
            .eye = {1.0, -3.0, 6.0}, .up = {0.0, 0.0, 1.0}, .fovy_deg = 30.0};
        const stp_ball ball = {{0.0, 0.0, 0.0}, 4.0};
        stp_view view;
        check_ok(stp_view_create(&view, &camera, &ball, SIZE, SIZE, err));
        const stp_draw_params params = {.exaggerate = k == 0 ? 3.0 : 0.0,
                                        .planes = {{{0.0, 0.0, 1.0}, -0.2 * z}},
                                        .plane_count = 1,
                                        .clip = {true, {{-0.8, -2.0, -2.0}, {2.0, 2.0, 2.0}}}};
        gl_fixture_draw(&f, &view, &params, NULL, pictures[k]);
        gl_fixture_close(&f);
    }
    size_t apart = 0;
    double mean = 0.0;
    differ(pictures[0], pictures[1], &apart, &mean);
    print_message("triangles: %zu pixels apart, colours by %.2f\n", apart, mean);
    assert_true(apart < 60 && mean < 1.0);
}

static void refused(void **state)
{
    gl_fixture *f = *state;
    static const double wrong[][2] = {
        {-1.0, 0.0}, {0.001, 0.0}, {101.0, 0.0}, {NAN, 0.0}, {2.0, INFINITY}};
    const stp_draw_params plain = {0};
    const stp_view view = view_of(f, &plain, false);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        stp_error error = {0};
        const stp_draw_params params = {.exaggerate = wrong[i][0], .exaggerate_about = wrong[i][1]};
        assert_int_equal(stp_renderer_draw(f->renderer, &view, &params, NULL, &error),
                         STP_INVALID_ARGUMENT);
        assert_non_null(strstr(error.message, "heights"));
    }
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_moved_before), cmocka_unit_test(threshold_holds),
        cmocka_unit_test(reads_the_model), cmocka_unit_test(clipped),
        cmocka_unit_test(triangles_too),   cmocka_unit_test(refused),
    };
    int failed = cmocka_run_group_tests(tests, open_model, close_model);
    stp_gl_context_destroy(&context);
    return failed;
}

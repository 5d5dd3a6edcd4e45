/* Tests depths and normals of a unit sphere, where they are known, in the world's axes: from the
 * renderer's functions and in the files that `stipple render` writes, whose first row is the top
 * one. */
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/support/exr_shim.h"

#include <unistd.h>

#define MODEL "test_gl_exr.stipple"
#define WIDTH 90
#define HEIGHT 70

/* Looks from below, turned about its axis, so that no axis of the picture is an axis of the
 * world. */
static const stp_camera camera = {
    .eye = {1.5, -2.0, -1.1}, .look = {0.2, 0.1, 0.0}, .up = {0.7, 0.1, 0.4}, .fovy_deg = 50.0};

static stp_view view_of(const stp_camera *c, const stp_model *model)
{
    stp_view view;
    check_ok(stp_view_create(&view, c, &model->ball, WIDTH, HEIGHT, err));
    return view;
}

/* Finds where the ray of a pixel (y upwards) meets the unit sphere about the origin. Returns false
 * if the square of half the ray's way through the sphere is below `rim`. */
static bool meet_sphere(const stp_view *v, int x, int y, double rim, stp_dvec3 *at, double *depth)
{
    double u = x + 0.5 - 0.5 * v->width, w = y + 0.5 - 0.5 * v->height;
    stp_dvec3 from = v->eye, ray = stp_dvec3_scale(v->back, -1.0);
    stp_dvec3 aside =
        stp_dvec3_add(stp_dvec3_scale(v->right, u / v->f), stp_dvec3_scale(v->up, w / v->f));
    if (v->orthographic)
        from = stp_dvec3_add(from, aside);
    else
        ray = stp_dvec3_add(ray, aside);
    double a = stp_dvec3_dot(ray, ray), b = stp_dvec3_dot(ray, from);
    double d = b * b - a * (stp_dvec3_dot(from, from) - 1.0);
    if (d < a * rim)
        return false;
    *depth = (-b - sqrt(d)) / a; /* the ray advances by 1 along the axis */
    *at = stp_dvec3_add(from, stp_dvec3_scale(ray, *depth));
    return true;
}

/* Checks pixels well inside the sphere; bottom: the first row is the lowest. */
static void check_sphere(const stp_view *view, const float *depth, const float *xyz, bool bottom)
{
    int inside = 0;
    for (int row = 0; row < view->height; row++)
        for (int x = 0; x < view->width; x++) {
            stp_dvec3 at;
            double known = 0.0;
            int y = bottom ? row : view->height - 1 - row;
            size_t i = (size_t)row * (size_t)view->width + (size_t)x;
            if (!meet_sphere(view, x, y, 0.5, &at, &known))
                continue;
            inside++;
            check_near((double)depth[i], known, 0.05);
            check_near((double)xyz[3 * i], at.x, 0.1);
            check_near((double)xyz[3 * i + 1], at.y, 0.1);
            check_near((double)xyz[3 * i + 2], at.z, 0.1);
        }
    assert_true(inside > WIDTH * HEIGHT / 8);
}

static void draw(gl_fixture *f, const stp_view *view, stp_draw_params params)
{
    stp_draw_stats stats;
    check_ok(stp_renderer_draw(f->renderer, view, &params, &stats, err));
    assert_true(stats.cut_complete);
}

static void reads_what_was_drawn(void **state)
{
    gl_fixture *f = *state;
    const size_t count = WIDTH * HEIGHT;
    float *depth = calloc(count, sizeof *depth), *xyz = calloc(count, 3 * sizeof *xyz);
    uint8_t *rgba = calloc(count, 4);
    assert_true(depth != NULL && xyz != NULL && rgba != NULL);
    for (int variant = 0; variant < 8; variant++) {
        stp_camera c = camera;
        c.height = variant & 1 ? 2.5 : 0.0;
        stp_view view = view_of(&c, f->model);
        draw(f, &view,
             (stp_draw_params){.shade = STP_SHADE_NORMAL,
                               .reconstruct =
                                   variant & 2 ? STP_RECONSTRUCT_POINTS : STP_RECONSTRUCT_GAUSS,
                               .cull = variant & 4 ? STP_CULL_NONE : STP_CULL_BACK,
                               .keep_pixels = true});
        check_ok(stp_renderer_read_depth(f->renderer, depth, err));
        check_ok(stp_renderer_read_normals(f->renderer, xyz, err));
        check_ok(stp_renderer_read(f->renderer, rgba, err));
        for (size_t i = 0; i < count; i++) {
            stp_dvec3 n = {(double)xyz[3 * i], (double)xyz[3 * i + 1], (double)xyz[3 * i + 2]};
            bool covered = rgba[4 * i + 3] != 0;
            float one = -1.0f;
            assert_int_equal(covered, depth[i] > 0.0f);
            if (i % 37 == 0) {
                check_ok(
                    stp_renderer_depth_at(f->renderer, (int)i % WIDTH, (int)i / WIDTH, &one, err));
                check_near((double)one, (double)depth[i], 0.0);
            }
            check_near(stp_dvec3_length(n), covered ? 1.0 : 0.0, 1e-5);
            if (!covered)
                continue;
            /* --shade normal shows normals in eye space */
            check_near(rgba[4 * i], 127.5 + 127.5 * stp_dvec3_dot(n, view.right), 0.75);
            check_near(rgba[4 * i + 1], 127.5 + 127.5 * stp_dvec3_dot(n, view.up), 0.75);
            check_near(rgba[4 * i + 2], 127.5 + 127.5 * stp_dvec3_dot(n, view.back), 0.75);
        }
        if (!(variant & 6)) /* closed, seen from outside */
            check_sphere(&view, depth, xyz, true);
    }
    free(depth);
    free(xyz);
    free(rgba);
}

static void asks_for_kept_pixels(void **state)
{
    gl_fixture *f = *state;
    float xyz[3] = {7.0f, 7.0f, 7.0f};
    stp_view view = view_of(&camera, f->model);
    draw(f, &view, (stp_draw_params){0});
    assert_int_equal(stp_renderer_read_normals(f->renderer, xyz, NULL), STP_INVALID_ARGUMENT);
    check_near((double)xyz[0], 7.0, 0.0);
}

/* Draws two views of one size in turn, one of them empty: nothing of the last frame may show. */
static void forgets_the_frame_before(void **state)
{
    gl_fixture *f = *state;
    const size_t count = WIDTH * HEIGHT;
    float *xyz = calloc(count, 3 * sizeof *xyz);
    stp_camera away = camera;
    assert_non_null(xyz);
    away.look = (stp_dvec3){3.0, -4.0, -2.2};
    stp_view view = view_of(&camera, f->model), nothing = view_of(&away, f->model);
    draw(f, &view, (stp_draw_params){.keep_pixels = true});
    draw(f, &nothing, (stp_draw_params){.keep_pixels = true});
    check_ok(stp_renderer_read_normals(f->renderer, xyz, err));
    for (size_t i = 0; i < 3 * count; i++)
        check_near((double)xyz[i], 0.0, 0.0);
    free(xyz);
}

static void files_have_the_top_row_first(void **state)
{
    gl_fixture *f = *state;
    char command[1024];
    exr_image depth = {.values = NULL}, normals = {.values = NULL};
    stp_camera noted = {.height = 0.0};
    snprintf(
        command, sizeof command,
        "'%s' render %s -o test_gl_exr.png --depth test_gl_exr_z.exr --normals "
        "test_gl_exr_n.exr --force --quiet --eye 1.5,-2,-1.1 --look 0.2,0.1,0 --up 0.7,0.1,0.4 "
        "--fovy 50 --size %dx%d",
        getenv("STIPPLE"), MODEL, WIDTH, HEIGHT);
    assert_int_equal(system(command), 0);
    assert_int_equal(exr_image_read("test_gl_exr_z.exr", &depth), 0);
    assert_int_equal(exr_image_read("test_gl_exr_n.exr", &normals), 0);
    assert_true(depth.width == WIDTH && depth.height == HEIGHT);
    assert_true(normals.width == WIDTH && normals.height == HEIGHT);
    assert_string_equal(depth.channels, "Z");
    assert_string_equal(normals.channels, "N.X N.Y N.Z");
    stp_view view = view_of(&camera, f->model);
    check_sphere(&view, depth.values, normals.values, false);
    for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
        double length = (double)normals.values[3 * i] * (double)normals.values[3 * i] +
                        (double)normals.values[3 * i + 1] * (double)normals.values[3 * i + 1] +
                        (double)normals.values[3 * i + 2] * (double)normals.values[3 * i + 2];
        check_near(length, isinf(depth.values[i]) ? 0.0 : 1.0, 1e-5);
        assert_true(depth.values[i] > 0.0f);
    }
    assert_true(isinf(depth.values[0]));
    /* --camera must read the camera in the file's note */
    FILE *file = fopen("test_gl_exr.json", "w");
    assert_non_null(file);
    fputs(depth.camera, file);
    fclose(file);
    check_ok(stp_camera_load(&noted, "test_gl_exr.json", err));
    assert_memory_equal(&noted.eye, &camera.eye, sizeof camera.eye);
    assert_memory_equal(&noted.look, &camera.look, sizeof camera.look);
    assert_int_equal(noted.size[0], WIDTH);
    check_near(noted.fovy_deg, 50.0, 0.0);
    free(depth.values);
    free(normals.values);
}

int main(void)
{
    const model_recipe recipe = {.shape = GEN_SPHERE, .point_count = 40000, .true_normals = true};
    stp_gl_context *context = gl_fixture_context();
    gl_fixture f = {NULL, NULL};
    model_fixture_build(MODEL, &recipe);
    gl_fixture_open(&f, MODEL, NULL);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate(reads_what_was_drawn, &f),
        cmocka_unit_test_prestate(asks_for_kept_pixels, &f),
        cmocka_unit_test_prestate(forgets_the_frame_before, &f),
        cmocka_unit_test_prestate(files_have_the_top_row_first, &f),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    gl_fixture_close(&f);
    stp_gl_context_destroy(&context);
    unlink(MODEL);
    return failed;
}

/* Tests pictures drawn in parts, each with a rim that is cut off: they must equal the picture drawn
 * at once. Screenshots larger than any framebuffer are made this way. */
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/support/views.h"

/* BORDER: the whole picture lacks the samples outside its rim, but the parts have them. */
enum { WIDTH = 1000, HEIGHT = 700, PART = 256, RIM = 128, BORDER = 24 };

/* Draws the parts and assembles them. */
static void draw_parts(gl_fixture *f, const stp_view *view, const stp_draw_params *params,
                       uint8_t *rgba, uint8_t *part)
{
    const int side = PART + 2 * RIM;
    for (int y = 0; y < HEIGHT; y += PART)
        for (int x = 0; x < WIDTH; x += PART) {
            int width = WIDTH - x < PART ? WIDTH - x : PART;
            int height = HEIGHT - y < PART ? HEIGHT - y : PART;
            stp_view of_part = stp_view_part(view, x - RIM, y - RIM, side, side);
            gl_fixture_draw(f, &of_part, params, NULL, part);
            for (int row = 0; row < height; row++)
                memcpy(rgba + 4 * ((size_t)(y + row) * WIDTH + (size_t)x),
                       part + 4 * ((size_t)(row + RIM) * (size_t)side + RIM), 4 * (size_t)width);
        }
}

static size_t covered(const uint8_t *rgba)
{
    size_t count = 0;
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; i++)
        count += rgba[4 * i + 3] > 0;
    return count;
}

static size_t different(const uint8_t *a, const uint8_t *b)
{
    size_t count = 0;
    for (int y = BORDER; y < HEIGHT - BORDER; y++)
        for (int x = BORDER; x < WIDTH - BORDER; x++) {
            size_t i = 4 * ((size_t)y * WIDTH + (size_t)x);
            count += memcmp(a + i, b + i, 4) != 0;
        }
    return count;
}

static void parts_are_the_whole(void **state)
{
    (void)state;
    static const stp_lod roads[] = {STP_LOD_GEOMETRY, STP_LOD_COMPUTE, STP_LOD_FULL};
    gl_fixture f;
    uint8_t *whole = calloc((size_t)WIDTH * HEIGHT, 4), *parts = calloc((size_t)WIDTH * HEIGHT, 4);
    uint8_t *part = calloc((size_t)(PART + 2 * RIM) * (PART + 2 * RIM), 4);
    assert_true(whole != NULL && parts != NULL && part != NULL);
    model_fixture_build("parts.stipple",
                        &(model_recipe){.shape = GEN_STATUE, .point_count = 100000});
    gl_fixture_open(&f, "parts.stipple", NULL);
    for (int i = 0; i < 6; i++) {
        stp_camera camera = stp_camera_around(&f.model->ball, (stp_dvec3){0.4, 0.3, 1.0},
                                              (stp_dvec3){0.0, 1.0, 0.0}, 45.0, WIDTH, HEIGHT);
        camera.height = i >= 3 ? 1.2 * f.model->ball.radius : 0.0;
        stp_view view;
        stp_draw_params params = {.lod = roads[i % 3]};
        check_ok(stp_view_create(&view, &camera, &f.model->ball, WIDTH, HEIGHT, err));
        gl_fixture_draw(&f, &view, &params, NULL, whole);
        draw_parts(&f, &view, &params, parts, part);
        assert_true(covered(whole) > (size_t)WIDTH * HEIGHT / 20);
        /* here and there a position rounds to another pixel */
        assert_true(different(whole, parts) < covered(whole) / 1000);
    }
    gl_fixture_close(&f);
    free(part);
    free(parts);
    free(whole);
}

/* A part's window coordinates are the view's minus the part's origin. */
static void parts_keep_positions(void **state)
{
    (void)state;
    stp_view view = check_view(WIDTH, HEIGHT, 800.0, false);
    stp_view part = stp_view_part(&view, 700, -50, 100, 80);
    stp_dvec3 p = stp_view_project(&view, (stp_dvec3){0.5, -0.25, -2.0});
    stp_dvec3 q = stp_view_project(&part, (stp_dvec3){0.5, -0.25, -2.0});
    check_near(q.x, p.x - 700.0, 1e-9);
    check_near(q.y, p.y + 50.0, 1e-9);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts_are_the_whole),
        cmocka_unit_test(parts_keep_positions),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stp_gl_context_destroy(&context);
    return failed;
}

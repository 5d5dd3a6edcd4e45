/* Tests the seam between triangles and points: one half of a ball is stored as triangles by prep's
 * own rule. From 26 directions no pixel at the seam may show the background or the ball's far side.
 * Box, which has gauss's shaders but for the weights, makes small pictures only, as templates do;
 * with the argument --every, as in long_gl_seams, large ones, too. */
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/support/views.h"

/* Quads around the x axis: few rings of wide quads for x < 0, many rings of small quads for x > 0.
 * At x = 0 fans of triangles join the two. */
enum { WIDE_AROUND = 60, WIDE_RINGS = 6, FINE_AROUND = 480, FINE_RINGS = 120 };
enum { FAN = FINE_AROUND / WIDE_AROUND, FINE_VERTICES = FINE_AROUND * (FINE_RINGS + 1) };

/* A pixel is judged if it is near enough to the seam and far enough inside the outline. */
#define BAND 0.2
#define INSIDE_PX 2.0
/* A surface this much behind the ball is its far side. At the outline, the wide triangles lie up to
 * 0.14 inside the ball. */
#define DEPTH_OFF 0.25

static void write_ring(FILE *file, int around, double angle, double side)
{
    for (int k = 0; k < around; k++) {
        double b = 2.0 * M_PI * k / around;
        fprintf(file, "v %.9g %.9g %.9g\n", side * sin(angle), cos(angle) * cos(b),
                cos(angle) * sin(b));
    }
}

/* The number of a vertex in a ring; the wide rings begin at ring 1. */
static int fine(int ring, int k)
{
    return 1 + ring * FINE_AROUND + k % FINE_AROUND;
}

static int wide(int ring, int k)
{
    return 1 + FINE_VERTICES + (ring - 1) * WIDE_AROUND + k % WIDE_AROUND;
}

static void write_quad(FILE *file, int a, int b, int c, int d)
{
    fprintf(file, "f %d %d %d\nf %d %d %d\n", a, b, c, a, c, d);
}

static void write_ball(const char *path)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (int r = 0; r <= FINE_RINGS; r++)
        write_ring(file, FINE_AROUND, 0.5 * M_PI * r / FINE_RINGS, 1.0);
    for (int r = 1; r <= WIDE_RINGS; r++)
        write_ring(file, WIDE_AROUND, 0.5 * M_PI * r / WIDE_RINGS, -1.0);
    for (int r = 0; r < FINE_RINGS; r++)
        for (int k = 0; k < FINE_AROUND; k++)
            write_quad(file, fine(r, k), fine(r, k + 1), fine(r + 1, k + 1), fine(r + 1, k));
    for (int k = 0; k < WIDE_AROUND; k++) {
        for (int j = FAN * k; j < FAN * (k + 1); j++)
            fprintf(file, "f %d %d %d\n", wide(1, k), fine(0, j + 1), fine(0, j));
        fprintf(file, "f %d %d %d\n", wide(1, k), wide(1, k + 1), fine(0, FAN * (k + 1)));
    }
    for (int r = 1; r < WIDE_RINGS; r++)
        for (int k = 0; k < WIDE_AROUND; k++)
            write_quad(file, wide(r, k), wide(r + 1, k), wide(r + 1, k + 1), wide(r, k + 1));
    assert_int_equal(fclose(file), 0);
}

/* Runs the ball through prep as --hybrid does. */
static void build(const char *path)
{
    const stp_scan_params params = {.hybrid = true};
    stp_triangle_set triangles = {0};
    stp_prep_stats stats;
    stp_scan *scan = NULL;
    write_ball("ball.obj");
    check_ok(stp_scan_open(&scan, "ball.obj", &params, err));
    stp_scan_take_triangles(scan, &triangles);
    assert_true(triangles.triangle_count > WIDE_AROUND * (2 * WIDE_RINGS - 3));
    prep_cloud points = prep_cloud_make((size_t)stp_scan_get_info(scan)->point_count);
    size_t count = 0, got = 1;
    while (got > 0) {
        check_ok(stp_scan_read(scan, points.points + count, points.count - count, &got, err));
        count += got;
    }
    assert_int_equal(count, points.count);
    stp_scan_close(&scan);
    check_ok(prep_shapes_run(&points, NULL, &triangles, path, 2, NULL, &stats, err));
    stp_triangle_set_clear(&triangles);
    free(points.points);
}

/* The depth of the unit ball at a pixel near the seam; 0: the pixel is not judged. */
static double depth_at(const stp_view *view, int x, int y)
{
    stp_dvec3 c = reference_to_eye(view, (stp_dvec3){0.0, 0.0, 0.0});
    stp_dvec3 ray = {(x + 0.5 - stp_view_axis_x(view)) / view->f,
                     (y + 0.5 - stp_view_axis_y(view)) / view->f, -1.0};
    double length = stp_dvec3_length(ray);
    stp_dvec3 unit = stp_dvec3_scale(ray, 1.0 / length);
    double along = stp_dvec3_dot(unit, c);
    double away = sqrt(fmax(0.0, stp_dvec3_dot(c, c) - along * along));
    if (away > 1.0 - INSIDE_PX * along / view->f)
        return 0.0;
    double distance = along - sqrt(1.0 - away * away);
    stp_dvec3 from_centre = stp_dvec3_sub(stp_dvec3_scale(unit, distance), c);
    double seam = from_centre.x * view->right.x + from_centre.y * view->up.x +
                  from_centre.z * view->back.x; /* the world's x */
    return fabs(seam) < BAND ? distance / length : 0.0;
}

typedef struct tally {
    size_t judged, background, far_side;
} tally;

static void judge_view(gl_fixture *f, const stp_view *view, const stp_draw_params *params,
                       tally *sum)
{
    stp_draw_stats stats;
    check_ok(stp_renderer_draw(f->renderer, view, params, &stats, err));
    reference_pixel *pixels = gl_fixture_pixels(f, true);
    for (int i = 0; i < view->width * view->height; i++) {
        double depth = depth_at(view, i % view->width, i / view->width);
        if (depth == 0.0)
            continue;
        sum->judged++;
        sum->background += pixels[i].tag == 0;
        sum->far_side += pixels[i].tag != 0 && pixels[i].z_min > depth + DEPTH_OFF;
    }
    free(pixels);
}

static bool every_size;

static void no_seam(void **state)
{
    (void)state;
    static const stp_reconstruct modes[] = {STP_RECONSTRUCT_GAUSS, STP_RECONSTRUCT_BOX,
                                            STP_RECONSTRUCT_TEMPLATE5, STP_RECONSTRUCT_TEMPLATE7};
    gl_fixture f = {0};
    build("ball.stipple");
    gl_fixture_open(&f, "ball.stipple", NULL);
    for (int m = 0; m < 4; m++)
        for (int size = 150; size <= (m < 1 + every_size ? 450 : 150); size += 300) {
            tally sum = {0};
            for (int v = 0; v < VIEWS_DIRECTIONS; v++) {
                stp_view view = views_get(v, &f.model->ball, NULL, 0, size, size);
                const stp_draw_params params = {
                    .reconstruct = modes[m], .threshold_px = 1.0, .keep_pixels = true};
                judge_view(&f, &view, &params, &sum);
            }
            print_message("mode %d, %d pixels wide: %zu pixels, %zu background, %zu far side\n",
                          (int)modes[m], size, sum.judged, sum.background, sum.far_side);
            assert_true(sum.judged > 20000);
            size_t holes = sum.background + sum.far_side;
            if (modes[m] == STP_RECONSTRUCT_TEMPLATE5) /* it leaves pinholes in points too */
                assert_true(holes < sum.judged / 1000);
            else
                assert_int_equal(holes, 0);
        }
    gl_fixture_close(&f);
}

int main(int argc, char **argv)
{
    every_size = argc > 1 && strcmp(argv[1], "--every") == 0;
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {cmocka_unit_test(no_seam)};
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

/* Tests segments and triangles in the picture against geometry: where they are visible, and which
 * is in front if they cross each other or points. Tests also what the clip box, the near plane and
 * hidden classes remove, and that every road gives the same picture. */
#include "tests/fixtures/chunk_reseal.h"
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/line_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/fixtures/square_fixture.h"
#include "tests/support/views.h"

enum { SIZE = 256, PIXELS = SIZE * SIZE };

#define FOVY_DEG 40.0
#define EYE_Z 4.0

static const stp_reconstruct modes[] = {STP_RECONSTRUCT_GAUSS,     STP_RECONSTRUCT_BOX,
                                        STP_RECONSTRUCT_TEMPLATE3, STP_RECONSTRUCT_TEMPLATE5,
                                        STP_RECONSTRUCT_TEMPLATE7, STP_RECONSTRUCT_SPLAT};
enum { MODE_COUNT = sizeof modes / sizeof *modes };

/* The share of pixels that may be holes: windows of three reach little more than a pixel. */
static double holes_allowed(stp_reconstruct mode)
{
    return mode == STP_RECONSTRUCT_TEMPLATE3 ? 0.05 : 0.005;
}

/* ---- shapes ---- */

static void paint(uint16_t rgb[3], unsigned channel)
{
    for (unsigned c = 0; c < 3; c++)
        rgb[c] = c == channel ? 65535 : 0;
}

/* Makes straight lines with `each` vertices; `ends` are their ends. */
static stp_line_set lines_make(uint64_t count, uint64_t each, stp_line_kind kind,
                               const stp_dvec3 (*ends)[2], float radius)
{
    stp_line_set out = line_set_make(count * each, count);
    for (uint64_t s = 0; s < count; s++) {
        out.strips[s] = (stp_line_strip){s * each, each, kind};
        for (uint64_t i = 0; i < each; i++) {
            stp_line_vertex *v = &out.vertices[s * each + i];
            double t = (double)i / (double)(each - 1);
            v->position =
                stp_dvec3_add(stp_dvec3_scale(ends[s][0], 1.0 - t), stp_dvec3_scale(ends[s][1], t));
            v->radius = radius;
            v->class_id = (uint8_t)(s + 1);
            paint(v->rgb, 1);
        }
    }
    return out;
}

/* A model in front of the eye, and its picture. */
typedef struct scene {
    gl_fixture f;
    stp_view view;
    uint8_t *rgba;
} scene;

static void open_file(scene *s, const char *path)
{
    s->rgba = calloc(PIXELS, 4);
    assert_non_null(s->rgba);
    gl_fixture_open(&s->f, path, NULL);
    s->view = views_look((stp_dvec3){0.0, 0.0, EYE_Z}, (stp_dvec3){0.0, 0.0, 0.0}, FOVY_DEG,
                         &s->f.model->ball, SIZE, SIZE);
}

static void open_shapes(scene *s, prep_cloud *points, const stp_line_set *lines,
                        const stp_triangle_set *triangles)
{
    stp_prep_stats stats;
    check_ok(prep_shapes_run(points, lines, triangles, "shapes.stipple", 2, NULL, &stats, err));
    open_file(s, "shapes.stipple");
}

static void close_scene(scene *s)
{
    free(s->rgba);
    gl_fixture_close(&s->f);
}

static void draw(scene *s, const stp_draw_params *params)
{
    gl_fixture_draw(&s->f, &s->view, params, NULL, s->rgba);
}

/* The ray in eye space through the centre of pixel i, with depth 1. */
static stp_dvec3 ray_of(const stp_view *view, int i)
{
    return (stp_dvec3){(i % SIZE + 0.5 - 0.5 * SIZE) / view->f,
                       (i / SIZE + 0.5 - 0.5 * SIZE) / view->f, -1.0};
}

/* ---- shapes that cross ---- */

#define RIBBON_HALF 0.05
#define RIBBON_GAP 0.25
/* Surfaces that are closer than about a disc's radius count as one. */
#define DEPTH_MARGIN 0.1

/* Points at z = -x where y > 0, ribbons along x at z = x, and triangles at z = 0. */
static void open_order(scene *s)
{
    static const stp_dvec3 square[4] = {
        {-1.0, -1.0, 0.0}, {1.0, -1.0, 0.0}, {1.0, 1.0, 0.0}, {-1.0, 1.0, 0.0}};
    enum { RIBBONS = 7, EACH = 150 };
    stp_dvec3 ends[RIBBONS][2];
    for (int i = 0; i < RIBBONS; i++) {
        double y = RIBBON_GAP * (i - RIBBONS / 2);
        ends[i][0] = (stp_dvec3){-1.0, y, -1.0};
        ends[i][1] = (stp_dvec3){1.0, y, 1.0};
    }
    stp_line_set lines = lines_make(RIBBONS, 80, STP_LINE_RIBBON, ends, (float)RIBBON_HALF);
    for (uint64_t i = 0; i < lines.vertex_count; i++)
        lines.vertices[i].direction = (vec3s){{-0.70710678f, 0.0f, 0.70710678f}};
    stp_triangle_set triangles = square_make(square);
    prep_cloud points = prep_cloud_make((size_t)EACH * EACH);
    for (int i = 0; i < EACH * EACH; i++) {
        double x = -1.0 + 2.0 * (i % EACH) / (EACH - 1.0), y = (double)(i / EACH) / (EACH - 1.0);
        points.points[i].position = (stp_dvec3){x, y, -x};
        paint(points.points[i].rgb, 0);
    }
    open_shapes(s, &points, &lines, &triangles);
    free(points.points);
    stp_line_set_clear(&lines);
    stp_triangle_set_clear(&triangles);
}

/* The front surface at a pixel: red, green, blue; -1: nothing is there or a border is near. */
static int front_of(const stp_view *view, int i)
{
    const double margin = 3.0 * EYE_Z / view->f;
    stp_dvec3 ray = ray_of(view, i);
    /* the ray through (0, 0, 4) meets z = x, z = 0 and z = -x */
    double ribbon = EYE_Z / (1.0 + ray.x), plane = EYE_Z, point = EYE_Z / (1.0 - ray.x);
    double x[3] = {ray.x * point, ray.x * ribbon, ray.x * plane};
    double y[3] = {ray.y * point, ray.y * ribbon, ray.y * plane}, least = INFINITY;
    const double depth[3] = {point, ribbon, plane};
    double to_ribbon = fabs(remainder(y[1], RIBBON_GAP)) - RIBBON_HALF;
    const bool there[3] = {y[0] > 0.0, to_ribbon < 0.0, true};
    int front = -1;
    for (int k = 0; k < 3; k++) {
        if (fabs(x[k]) > 1.0 - margin || y[k] > 1.0 - margin || y[k] < -1.0 + margin ||
            fabs(y[1]) > 0.8)
            return -1;
        if (there[k] && depth[k] < least) {
            least = depth[k];
            front = k;
        }
    }
    for (int k = 0; k < 3; k++)
        if (k != front && there[k] && depth[k] < least + DEPTH_MARGIN)
            return -1;
    bool border = fabs(x[2]) < margin || fabs(y[0]) < margin || fabs(to_ribbon) < margin;
    return border ? -1 : front;
}

static int strongest(const uint8_t rgb[4])
{
    int best = rgb[1] > rgb[0] ? 1 : 0;
    return rgb[3] == 0 ? -1 : rgb[2] > rgb[best] ? 2 : best;
}

static void order(void **state)
{
    (void)state;
    scene s = {0};
    open_order(&s);
    for (int m = 0; m < MODE_COUNT; m++) {
        const stp_draw_params params = {.reconstruct = modes[m], .shade = STP_SHADE_LAMBERT};
        int judged[3] = {0}, wrong = 0, holes = 0, all = 0;
        draw(&s, &params);
        for (int i = 0; i < PIXELS; i++) {
            int front = front_of(&s.view, i);
            if (front < 0)
                continue;
            judged[front]++;
            int found = strongest(s.rgba + 4 * i);
            wrong += found >= 0 && found != front;
            holes += found < 0;
            all++;
        }
        print_message("mode %d: points %d, ribbons %d, triangles %d pixels, %d wrong, %d holes\n",
                      (int)modes[m], judged[0], judged[1], judged[2], wrong, holes);
        for (int k = 0; k < 3; k++)
            assert_true(judged[k] > 800);
        if (modes[m] != STP_RECONSTRUCT_TEMPLATE3) /* it has holes, which show what is behind */
            assert_int_equal(wrong, 0);
        assert_true(wrong + holes <= holes_allowed(modes[m]) * all);
    }
    close_scene(&s);
}

/* ---- outlines ---- */

/* How far a point lies to the left of an edge. */
static double left_of(const double a[2], const double b[2], const double p[2])
{
    double x = b[0] - a[0], y = b[1] - a[1];
    return (x * (p[1] - a[1]) - y * (p[0] - a[0])) / hypot(x, y);
}

/* A square that leans back must cover the pixels whose centres it contains, and no others. */
static void triangles_cover(void **state)
{
    (void)state;
    static const stp_dvec3 square[4] = {
        {-0.9, -0.8, 0.5}, {0.7, -0.9, 0.2}, {0.9, 0.7, -1.0}, {-0.6, 0.8, -1.2}};
    scene s = {0};
    stp_triangle_set set = square_make(square);
    open_shapes(&s, NULL, NULL, &set);
    double corners[4][2];
    for (int i = 0; i < 4; i++) {
        corners[i][0] = 0.5 * SIZE + square[i].x * s.view.f / (EYE_Z - square[i].z);
        corners[i][1] = 0.5 * SIZE + square[i].y * s.view.f / (EYE_Z - square[i].z);
    }
    for (int m = 0; m < MODE_COUNT; m++) {
        size_t wrong = 0, held = 0;
        draw(&s, &(stp_draw_params){.reconstruct = modes[m]});
        for (int i = 0; i < PIXELS; i++) {
            const double p[2] = {i % SIZE + 0.5, i / SIZE + 0.5};
            double least = INFINITY;
            for (int k = 0; k < 4; k++)
                least = fmin(least, left_of(corners[k], corners[(k + 1) % 4], p));
            held += least > 0.0;
            wrong += fabs(least) > 0.1 && (least > 0.0) != (s.rgba[4 * i + 3] != 0);
        }
        print_message("mode %d: %zu pixels, %zu wrong\n", (int)modes[m], held, wrong);
        assert_true(held > 10000);
        assert_int_equal(wrong, 0);
    }
    stp_triangle_set_clear(&set);
    close_scene(&s);
}

/* A ribbon of two vertices that leans back must cover what its card covers: any reconstruction
 * gives it square ends. The lattice moves an edge by some tenths of a pixel. */
static void ribbon_is_a_card(void **state)
{
    (void)state;
    const double radius = 0.4, slack = 1.5;
    const stp_dvec3 ends[1][2] = {{{-0.5, -0.4, 0.3}, {0.6, 0.5, -0.5}}};
    const stp_dvec3 way = stp_dvec3_sub(ends[0][1], ends[0][0]);
    const stp_dvec3 half = stp_dvec3_scale(
        stp_dvec3_normalize(stp_dvec3_cross((stp_dvec3){0.2, 0.3, 1.0}, way)), radius);
    const stp_dvec3 normal = stp_dvec3_normalize(stp_dvec3_cross(way, half));
    stp_line_set set = lines_make(1, 2, STP_LINE_RIBBON, ends, (float)radius);
    double corners[4][2];
    scene s = {0};
    for (int i = 0; i < 2; i++)
        set.vertices[i].direction = stp_dvec3_to_float(normal);
    open_shapes(&s, NULL, &set, NULL);
    for (int i = 0; i < 4; i++) { /* around the card */
        bool far = i == 1 || i == 2;
        stp_dvec3 p = stp_dvec3_add(ends[0][far], stp_dvec3_scale(half, i < 2 ? -1.0 : 1.0));
        corners[i][0] = 0.5 * SIZE + p.x * s.view.f / (EYE_Z - p.z);
        corners[i][1] = 0.5 * SIZE + p.y * s.view.f / (EYE_Z - p.z);
    }
    for (int m = 0; m < MODE_COUNT; m++) {
        size_t wrong = 0, held = 0;
        draw(&s, &(stp_draw_params){.reconstruct = modes[m], .every_sample = true});
        for (int i = 0; i < PIXELS; i++) {
            const double p[2] = {i % SIZE + 0.5, i / SIZE + 0.5};
            double least = INFINITY;
            for (int k = 0; k < 4; k++)
                least = fmin(least, left_of(corners[k], corners[(k + 1) % 4], p));
            held += least > 0.0;
            wrong += fabs(least) > slack && (least > 0.0) != (s.rgba[4 * i + 3] != 0);
        }
        print_message("mode %d: %zu pixels, %zu wrong\n", (int)modes[m], held, wrong);
        assert_true(held > 5000);
        assert_int_equal(wrong, 0);
    }
    stp_line_set_clear(&set);
    close_scene(&s);
}

/* The tangent of the angle by which a ray of depth 1 misses a segment; both start from the eye. */
static double away_from(stp_dvec3 a, stp_dvec3 b, stp_dvec3 ray)
{
    enum { STEPS = 400 };
    double least = INFINITY;
    for (int i = 0; i <= STEPS; i++) {
        double t = (double)i / STEPS;
        stp_dvec3 p = stp_dvec3_add(stp_dvec3_scale(a, 1.0 - t), stp_dvec3_scale(b, t));
        if (p.z < 0.0)
            least = fmin(least, hypot(p.x / -p.z - ray.x, p.y / -p.z - ray.y));
    }
    return least;
}

/* A tube of constant width in the picture: its radius grows with its depth. Pixels nearer to its
 * axis must be covered, pixels farther away must not. */
static void judge_tube(stp_dvec3 from, stp_dvec3 to, double slack)
{
    enum { EACH = 41 };
    const stp_dvec3 ends[1][2] = {{from, to}};
    const double angle = 0.03;
    scene s = {0};
    stp_line_set set = lines_make(1, EACH, STP_LINE_TUBE, ends, 1.0f);
    for (int i = 0; i < EACH; i++)
        set.vertices[i].radius = (float)(angle * fabs(EYE_Z - set.vertices[i].position.z));
    open_shapes(&s, NULL, &set, NULL);
    const stp_dvec3 eye = {0.0, 0.0, EYE_Z};
    double *off = calloc(PIXELS, sizeof *off); /* from the outline, in pixels */
    for (int i = 0; i < PIXELS; i++)
        off[i] = s.view.f *
                 (away_from(stp_dvec3_sub(from, eye), stp_dvec3_sub(to, eye), ray_of(&s.view, i)) -
                  angle);
    for (int m = 0; m < MODE_COUNT; m++) {
        size_t inside = 0, missed = 0, beyond = 0;
        draw(&s, &(stp_draw_params){.reconstruct = modes[m], .every_sample = true});
        for (int i = 0; i < PIXELS; i++) {
            inside += off[i] < 0.0;
            missed += off[i] < -slack && s.rgba[4 * i + 3] == 0;
            beyond += off[i] > slack && s.rgba[4 * i + 3] != 0;
        }
        print_message("mode %d: %zu pixels, %zu missed, %zu beyond\n", (int)modes[m], inside,
                      missed, beyond);
        assert_true(inside > 500);
        assert_true((double)missed <= holes_allowed(modes[m]) * (double)inside);
        assert_true(beyond <= inside / 200);
    }
    free(off);
    stp_line_set_clear(&set);
    close_scene(&s);
}

static void tube_covers(void **state)
{
    (void)state;
    judge_tube((stp_dvec3){-0.8, -0.5, 0.3}, (stp_dvec3){0.9, 0.7, -0.8}, 1.6);
}

/* The tube runs from in front of the eye to behind it. */
static void tube_passes_the_eye(void **state)
{
    (void)state;
    judge_tube((stp_dvec3){-0.6, -0.5, 0.0}, (stp_dvec3){1.6, 1.0, EYE_Z + 2.0}, 2.5);
}

/* ---- clipped and hidden, by every road ---- */

static void judge_clip(stp_reconstruct mode)
{
    scene s = {0};
    open_order(&s);
    stp_draw_params params = {.reconstruct = mode, .shade = STP_SHADE_LAMBERT};
    draw(&s, &params);
    size_t before = gl_fixture_covered(s.rgba, PIXELS), beyond = 0, missed = 0;
    params.clip = (stp_clip){true, {{-0.31, -2.0, -0.01}, {0.47, 2.0, 0.01}}};
    draw(&s, &params);
    for (int i = 0; i < PIXELS; i++) { /* the square at z = 0 */
        stp_dvec3 ray = ray_of(&s.view, i);
        double x = EYE_Z * ray.x, y = EYE_Z * ray.y, off = 0.02;
        bool in = x > -0.31 + off && x < 0.47 - off && fabs(y) < 1.0 - off;
        bool out = x < -0.31 - off || x > 0.47 + off || fabs(y) > 1.0 + off;
        missed += in && s.rgba[4 * i + 3] == 0;
        beyond += out && s.rgba[4 * i + 3] != 0;
    }
    assert_true(gl_fixture_covered(s.rgba, PIXELS) < before / 2);
    assert_int_equal(missed, 0);
    assert_int_equal(beyond, 0);
    close_scene(&s);
}

static void clip_cuts(void **state)
{
    (void)state;
    judge_clip(STP_RECONSTRUCT_POINTS);
    judge_clip(STP_RECONSTRUCT_SPLAT);
}

static void judge_classes(stp_reconstruct mode)
{
    scene s = {0};
    open_order(&s);
    stp_draw_params params = {.reconstruct = mode, .shade = STP_SHADE_LAMBERT};
    params.hidden_classes[0] = 1u << 9 | 1u << 4; /* the square, the middle ribbon */
    size_t green[2] = {0, 0}, blue = 0;
    draw(&s, &params);
    for (int i = 0; i < PIXELS; i++) {
        double y = fabs(ray_of(&s.view, i).y) * EYE_Z;
        green[y < 0.12] += strongest(s.rgba + 4 * i) == 1;
        blue += strongest(s.rgba + 4 * i) == 2;
    }
    assert_int_equal(blue, 0);
    assert_int_equal(green[1], 0);
    assert_true(green[0] > 1000);
    close_scene(&s);
}

static void classes_hide(void **state)
{
    (void)state;
    judge_classes(STP_RECONSTRUCT_GAUSS);
    judge_classes(STP_RECONSTRUCT_SPLAT);
}

/* Draws views from around with the other roads. every: all of them draw every sample. */
static void compare_roads(scene *s, stp_reconstruct mode, bool every)
{
    static const stp_lod roads[] = {STP_LOD_CPU, STP_LOD_COMPUTE, STP_LOD_FULL};
    uint8_t *wanted = calloc(PIXELS, 4);
    assert_non_null(wanted);
    for (int v = 0; v < 6; v++) {
        s->view = views_get(4 * v, &s->f.model->ball, NULL, 0, SIZE, SIZE);
        for (int k = 0; k < 3; k++) {
            stp_draw_params params = {.reconstruct = mode,
                                      .every_sample = every || roads[k] == STP_LOD_FULL,
                                      .threshold_px = v % 3};
            draw(s, &params);
            memcpy(wanted, s->rgba, 4 * PIXELS);
            params.lod = roads[k];
            draw(s, &params);
            assert_true(gl_fixture_covered(s->rgba, PIXELS) > 1000);
            assert_memory_equal(wanted, s->rgba, 4 * PIXELS);
        }
    }
    free(wanted);
}

static void roads_agree(void **state)
{
    (void)state;
    scene s = {0};
    open_order(&s);
    compare_roads(&s, STP_RECONSTRUCT_GAUSS, false);
    compare_roads(&s, STP_RECONSTRUCT_SPLAT, false);
    close_scene(&s);
}

/* If a file has shapes but its header says that it has none, it is damaged: no road draws these
 * chunks. */
static void header_denies_them(void **state)
{
    (void)state;
    enum { ATTRIBUTES = 72 };
    size_t size = 0;
    scene s = {0};
    open_order(&s);
    close_scene(&s);
    uint8_t *bytes = prep_file_bytes("shapes.stipple", &size);
    uint32_t attributes = stp_get_u32(bytes + ATTRIBUTES);
    assert_true((attributes & STP_HAS_LINES) && (attributes & STP_HAS_TRIANGLES));
    stp_put_u32(bytes + ATTRIBUTES, attributes & ~(unsigned)(STP_HAS_LINES | STP_HAS_TRIANGLES));
    reseal(bytes, size, false);
    scan_fixture_bytes("denied.stipple", bytes, size);
    s = (scene){0};
    open_file(&s, "denied.stipple");
    s.view = views_get(0, &s.f.model->ball, NULL, 0, SIZE, SIZE);
    for (int lod = STP_LOD_AUTO; lod <= STP_LOD_FULL; lod++) {
        stp_draw_params params = {.lod = lod, .every_sample = lod == STP_LOD_FULL};
        stp_draw_stats stats = {0};
        check_ok(stp_renderer_draw(s.f.renderer, &s.view, &params, &stats, err));
        assert_true(stats.chunks_missing > 0);
        assert_false(stats.cut_complete);
    }
    free(bytes);
    close_scene(&s);
}

/* Picks on ribbons and triangles must hit the shape, and give its class if the sample is known. */
static void picks_hit(void **state)
{
    (void)state;
    scene s = {0};
    open_order(&s);
    int picked[3] = {0};
    draw(&s, &(stp_draw_params){.keep_pixels = true});
    for (int i = 0; i < PIXELS; i += 37) {
        stp_pick pick;
        int front = front_of(&s.view, i);
        if (front <= 0)
            continue;
        check_ok(stp_renderer_pick(s.f.renderer, i % SIZE, i / SIZE, &pick, err));
        assert_true(pick.hit);
        double z = front == 1 ? pick.position.x : 0.0;
        assert_true(fabs(pick.position.z - z) < RIBBON_HALF);
        picked[front]++;
        if (pick.level < 0) /* a coarse pixel's sample may be unknown */
            continue;
        assert_true(front == 2 ? pick.class_id == 9 : pick.class_id >= 1 && pick.class_id <= 7);
    }
    assert_true(picked[1] > 20);
    assert_true(picked[2] > 100);
    close_scene(&s);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(order),
        cmocka_unit_test(triangles_cover),
        cmocka_unit_test(ribbon_is_a_card),
        cmocka_unit_test(tube_covers),
        cmocka_unit_test(tube_passes_the_eye),
        cmocka_unit_test(clip_cuts),
        cmocka_unit_test(classes_hide),
        cmocka_unit_test(roads_agree),
        cmocka_unit_test(picks_hit),
        cmocka_unit_test(header_denies_them),
    };
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

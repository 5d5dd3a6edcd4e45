/* Tests picking: random picks must find the front surface of known models. long_gl_pick.c does ten
 * thousand picks of each, in three times as many views. */
#include "tests/fixtures/gl_pick.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"

/* With fewer points or pixels the statue's feathers would not show. Its mesh is the one that
 * statue_kept.h keeps. */
enum { COUNT = 200000, SIZE = 512, PICKS = 2000, STEP = 3 };

static void statue(void **state)
{
    (void)state;
    pick_tally t = pick_model("statue", &(model_recipe){.shape = GEN_STATUE, .point_count = COUNT},
                              700000, SIZE, PICKS, STEP);
    assert_true(t.right * 1000 >= t.picks * 997); /* feathers are as thin as the spacing */
}

static void sheet(void **state)
{
    (void)state;
    const model_recipe recipe = {
        .shape = GEN_SHEET, .point_count = COUNT / 4, .true_normals = true};
    pick_tally t = pick_model("sheet", &recipe, 0, SIZE, PICKS, STEP);
    assert_true(t.right * 1000 >=
                t.picks * 997); /* from near, one side is a pixel from the other */
}

/* A strip far in front of a wall, each of its own class. They have no orientation, so nothing is
 * culled. */
enum { STRIP = 1, WALL = 2, WALL_POINTS = 40000, STRIP_POINTS = 40000 };
#define STRIP_HALF 0.03
#define STRIP_HEIGHT 1.0

static void build_strip(const char *path)
{
    stp_prep_stats stats;
    prep_cloud cloud = prep_cloud_make(WALL_POINTS + STRIP_POINTS);
    for (size_t i = 0; i < cloud.count; i++) {
        bool strip = i >= WALL_POINTS;
        double x = 2.0 * stp_random_unit(1, i) - 1.0, y = 2.0 * stp_random_unit(2, i) - 1.0;
        cloud.points[i].position =
            (stp_dvec3){strip ? STRIP_HALF * x : x, y, strip ? STRIP_HEIGHT : 0.0};
        cloud.points[i].class_id = strip ? STRIP : WALL;
        cloud.points[i].intensity = strip ? 65535 : 0;
    }
    const stp_prep_params params = {.orient = STP_ORIENT_NONE};
    check_ok(prep_cloud_run(&cloud, path, 2, &params, &stats, err));
    free(cloud.points);
}

static stp_pick pick_at(gl_fixture *f, const stp_view *view, stp_dvec3 at)
{
    stp_pick pick;
    stp_dvec3 w = stp_view_project(view, at);
    check_ok(stp_renderer_pick(f->renderer, (int)w.x, (int)w.y, &pick, err));
    assert_true(pick.hit && pick.chunk != STP_CHUNK_NONE && pick.level >= 0);
    return pick;
}

/* Just inside its outline a pick must find the strip and never the wall; outside, it must find the
 * wall. */
static void before_a_wall(void **state)
{
    (void)state;
    gl_fixture f = {0};
    build_strip("strip.stipple");
    gl_fixture_open(&f, "strip.stipple", NULL);
    for (int variant = 0; variant < 6; variant++) {
        const stp_draw_params params = {.every_sample = variant % 2};
        stp_view view =
            views_look((stp_dvec3){0.8 - 0.3 * variant, 0.1, 4.0 - 0.3 * variant},
                       (stp_dvec3){0.0, 0.0, STRIP_HEIGHT}, 30.0, &f.model->ball, SIZE, SIZE);
        view.orthographic = variant == 3;
        view.f = variant == 3 ? 0.4 * SIZE : view.f;
        check_ok(stp_renderer_draw(f.renderer, &view, &params, NULL, err));
        double pixel = view.orthographic ? 1.0 / view.f : 3.0 / view.f; /* at the strip, about */
        for (int k = 0; k < 200; k++) {
            double y = 0.3 * (k / 100.0 - 1.0), side = k % 2 ? 1.0 : -1.0;
            stp_dvec3 in = {side * (STRIP_HALF - 1.5 * pixel), y, STRIP_HEIGHT};
            stp_dvec3 out = {side * (STRIP_HALF + 8.0 * pixel), y, STRIP_HEIGHT};
            stp_pick strip = pick_at(&f, &view, in), wall = pick_at(&f, &view, out);
            assert_int_equal(strip.class_id, STRIP);
            assert_true(fabs(strip.position.z - STRIP_HEIGHT) <= strip.radius);
            assert_true(strip.depth_end < wall.depth && strip.intensity == 1.0);
            assert_int_equal(wall.class_id, WALL);
            assert_true(fabs(wall.position.z) <= wall.radius && wall.intensity == 0.0);
            assert_true(wall.normal.z > 0.99);
        }
    }
    gl_fixture_close(&f);
}

enum { EDGE = 61 };

/* Picks at a picture's corners, twice, and beside them; the picture must stay as it is. */
static void check_corners(gl_fixture *f)
{
    stp_pick pick, again;
    static uint8_t before[EDGE * EDGE * 4], after[EDGE * EDGE * 4];
    check_ok(stp_renderer_read(f->renderer, before, err));
    for (int k = 0; k < 4; k++) {
        int x = k % 2 * (EDGE - 1), y = k / 2 * (EDGE - 1);
        check_ok(stp_renderer_pick(f->renderer, x, y, &pick, err));
        check_ok(stp_renderer_pick(f->renderer, x, y, &again, err));
        assert_true(pick.hit && again.hit && pick.chunk == again.chunk);
        assert_memory_equal(&pick.position, &again.position, sizeof pick.position);
    }
    assert_int_equal(stp_renderer_pick(f->renderer, EDGE, 0, &pick, NULL), STP_INVALID_ARGUMENT);
    assert_int_equal(stp_renderer_pick(f->renderer, 0, -1, &pick, NULL), STP_INVALID_ARGUMENT);
    check_ok(stp_renderer_read(f->renderer, after, err));
    assert_memory_equal(before, after, sizeof before);
}

/* Picks before the first picture, at a picture's edges, and where nothing is. */
static void boundaries(void **state)
{
    (void)state;
    gl_fixture f = {0};
    stp_pick pick;
    build_strip("strip.stipple");
    gl_fixture_open(&f, "strip.stipple", NULL);
    assert_int_equal(stp_renderer_pick(f.renderer, 0, 0, &pick, NULL), STP_INVALID_ARGUMENT);
    const stp_dvec3 eye = {0.0, 0.0, 2.0};
    stp_view view = views_look(eye, (stp_dvec3){0.0, 0.0, 0.0}, 30.0, &f.model->ball, EDGE, EDGE);
    for (int reconstruct = 0; reconstruct <= STP_RECONSTRUCT_LAST; reconstruct++) {
        const stp_draw_params params = {.reconstruct = (stp_reconstruct)reconstruct};
        check_ok(stp_renderer_draw(f.renderer, &view, &params, NULL, err));
        check_corners(&f);
    }
    view = views_look(eye, (stp_dvec3){0.0, 0.0, 5.0}, 30.0, &f.model->ball, EDGE, EDGE);
    check_ok(stp_renderer_draw(f.renderer, &view, &(stp_draw_params){0}, NULL, err));
    check_ok(stp_renderer_pick(f.renderer, EDGE / 2, EDGE / 2, &pick, err));
    assert_false(pick.hit);
    assert_int_equal(pick.chunk, STP_CHUNK_NONE);
    gl_fixture_close(&f);
}

/* Picks all over a picture of the unit sphere. Returns how many picks named their sample. */
static size_t pick_sphere(stp_renderer *renderer, stp_dvec3 centre)
{
    size_t hits = 0, named = 0;
    for (int i = 0; i < 400; i++) {
        stp_pick pick;
        check_ok(
            stp_renderer_pick(renderer, SIZE * (i % 20) / 20, SIZE * (i / 20) / 20, &pick, err));
        double away = stp_dvec3_length(stp_dvec3_sub(pick.position, centre));
        hits += pick.hit;
        named += pick.hit && pick.chunk != STP_CHUNK_NONE;
        assert_true(!pick.hit || fabs(away - 1.0) <= pick.radius);
        assert_true(!pick.hit || (pick.level >= 0) == (pick.chunk != STP_CHUNK_NONE));
    }
    assert_true(hits > 60); /* of a quarter of the picture */
    assert_true(named <= hits);
    return named;
}

/* A picture drawn in several passes: picks still find the surface, but name a sample only if the
 * last pass drew it. While a picture at rest is drawn in passes behind the last picture, picks
 * answer for the last one. */
static void in_passes(void **state)
{
    (void)state;
    stp_model *model = NULL;
    stp_renderer *renderer = NULL;
    stp_draw_stats stats = {0};
    const model_recipe sphere = {.shape = GEN_SPHERE, .point_count = 300000};
    model_fixture_build("passes.stipple", &sphere);
    check_ok(stp_model_open(&model, "passes.stipple", err));
    const stp_renderer_params small = {
        .model = model, .thread_count = 2, .gpu_memory_bytes = UINT64_C(2) << 20};
    check_ok(stp_renderer_create(&renderer, &small, err));
    stp_view view = views_get(21, &model->ball, NULL, 0, SIZE, SIZE);
    const stp_draw_params full = {.lod = STP_LOD_FULL};
    check_ok(stp_renderer_draw(renderer, &view, &full, &stats, err));
    assert_true(stats.passes > 1);
    size_t named = pick_sphere(renderer, model->ball.centre);
    const stp_draw_params refined = {.stream = true, .refine = true, .threshold_px = 4.0};
    for (int frame = 0; frame < 30000 && !stats.every_sample; frame++) {
        check_ok(stp_renderer_draw(renderer, &view, &refined, &stats, err));
        if (frame == 20 || frame == 60)
            assert_true(pick_sphere(renderer, model->ball.centre) > 60);
    }
    assert_true(stats.every_sample && stats.passes > 1);
    assert_true(pick_sphere(renderer, model->ball.centre) == named);
    stp_renderer_destroy(&renderer);
    stp_model_close(&model);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(statue),     cmocka_unit_test(sheet),     cmocka_unit_test(before_a_wall),
        cmocka_unit_test(boundaries), cmocka_unit_test(in_passes),
    };
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

/* Tests that screen-space passes may draw only the tiles that the cut may cover and rely on the
 * rest being empty. A renderer's first frame draws everything, so it is the judge: whatever a
 * renderer drew before, in any size and with any number of levels, its picture must be the same.
 * With each road that chooses levels, the same pixels must have a sample (which one may differ
 * where depths tie). */
#include "runtime/cut/tiles.h"
#include "runtime/stream/spots.h"
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/support/views.h"

typedef struct step {
    int direction; /* an index of views_get */
    int width, height;
    stp_reconstruct reconstruct;
    double threshold_px;
    double away; /* the eye's distance, as a multiple of the one that shows all; 0: 1 */
    stp_lod lod;
} step;

/* Each step is followed by one that covers less or has more levels. */
static const step steps[] = {
    {0, 300, 200, STP_RECONSTRUCT_GAUSS, 1.0, 0.0, STP_LOD_GEOMETRY},
    {4, 300, 200, STP_RECONSTRUCT_GAUSS, 8.0, 3.0, STP_LOD_GEOMETRY},
    {4, 300, 200, STP_RECONSTRUCT_POINTS, 1.0, 0.0, STP_LOD_CPU},
    {20, 300, 200, STP_RECONSTRUCT_GAUSS, 1.0, 9.0, STP_LOD_COMPUTE},
    {28, 300, 200, STP_RECONSTRUCT_BOX, 4.0, 0.0, STP_LOD_GEOMETRY}, /* close */
    {9, 300, 200, STP_RECONSTRUCT_BOX, 0.5, 2.0, STP_LOD_FULL},
    {12, 97, 401, STP_RECONSTRUCT_GAUSS, 2.0, 0.0, STP_LOD_COMPUTE},
    {12, 97, 401, STP_RECONSTRUCT_GAUSS, 2.0, 5.0, STP_LOD_COMPUTE},
    {30, 300, 200, STP_RECONSTRUCT_GAUSS, 1.0, 0.0, STP_LOD_GEOMETRY}, /* close */
    {12, 300, 200, STP_RECONSTRUCT_TEMPLATE5, 2.0, 3.0, STP_LOD_GEOMETRY},
    {28, 300, 200, STP_RECONSTRUCT_TEMPLATE3, 4.0, 0.0, STP_LOD_CPU}, /* close */
    {12, 300, 200, STP_RECONSTRUCT_TEMPLATE7, 1.0, 2.0, STP_LOD_GEOMETRY},
    {3, 300, 200, STP_RECONSTRUCT_SPLAT, 1.0, 0.0, STP_LOD_GEOMETRY},
    {12, 300, 200, STP_RECONSTRUCT_SPLAT, 1.0, 3.0, STP_LOD_GEOMETRY},
    {0, 300, 200, STP_RECONSTRUCT_GAUSS, 1.0, 0.0, STP_LOD_GEOMETRY},
    {0, 300, 200, STP_RECONSTRUCT_POINTS, 1.0, 2.0, STP_LOD_GEOMETRY},
    {0, 300, 200, STP_RECONSTRUCT_GAUSS, 1.0, 2.0, STP_LOD_GEOMETRY},
    {15, 300, 200, STP_RECONSTRUCT_GAUSS, 1.0, 1.5, STP_LOD_GEOMETRY},
};

enum { ROADS = 3 };
static const stp_lod roads[ROADS] = {STP_LOD_GEOMETRY, STP_LOD_CPU, STP_LOD_COMPUTE};

static stp_view view_of(const step *s, const stp_ball *ball, const promise_disc *discs,
                        size_t count)
{
    stp_view view = views_get(s->direction, ball, discs, count, s->width, s->height);
    if (s->away > 0.0) {
        stp_dvec3 from = stp_dvec3_sub(view.eye, ball->centre);
        view.eye = stp_dvec3_add(ball->centre, stp_dvec3_scale(from, s->away));
    }
    return view;
}

/* Draws a picture; free it with free(). */
static uint8_t *draw(gl_fixture *f, const stp_view *view, const step *s)
{
    stp_draw_params params = {
        .lod = s->lod, .reconstruct = s->reconstruct, .threshold_px = s->threshold_px};
    uint8_t *picture = calloc((size_t)s->width * (size_t)s->height + 1, 4);
    assert_non_null(picture);
    check_ok(stp_renderer_draw(f->renderer, view, &params, NULL, err));
    check_ok(stp_renderer_read(f->renderer, picture, err));
    return picture;
}

static void judge_roads(gl_fixture *f, const stp_view *view, const step *s, size_t index)
{
    size_t pixels = (size_t)s->width * (size_t)s->height;
    uint8_t *pictures[ROADS];
    for (int road = 0; road < ROADS; road++) {
        step other = *s;
        other.lod = roads[road];
        other.reconstruct = STP_RECONSTRUCT_POINTS;
        pictures[road] = draw(f, view, &other);
        for (size_t k = 0; k < pixels; k++)
            if ((pictures[road][4 * k + 3] != 0) != (pictures[0][4 * k + 3] != 0))
                fail_msg("step %zu: road %d covers other pixels than road %d", index,
                         (int)roads[road], (int)roads[0]);
    }
    for (int road = 0; road < ROADS; road++)
        free(pictures[road]);
}

static void judge(const model_recipe *recipe)
{
    gl_fixture used = {0};
    promise_disc *leaves = NULL;
    size_t leaf_count = 0, seen = 0;
    model_fixture_build("tiles.stipple", recipe);
    gl_fixture_open(&used, "tiles.stipple", NULL);
    check_ok(promise_load_leaves(used.model->file, &leaves, &leaf_count, err));
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
        const step *s = &steps[i];
        gl_fixture fresh = {0};
        gl_fixture_open(&fresh, "tiles.stipple", NULL);
        stp_view view = view_of(s, &used.model->ball, leaves, leaf_count);
        uint8_t *expected = draw(&fresh, &view, s), *found = draw(&used, &view, s);
        size_t pixels = (size_t)s->width * (size_t)s->height, covered = 0, wrong = 0;
        for (size_t k = 0; k < pixels; k++) {
            covered += expected[4 * k + 3] != 0;
            wrong += memcmp(expected + 4 * k, found + 4 * k, 4) != 0;
        }
        if (wrong > 0)
            fail_msg("step %zu: %zu of %zu covered pixels are not as in a first frame", i, wrong,
                     covered);
        seen += covered > 50;
        judge_roads(&used, &view, s, i);
        free(expected);
        free(found);
        gl_fixture_close(&fresh);
    }
    assert_true(2 * seen > sizeof steps / sizeof *steps); /* a terrain has a back */
    free(leaves);
    gl_fixture_close(&used);
}

static size_t covered_pixels(gl_fixture *f, const stp_view *view, const stp_draw_params *params,
                             uint8_t *picture, bool *complete)
{
    size_t covered = 0, pixels = (size_t)view->width * (size_t)view->height;
    stp_draw_stats stats;
    check_ok(stp_renderer_draw(f->renderer, view, params, &stats, err));
    check_ok(stp_renderer_read(f->renderer, picture, err));
    for (size_t k = 0; k < pixels; k++)
        covered += picture[4 * k + 3] != 0;
    *complete = stats.cut_complete;
    return covered;
}

/* Frames that do not wait draw the loaded chunks, with every road, and must end at the picture of a
 * frame that waits. */
static void while_loading(void **state)
{
    (void)state;
    static const stp_lod all[] = {STP_LOD_GEOMETRY, STP_LOD_CPU, STP_LOD_COMPUTE, STP_LOD_FULL};
    enum { SIZE = 200, PIXELS = SIZE * SIZE };
    static uint8_t found[4 * PIXELS], expected[4 * PIXELS];
    model_fixture_build("tiles.stipple",
                        &(model_recipe){.shape = GEN_BUMPY, .point_count = 250000});
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        gl_fixture f = {0};
        bool complete = false;
        int frames = 0;
        gl_fixture_open(&f, "tiles.stipple", NULL);
        stp_view view = views_get(3, &f.model->ball, NULL, 0, SIZE, SIZE);
        stp_draw_params params = {.lod = STP_LOD_GEOMETRY, .threshold_px = 16.0};
        assert_true(covered_pixels(&f, &view, &params, found, &complete) > PIXELS / 8);
        params = (stp_draw_params){.lod = all[i], .threshold_px = 0.25, .stream = true};
        for (complete = false; !complete && frames < 1000; frames++)
            assert_true(covered_pixels(&f, &view, &params, found, &complete) > PIXELS / 8);
        assert_true(complete && frames > 1);
        gl_fixture_close(&f);
        gl_fixture_open(&f, "tiles.stipple", NULL);
        params.stream = false;
        (void)covered_pixels(&f, &view, &params, expected, &complete);
        assert_memory_equal(found, expected, sizeof found);
        gl_fixture_close(&f);
    }
}

static void statue(void **state)
{
    (void)state;
    judge(&(model_recipe){.shape = GEN_STATUE, .point_count = 30000, .true_normals = true});
}

static void terrain(void **state)
{
    (void)state;
    judge(&(model_recipe){.shape = GEN_TERRAIN, .point_count = 5000});
}

/* Samples so small that patches are wide: their spots say which tiles they cover. */
static void wide(void **state)
{
    (void)state;
    judge(&(model_recipe){
        .shape = GEN_STATUE, .point_count = 10000, .true_normals = true, .lambda = 0.25});
}

/* A sample whose place or reach is not a number, or infinite, may be anywhere. */
static void no_number(void **state)
{
    const float bad[][3] = {
        {NAN, 0.0f, 1.0f}, {0.0f, NAN, 1.0f}, {0.0f, 0.0f, NAN}, {INFINITY, 0.0f, INFINITY}};
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        stp_tiles tiles = {0};
        assert_int_equal(stp_tiles_begin(&tiles, 300, 200, 1, NULL), STP_OK);
        stp_tiles_mark(&tiles, 0, bad[i][0], bad[i][1], bad[i][2]);
        for (size_t t = 0; t < tiles.count; t++)
            assert_int_equal(tiles.marks[t], 1);
        stp_tiles_destroy(&tiles);
    }
}

/* The tiles of a rectangle are marked if marking what it holds would change nothing. */
static void marked(void **state)
{
    uint32_t seed = 1;
    int yes = 0, no = 0;
    stp_tiles tiles = {0};
    (void)state;
    assert_int_equal(stp_tiles_begin(&tiles, 300, 200, 1, NULL), STP_OK);
    for (int i = 0; i < 2000; i++) {
        float at[3];
        for (int k = 0; k < 3; k++) {
            seed = seed * 1664525u + 1013904223u;
            at[k] = (float)(seed >> 16) / 65536.0f * (k == 2 ? 5.0f : 340.0f) - 20.0f * (k < 2);
        }
        const float low[2] = {at[0] - at[2], at[1] - at[2]};
        const float high[2] = {at[0] + at[2], at[1] + at[2]};
        size_t before = 0, after = 0;
        const bool said = stp_tiles_marked(&tiles, 0, low, high);
        for (size_t t = 0; t < tiles.count; t++)
            before += tiles.marks[t];
        stp_tiles_mark(&tiles, 0, at[0], at[1], at[2]);
        for (size_t t = 0; t < tiles.count; t++)
            after += tiles.marks[t];
        assert_int_equal(said, before == after);
        yes += said;
        no += !said;
    }
    assert_true(yes > 20 && no > 20);
    stp_tiles_destroy(&tiles);
}

/* Samples of a wide patch are known by their spots, to within their reach; those of a dense patch,
 * or of one with more samples than there is room for, are not. */
static void spots(void **state)
{
    enum { MOST = STP_SPOTS_A_PATCH + 1 };
    static const uint16_t places[3][3] = {{0, 0, 0}, {40000, 1, 65535}, {65535, 32768, 3}};
    static stp_sample samples[MOST];
    stp_patch patch = {.exponent = 0};
    uint32_t begin[2] = {0, 3};
    const stp_chunk chunk = {
        .patch_count = 1, .patches = &patch, .level_begin = {begin}, .samples = {samples}};
    stp_spot *found = NULL;
    (void)state;
    for (int i = 0; i < 3; i++)
        memcpy(samples[i].position, places[i], sizeof places[i]);
    stp_mirror_patch wide = {.bound_centre = {32768.0f, 32768.0f, 32768.0f},
                             .bound_radius = 60000.0f,
                             .radius = {100.0f},
                             .count = {3}};
    stp_mirror_patch dense = wide, full = wide;
    check_ok(stp_spots_list(&found, &wide, &chunk, err));
    assert_int_equal(wide.spots, 1);
    for (int i = 0; i < 3; i++) {
        float offset[3], square = 0.0f;
        stp_spot_offset(&found[i], wide.bound_radius, offset);
        for (int k = 0; k < 3; k++) {
            const float off = wide.bound_centre[k] + offset[k] - (float)places[i][k];
            square += off * off;
        }
        assert_true(sqrtf(square) <= stp_spot_reach(wide.bound_radius, 0.0f));
        assert_true(stp_spot_reach(wide.bound_radius, 0.0f) < 500.0f);
    }
    free(found);
    found = NULL;
    dense.radius[0] = 10000.0f;
    check_ok(stp_spots_list(&found, &dense, &chunk, err));
    assert_true(found == NULL && dense.spots == 0);
    full.count[0] = MOST;
    begin[1] = MOST;
    check_ok(stp_spots_list(&found, &full, &chunk, err));
    assert_true(found == NULL && full.spots == 0);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(while_loading), cmocka_unit_test(statue),    cmocka_unit_test(terrain),
        cmocka_unit_test(wide),          cmocka_unit_test(no_number), cmocka_unit_test(marked),
        cmocka_unit_test(spots),
    };
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

/* Tests conditions on what is drawn: exactly the samples that fulfil them, by every road, in passes
 * and while blocks stream; picks find no other sample; wrong conditions get a sentence. */
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/support/views.h"

/* Too little for the whole model. */
#define SMALL_BYTES (UINT64_C(2) << 20)

enum { COUNT = 120000, SIZE = 200, PIXELS = SIZE * SIZE };

static const stp_dvec3 centre = {500000.0, 4.5e6, 300.0};
static const uint8_t classes[4] = {2, 5, 7, 200};

/* ---- a model with attributes ---- */

static const stp_attribute_list kept = {
    .items = {{.name = "rank", .type = STP_ATTRIBUTE_U8, .scale = 1.0},
              {.name = "time", .type = STP_ATTRIBUTE_F64, .scale = 1.0},
              {.name = "rare",
               .type = STP_ATTRIBUTE_I32,
               .scale = 1.0,
               .has_missing = true,
               .missing = -1},
              {.name = "red",
               .type = STP_ATTRIBUTE_U16,
               .scale = 1.0,
               .coarse = STP_COARSE_RED,
               .coarse_scale = 257.0}},
    .count = 4};

static uint64_t red_of(uint32_t i)
{
    return (i & 255u) * 257u + (i >> 8) % 200u; /* more than 8 bits have of it */
}

static void words_of(uint32_t i, uint64_t words[4])
{
    const double time = 0.5 * i;
    words[0] = i % 4;
    memcpy(&words[1], &time, sizeof time);
    words[2] = i % 5 == 0 ? (uint64_t)-1 : i % 7;
    words[3] = (i & 255u) == 255u ? 65535u : red_of(i);
}

typedef struct numbered_cloud {
    prep_cloud cloud;
    uint8_t *packed; /* of the points read last */
} numbered_cloud;

static stp_status read_numbered(void *context, stp_point *points, size_t capacity, size_t *count,
                                stp_error *err)
{
    numbered_cloud *n = context;
    const size_t before = n->cloud.given, stride = stp_attribute_list_bytes(&kept);
    stp_status status = prep_cloud_read(&n->cloud, points, capacity, count, err);
    for (size_t k = 0; k < *count; k++) {
        uint64_t words[4];
        uint8_t *at = n->packed + k * stride;
        words_of((uint32_t)(before + k), words);
        for (int a = 0; a < 4; a++) {
            stp_attribute_put(kept.items[a].type, words[a], at);
            at += stp_attribute_bytes(kept.items[a].type);
        }
    }
    return status;
}

static const uint8_t *packed_numbers(void *context)
{
    return ((numbered_cloud *)context)->packed;
}

static void build(const char *path, bool numbers)
{
    stp_prep_stats stats;
    stp_pool *pool = NULL;
    numbered_cloud n = {.cloud = prep_cloud_wavy(COUNT, centre, 20.0),
                        .packed = calloc(COUNT, stp_attribute_list_bytes(&kept))};
    const stp_prep_params params = {.force = true, .codec = STP_CODEC_ZSTD}; /* in blocks */
    const stp_prep_file file = {.name = "a known surface"};
    const stp_prep_source source = {.context = &n,
                                    .read = read_numbered,
                                    .kept = numbers ? &kept : NULL,
                                    .numbers = packed_numbers,
                                    .point_count = COUNT,
                                    .attributes = STP_POINT_HAS_COLOUR |
                                                  (numbers ? STP_POINT_HAS_CLASS : 0u) |
                                                  (numbers ? STP_POINT_HAS_INTENSITY : 0u),
                                    .files = &file,
                                    .file_count = 1};
    for (uint32_t i = 0; i < COUNT; i++)
        n.cloud.points[i].class_id = classes[i % 4];
    check_ok(stp_pool_create(&pool, 2, err));
    check_ok(stp_prep_run(path, &source, &params, pool, NULL, &stats, err));
    stp_pool_destroy(&pool);
    free(n.cloud.points);
    free(n.packed);
}

/* ---- conditions ---- */

static bool is_class_5(uint32_t i, stp_dvec3 at)
{
    (void)at;
    return i % 4 == 1;
}

static bool is_early(uint32_t i, stp_dvec3 at)
{
    return 0.5 * i < 18000.0 && i % 4 != 2 && at.z > 295.0;
}

static bool is_rare(uint32_t i, stp_dvec3 at)
{
    (void)at;
    return i % 5 != 0 && i % 7 != 3 && !(i % 4 == 0);
}

static bool is_red(uint32_t i, stp_dvec3 at)
{
    uint64_t words[4];
    (void)at;
    words_of(i, words);
    return words[3] >= 30123;
}

typedef bool predicate(uint32_t i, stp_dvec3 at);

typedef struct chosen_points {
    const char *text;
    predicate *holds;
} chosen_points;

static const chosen_points conditions[] = {{"class==5", is_class_5},
                                           {"rank==1", is_class_5},
                                           {"time<18000 && class!=7 && z>295", is_early},
                                           {"rare!=3 && !(rank==0)", is_rare},
                                           {"red>=30123", is_red}};
enum { CONDITIONS = sizeof conditions / sizeof *conditions };

static void open_chosen(gl_fixture *f, const char *path, const char *condition, uint64_t memory)
{
    check_ok(stp_model_open(&f->model, path, err));
    if (condition)
        check_ok(stp_model_choose(f->model, condition, err));
    const stp_renderer_params params = {
        .model = f->model, .thread_count = 2, .gpu_memory_bytes = memory};
    check_ok(stp_renderer_create(&f->renderer, &params, err));
}

static stp_view view_from(const gl_fixture *f, int direction)
{
    return views_get(direction, &f->model->ball, NULL, 0, SIZE, SIZE);
}

/* ---- what must be seen ---- */

static bool fulfils(const void *context, const stp_sample *sample, stp_dvec3 at)
{
    const chosen_points *c = context;
    return c->holds(prep_number_of(sample) & 0xffffffu, at);
}

static const stp_lod roads[] = {STP_LOD_GEOMETRY, STP_LOD_COMPUTE, STP_LOD_CPU, STP_LOD_FULL};
enum { ROADS = sizeof roads / sizeof *roads, COUNTING_ROADS = 2 };

/* At threshold 0 every road draws the points that fulfil the condition: their pixels, their
 * number. */
static void exact(void **state)
{
    static uint8_t rgba[4 * PIXELS], mask[PIXELS];
    (void)state;
    for (int c = 0; c < CONDITIONS; c++) {
        gl_fixture f = {0};
        open_chosen(&f, "where.stipple", conditions[c].text, 0);
        const stp_view view = view_from(&f, 18 + c);
        const uint64_t count = gl_fixture_expect(&f, &view, fulfils, &conditions[c], mask);
        assert_true(count > COUNT / 20 && count < COUNT);
        for (int r = 0; r < ROADS; r++) {
            stp_draw_stats stats = {0};
            const stp_draw_params params = {.reconstruct = STP_RECONSTRUCT_POINTS,
                                            .every_sample = true,
                                            .cull = STP_CULL_NONE,
                                            .lod = roads[r]};
            size_t differing = 0;
            gl_fixture_draw(&f, &view, &params, &stats, rgba);
            for (size_t i = 0; i < PIXELS; i++)
                differing += mask[i] != (rgba[4 * i + 3] != 0);
            if (differing > 4) /* floats may round a sample into the next pixel */
                fail_msg("%s, road %d: %zu pixels differ", conditions[c].text, r, differing);
            if (r < COUNTING_ROADS && stats.points_drawn != count)
                fail_msg("%s, road %d: %llu points drawn, not %llu", conditions[c].text, r,
                         (unsigned long long)stats.points_drawn, (unsigned long long)count);
        }
        gl_fixture_close(&f);
    }
}

/* A class chosen by a condition makes the picture that hiding the other classes makes, at any
 * threshold and by every road. */
static void as_hidden_classes(void **state)
{
    static uint8_t hidden[4 * PIXELS], chosen[4 * PIXELS];
    (void)state;
    gl_fixture f = {0}, whole = {0};
    open_chosen(&f, "where.stipple", "class==5", 0);
    open_chosen(&whole, "where.stipple", NULL, 0);
    for (int reconstruct = 0; reconstruct <= STP_RECONSTRUCT_LAST; reconstruct++)
        for (int r = reconstruct % ROADS; r < ROADS; r += reconstruct == 0 ? 1 : ROADS) {
            const stp_view view = view_from(&f, 18 + reconstruct);
            stp_draw_params params = {.reconstruct = (stp_reconstruct)reconstruct,
                                      .lod = roads[r],
                                      .threshold_px = 0.5 + reconstruct % 3};
            gl_fixture_draw(&f, &view, &params, NULL, chosen);
            params.radius_cap_px = STP_RADIUS_CAP_CHOSEN_PX;
            for (int i = 0; i < 8; i++)
                params.hidden_classes[i] = UINT32_MAX;
            params.hidden_classes[0] &= ~(UINT32_C(1) << 5);
            gl_fixture_draw(&whole, &view, &params, NULL, hidden);
            assert_true(gl_fixture_covered(chosen, PIXELS) > PIXELS / 50);
            assert_memory_equal(chosen, hidden, sizeof chosen);
        }
    gl_fixture_close(&f);
    gl_fixture_close(&whole);
}

/* With chosen levels, all roads make one picture of a condition on attributes. In little memory,
 * where blocks are evicted and pictures take passes, it is the same. */
static void roads_agree(void **state)
{
    static uint8_t first[4 * PIXELS], rgba[4 * PIXELS];
    (void)state;
    for (int c = 1; c < CONDITIONS; c++) {
        gl_fixture f = {0}, small = {0};
        stp_draw_stats stats = {0};
        open_chosen(&f, "where.stipple", conditions[c].text, 0);
        open_chosen(&small, "where.stipple", conditions[c].text, SMALL_BYTES);
        for (int every = 0; every < 2; every++) {
            const stp_view view = view_from(&f, 10 + c);
            stp_draw_params params = {.every_sample = every, .threshold_px = 1.0};
            gl_fixture_draw(&f, &view, &params, NULL, first);
            assert_true(gl_fixture_covered(first, PIXELS) > PIXELS / 50);
            for (int r = 0; r < (every ? ROADS : ROADS - 1); r++) {
                params.lod = roads[r];
                gl_fixture_draw(&f, &view, &params, NULL, rgba);
                assert_memory_equal(first, rgba, sizeof rgba);
            }
            params.lod = STP_LOD_AUTO;
            gl_fixture_draw(&small, &view, &params, &stats, rgba);
            assert_memory_equal(first, rgba, sizeof rgba);
        }
        assert_true(stats.passes > 1);
        gl_fixture_close(&f);
        gl_fixture_close(&small);
    }
}

/* Whatever is picked fulfils the condition, also where others lie in front of it. */
static void picks(void **state)
{
    static uint8_t rgba[4 * PIXELS];
    (void)state;
    for (int c = 0; c < 2; c++)
        for (int every = 0; every < 2; every++) {
            gl_fixture f = {0};
            size_t hits = 0;
            open_chosen(&f, "where.stipple", conditions[c].text, 0);
            const stp_view view = view_from(&f, 20);
            /* the class of a merged sample need not be that of the point that lent its rank */
            const stp_draw_params params = {.every_sample = every || c == 1};
            gl_fixture_draw(&f, &view, &params, NULL, rgba);
            for (int i = 0; i < PIXELS; i += 97) {
                stp_pick pick;
                check_ok(stp_renderer_pick(f.renderer, i % SIZE, i / SIZE, &pick, err));
                if (!pick.hit || pick.level < 0)
                    continue;
                hits++;
                assert_int_equal(pick.class_id, 5);
            }
            assert_true(hits > 50);
            gl_fixture_close(&f);
        }
}

/* No sample that stands for several points is larger than a pixel, unless the host says so. */
static void small_samples(void **state)
{
    static uint8_t rgba[4 * PIXELS];
    (void)state;
    gl_fixture f = {0}, whole = {0};
    open_chosen(&f, "where.stipple", "rank==1", 0);
    open_chosen(&whole, "where.stipple", NULL, 0);
    const stp_view view = view_from(&f, 20);
    stp_draw_params params = {.threshold_px = 1.0};
    gl_fixture_draw(&f, &view, &params, NULL, rgba);
    const stp_gpu_frame *frame = stp_renderer_inspect(f.renderer).frame;
    assert_true(frame->quality[1] == 1.0f);
    gl_fixture_draw(&whole, &view, &params, NULL, rgba);
    assert_true(stp_renderer_inspect(whole.renderer).frame->quality[1] == 6.0f);
    params.radius_cap_px = 3.0;
    gl_fixture_draw(&f, &view, &params, NULL, rgba);
    assert_true(stp_renderer_inspect(f.renderer).frame->quality[1] == 3.0f);
    gl_fixture_close(&f);
    gl_fixture_close(&whole);
}

/* If no point fulfils the condition, the picture is empty; if all do, it is that without one. */
static void none_and_all(void **state)
{
    static uint8_t rgba[4 * PIXELS], whole[4 * PIXELS];
    (void)state;
    const char *const texts[2] = {"rank==9", "rank<9"};
    for (int all = 0; all < 2; all++) {
        gl_fixture f = {0}, plain = {0};
        open_chosen(&f, "where.stipple", texts[all], 0);
        open_chosen(&plain, "where.stipple", NULL, 0);
        const stp_view view = view_from(&f, 3);
        for (int r = 0; r < ROADS; r++) {
            stp_draw_params params = {.lod = roads[r], .radius_cap_px = 4.0};
            gl_fixture_draw(&f, &view, &params, NULL, rgba);
            params.hidden_classes[2] = 1; /* of nobody; then backs may be seen, too */
            gl_fixture_draw(&plain, &view, &params, NULL, whole);
            if (all)
                assert_memory_equal(rgba, whole, sizeof rgba);
            else
                assert_int_equal(gl_fixture_covered(rgba, PIXELS), 0);
        }
        gl_fixture_close(&f);
        gl_fixture_close(&plain);
    }
}

static void refused(const char *path, const char *condition, const char *said)
{
    stp_model *model = NULL;
    stp_error error = {0};
    check_ok(stp_model_open(&model, path, err));
    assert_int_equal(stp_model_choose(model, condition, &error), STP_INVALID_ARGUMENT);
    if (!strstr(error.message, said))
        fail_msg("%s: %s", condition, error.message);
    stp_model_close(&model);
}

static void refusals(void **state)
{
    (void)state;
    refused("where.stipple", "rank=1", "is expected at '=1'");
    refused("where.stipple", "height>1", "no 'height': they have x, y, z, intensity, class");
    refused("plain.stipple", "rank==1", "plain.stipple: --where: the points have no 'rank'");
    refused("plain.stipple", "class==5", "no 'class'");
}

/* Several models in one picture, each with its own condition. */
static void two_models(void **state)
{
    static uint8_t rgba[4 * PIXELS], both[4 * PIXELS];
    (void)state;
    gl_fixture f = {0};
    stp_model *second = NULL;
    open_chosen(&f, "where.stipple", "rank==1", 0);
    check_ok(stp_model_open(&second, "where.stipple", err));
    check_ok(stp_model_choose(second, "rank==9", err));
    const stp_view view = view_from(&f, 5);
    const stp_draw_params params = {.threshold_px = 1.0};
    gl_fixture_draw(&f, &view, &params, NULL, rgba);
    const stp_model *const models[2] = {f.model, second};
    check_ok(stp_renderer_set_models(f.renderer, models, 2, err));
    gl_fixture_draw(&f, &view, &params, NULL, both);
    assert_memory_equal(rgba, both, sizeof rgba);
    gl_fixture_close(&f);
    stp_model_close(&second);
}

static int enter(void **state)
{
    if (scan_fixture_enter(state) != 0)
        return 1;
    build("where.stipple", true);
    build("plain.stipple", false);
    return 0;
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exact),         cmocka_unit_test(as_hidden_classes),
        cmocka_unit_test(roads_agree),   cmocka_unit_test(picks),
        cmocka_unit_test(small_samples), cmocka_unit_test(none_and_all),
        cmocka_unit_test(refusals),      cmocka_unit_test(two_models),
    };
    const int failed = cmocka_run_group_tests(tests, enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

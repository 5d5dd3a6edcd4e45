/* Tests the measures of `tune`: known outlines, normals, changes and nearest points, and solvers of
 * known functions. */
#include "tests/fixtures/model_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/support/promise.h"
#include "tools/tune/tune_advice.h"
#include "tools/tune/tune_metrics.h"
#include "tools/tune/tune_nearest.h"
#include "tools/tune/tune_solve.h"

#include <math.h>
#include <string.h>

enum { SIDE = 128 };

static stp_image blank(void)
{
    stp_image image = {SIDE, SIDE, calloc((size_t)SIDE * SIDE, 4)};
    assert_non_null(image.rgba);
    return image;
}

static uint8_t *at(const stp_image *image, int x, int y)
{
    return image->rgba + 4 * (y * image->width + x);
}

static void set(const stp_image *image, int x, int y, int grey, int alpha)
{
    uint8_t *p = at(image, x, y);
    p[0] = p[1] = p[2] = (uint8_t)grey;
    p[3] = (uint8_t)alpha;
}

/* A disc whose rim covers its pixels in part, by 16 x 16 samples in each. */
static stp_image disc(double radius)
{
    stp_image image = blank();
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            int inside = 0;
            for (int k = 0; k < 256; k++)
                inside +=
                    hypot(x + (k % 16 + 0.5) / 16 - 64, y + (k / 16 + 0.5) / 16 - 64) < radius;
            set(&image, x, y, 200, inside > 0 ? inside - (inside > 255) : 0);
        }
    return image;
}

static stp_image square(int x0, int y0, int side)
{
    stp_image image = blank();
    for (int y = y0; y < y0 + side; y++)
        for (int x = x0; x < x0 + side; x++)
            set(&image, x, y, 200, 255);
    return image;
}

static tune_shift shift(stp_image a, stp_image b)
{
    tune_shift found;
    check_ok(tune_shift_compute(&a, &b, &found, err));
    stp_image_destroy(&a);
    stp_image_destroy(&b);
    return found;
}

static void near(double value, double expected, double by)
{
    if (!(fabs(value - expected) <= by))
        fail_msg("%.9g, expected %.9g within %g", value, expected, by);
}

static void outlines(void **state)
{
    (void)state;
    tune_shift s = shift(disc(30.0), disc(32.0));
    near(s.mean_px, 2.0, 0.05);
    near(s.p95_px, 2.0, 0.1);
    near(s.max_px, 2.0, 0.15);
    assert_true(s.points > 200);
    s = shift(disc(30.0), disc(30.5));
    near(s.mean_px, 0.5, 0.05);
    s = shift(square(20, 20, 40), square(25, 20, 40)); /* moved 5 to the right */
    near(s.max_px, 5.0, 1e-6);
    s = shift(square(20, 20, 40), square(20, 20, 40));
    near(s.max_px, 0.0, 0.0);
    s = shift(blank(), blank());
    assert_int_equal(s.points, 0);
    near(s.max_px, 0.0, 0.0);
    s = shift(square(20, 20, 40), blank()); /* a missing outline counts as farthest */
    near(s.mean_px, TUNE_OUTLINE_LIMIT_PX, 0.0);
}

/* Small gaps are holes and no outlines; anything that touches the rim is no hole. */
static void outlines_without_holes(void **state)
{
    (void)state;
    stp_image a = square(20, 20, 60);
    for (int i = 0; i < TUNE_HOLE_PIXELS - 1; i++)
        set(&a, 40 + i % 5, 40 + i / 5, 0, 0);
    tune_shift s = shift(a, square(20, 20, 60));
    near(s.max_px, 0.0, 0.0);
    a = square(20, 20, 60);
    for (int i = 0; i < 64; i++)
        set(&a, 40 + i % 8, 40 + i / 8, 0, 0);
    s = shift(a, square(20, 20, 60));
    assert_true(s.max_px > 15.0);
    stp_image small = {4, 4, NULL}, large = {4, 5, NULL};
    stp_error err;
    assert_int_equal(tune_shift_compute(&small, &large, &s, &err), STP_INVALID_ARGUMENT);
}

static void angles(void **state)
{
    (void)state;
    enum { COUNT = 100 };
    float a[3 * COUNT] = {0.0f}, b[3 * COUNT] = {0.0f};
    for (int i = 0; i < COUNT; i++) { /* 10 degrees, ten pixels 90, ten without normal */
        double angle = (i < 10 ? 90.0 : 10.0) * M_PI / 180.0;
        a[3 * i + 2] = i < 90 ? 1.0f : 0.0f;
        b[3 * i] = (float)sin(angle);
        b[3 * i + 2] = (float)cos(angle);
    }
    tune_angles found;
    check_ok(tune_angles_compute(a, b, COUNT, &found, err));
    assert_int_equal(found.pixels, 90);
    near(found.median_deg, 10.0, 1e-4);
    near(found.p95_deg, 90.0, 1e-4);
    near(found.mean_deg, (10 * 90.0 + 80 * 10.0) / 90.0, 1e-4);
    check_ok(tune_angles_compute(a, a, COUNT, &found, err));
    near(found.p95_deg, 0.0, 0.0);
}

/* Two single pixels open as holes, then close. A change that both pictures share is no extra
 * change. */
static void changes(void **state)
{
    (void)state;
    stp_image full = square(20, 20, 40), whole = square(20, 20, 40), holed = square(20, 20, 40);
    stp_image dark = square(20, 20, 40);
    set(&holed, 30, 30, 0, 0);
    set(&holed, 50, 50, 0, 0);
    set(&holed, 20, 20, 0, 0); /* at the rim: no hole */
    for (int y = 20; y < 60; y++)
        for (int x = 20; x < 60; x++)
            set(&dark, x, y, 190, 255);
    tune_change c = {0};
    tune_change_add(&c, &whole, &holed, &full, &full);
    assert_int_equal(c.opened, 2);
    assert_int_equal(c.closed, 0);
    tune_change_add(&c, &holed, &whole, &full, &full);
    assert_int_equal(c.opened, 2);
    assert_int_equal(c.closed, 2);
    assert_int_equal(c.steps, 2);
    c = (tune_change){0};
    tune_change_add(&c, &full, &dark, &full, &dark);
    assert_int_equal(c.pixels, 1600);
    near(tune_change_level(&c, c.squares_a), 10.0, 1e-9);
    near(tune_change_level(&c, c.squares_extra), 0.0, 0.0);
    tune_change_add(&c, &full, &full, &full, &dark);
    near(tune_change_level(&c, c.squares_extra), sqrt(50.0), 1e-9);
    stp_image_destroy(&full);
    stp_image_destroy(&whole);
    stp_image_destroy(&holed);
    stp_image_destroy(&dark);
}

/* The nearest points must be those that the promise's own judge finds; it has all discs in
 * memory. */
static void nearest(void **state)
{
    (void)state;
    enum { COUNT = 2000 };
    stp_chunk_file *file = NULL;
    stp_pool *pool = NULL;
    promise_disc *discs = NULL;
    promise_index *index = NULL;
    size_t count = 0;
    model_fixture_build("near.stipple",
                        &(model_recipe){.shape = GEN_STATUE, .point_count = 200000});
    check_ok(stp_chunk_file_open(&file, "near.stipple", err));
    check_ok(stp_pool_create(&pool, 2, err));
    uint32_t chunks = stp_chunk_file_get_info(file)->chunk_count;
    assert_true(chunks > 3);
    stp_chunk_entry *entries = calloc(chunks, sizeof *entries);
    tune_probe *probes = calloc(COUNT, sizeof *probes);
    assert_true(entries != NULL && probes != NULL);
    for (uint32_t id = 0; id < chunks; id++)
        check_ok(stp_chunk_file_entry(file, id, &entries[id], err));
    check_ok(promise_load_leaves(file, &discs, &count, err));
    check_ok(promise_index_create(&index, discs, count, err));
    for (size_t i = 0; i < COUNT; i++) { /* beside discs, up to some hundred radii away */
        const promise_disc *d = &discs[i * 7919 % count];
        double away = d->radius * (double)(i % 7) * (double)(i % 7) * (i % 97 == 0 ? 20.0 : 0.3);
        probes[i].at = stp_dvec3_add(d->centre, (stp_dvec3){away * sin(0.1 * (double)i),
                                                            away * cos(0.37 * (double)i), away});
    }
    tune_nearest_params params = {
        .file = file, .entries = entries, .chunk_count = chunks, .pool = pool};
    check_ok(tune_nearest_find(&params, probes, COUNT, err));
    for (size_t i = 0; i < COUNT; i++) {
        stp_dvec3 best = promise_nearest(index, probes[i].at, NULL);
        near(probes[i].distance, stp_dvec3_length(stp_dvec3_sub(best, probes[i].at)), 1e-9);
    }
    promise_index_destroy(&index);
    free(discs);
    free(entries);
    free(probes);
    stp_pool_destroy(&pool);
    stp_chunk_file_close(&file);
}

/* ---- solvers ---- */

enum { LADDER = 8 };
static const double ladder[LADDER] = {0.0, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0};

/* Frames per second, decibels, bytes as functions of the threshold: smooth, but bytes in steps. */
static double function_of(tune_goal_kind kind, double t)
{
    return kind == TUNE_GOAL_FPS    ? 10.0 + 20.0 * sqrt(t)
           : kind == TUNE_GOAL_PSNR ? 40.0 - 6.0 * log2(1.0 + t)
                                    : 1e6 * floor(1.0 + 100.0 / (1.0 + t));
}

static stp_status measure(void *context, const double *thresholds, size_t count, double *values,
                          stp_error *err)
{
    (void)err;
    for (size_t i = 0; i < count; i++)
        values[i] = function_of(*(tune_goal_kind *)context, thresholds[i]);
    return STP_OK;
}

static stp_status solve(tune_goal_kind kind, double target, tune_solution *out, stp_error *err)
{
    double values[LADDER];
    for (int i = 0; i < LADDER; i++)
        values[i] = function_of(kind, ladder[i]);
    return tune_solve(out,
                      &(tune_solve_params){.kind = kind,
                                           .target = target,
                                           .thresholds = ladder,
                                           .values = values,
                                           .count = LADDER,
                                           .measure = measure,
                                           .context = &kind},
                      err);
}

static void solved(void **state)
{
    (void)state;
    tune_solution s;
    for (double target = 11.0; target < 165.0; target *= 1.13) {
        check_ok(solve(TUNE_GOAL_FPS, target, &s, err));
        near(s.value, target, 0.1 * target);
        near(s.value, function_of(TUNE_GOAL_FPS, s.threshold_px), 1e-9);
    }
    for (double target = 4.5; target <= 40.0; target += 0.73) {
        check_ok(solve(TUNE_GOAL_PSNR, target, &s, err));
        near(s.value, target, 0.5);
        assert_true(s.measured <= 24);
    }
    for (double target = 2.1e6; target < 2e8; target *= 1.31) {
        check_ok(solve(TUNE_GOAL_BYTES, target, &s, err));
        assert_true(s.value <= target);
        assert_true(s.value >= fmin(target, 1.01e8) - 1e6 - 0.03 * target);
    }
}

static void refused(void **state)
{
    (void)state;
    tune_solution s = {.threshold_px = -7.0};
    stp_error err;
    assert_int_equal(solve(TUNE_GOAL_FPS, 500.0, &s, &err), STP_INVALID_ARGUMENT);
    assert_non_null(strstr(err.message, "from 0 to 64 px give 10.0 frames a second to 170.0"));
    assert_int_equal(solve(TUNE_GOAL_FPS, 5.0, &s, &err), STP_INVALID_ARGUMENT);
    assert_int_equal(solve(TUNE_GOAL_PSNR, 45.0, &s, &err), STP_INVALID_ARGUMENT);
    assert_non_null(strstr(err.message, "--psnr: 45.00 dB cannot be reached"));
    assert_int_equal(solve(TUNE_GOAL_PSNR, 1.0, &s, &err), STP_INVALID_ARGUMENT);
    assert_int_equal(solve(TUNE_GOAL_BYTES, 1e5, &s, &err), STP_INVALID_ARGUMENT);
    assert_true(s.threshold_px == -7.0); /* untouched */
}

/* tune must recommend the greatest threshold up to which pictures look like the finest one. */
static void advised(void **state)
{
    (void)state;
    tune_choice choices[] = {{0.25, 40.0, 8000.0, 20.0},
                             {0.5, 40.2, 4000.0, 10.0},
                             {1.0, 39.6, 2000.0, 8.0},
                             {2.0, 37.0, 1000.0, 7.0},
                             {4.0, 39.9, 500.0, 6.0}}; /* by chance: an earlier one fails */
    char words[240];
    tune_advice a;
    assert_false(tune_advise(choices, 1, &a));
    assert_true(tune_advise(choices, 5, &a));
    assert_int_equal(a.chosen, 2);
    tune_advice_words(&a, choices, words);
    assert_string_equal(words, "recommended: --threshold 1: it looks like 0.25 px (0.40 dB less), "
                               "draws 4.0 times fewer samples and is 2.5 times as fast");
    choices[2].psnr_db = choices[1].psnr_db = 30.0;
    assert_true(tune_advise(choices, 5, &a));
    assert_int_equal(a.chosen, a.finest);
    tune_advice_words(&a, choices, words);
    assert_non_null(strstr(
        words, "recommended: --threshold 0.25: the next coarser one, 0.5 px, loses 10.00 dB"));
    choices[1] = (tune_choice){0.5, 41.0, 4000.0, 19.9};
    assert_true(tune_advise(choices, 5, &a));
    tune_advice_words(&a, choices, words);
    assert_non_null(strstr(words, "--threshold 0.5: it looks like 0.25 px (no dB less), draws 2.0 "
                                  "times fewer samples and is as fast on this machine"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(outlines), cmocka_unit_test(outlines_without_holes),
        cmocka_unit_test(angles),   cmocka_unit_test(changes),
        cmocka_unit_test(nearest),  cmocka_unit_test(solved),
        cmocka_unit_test(refused),  cmocka_unit_test(advised),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}

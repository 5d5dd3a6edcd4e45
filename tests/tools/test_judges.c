/* Tests the judges themselves: triangles, coverage and nearest points against results known by hand
 * or by exhaustive search. */
#include "tests/support/check.h"
#include "tests/support/coverage.h"
#include "tests/support/promise.h"
#include "tests/support/triangles.h"

/* ---- triangles ---- */

/* A fan around an inner point, with corners on pixel centres: no pixel may be missed or covered
 * twice. */
static void fan_covers_once(void **state)
{
    (void)state;
    stp_view view = check_view(41, 37, 1.0, true);
    stp_dvec3 positions[9] = {{0.5, 0.5, -2.0}};
    uint32_t triangles[8][3];
    for (uint32_t i = 0; i < 8; i++) {
        double x[8] = {1, 1, 0, -1, -1, -1, 0, 1}, y[8] = {0, 1, 1, 1, 0, -1, -1, -1};
        positions[i + 1] = (stp_dvec3){12.0 * x[i], 12.0 * y[i], -2.0};
        triangles[i][0] = 0;
        triangles[i][1] = i % 3 ? i + 1 : (i + 1) % 8 + 1; /* either orientation */
        triangles[i][2] = i % 3 ? (i + 1) % 8 + 1 : i + 1;
    }
    triangles_mesh mesh = {9, 8, positions, NULL, (const uint32_t(*)[3])triangles};
    triangles_picture picture;
    check_ok(triangles_draw(&picture, &mesh, &view, err));
    size_t covered = 0;
    for (int i = 0; i < 41 * 37; i++) {
        assert_true(picture.pixels[i].layers <= 1);
        covered += picture.pixels[i].layers;
    }
    assert_int_equal(covered, 24 * 24);
    triangles_destroy(&picture);
}

/* A slanted plane in perspective, cut by the near plane: checks depth and normal at every pixel. */
static void perspective_plane(void **state)
{
    (void)state;
    stp_view view = check_view(64, 64, 40.0, false);
    view.near_depth = 0.5;
    /* the floor y = -1, from behind the eye to far away; its normals are not the faces' */
    stp_dvec3 positions[4] = {{-50, -1, 5}, {50, -1, 5}, {50, -1, -70}, {-50, -1, -70}};
    stp_dvec3 normals[4];
    for (int i = 0; i < 4; i++)
        normals[i] = (stp_dvec3){0.0, 0.8, 0.6};
    const uint32_t triangles[2][3] = {{0, 1, 2}, {0, 2, 3}};
    triangles_mesh mesh = {4, 2, positions, normals, triangles};
    for (int with_normals = 0; with_normals < 2; with_normals++) {
        mesh.normals = with_normals ? normals : NULL;
        triangles_picture picture;
        check_ok(triangles_draw(&picture, &mesh, &view, err));
        for (int y = 0; y < 64; y++)
            for (int x = 0; x < 64; x++) {
                double down = -(y + 0.5 - 32.0) / 40.0, depth = 1.0 / down;
                const triangles_pixel *p = &picture.pixels[y * 64 + x];
                bool hit =
                    down > 0.0 && depth < 70.0 && fabs((x + 0.5 - 32.0) / 40.0) * depth < 50.0;
                assert_int_equal(p->layers, hit);
                if (!hit)
                    continue;
                check_near(p->depth, depth, 1e-9 * depth);
                check_near(p->normal.y, with_normals ? 0.8 : 1.0, 1e-12);
            }
        triangles_destroy(&picture);
    }
}

/* Depth decides, not the order; a sphere's silhouette must be a disc. */
static void nearest_triangle_and_sphere(void **state)
{
    (void)state;
    enum { RINGS = 96, SIDES = 192 };
    static stp_dvec3 positions[(RINGS + 1) * SIDES];
    static uint32_t triangles[2 * RINGS * SIDES][3];
    size_t count = 0;
    for (uint32_t i = 0; i <= RINGS; i++)
        for (uint32_t j = 0; j < SIDES; j++) {
            double theta = M_PI * i / RINGS, phi = 2.0 * M_PI * j / SIDES;
            positions[i * SIDES + j] =
                (stp_dvec3){sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi) - 3.0};
        }
    for (uint32_t i = 0; i < RINGS; i++)
        for (uint32_t j = 0; j < SIDES; j++) {
            uint32_t a = i * SIDES + j, b = i * SIDES + (j + 1) % SIDES;
            uint32_t both[2][3] = {{a, b, a + SIDES}, {b, b + SIDES, a + SIDES}};
            memcpy(triangles[count], both, sizeof both);
            count += 2;
        }
    stp_view view = check_view(128, 128, 100.0, false);
    triangles_mesh mesh = {(RINGS + 1) * SIDES, count, positions, NULL,
                           (const uint32_t(*)[3])triangles};
    triangles_picture picture;
    check_ok(triangles_draw(&picture, &mesh, &view, err));
    double radius = 100.0 / sqrt(8.0); /* tan(asin(1 / 3)) */
    for (int y = 0; y < 128; y++)
        for (int x = 0; x < 128; x++) {
            const triangles_pixel *p = &picture.pixels[y * 128 + x];
            double r = hypot(x + 0.5 - 64.0, y + 0.5 - 64.0);
            if (r < radius - 0.05)
                assert_int_equal(p->layers, 2);
            if (r > radius)
                assert_int_equal(p->layers, 0);
            if (p->layers == 0)
                continue;
            /* the nearer point where the ray meets the unit ball */
            double a = 1.0 + r * r * 1e-4, depth = (3.0 - sqrt(fmax(0.0, 9.0 - 8.0 * a))) / a;
            if (r < radius - 2.0)
                check_near(p->depth, depth, 3e-3);
            assert_true(p->normal.z > -1e-9 || r > radius - 2.0);
        }
    triangles_destroy(&picture);
}

/* ---- coverage ---- */

enum { W = 60, H = 50 };

static void rectangle(uint8_t *mask, int x0, int y0, int x1, int y1, uint8_t value)
{
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++)
            mask[y * W + x] = value;
}

static coverage_verdict judged(const uint8_t *picture, const uint8_t *truth, double tolerance)
{
    coverage_verdict v;
    check_ok(coverage_judge(picture, W, H, truth, 1, tolerance, &v, err));
    return v;
}

static void holes_are_found(void **state)
{
    (void)state;
    uint8_t truth[W * H] = {0}, picture[W * H] = {0};
    rectangle(truth, 10, 10, 50, 40, 1);
    rectangle(truth, 25, 20, 30, 25, 0); /* an opening of the model itself */
    memcpy(picture, truth, sizeof picture);
    coverage_verdict v = judged(picture, truth, 2.0);
    assert_int_equal(v.silhouette, 40 * 30 - 25);
    assert_int_equal(v.hole_pixels + v.spill + v.lost, 0);
    check_near(v.spill_max_px + v.lost_max_px, 0.0, 0.0);
    picture[12 * W + 12] = 0;                        /* alone */
    picture[15 * W + 20] = picture[16 * W + 21] = 0; /* across a corner: one hole of two pixels */
    rectangle(picture, 40, 30, 43, 32, 0);
    v = judged(picture, truth, 2.0);
    assert_int_equal(v.hole_pixels, 1 + 2 + 6);
    assert_int_equal(v.hole_count, 3);
    assert_int_equal(v.largest_hole, 6);
}

static void what_is_eaten_away_is_outline(void **state)
{
    (void)state;
    uint8_t truth[W * H] = {0}, picture[W * H] = {0};
    rectangle(truth, 10, 10, 50, 40, 1);
    rectangle(picture, 12, 10, 50, 40, 1); /* two columns too narrow */
    coverage_verdict v = judged(picture, truth, 2.0);
    assert_int_equal(v.hole_pixels, 0);
    assert_int_equal(v.outline, 2 * (40 + 30) - 4 + 2 * (38 + 30) - 4);
    assert_int_equal(v.spill + v.lost, 0);
    check_near(v.lost_max_px, 2.0, 0.0);
    v = judged(picture, truth, 1.5);
    assert_int_equal(v.lost, 30);
    /* pixels inside, with all neighbours, and deeper than the outline's tolerance */
    rectangle(picture, 12, 24, 30, 25, 0);
    v = judged(picture, truth, 3.0);
    assert_int_equal(v.hole_count, 1);
    assert_int_equal(v.hole_pixels, 30 - 13);
    /* a single pixel on the border is no hole; an enclosed one beside it is */
    memcpy(picture, truth, sizeof picture);
    picture[10 * W + 20] = 0;
    assert_int_equal(judged(picture, truth, 2.0).hole_pixels, 0);
    memcpy(picture, truth, sizeof picture);
    picture[11 * W + 20] = 0;
    assert_int_equal(judged(picture, truth, 2.0).hole_pixels, 1);
}

static void spill_and_empty_pictures(void **state)
{
    (void)state;
    uint8_t truth[W * H] = {0}, picture[W * H] = {0};
    rectangle(truth, 0, 10, 50, H, 1); /* reaches the picture's edges */
    rectangle(picture, 0, 9, 51, H, 1);
    coverage_verdict v = judged(picture, truth, 1.5); /* a corner is off by a diagonal */
    assert_int_equal(v.spill + v.hole_pixels + v.lost, 0);
    rectangle(picture, 0, 8, 10, 9, 1);
    v = judged(picture, truth, 1.5);
    assert_int_equal(v.spill, 10);
    check_near(v.spill_max_px, 2.0, 0.0);
    memset(picture, 0, sizeof picture);
    v = judged(picture, truth, 3.0);
    assert_int_equal(v.lost, v.silhouette);
    assert_true(isinf(v.lost_max_px));
    assert_true(v.hole_pixels > 1000 && v.hole_count == 1);
    memset(truth, 0, sizeof truth);
    v = judged(picture, truth, 3.0);
    assert_int_equal(v.outline + v.silhouette, 0);
}

/* A gap as wide as twice the tolerance may close; what a wider one loses beyond that is spill. */
static void narrow_gaps_may_close(void **state)
{
    (void)state;
    uint8_t truth[W * H] = {0}, picture[W * H] = {0};
    rectangle(truth, 10, 10, 50, 40, 1);
    memcpy(picture, truth, sizeof picture);
    rectangle(truth, 20, 10, 24, 40, 0);
    assert_int_equal(judged(picture, truth, 2.0).spill, 0);
    rectangle(truth, 20, 10, 26, 40, 0);
    assert_int_equal(judged(picture, truth, 2.0).spill, 2 * 30);
}

/* The truth is three times as fine: it ends a third of a pixel beyond a pixel's centre. */
static void truth_may_be_finer(void **state)
{
    (void)state;
    static uint8_t truth[9 * W * H];
    uint8_t picture[W * H] = {0};
    for (int i = 0; i < 9 * W * H; i++)
        truth[i] = i % (3 * W) < 3 * 20;
    rectangle(picture, 0, 0, 22, H, 1);
    coverage_verdict v;
    check_ok(coverage_judge(picture, W, H, truth, 3, 1.7, &v, err));
    assert_int_equal(v.silhouette, 20 * H);
    assert_int_equal(v.spill + v.lost + v.hole_pixels, 0);
    check_near(v.spill_max_px, 5.0 / 3.0, 1e-12);
    check_ok(coverage_judge(picture, W, H, truth, 3, 1.6, &v, err));
    assert_int_equal(v.spill, H);
}

static void distances_are_exact(void **state)
{
    (void)state;
    uint8_t mask[W * H] = {0};
    double distance[W * H];
    unsigned seed = 7;
    for (int i = 0; i < W * H; i++) {
        seed = seed * 1664525u + 1013904223u;
        mask[i] = seed >> 24 < 3;
    }
    check_ok(coverage_distance(mask, W, H, distance, err));
    for (int i = 0; i < W * H; i++) {
        double best = INFINITY;
        for (int k = 0; k < W * H; k++)
            if (mask[k])
                best = fmin(best, hypot(i % W - k % W, i / W - k / W));
        check_near(distance[i], best, 1e-12);
    }
}

/* ---- nearest points ---- */

static double random_unit(unsigned *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (*seed >> 8) / 16777216.0;
}

static stp_dvec3 random_point(unsigned *seed)
{
    return (stp_dvec3){random_unit(seed) - 0.5, random_unit(seed) - 0.5, random_unit(seed) - 0.5};
}

static void nearest_on_one_disc(void **state)
{
    (void)state;
    promise_disc disc = {{1.0, 2.0, 3.0}, {0.0, 0.0, 1.0}, 2.0};
    stp_dvec3 y = promise_nearest_on(&disc, (stp_dvec3){2.0, 2.0, 7.0});
    check_near(y.x, 2.0, 1e-15);
    check_near(y.z, 3.0, 1e-15);
    y = promise_nearest_on(&disc, (stp_dvec3){1.0, 9.0, -1.0});
    check_near(y.y, 4.0, 1e-15);
    check_near(y.z, 3.0, 1e-15);
    /* compares with thousands of points of the disc */
    unsigned seed = 3;
    for (int k = 0; k < 50; k++) {
        promise_disc d = {random_point(&seed), stp_dvec3_normalize(random_point(&seed)), 0.4};
        stp_dvec3 x = random_point(&seed), u, best = promise_nearest_on(&d, x);
        double least = stp_dvec3_length(stp_dvec3_sub(x, best));
        check_near(stp_dvec3_dot(stp_dvec3_sub(best, d.centre), d.normal), 0.0, 1e-12);
        assert_true(stp_dvec3_length(stp_dvec3_sub(best, d.centre)) <= 0.4 + 1e-12);
        for (int i = 0; i < 2000; i++) {
            u = stp_dvec3_cross(d.normal, random_point(&seed));
            u = stp_dvec3_scale(stp_dvec3_normalize(u), 0.4 * sqrt(random_unit(&seed)));
            double other = stp_dvec3_length(stp_dvec3_sub(x, stp_dvec3_add(d.centre, u)));
            assert_true(other >= least - 1e-12);
        }
    }
    disc.normal = (stp_dvec3){0.0, 0.0, 0.0}; /* a ball */
    y = promise_nearest_on(&disc, (stp_dvec3){1.0, 2.0, 8.0});
    check_near(y.z, 5.0, 1e-15);
}

static void grid_agrees_with_trying_all(void **state)
{
    (void)state;
    enum { N = 700 };
    static promise_disc discs[N];
    unsigned seed = 11;
    for (int kind = 0; kind < 4; kind++) {
        size_t count = kind == 3 ? 1 : N;
        for (size_t i = 0; i < count; i++) {
            stp_dvec3 p = random_point(&seed);
            if (kind == 1) /* a flat sheet, so that the grid is one cell high */
                p.z = 0.0;
            if (kind == 2) /* far from the origin, with one disc larger than the others */
                p = stp_dvec3_add(stp_dvec3_scale(p, 100.0), (stp_dvec3){1e6, -2e6, 10.0});
            discs[i] = (promise_disc){p, stp_dvec3_normalize(random_point(&seed)),
                                      (kind == 2 ? 3.0 : 0.03) * random_unit(&seed)};
            if (i % 50 == 0)
                discs[i].normal = (stp_dvec3){0.0, 0.0, 0.0};
        }
        if (kind == 2)
            discs[5].radius = 80.0;
        promise_index *index = NULL;
        check_ok(promise_index_create(&index, discs, count, err));
        for (int k = 0; k < 3000; k++) {
            stp_dvec3 x = stp_dvec3_scale(random_point(&seed), k % 3 ? 1.1 : 4.0);
            if (kind == 2)
                x = stp_dvec3_add(stp_dvec3_scale(x, 100.0), (stp_dvec3){1e6, -2e6, 10.0});
            double best = INFINITY;
            for (size_t i = 0; i < count; i++)
                best = fmin(best,
                            stp_dvec3_length(stp_dvec3_sub(x, promise_nearest_on(&discs[i], x))));
            size_t disc = count;
            stp_dvec3 y = promise_nearest(index, x, &disc);
            double found = stp_dvec3_length(stp_dvec3_sub(x, y));
            check_near(found, best, 0.0);
            check_near(stp_dvec3_length(stp_dvec3_sub(y, promise_nearest_on(&discs[disc], x))), 0.0,
                       0.0);
        }
        promise_index_destroy(&index);
        assert_null(index);
    }
    promise_index *index = NULL;
    assert_int_equal(promise_index_create(&index, discs, 0, NULL), STP_EMPTY);
}

/* A drawn disc lifted by h off a plane of small discs, seen from the side: every point is off by
 * the same h f / z. The rim points lie on the rim. */
static void displacement_is_known(void **state)
{
    (void)state;
    static promise_disc discs[41 * 41];
    for (int i = 0; i < 41 * 41; i++)
        discs[i] = (promise_disc){
            {(i % 41 - 20) * 0.05, 0.0, -5.0 + (i / 41 - 20) * 0.05}, {0.0, 1.0, 0.0}, 0.05};
    promise_index *index = NULL;
    check_ok(promise_index_create(&index, discs, 41 * 41, err));
    stp_view view = check_view(200, 200, 100.0, true);
    promise_disc drawn = {{0.0, 0.02, -5.0}, {0.0, 1.0, 0.0}, 0.5};
    promise_pairs pairs;
    promise_trace(index, &drawn, view.eye, &pairs);
    promise_tally tally = {0};
    promise_add(&tally, &pairs, &view, 1.0);
    assert_int_equal(tally.points, PROMISE_POINTS);
    assert_int_equal(tally.broken, PROMISE_POINTS);
    check_near(tally.max_px, 2.0, 1e-9);
    check_near(tally.sum_px, 2.0 * PROMISE_POINTS, 1e-9);
    check_near(stp_dvec3_length(stp_dvec3_sub(pairs.drawn[1], drawn.centre)), 0.5, 1e-12);
    check_near(stp_dvec3_length(stp_dvec3_sub(pairs.drawn[1], pairs.drawn[9])), 1.0, 1e-12);
    tally = (promise_tally){0};
    promise_add(&tally, &pairs, &view, 2.5);
    assert_int_equal(tally.broken, 0);
    check_near(promise_quantile(&tally, 0.99), 26.0 / 32.0, 1e-9);
    check_near(promise_displacement_px(&view, (stp_dvec3){0, 0, 1}, (stp_dvec3){0, 0, -1}), -1.0,
               0.0);
    view.orthographic = false;
    check_near(promise_displacement_px(&view, (stp_dvec3){0, 0, -2}, (stp_dvec3){0.03, 0.04, -2}),
               2.5, 1e-12);
    /* a disc without normal faces the eye: its rim looks round from there */
    drawn.normal = (stp_dvec3){0.0, 0.0, 0.0};
    promise_trace(index, &drawn, view.eye, &pairs);
    for (int i = 1; i < PROMISE_POINTS; i++)
        check_near(stp_dvec3_dot(stp_dvec3_sub(pairs.drawn[i], drawn.centre), drawn.centre), 0.0,
                   1e-12);
    promise_index_destroy(&index);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fan_covers_once),
        cmocka_unit_test(perspective_plane),
        cmocka_unit_test(nearest_triangle_and_sphere),
        cmocka_unit_test(holes_are_found),
        cmocka_unit_test(what_is_eaten_away_is_outline),
        cmocka_unit_test(spill_and_empty_pictures),
        cmocka_unit_test(narrow_gaps_may_close),
        cmocka_unit_test(truth_may_be_finer),
        cmocka_unit_test(distances_are_exact),
        cmocka_unit_test(nearest_on_one_disc),
        cmocka_unit_test(grid_agrees_with_trying_all),
        cmocka_unit_test(displacement_is_known),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

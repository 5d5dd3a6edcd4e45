/* Tests that splats drawn in several passes, because memory is short, equal splats drawn at once:
 * all fronts are found before any splat is added. Sums are exact, so the pictures are equal to the
 * last bit, waiting or streaming. Tests also that discs of up to thousands of pixels, oblique or
 * around the eye, cover the right pixels with every road: each disc with two, in turns. With the
 * argument --every, as in long_gl_splat, it tries each disc with all four, and twice as many views.
 */
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/support/views.h"

enum { SIZE = 200, VIEWS = 6, FRAMES_LIMIT = 20000 };

static bool every; /* argument --every */

#define LITTLE_BYTES (UINT64_C(4) << 20)

static uint8_t expected[4 * SIZE * SIZE], found[4 * SIZE * SIZE];

static void check_same(stp_renderer *renderer, const char *how, int view)
{
    size_t covered = 0;
    check_ok(stp_renderer_read(renderer, found, err));
    for (size_t i = 0; i < sizeof found; i++) {
        covered += i % 4 == 3 && expected[i] > 0;
        if (found[i] != expected[i])
            fail_msg("%s, view %d: component %zu is %d, at once %d", how, view, i, found[i],
                     expected[i]);
    }
    assert_true(covered > SIZE * SIZE / 20);
}

static void passes_are_the_whole(void **state)
{
    (void)state;
    gl_fixture roomy;
    stp_renderer *little = NULL;
    unsigned in_passes = 0;
    model_fixture_build("splat.stipple",
                        &(model_recipe){.shape = GEN_STATUE, .point_count = 300000});
    gl_fixture_open(&roomy, "splat.stipple", NULL);
    check_ok(stp_renderer_create(
        &little, &(stp_renderer_params){.model = roomy.model, .gpu_memory_bytes = LITTLE_BYTES},
        err));
    for (int i = 0; i < (every ? VIEWS : VIEWS / 2); i++) {
        stp_draw_stats stats = {0};
        stp_view view = views_get(4 * i, &roomy.model->ball, NULL, 0, SIZE, SIZE);
        stp_draw_params params = {
            .reconstruct = STP_RECONSTRUCT_SPLAT, .lod = (stp_lod)(i % 3), .threshold_px = 0.2};
        check_ok(stp_renderer_draw(roomy.renderer, &view, &params, &stats, err));
        assert_int_equal(stats.passes, 1);
        check_ok(stp_renderer_read(roomy.renderer, expected, err));
        check_ok(stp_renderer_draw(little, &view, &params, &stats, err));
        in_passes += stats.passes > 1;
        check_same(little, "waiting", i);
        params.stream = true;
        stats.cut_complete = false;
        for (int frame = 0; !stats.cut_complete; frame++) {
            assert_true(frame < FRAMES_LIMIT);
            check_ok(stp_renderer_draw(little, &view, &params, &stats, err));
            usleep(2000);
        }
        check_same(little, "streaming", i);
    }
    assert_true(in_passes > 0);
    stp_renderer_destroy(&little);
    gl_fixture_close(&roomy);
}

/* ---- large discs ---- */

/* Half the side of a box around a disc's centre, in its radii; the box contains no other centre. */
#define ALONE 1e-3
/* A pixel this near to the rim (in q) or to the near plane may be covered or not. */
#define EITHER 4e-3

/* A view that shows the disc with this radius, turned from its normal by an angle. The disc is not
 * in the middle. */
static stp_view large_view(const promise_disc *disc, const stp_ball *ball, double radius_px,
                           double fovy_deg, double angle)
{
    double f = SIZE / (2.0 * tan(fovy_deg * M_PI / 360.0));
    double distance = 0.85 * disc->radius * f / radius_px;
    stp_dvec3 aside =
        stp_dvec3_normalize(stp_dvec3_cross(disc->normal, (stp_dvec3){0.36, 0.48, 0.8}));
    stp_dvec3 towards = stp_dvec3_add(stp_dvec3_scale(disc->normal, cos(angle)),
                                      stp_dvec3_scale(aside, sin(angle)));
    stp_dvec3 eye = stp_dvec3_add(disc->centre, stp_dvec3_scale(towards, distance));
    stp_dvec3 look =
        stp_dvec3_add(disc->centre, stp_dvec3_scale(aside, 0.3 * distance * SIZE / (2.0 * f)));
    return views_look(eye, look, fovy_deg, ball, SIZE, SIZE);
}

/* Returns the one drawn disc as a pixel. */
static reference_pixel only_disc(gl_fixture *f, const promise_disc *disc, reference_pyramid *r)
{
    size_t found_count = 0;
    reference_pixel p = {0}, q;
    reference_disc_list discs = gl_fixture_discs(f, &r->view, true);
    stp_dvec3 at = reference_to_eye(&r->view, disc->centre);
    for (size_t i = 0; i < discs.count; i++)
        if (stp_dvec3_length(stp_dvec3_sub(discs.items[i].position, at)) < ALONE * disc->radius &&
            reference_sample(r, &discs.items[i], &q)) {
            p = q;
            found_count++;
        }
    assert_int_equal(found_count, 1);
    reference_disc_list_clear(&discs);
    return p;
}

/* Compares each pixel with the disc; counts those left out in sums[0] and those covered in
 * sums[1]. */
static void check_cover(const reference_pyramid *r, const reference_pixel *p, size_t sums[2])
{
    for (int j = 0; j < SIZE; j++)
        for (int i = 0; i < SIZE; i++) {
            double depth, near = r->view.near_depth;
            double q = reference_meet(r, p, p->dx, p->dy, i + 0.5, j + 0.5, &depth);
            bool covered = found[4 * (j * SIZE + i) + 3] > 0;
            bool inside = q <= 1.0 && depth > near;
            sums[covered]++;
            if (covered != inside && fabs(q - 1.0) > EITHER && fabs(depth - near) > EITHER * near)
                fail_msg("pixel %d %d is %s: q %g, depth %g, radius %g px", i, j,
                         covered ? "covered" : "left out", q, depth, reference_radius_px(r, p));
        }
}

static void large_discs(void **state)
{
    (void)state;
    static const double radii_px[] = {40.0, 300.0, 1000.0, 3000.0}, fovy_deg[] = {4.0, 60.0},
                        angles[] = {0.0, 1.0, 1.4, 1.54};
    gl_fixture f;
    promise_disc *discs = NULL;
    size_t disc_count = 0, sums[2] = {0};
    model_fixture_build("large.stipple", &(model_recipe){.shape = GEN_STATUE, .point_count = 2000});
    gl_fixture_open(&f, "large.stipple", NULL);
    check_ok(promise_load_leaves(f.model->file, &discs, &disc_count, err));
    for (int i = 0; i < 32; i++) {
        const promise_disc *disc = &discs[disc_count / 33 * (size_t)i];
        stp_dvec3 away = stp_dvec3_scale((stp_dvec3){1.0, 1.0, 1.0}, ALONE * disc->radius);
        reference_pyramid r = {.filter = REFERENCE_SPLAT};
        stp_draw_params params = {
            .reconstruct = STP_RECONSTRUCT_SPLAT,
            .every_sample = true,
            .clip = {true, {stp_dvec3_sub(disc->centre, away), stp_dvec3_add(disc->centre, away)}}};
        r.view =
            large_view(disc, &f.model->ball, radii_px[i % 4], fovy_deg[i / 4 % 2], angles[i / 8]);
        for (int lod = every ? 0 : (i + i / 4 + i / 8) % 2; lod < 4; lod += every ? 1 : 2) {
            params.lod = (stp_lod)lod;
            check_ok(stp_renderer_draw(f.renderer, &r.view, &params, NULL, err));
            check_ok(stp_renderer_read(f.renderer, found, err));
            reference_pixel p = only_disc(&f, disc, &r);
            check_cover(&r, &p, sums);
        }
    }
    assert_true(sums[0] > 100000 && sums[1] > 100000);
    free(discs);
    gl_fixture_close(&f);
}

int main(int argc, char **argv)
{
    every = argc > 1 && strcmp(argv[1], "--every") == 0;
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {cmocka_unit_test(passes_are_the_whole),
                                       cmocka_unit_test(large_discs)};
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

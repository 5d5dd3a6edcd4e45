/* Tests views from inside a thicket: discs of all directions, many pixels wide, one behind another.
 * Near discs must not take the pixels beside them from the far ones: nearly every pixel that a disc
 * covers must be covered in the picture. */
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/support/views.h"

enum { COUNT = 1500, SIZE = 320, VIEWS = 6 };

static void build(const char *path)
{
    stp_prep_stats stats;
    prep_cloud cloud = prep_cloud_make(COUNT);
    for (size_t i = 0; i < COUNT; i++)
        cloud.points[i].position =
            (stp_dvec3){stp_random_unit(1, i), stp_random_unit(2, i), stp_random_unit(3, i)};
    check_ok(prep_cloud_run(&cloud, path, 2, NULL, &stats, err));
    free(cloud.points);
}

/* Finds the pixels whose rays meet a disc that has its centre in the picture. */
static void cast(const stp_view *view, const reference_disc_list *discs, bool *covered)
{
    memset(covered, 0, SIZE * SIZE);
    for (size_t k = 0; k < discs->count; k++) {
        const reference_disc *d = &discs->items[k];
        const double x = stp_view_axis_x(view) - view->f * d->position.x / d->position.z;
        const double y = stp_view_axis_y(view) - view->f * d->position.y / d->position.z;
        if (!(-d->position.z > view->near_depth && x >= 0.0 && x < SIZE && y >= 0.0 && y < SIZE))
            continue;
        for (int i = 0; i < SIZE * SIZE; i++) {
            stp_dvec3 ray = {(i % SIZE + 0.5 - stp_view_axis_x(view)) / view->f,
                             (i / SIZE + 0.5 - stp_view_axis_y(view)) / view->f, -1.0};
            double depth = stp_dvec3_dot(d->normal, d->position) / stp_dvec3_dot(d->normal, ray);
            stp_dvec3 off = stp_dvec3_sub(stp_dvec3_scale(ray, depth), d->position);
            covered[i] |= depth > view->near_depth && stp_dvec3_length(off) <= d->radius;
        }
    }
}

static void discs_behind_are_seen(void **state)
{
    (void)state;
    static bool covered[SIZE * SIZE];
    size_t all = 0, open = 0;
    gl_fixture f = {0};
    build("thicket.stipple");
    gl_fixture_open(&f, "thicket.stipple", NULL);
    for (int v = 0; v < VIEWS; v++) {
        const double ahead = v % 2 ? 1.0 : -1.0;
        const stp_dvec3 eye = {0.5, 0.5, 0.5};
        const stp_dvec3 look = {eye.x + (v / 2 == 0 ? ahead : 0.0),
                                eye.y + (v / 2 == 1 ? ahead : 0.0),
                                eye.z + (v / 2 == 2 ? ahead : 0.0)};
        stp_view view = views_look(eye, look, 60.0, &f.model->ball, SIZE, SIZE);
        const stp_draw_params params = {.threshold_px = 0.01, .keep_pixels = true};
        stp_draw_stats stats;
        check_ok(stp_renderer_draw(f.renderer, &view, &params, &stats, err));
        reference_disc_list discs = gl_fixture_discs(&f, &view, false);
        reference_pixel *pixels = gl_fixture_pixels(&f, true);
        cast(&view, &discs, covered);
        for (int i = 0; i < SIZE * SIZE; i++) {
            all += covered[i];
            open += covered[i] && pixels[i].tag == 0;
        }
        free(pixels);
        reference_disc_list_clear(&discs);
    }
    print_message("%zu pixels covered by discs, %zu open\n", all, open);
    assert_true(all > VIEWS * SIZE * SIZE / 2 && open * 12000 < all);
    gl_fixture_close(&f);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {cmocka_unit_test(discs_behind_are_seen)};
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

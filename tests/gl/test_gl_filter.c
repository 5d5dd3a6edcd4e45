/* Tests the clip box, the host's planes and hidden classes: exactly the right samples are drawn,
 * every road draws the same, nothing outside the box is loaded, and wrong boxes are refused.
 *
 * Each reconstruction meets one of the other roads, in turns, and the wider templates, which are
 * one shader with template3, are left out; with the argument --every, as in long_gl_filter, nothing
 * is. */
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/fixtures/square_fixture.h"
#include "tests/support/views.h"

enum { COUNT = 60000, SIZE = 200, PIXELS = SIZE * SIZE };

/* Georeferenced: a float could not tell the box from its neighbour. */
static const stp_dvec3 centre = {500000.0, 4.5e6, 300.0};
static const double radius = 20.0;

/* Everything above the middle but one corner. Classes alternate: ground, vegetation, noise, 200. */
static const stp_clip upper = {
    true, {{500000.0 - 30.0, 4.5e6 - 30.0, 300.0}, {500000.0 + 9.0, 4.5e6 + 30.0, 330.0}}};
static const uint8_t classes[4] = {2, 5, 7, 200};

static void hide(stp_draw_params *params, unsigned class_id)
{
    params->hidden_classes[class_id / 32] |= UINT32_C(1) << class_id % 32;
}

static bool hidden(const stp_draw_params *params, unsigned class_id)
{
    return params->hidden_classes[class_id / 32] >> class_id % 32 & 1;
}

static bool inside(const stp_clip *clip, stp_dvec3 p)
{
    return !clip->enabled || stp_dbox_distance_squared(&clip->box, p) == 0.0;
}

static void build(const char *path)
{
    stp_prep_stats stats;
    prep_cloud cloud = prep_cloud_wavy(COUNT, centre, radius);
    for (uint32_t i = 0; i < COUNT; i++)
        cloud.points[i].class_id = classes[i % 4];
    check_ok(prep_cloud_run(&cloud, path, 2, NULL, &stats, err));
    free(cloud.points);
}

static int open_model(void **state)
{
    static gl_fixture f;
    *state = &f;
    if (scan_fixture_enter(state) != 0)
        return 1;
    build("filter.stipple");
    gl_fixture_open(&f, "filter.stipple", NULL);
    *state = &f;
    return 0;
}

static int close_model(void **state)
{
    gl_fixture_close(*state);
    return scan_fixture_leave(state);
}

static stp_view view_from(const gl_fixture *f, int direction)
{
    return views_get(direction, &f->model->ball, NULL, 0, SIZE, SIZE);
}

static bool passes(const void *context, const stp_sample *sample, stp_dvec3 at)
{
    const stp_draw_params *params = context;
    return inside(&params->clip, at) && !hidden(params, sample->class_id);
}

static const stp_lod roads[] = {STP_LOD_GEOMETRY, STP_LOD_CPU, STP_LOD_COMPUTE, STP_LOD_FULL};
enum { ROADS = sizeof roads / sizeof *roads };

/* Single pixels, drawn by every road, must be those of the samples that pass. */
static void exact(void **state)
{
    gl_fixture *f = *state;
    static uint8_t rgba[4 * PIXELS], mask[PIXELS];
    for (int variant = 0; variant < 3; variant++) {
        stp_draw_params params = {.reconstruct = STP_RECONSTRUCT_POINTS, .every_sample = true};
        if (variant != 1)
            params.clip = upper;
        if (variant != 0) {
            hide(&params, 7);
            hide(&params, 200);
        }
        stp_view view = view_from(f, 18 + 2 * variant);
        gl_fixture_expect(f, &view, passes, &params, mask);
        for (int r = 0; r < ROADS; r++) {
            size_t differing = 0;
            params.lod = roads[r];
            gl_fixture_draw(f, &view, &params, NULL, rgba);
            for (size_t i = 0; i < PIXELS; i++)
                differing += mask[i] != (rgba[4 * i + 3] != 0);
            assert_true(gl_fixture_covered(rgba, PIXELS) > PIXELS / 20);
            if (differing > 4) /* floats may round a sample into the next pixel */
                fail_msg("road %d, variant %d: %zu components differ", r, variant, differing);
        }
    }
}

static bool every_road;

static bool is_left_out(int reconstruct)
{
    return !every_road &&
           (reconstruct == STP_RECONSTRUCT_TEMPLATE5 || reconstruct == STP_RECONSTRUCT_TEMPLATE7);
}

/* With chosen levels and reconstruction, all roads must make one picture. */
static void roads_agree(void **state)
{
    gl_fixture *f = *state;
    static uint8_t first[4 * PIXELS], rgba[4 * PIXELS], whole[4 * PIXELS];
    for (int reconstruct = 0; reconstruct <= STP_RECONSTRUCT_LAST; reconstruct++)
        for (int every = 0; every < 2 && !is_left_out(reconstruct); every++) {
            stp_draw_params params = {.reconstruct = (stp_reconstruct)reconstruct,
                                      .every_sample = every,
                                      .threshold_px = 2.0};
            stp_view view = view_from(f, 18 + reconstruct);
            view.orthographic = reconstruct == 1;
            if (view.orthographic)
                view.f = 0.4 * SIZE / radius;
            gl_fixture_draw(f, &view, &params, NULL, whole);
            params.clip = upper;
            hide(&params, 2);
            hide(&params, 5);
            gl_fixture_draw(f, &view, &params, NULL, first);
            assert_true(gl_fixture_covered(first, PIXELS) > PIXELS / 50 &&
                        gl_fixture_covered(first, PIXELS) < gl_fixture_covered(whole, PIXELS));
            const int roads_end = every ? ROADS : ROADS - 1;
            for (int r = 1; r < roads_end; r++) {
                size_t differing = 0;
                if (!every_road && r != 1 + (reconstruct + every) % (roads_end - 1))
                    continue;
                params.lod = roads[r];
                gl_fixture_draw(f, &view, &params, NULL, rgba);
                for (size_t i = 0; i < 4 * PIXELS; i++)
                    differing += rgba[i] != first[i];
                if (differing > 0)
                    fail_msg("reconstruct %d, road %d: %zu pixels differ", reconstruct, r,
                             differing);
            }
        }
}

/* The six planes of a box, with normals of some length. */
static void set_planes(stp_draw_params *params, const stp_dbox *box)
{
    params->plane_count = 6;
    for (int i = 0; i < 3; i++) {
        const stp_dvec3 axis = {i == 0, i == 1, i == 2};
        params->planes[2 * i] = (stp_plane){axis, stp_dvec3_dot(axis, box->min)};
        params->planes[2 * i + 1] =
            (stp_plane){stp_dvec3_scale(axis, -2.0), -2.0 * stp_dvec3_dot(axis, box->max)};
    }
}

/* The host's planes around a box must make the picture that the box makes: by every road and
 * reconstruction, in both projections. */
static void planes_as_box(void **state)
{
    gl_fixture *f = *state;
    static uint8_t boxed[4 * PIXELS], planed[4 * PIXELS];
    for (int reconstruct = 0; reconstruct <= STP_RECONSTRUCT_LAST; reconstruct++)
        for (int r = is_left_out(reconstruct) ? ROADS : reconstruct % ROADS; r < ROADS;
             r += reconstruct == 0 ? 1 : ROADS) {
            stp_draw_params params = {
                .reconstruct = (stp_reconstruct)reconstruct, .lod = roads[r], .clip = upper};
            stp_view view = view_from(f, 18 + reconstruct);
            view.orthographic = r % 2 != 0;
            if (view.orthographic)
                view.f = 0.4 * SIZE / radius;
            gl_fixture_draw(f, &view, &params, NULL, boxed);
            params.clip.enabled = false;
            set_planes(&params, &upper.box);
            gl_fixture_draw(f, &view, &params, NULL, planed);
            assert_true(gl_fixture_covered(boxed, PIXELS) > PIXELS / 50);
            assert_memory_equal(boxed, planed, sizeof boxed);
        }
}

/* Planes cut triangles where the box does: to the pixel, but for rounding. */
static void planes_cut_triangles(void **state)
{
    (void)state;
    static uint8_t boxed[4 * PIXELS], planed[4 * PIXELS];
    static const stp_dvec3 corners[4] = {
        {-1.0, -1.0, 0.0}, {1.0, -1.0, 0.5}, {1.0, 1.0, 1.0}, {-1.0, 1.0, 0.5}};
    gl_fixture f = {0};
    stp_prep_stats stats;
    stp_triangle_set square = square_make(corners);
    check_ok(prep_shapes_run(NULL, NULL, &square, "square.stipple", 2, NULL, &stats, err));
    stp_triangle_set_clear(&square);
    gl_fixture_open(&f, "square.stipple", NULL);
    for (int splat = 0; splat < 2; splat++) {
        const stp_view view = view_from(&f, 20);
        stp_draw_params params = {.reconstruct =
                                      splat ? STP_RECONSTRUCT_SPLAT : STP_RECONSTRUCT_GAUSS,
                                  .clip = {true, {{-0.7, -0.5, 0.2}, {0.6, 3.0, 0.9}}}};
        const stp_dbox box = params.clip.box;
        size_t apart = 0;
        gl_fixture_draw(&f, &view, &params, NULL, boxed);
        params.clip.enabled = false;
        set_planes(&params, &box);
        gl_fixture_draw(&f, &view, &params, NULL, planed);
        for (int i = 0; i < PIXELS; i++)
            apart += boxed[4 * i + 3] != planed[4 * i + 3];
        assert_true(gl_fixture_covered(boxed, PIXELS) > 500);
        print_message("triangles: %zu pixels apart\n", apart);
        assert_true(apart < 12);
    }
    gl_fixture_close(&f);
}

/* One slanting plane: only what lies on its kept side is picked; and a box as well cuts away more.
 */
static void slanting_plane(void **state)
{
    gl_fixture *f = *state;
    static uint8_t rgba[4 * PIXELS], both[4 * PIXELS];
    const stp_view view = view_from(f, 20);
    const stp_dvec3 normal = {0.6, 0.0, 0.8};
    stp_draw_params params = {.planes = {{normal, stp_dvec3_dot(normal, centre)}},
                              .plane_count = 1};
    gl_fixture_draw(f, &view, &params, NULL, rgba);
    size_t hits = 0;
    for (int i = 0; i < PIXELS; i += 53) {
        stp_pick pick;
        check_ok(stp_renderer_pick(f->renderer, i % SIZE, i / SIZE, &pick, err));
        if (!pick.hit)
            continue;
        hits++;
        assert_true(stp_dvec3_dot(normal, stp_dvec3_sub(pick.position, centre)) > -pick.radius);
    }
    assert_true(hits > 20);
    params.clip = upper;
    gl_fixture_draw(f, &view, &params, NULL, both);
    for (int i = 0; i < PIXELS; i++)
        assert_true(both[4 * i + 3] == 0 || rgba[4 * i + 3] != 0);
    assert_true(gl_fixture_covered(both, PIXELS) < gl_fixture_covered(rgba, PIXELS));
}

/* A clipped picture must cover what the picture of the points clipped beforehand covers, except at
 * its edge. */
static void as_clipped_before(void **state)
{
    gl_fixture *f = *state, other = {0};
    static uint8_t rgba[4 * PIXELS], before[4 * PIXELS];
    stp_prep_stats stats;
    prep_cloud cloud = prep_cloud_wavy(COUNT, centre, radius);
    size_t kept = 0;
    for (size_t i = 0; i < COUNT; i++)
        if (inside(&upper, cloud.points[i].position))
            cloud.points[kept++] = cloud.points[i];
    cloud.count = kept;
    check_ok(prep_cloud_run(&cloud, "before.stipple", 2, NULL, &stats, err));
    gl_fixture_open(&other, "before.stipple", NULL);
    stp_view view = view_from(f, 22);
    stp_draw_params params = {.cull = STP_CULL_NONE}; /* the other file's orientations differ */
    gl_fixture_draw(&other, &view, &params, NULL, before);
    params.clip = upper;
    gl_fixture_draw(f, &view, &params, NULL, rgba);
    size_t both = 0, either = 0;
    for (size_t i = 0; i < PIXELS; i++) {
        both += rgba[4 * i + 3] && before[4 * i + 3];
        either += rgba[4 * i + 3] || before[4 * i + 3];
    }
    print_message("clipped and clipped before share %zu of %zu pixels\n", both, either);
    assert_true(either > PIXELS / 20 && both * 100 >= either * 99);
    gl_fixture_close(&other);
    free(cloud.points);
}

/* Samples outside the box are neither read nor projected. */
static void culled(void **state)
{
    (void)state;
    gl_fixture f = {0};
    static uint8_t rgba[4 * PIXELS];
    stp_draw_stats small, whole;
    gl_fixture_open(&f, "filter.stipple", NULL);
    stp_view view = view_from(&f, 21);
    stp_draw_params params = {.every_sample = true, .clip = {.enabled = true}};
    params.clip.box.min = (stp_dvec3){centre.x - 3.0, centre.y - 3.0, centre.z};
    params.clip.box.max = (stp_dvec3){centre.x + 3.0, centre.y + 3.0, INFINITY};
    gl_fixture_draw(&f, &view, &params, &small, rgba);
    uint64_t bytes = stp_renderer_bytes_read(f.renderer);
    params.clip.enabled = false;
    gl_fixture_draw(&f, &view, &params, &whole, rgba);
    assert_true(small.points_drawn > 0 && small.points_drawn * 10 < whole.points_drawn);
    assert_true(bytes < stp_renderer_bytes_read(f.renderer) || whole.chunks_drawn == 1);
    gl_fixture_close(&f);
}

/* If nothing is left to draw, every road makes an empty picture. */
static void nothing(void **state)
{
    gl_fixture *f = *state;
    static uint8_t rgba[4 * PIXELS];
    stp_view view = view_from(f, 0);
    for (int r = 0; r < ROADS; r++) {
        stp_draw_params params = {.lod = roads[r], .clip = {.enabled = true}};
        params.clip.box = (stp_dbox){centre, stp_dvec3_add(centre, (stp_dvec3){1.0, 1.0, 1.0})};
        gl_fixture_draw(f, &view, &params, NULL, rgba); /* the surface is hollow */
        assert_int_equal(gl_fixture_covered(rgba, PIXELS), 0);
        params.clip.box = (stp_dbox){{1e300, 1e300, 1e300}, {1e301, 1e301, 1e301}};
        gl_fixture_draw(f, &view, &params, NULL, rgba);
        assert_int_equal(gl_fixture_covered(rgba, PIXELS), 0);
        params = (stp_draw_params){.lod = roads[r]};
        memset(params.hidden_classes, 255, sizeof params.hidden_classes);
        gl_fixture_draw(f, &view, &params, NULL, rgba);
        assert_int_equal(gl_fixture_covered(rgba, PIXELS), 0);
    }
}

static void refused(void **state)
{
    gl_fixture *f = *state;
    stp_view view = view_from(f, 0);
    const stp_draw_params wrong[] = {
        {.clip = {true, {{0.0, 0.0, NAN}, {1.0, 1.0, 1.0}}}},
        {.clip = {true, {{0.0, 2.0, 0.0}, {1.0, 1.0, 1.0}}}},
        {.plane_count = 1},
        {.plane_count = 1, .planes = {{{0.0, 0.0, NAN}, 0.0}}},
        {.plane_count = 1, .planes = {{{0.0, 0.0, 1.0}, INFINITY}}},
        {.plane_count = 7},
        {.overlay = 1.5},
        {.overlay = NAN},
        {.edl = -1.0},
        {.edl = INFINITY},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        stp_error err = {0};
        assert_int_equal(stp_renderer_draw(f->renderer, &view, &wrong[i], NULL, &err),
                         STP_INVALID_ARGUMENT);
        assert_true(strlen(err.message) > 20);
    }
}

int main(int argc, char **argv)
{
    every_road = argc > 1 && strcmp(argv[1], "--every") == 0;
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exact),          cmocka_unit_test(roads_agree),
        cmocka_unit_test(planes_as_box),  cmocka_unit_test(planes_cut_triangles),
        cmocka_unit_test(slanting_plane), cmocka_unit_test(as_clipped_before),
        cmocka_unit_test(culled),         cmocka_unit_test(nothing),
        cmocka_unit_test(refused),
    };
    int failed = cmocka_run_group_tests(tests, open_model, close_model);
    stp_gl_context_destroy(&context);
    return failed;
}

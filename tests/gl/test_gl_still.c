/* Tests that a view at rest takes cut, sight and chosen levels from the frame before, and that
 * whatever may change them is noticed: then, too, the picture is that of a renderer which draws its
 * first. */
#include "tests/fixtures/gl_model.h"

enum { WIDTH = 160, HEIGHT = 120, BYTES = 4 * WIDTH * HEIGHT };

typedef struct pictures {
    uint8_t first[BYTES], next[BYTES];
} pictures;

static stp_view view_of(const stp_model *model, stp_dvec3 from)
{
    const stp_camera camera =
        stp_camera_around(&model->ball, from, (stp_dvec3){0.0, 0.0, 1.0}, 40.0, WIDTH, HEIGHT);
    stp_view view;
    check_ok(stp_view_create(&view, &camera, &model->ball, WIDTH, HEIGHT, err));
    return view;
}

static const stp_dvec3 front = {0.4, 0.3, 1.0}, side = {1.0, 0.2, 0.1};

/* Draws, and returns whether cut and sight were kept. */
static bool draw(const gl_fixture *f, const stp_view *view, const stp_draw_params *params,
                 stp_draw_stats *stats, uint8_t *out)
{
    gl_fixture_draw(f, view, params, stats, out);
    return stp_renderer_inspect(f->renderer).kept;
}

static void at_rest(void **state)
{
    const gl_fixture *f = *state;
    static const stp_draw_params roads[] = {
        {.lod = STP_LOD_GEOMETRY},
        {.lod = STP_LOD_COMPUTE},
        {.lod = STP_LOD_CPU},
        {.lod = STP_LOD_COMPUTE, .reconstruct = STP_RECONSTRUCT_SPLAT},
        {.lod = STP_LOD_GEOMETRY, .stream = true, .occlusion = STP_OCCLUSION_OFF},
    };
    const stp_view view = view_of(f->model, front), other = view_of(f->model, side);
    static pictures p;
    for (size_t i = 0; i < sizeof roads / sizeof *roads; i++) {
        stp_draw_params params = roads[i];
        stp_draw_stats first = {0}, next = {0};
        params.threshold_px = 2.0;
        draw(f, &other, &params, &next, p.next);
        for (int frames = 0; !first.cut_complete || frames == 1; frames++)
            draw(f, &view, &params, &first, p.first); /* one frame more: nothing is on its way */
        for (int k = 0; k < 3; k++) {
            assert_true(draw(f, &view, &params, &next, p.next));
            assert_memory_equal(p.first, p.next, BYTES);
            assert_int_equal(next.points_drawn, first.points_drawn);
            assert_int_equal(next.chunks_drawn, first.chunks_drawn);
        }
        params.threshold_px = 3.0;
        assert_false(draw(f, &view, &params, &next, p.next));
        assert_false(draw(f, &other, &params, &next, p.next));
        params.threshold_px = 2.0;
        assert_false(draw(f, &view, &params, &next, p.next));
        assert_true(!next.cut_complete || memcmp(p.first, p.next, BYTES) == 0);
    }
}

/* A picture in passes leaves little of its cut resident. */
static void little_memory(void **state)
{
    (void)state;
    gl_fixture roomy;
    model_fixture_build("plane.stipple",
                        &(model_recipe){.shape = GEN_PLANE, .point_count = 300000});
    gl_fixture_open(&roomy, "plane.stipple", NULL);
    const stp_view view = view_of(roomy.model, front);
    const stp_draw_params params = {.lod = STP_LOD_COMPUTE, .threshold_px = 0.001};
    gl_fixture little = {.model = roomy.model};
    stp_draw_stats stats = {0};
    static pictures p;
    check_ok(stp_renderer_create(&little.renderer,
                                 &(stp_renderer_params){.model = roomy.model,
                                                        .thread_count = 2,
                                                        .gpu_memory_bytes = UINT64_C(3) << 19},
                                 err));
    draw(&roomy, &view, &params, &stats, p.first);
    for (int k = 0; k < 3; k++) {
        assert_false(draw(&little, &view, &params, &stats, p.next));
        assert_true(stats.passes > 1);
        assert_memory_equal(p.first, p.next, BYTES);
    }
    stp_renderer_destroy(&little.renderer);
    gl_fixture_close(&roomy);
}

/* What an earlier picture hides may be another thing each time. */
static void occlusion(void **state)
{
    const gl_fixture *f = *state;
    const stp_view view = view_of(f->model, front);
    const stp_draw_params params = {
        .lod = STP_LOD_COMPUTE, .threshold_px = 1.0, .occlusion = STP_OCCLUSION_ON};
    stp_draw_stats stats = {0};
    static pictures p;
    draw(f, &view, &params, &stats, p.first);
    for (int k = 0; k < 3; k++) {
        assert_false(draw(f, &view, &params, &stats, p.next));
        assert_memory_equal(p.first, p.next, BYTES);
    }
}

/* What a host may change about a view at rest. */
static void change(int which, stp_draw_params *p, const stp_ball *ball)
{
    switch (which) {
    case 0:
        p->clip = (stp_clip){.enabled = true, .box = {{-1e9, -1e9, -1e9}, {1e9, 1e9, 1e9}}};
        p->clip.box.max.x = ball->centre.x;
        break;
    case 1:
        p->plane_count = 1;
        p->planes[0] = (stp_plane){{0.0, 1.0, 0.0}, ball->centre.y};
        break;
    case 2:
        p->hidden_classes[0] = 1;
        break;
    case 3:
        p->radius_cap_px = 1.5;
        break;
    case 4:
        p->terms = STP_TERM_RADIUS;
        break;
    case 5:
        p->exaggerate = 2.0;
        p->exaggerate_about = ball->centre.z;
        break;
    case 6:
        p->cull = STP_CULL_BACK;
        break;
    case 7:
        p->light[0] = 1.0;
        p->edl = 1.0;
        break;
    case 8:
        p->hidden_models = 1;
        break;
    case 9:
        p->colour = STP_COLOUR_ELEVATION;
        p->colour_range[1] = ball->radius;
        break;
    case 10:
        p->shade = STP_SHADE_LEVEL;
        break;
    case 11:
        p->every_sample = true;
        break;
    case 12:
        p->reconstruct = STP_RECONSTRUCT_TEMPLATE5;
        break;
    default:
        p->smooth_edges = true;
    }
}

enum { CHANGES = 14 };

/* Draws a view that the frame before did not have. */
static void draw_anew(const gl_fixture *f, const stp_view *view, const stp_view *other,
                      const stp_draw_params *params, uint8_t *out)
{
    stp_draw_stats stats = {0};
    draw(f, other, params, &stats, out);
    assert_false(draw(f, view, params, &stats, out));
}

/* One change after another, each with a view at rest before and after. */
static void changes(void **state)
{
    const gl_fixture *f = *state;
    static const stp_lod roads[] = {STP_LOD_GEOMETRY, STP_LOD_COMPUTE, STP_LOD_CPU};
    const stp_ball ball = stp_model_ball(f->model);
    const stp_view view = view_of(f->model, front), other = view_of(f->model, side);
    static pictures p;
    static uint8_t plain[BYTES];
    gl_fixture fresh;
    gl_fixture_open(&fresh, "model.stipple", NULL);
    for (size_t i = 0; i < sizeof roads / sizeof *roads; i++) {
        const stp_draw_params base = {.lod = roads[i], .threshold_px = 2.0};
        stp_draw_stats stats = {0};
        draw_anew(&fresh, &view, &other, &base, plain);
        draw(f, &view, &base, &stats, p.next);
        for (int which = 0; which < CHANGES; which++) {
            stp_draw_params params = base;
            change(which, &params, &ball);
            draw_anew(&fresh, &view, &other, &params, p.first);
            for (int k = 0; k < 3; k++) {
                draw(f, &view, &params, &stats, p.next);
                assert_memory_equal(p.first, p.next, BYTES);
            }
            for (int k = 0; k < 2; k++) {
                draw(f, &view, &base, &stats, p.next);
                assert_memory_equal(plain, p.next, BYTES);
            }
        }
    }
    gl_fixture_close(&fresh);
}

/* Shaders are loaded again, and models are set, between two frames of one view. */
static void other_models(void **state)
{
    gl_fixture *f = *state;
    const stp_view view = view_of(f->model, front);
    const stp_draw_params params = {.lod = STP_LOD_COMPUTE, .threshold_px = 2.0};
    stp_draw_stats stats = {0};
    stp_model *second = NULL;
    static pictures p, both;
    model_fixture_build("ball.stipple", &(model_recipe){.shape = GEN_SPHERE, .point_count = 20000});
    check_ok(stp_model_open(&second, "ball.stipple", err));
    const stp_model *const sets[3][2] = {{f->model, second}, {second, NULL}, {f->model, NULL}};
    draw(f, &view, &params, &stats, p.first);
    draw(f, &view, &params, &stats, p.first);
    check_ok(stp_renderer_reload_shaders(f->renderer, err));
    draw(f, &view, &params, &stats, p.next);
    assert_memory_equal(p.first, p.next, BYTES);
    for (int i = 0; i < 3; i++) {
        check_ok(stp_renderer_set_models(f->renderer, sets[i], i == 0 ? 2 : 1, err));
        assert_false(draw(f, &view, &params, &stats, both.first));
        assert_true(draw(f, &view, &params, &stats, both.next));
        assert_memory_equal(both.first, both.next, BYTES);
        assert_int_equal(memcmp(p.first, both.first, BYTES) == 0, i == 2);
    }
    stp_model_close(&second);
}

/* Draws, and returns how many invocations of compute shaders that took. */
static GLuint64 invocations_of(const gl_fixture *f, const stp_view *view, uint8_t *out)
{
    const stp_draw_params params = {.lod = STP_LOD_COMPUTE, .threshold_px = 2.0};
    stp_draw_stats stats = {0};
    GLuint64 count = 0;
    GLuint query = 0;
    glGenQueries(1, &query);
    glBeginQuery(GL_COMPUTE_SHADER_INVOCATIONS, query);
    draw(f, view, &params, &stats, out);
    glEndQuery(GL_COMPUTE_SHADER_INVOCATIONS);
    glGetQueryObjectui64v(query, GL_QUERY_RESULT, &count);
    glDeleteQueries(1, &query);
    return count;
}

/* Compute shaders choose levels once, and again if shaders are loaded anew. */
static void chooses_once(void **state)
{
    const gl_fixture *f = *state;
    const stp_view view = view_of(f->model, front), other = view_of(f->model, side);
    static pictures p;
    if (!epoxy_has_gl_extension("GL_ARB_pipeline_statistics_query"))
        skip();
    invocations_of(f, &other, p.first);
    for (int k = 0; k < 2; k++) {
        const GLuint64 first = invocations_of(f, &view, p.first);
        assert_true(invocations_of(f, &view, p.next) < first);
        assert_memory_equal(p.first, p.next, BYTES);
        check_ok(stp_renderer_reload_shaders(f->renderer, err));
    }
}

static int enter(void **state)
{
    return gl_model_enter(state, &(model_recipe){.shape = GEN_STATUE, .point_count = 60000});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(at_rest),       cmocka_unit_test(changes),
        cmocka_unit_test(other_models),  cmocka_unit_test(chooses_once),
        cmocka_unit_test(little_memory), cmocka_unit_test(occlusion)};
    stp_gl_context *context = gl_fixture_context();
    int failed = cmocka_run_group_tests(tests, enter, gl_model_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

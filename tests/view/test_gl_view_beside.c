/* Tests two sides beside each other: the text of --beside, the divider, what is changed on both
 * sides, and that each column of a picture is that of the side shown there. */
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/model_fixture.h"
#include "tools/draw/draw_beside.h"
#include "tools/view/view_app.h"

#include <unistd.h>

#define MODEL "view_beside.stipple"
enum { WIDTH = 150, HEIGHT = 90 };

static draw_beside parse(const char *text)
{
    draw_options first = draw_options_default();
    draw_beside b = {0};
    first.threshold_px = 2.5;
    first.reconstruct = STP_RECONSTRUCT_BOX;
    first.colour_name = first.attribute = "gps_time";
    assert_int_equal(draw_beside_parse(&b, text, &first, true), CLI_CONTINUE);
    return b;
}

static void a_text_is_a_path_and_options(void **state)
{
    (void)state;
    draw_beside b = parse("scans/my house.stipple  ");
    assert_string_equal(b.path, "scans/my house.stipple");
    assert_true(b.options.threshold_px == 2.5); /* as on the first side */
    assert_int_equal(b.options.reconstruct, STP_RECONSTRUCT_BOX);
    assert_string_equal(b.options.attribute, "gps_time");
    draw_beside_clear(&b);
    b = parse("--threshold 4 --colour elevation");
    assert_null(b.path);
    assert_true(b.options.threshold_px == 4.0 && b.options.has_threshold);
    assert_int_equal(b.options.reconstruct, STP_RECONSTRUCT_BOX);
    assert_int_equal(b.options.colour, STP_COLOUR_ELEVATION);
    assert_null(b.options.attribute);
    draw_beside_clear(&b);
    b = parse("a b-c.stipple   --where 'return == 1 && class!=7'  --lod=cpu --classes \"2,3\"");
    assert_string_equal(b.path, "a b-c.stipple");
    assert_string_equal(b.options.where, "return == 1 && class!=7");
    assert_string_equal(b.options.classes, "2,3");
    assert_int_equal(b.options.lod, STP_LOD_CPU);
    draw_beside_clear(&b);
    assert_null(b.text);
}

static void other_texts_are_refused(void **state)
{
    (void)state;
    const draw_options first = draw_options_default();
    static const char *const texts[] = {
        "--threshold",         "--threshold x",    "--threshold -1",  "--where 'a",
        "--where a<",          "--eye 1,2,3",      "--camera c.json", "--size 20x20",
        "--view whole",        "--gpu-memory 1G",  "--cpu-memory 1G", "--no-cache",
        "--shaders s",         "--exaggerate 2",   "--none",          "--lod cpu b.stipple",
        "a.stipple --lod gpu", "--beside --lod 1", "--aa 2",          "--fps 3",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        draw_beside b = {0};
        const int code = draw_beside_parse(&b, texts[i], &first, true);
        if (code != CLI_USAGE && code != CLI_FAILED)
            fail_msg("'%s' gives %d", texts[i], code);
        assert_null(b.text);
    }
    char many[256] = "--classes 2";
    memset(many + strlen(many), ' ', sizeof many - strlen(many) - 1);
    for (size_t i = 12; i < sizeof many - 1; i += 2)
        many[i] = 'a';
    draw_beside b = {0};
    assert_int_equal(draw_beside_parse(&b, many, &first, true), CLI_USAGE);
}

static void the_divider_stays_in_the_picture(void **state)
{
    (void)state;
    view_divider d = {.at = 0.5};
    assert_int_equal(view_divider_column(&d, 100), 50);
    assert_int_equal(view_divider_column(&d, 1), 1);
    assert_int_equal(view_divider_side(&d, 100, 49.9), 0);
    assert_int_equal(view_divider_side(&d, 100, 50.0), 1);
    assert_false(view_divider_take(&d, 100, 57.0, 6.0));
    assert_false(d.dragged);
    assert_true(view_divider_take(&d, 100, 53.0, 6.0)); /* keeps its 3 pixels from the cursor */
    view_divider_drag(&d, 100, 73.0);
    assert_int_equal(view_divider_column(&d, 100), 70);
    assert_int_equal(view_divider_column(&d, 1000), 700); /* a share, whatever the width */
    view_divider_drag(&d, 100, -40.0);
    assert_int_equal(view_divider_column(&d, 100), 0);
    view_divider_drag(&d, 100, 400.0);
    assert_int_equal(view_divider_column(&d, 100), 100);
    for (int i = 0; i < 30; i++)
        view_divider_step(&d, -0.05);
    assert_true(d.at == 0.0);
    view_divider_step(&d, 0.05);
    assert_int_equal(view_divider_column(&d, 100), 5);
    d.swapped = true;
    assert_int_equal(view_divider_side(&d, 100, 4.0), 1);
    assert_int_equal(view_divider_side(&d, 100, 5.0), 0);
    d.shows = VIEW_DIVIDER_LEFT;
    assert_int_equal(view_divider_side(&d, 100, 99.0), 1);
    assert_false(view_divider_take(&d, 100, 100.0, 6.0));
    d.shows = VIEW_DIVIDER_RIGHT;
    assert_int_equal(view_divider_side(&d, 100, 0.0), 0);
    view_divider_step(&d, 0.05);
    assert_int_equal(d.shows, VIEW_DIVIDER_BOTH);
}

/* A viewer with two sides and no window. */
static viewer *two_sides(void)
{
    static viewer v;
    static draw_options options[2];
    v = (viewer){.options = &options[0], .beside = {.other = {.options = &options[1]}}};
    v.beside.divider.at = 0.5;
    v.control.params = v.beside.params = (stp_draw_params){.threshold_px = 1.0, .edl = 0.5};
    v.beside.params.threshold_px = 4.0;
    view_beside_link(&v);
    return &v;
}

static void what_was_alike_stays_alike(void **state)
{
    (void)state;
    viewer *v = two_sides();
    stp_draw_params *here = &v->control.params;
    here->threshold_px = 2.0;
    here->reconstruct = STP_RECONSTRUCT_SPLAT;
    here->hidden_classes[3] = 8;
    here->clip.box.max.z = 3.0;
    view_beside_link(v);
    const stp_draw_params *there = &v->beside.params;
    assert_true(there->threshold_px == 4.0); /* was different before */
    assert_int_equal(there->reconstruct, STP_RECONSTRUCT_SPLAT);
    assert_int_equal(there->hidden_classes[3], 8);
    assert_true(there->clip.box.max.z == 3.0);
    assert_int_equal(view_beside_use(v, 1), 0);
    assert_true(here->threshold_px == 4.0 && there->threshold_px == 2.0);
    here->edl = 0.0;
    here->threshold_px = 2.0; /* alike now: the next change is for both */
    assert_int_equal(view_beside_use(v, 0), 1);
    assert_true(here->edl == 0.0 && here->threshold_px == 2.0);
    here->threshold_px = 8.0;
    view_beside_link(v);
    assert_true(there->threshold_px == 8.0);
    v->beside.apart = true;
    here->threshold_px = 1.0;
    here->shade = STP_SHADE_NORMAL;
    view_beside_link(v);
    assert_true(there->threshold_px == 8.0 && there->shade == STP_SHADE_PHONG);
    v->beside.apart = false;
    view_beside_link(v); /* brings nothing later */
    assert_int_equal(there->shade, STP_SHADE_PHONG);
}

static void sides_are_named_by_what_differs(void **state)
{
    (void)state;
    viewer *v = two_sides();
    char name[VIEW_SIDE_NAME];
    v->control.params.lod = STP_LOD_CPU;
    view_beside_name(v, name);
    assert_string_equal(name, "threshold 1 px, levels cpu");
    view_beside_use(v, 1); /* has cpu, too, by now */
    view_beside_name(v, name);
    assert_string_equal(name, "threshold 4 px");
    v->beside.apart = true;
    v->control.params.every_sample = true;
    v->control.params.colour = STP_COLOUR_CLASS;
    v->control.params.smooth_edges = true;
    v->control.params.edl = 2.0;
    view_beside_name(v, name);
    assert_string_equal(name, "every sample, class, smooth edges, eye-dome 2");
    view_beside_use(v, 0);
    view_beside_name(v, name);
    assert_string_equal(name, "threshold 1 px, rgb, hard edges, eye-dome 0.5");
    v->control.params.grid_draw = STP_GRID_POINTS;
    view_beside_name(v, name);
    assert_string_equal(name, "threshold 1 px, rgb, grids as points, hard edges, eye-dome 0.5");
}

static void stripes_cover_a_picture_once(void **state)
{
    (void)state;
    viewer *v = two_sides();
    char names[2]; /* the renderers are only compared */
    stp_renderer *const renderers[2] = {(stp_renderer *)&names[0], (stp_renderer *)&names[1]};
    v->renderer = renderers[0];
    v->beside.other.renderer = renderers[1];
    for (int i = 0; i < 2 * 2 * 3 * 5; i++) {
        view_divider *d = &v->beside.divider;
        view_stripe stripes[2];
        view_beside_use(v, i % 2);
        *d = (view_divider){.at = i / 12 * 0.25, .shows = i / 4 % 3, .swapped = i / 2 % 2 != 0};
        for (int width = 1; width < 40; width += 6) {
            const int count = view_beside_stripes(v, width, stripes);
            int x = 0;
            v->layout.picture_width = width;
            for (int k = 0; k < count; k++) {
                assert_int_equal(stripes[k].begin, x);
                for (; x < stripes[k].end; x++) {
                    const int side = view_divider_side(d, width, x);
                    assert_ptr_equal(stripes[k].renderer, renderers[side]);
                    assert_ptr_equal(view_beside_renderer(v, x), renderers[side]);
                    assert_true(stripes[k].params.threshold_px == (side == 0 ? 1.0 : 4.0));
                }
            }
            assert_int_equal(x, width);
        }
    }
}

static stp_view whole_view(const stp_model *model)
{
    const stp_ball ball = stp_model_ball(model);
    const stp_camera camera = stp_model_camera(model, STP_HOME_WHOLE, WIDTH, HEIGHT);
    stp_view view;
    check_ok(stp_view_create(&view, &camera, &ball, WIDTH, HEIGHT, err));
    return view;
}

/* Makes a screenshot of these stripes. */
static void take_shot(const stp_view *view, const view_stripe *stripes, int count,
                      uint8_t rgba[4 * WIDTH * HEIGHT])
{
    view_shot shot = {0};
    unlink("beside.png");
    check_ok(view_shot_begin(&shot, view, "beside.png", err));
    check_ok(view_shot_draw(&shot, stripes, count, err));
    view_shot_end(&shot); /* waits for the file */
    stp_image image = {0};
    check_ok(stp_image_load(&image, "beside.png", err));
    memcpy(rgba, image.rgba, 4 * WIDTH * HEIGHT);
    stp_image_destroy(&image);
    unlink("beside.png");
}

/* Of two settings, a framebuffer and a screenshot have the columns of each setting alone. */
static void columns_are_those_of_their_side(void **state)
{
    (void)state;
    static uint8_t drawn[2][4 * WIDTH * HEIGHT], shots[2][4 * WIDTH * HEIGHT],
        shown[4 * WIDTH * HEIGHT], shot[4 * WIDTH * HEIGHT];
    gl_fixture f[2] = {{0}};
    view_stripe stripes[2] = {{.end = 67}, {.begin = 67, .end = WIDTH}};
    GLuint frame = 0, texture = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    glTextureStorage2D(texture, 1, GL_RGBA8, WIDTH, HEIGHT);
    glCreateFramebuffers(1, &frame);
    glNamedFramebufferTexture(frame, GL_COLOR_ATTACHMENT0, texture, 0);
    for (int i = 0; i < 2; i++) {
        view_stripe alone = {.end = WIDTH};
        gl_fixture_open(&f[i], MODEL, NULL);
        const stp_view view = whole_view(f[i].model);
        stripes[i].renderer = alone.renderer = f[i].renderer;
        stripes[i].params.lod = STP_LOD_CPU;
        stripes[i].params.shade = i == 0 ? STP_SHADE_PHONG : STP_SHADE_NORMAL;
        alone.params = stripes[i].params;
        take_shot(&view, &alone, 1, shots[i]);
        gl_fixture_draw(&f[i], &view, &alone.params, NULL, drawn[i]);
        stp_renderer_present_columns(f[i].renderer, frame, WIDTH, HEIGHT, stripes[i].begin,
                                     stripes[i].end);
    }
    glGetTextureImage(texture, 0, GL_RGBA, GL_UNSIGNED_BYTE, sizeof shown, shown);
    const stp_view view = whole_view(f[0].model);
    take_shot(&view, stripes, 2, shot);
    assert_true(memcmp(drawn[0], drawn[1], sizeof drawn[0]) != 0);
    for (size_t i = 0; i < sizeof shown; i++) {
        const int side = i / 4 % WIDTH >= 67;
        assert_int_equal(shown[i], drawn[side][i]);
        assert_int_equal(shot[i], shots[side][i]);
    }
    glDeleteFramebuffers(1, &frame);
    glDeleteTextures(1, &texture);
    gl_fixture_close(&f[0]);
    gl_fixture_close(&f[1]);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const model_recipe sphere = {.shape = GEN_SPHERE, .point_count = 30000, .true_normals = true};
    model_fixture_build(MODEL, &sphere);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_text_is_a_path_and_options),
        cmocka_unit_test(other_texts_are_refused),
        cmocka_unit_test(the_divider_stays_in_the_picture),
        cmocka_unit_test(what_was_alike_stays_alike),
        cmocka_unit_test(sides_are_named_by_what_differs),
        cmocka_unit_test(stripes_cover_a_picture_once),
        cmocka_unit_test(columns_are_those_of_their_side),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    unlink(MODEL);
    stp_gl_context_destroy(&context);
    return failed;
}

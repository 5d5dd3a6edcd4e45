/* Tests the panels' shim without a window: typed text stays in its field, quick clicks count,
 * pictures and OpenGL's state stay untouched, and text is legible at any scale of the screen. */
#include "tests/fixtures/gl_fixture.h"

#include "runtime/window/imgui_marks_shim.h"

enum { WIDTH = 400, HEIGHT = 300 };

/* The target of drawing: without a display there is no framebuffer 0. */
typedef struct target {
    GLuint texture, frame;
} target;

static int make_target(void **state)
{
    static target t;
    glCreateTextures(GL_TEXTURE_2D, 1, &t.texture);
    glTextureStorage2D(t.texture, 1, GL_RGBA8, WIDTH, HEIGHT);
    glCreateFramebuffers(1, &t.frame);
    glNamedFramebufferTexture(t.frame, GL_COLOR_ATTACHMENT0, t.texture, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, t.frame);
    *state = &t;
    return 0;
}

static int delete_target(void **state)
{
    const target *t = *state;
    glDeleteFramebuffers(1, &t->frame);
    glDeleteTextures(1, &t->texture);
    return 0;
}

typedef struct panel {
    stp_ui *ui;
    char text[32];
    double number;
    bool checked, open;
    int pressed, taken;
} panel;

/* Draws a panel of fixed rows. The tests find the rows' places by trying. */
static void frame(panel *p)
{
    const stp_ui_rect rect = {200.0, 0.0, 200.0, HEIGHT};
    stp_ui_begin(p->ui, WIDTH, HEIGHT, 0.02);
    stp_ui_draw_line(10.0, 10.0, 100.0, 100.0, 0xff0000ffu, 3.0);
    stp_ui_draw_label(20.0, 200.0, "a label", 0xffffffffu, false);
    if (stp_ui_panel_begin("panel", &rect)) {
        if (stp_ui_section("section", &p->open)) {
            stp_ui_row("label", "value");
            p->taken += stp_ui_field("##field", p->text, sizeof p->text);
            p->pressed += stp_ui_button("button");
            stp_ui_check("check", &p->checked);
            stp_ui_number("number", &p->number, "%.3f");
        }
    }
    stp_ui_panel_end();
    stp_ui_end(p->ui);
}

/* A press and a release that arrive together, as a queue of events may bring them: each needs a
 * frame. */
static void click(panel *p, double x, double y)
{
    stp_ui_pointer(p->ui, x, y);
    frame(p);
    stp_ui_button_down(p->ui, 0, true);
    frame(p);
    stp_ui_button_down(p->ui, 0, false);
    frame(p);
}

static void type(panel *p, const char *text)
{
    for (; *text != '\0'; text++)
        stp_ui_character(p->ui, (unsigned char)*text);
    frame(p);
}

static panel open_panel(double scale)
{
    panel p = {.open = true, .text = "old"};
    check_ok(stp_ui_create(&p.ui, scale, NULL, err));
    frame(&p);
    frame(&p);
    return p;
}

static void keys_belong_to_the_field(void **state)
{
    (void)state;
    panel p = open_panel(1.0);
    assert_false(stp_ui_wants_keys(p.ui));
    double y = 10.0;
    for (; y < HEIGHT && !stp_ui_wants_keys(p.ui); y += 4.0) {
        p.open = true; /* a click may have closed the heading */
        click(&p, 260.0, y);
    }
    assert_true(stp_ui_wants_keys(p.ui)); /* some row is the field */
    stp_ui_key_down(p.ui, STP_UI_KEY_END, true, false, false);
    frame(&p);
    stp_ui_key_down(p.ui, STP_UI_KEY_END, false, false, false);
    type(&p, "wasdq");
    assert_true(stp_ui_wants_keys(p.ui));
    stp_ui_key_down(p.ui, STP_UI_KEY_ENTER, true, false, false);
    frame(&p);
    stp_ui_key_down(p.ui, STP_UI_KEY_ENTER, false, false, false);
    frame(&p);
    frame(&p);
    assert_false(stp_ui_wants_keys(p.ui));
    assert_string_equal(p.text, "oldwasdq");
    assert_int_equal(p.taken, 1);
    stp_ui_destroy(&p.ui);
    assert_null(p.ui);
}

static void clicks_find_widgets(void **state)
{
    (void)state;
    panel p = open_panel(1.0);
    for (double y = 2.0; y < HEIGHT && !p.checked; y += 4.0) {
        p.open = true; /* as above */
        click(&p, 225.0, y);
    }
    assert_true(p.checked);
    assert_true(p.pressed > 0);
    stp_ui_pointer(p.ui, 300.0, 50.0);
    assert_true(stp_ui_wants_pointer(p.ui));
    stp_ui_pointer(p.ui, 100.0, 50.0); /* beside the panel, without a frame */
    assert_false(stp_ui_wants_pointer(p.ui));
    stp_ui_destroy(&p.ui);
}

static void marks_are_drawn_and_state_is_kept(void **state)
{
    const target *t = *state;
    const float clear[4] = {0.0f, 0.0f, 0.0f, 1.0f};
    GLint clip = 0, bound = 0;
    uint8_t *rgba = calloc((size_t)WIDTH * HEIGHT, 4);
    assert_non_null(rgba);
    glClearNamedFramebufferfv(t->frame, GL_COLOR, 0, clear);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    panel p = open_panel(1.0);
    glGetTextureImage(t->texture, 0, GL_RGBA, GL_UNSIGNED_BYTE, 4 * WIDTH * HEIGHT, rgba);
    const uint8_t *on_line = rgba + 4 * ((HEIGHT - 1 - 50) * WIDTH + 50);
    const uint8_t *beside = rgba + 4 * ((HEIGHT - 1 - 50) * WIDTH + 150);
    const uint8_t *in_panel = rgba + 4 * ((HEIGHT - 1 - 280) * WIDTH + 390);
    assert_true(on_line[0] > 200 && on_line[1] < 50);
    assert_int_equal(beside[0] + beside[1] + beside[2], 0);
    assert_true(in_panel[0] + in_panel[1] + in_panel[2] > 0);
    glGetIntegerv(GL_CLIP_DEPTH_MODE, &clip);
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound);
    assert_int_equal(clip, GL_ZERO_TO_ONE);
    assert_int_equal(bound, t->frame);
    assert_true(glIsEnabled(GL_DEPTH_TEST));
    check_ok(stp_gl_check("drawing panels", err));
    stp_ui_destroy(&p.ui);
    free(rgba);
}

/* A panel of this width with one row. */
static void draw_row(const target *t, stp_ui *ui, double width, const char *value,
                     uint8_t rgba[4 * WIDTH * HEIGHT])
{
    const float clear[4] = {0.0f, 0.0f, 0.0f, 1.0f};
    const stp_ui_rect rect = {0.0, 0.0, width, HEIGHT};
    for (int turn = 0; turn < 3; turn++) {
        glClearNamedFramebufferfv(t->frame, GL_COLOR, 0, clear);
        stp_ui_begin(ui, WIDTH, HEIGHT, 0.02);
        if (stp_ui_panel_begin("panel", &rect))
            stp_ui_row("to", value);
        stp_ui_panel_end();
        stp_ui_end(ui);
    }
    glGetTextureImage(t->texture, 0, GL_RGBA, GL_UNSIGNED_BYTE, 4 * WIDTH * HEIGHT, rgba);
}

/* Where two numbers do not fit beside each other, the second one begins a line, even if its first
 * digits would fit. */
static void rows_keep_numbers_whole(void **state)
{
    static uint8_t found[4 * WIDTH * HEIGHT], expected[4 * WIDTH * HEIGHT];
    stp_ui *ui = NULL;
    check_ok(stp_ui_create(&ui, 1.0, NULL, err));
    draw_row(*state, ui, 200.0, "", found);
    const double text = stp_ui_text_height();
    for (double column = 7.0; column < 11.0; column += 0.2) {
        const double width = column * text / 0.64 + 10.0; /* 64 % of what the padding leaves */
        draw_row(*state, ui, width, "456123.250  5428001.125", found);
        draw_row(*state, ui, width, "456123.250 \n5428001.125", expected);
        assert_memory_equal(found, expected, sizeof found);
    }
    stp_ui_destroy(&ui);
}

/* A long text is wrapped, and the bar is as high as the text needs. */
static void a_bar_holds_its_text(void **state)
{
    const target *t = *state;
    static uint8_t rgba[4 * WIDTH * HEIGHT];
    const char *const text = "Parts of the model cannot be read: the server answers 503";
    const double widths[2] = {WIDTH, 0.25 * WIDTH};
    double heights[2];
    stp_ui *ui = NULL;
    check_ok(stp_ui_create(&ui, 1.0, NULL, err));
    for (int i = 0; i < 2; i++) {
        const float clear[4] = {0.0f, 0.0f, 0.0f, 1.0f};
        const stp_ui_rect rect = {0.0, 0.0, widths[i], HEIGHT};
        glClearNamedFramebufferfv(t->frame, GL_COLOR, 0, clear);
        stp_ui_begin(ui, WIDTH, HEIGHT, 0.02);
        heights[i] = stp_ui_draw_bar(&rect, text);
        stp_ui_end(ui);
        glGetTextureImage(t->texture, 0, GL_RGBA, GL_UNSIGNED_BYTE, sizeof rgba, rgba);
        const int below = (int)heights[i] + 2;
        const uint8_t *corner = rgba + 4 * ((HEIGHT - 1 - 1) * WIDTH + 1);
        const uint8_t *under = rgba + 4 * ((HEIGHT - 1 - below) * WIDTH + 1);
        assert_true(corner[0] > 100 && corner[1] < 60);
        assert_int_equal(under[0], 0);
    }
    assert_true(heights[1] > 2.0 * heights[0]);
    stp_ui_destroy(&ui);
}

static void text_follows_the_scale(void **state)
{
    (void)state;
    double heights[3] = {0.0};
    const double scales[3] = {1.0, 2.0, 1.5};
    panel p = open_panel(1.0);
    for (int i = 0; i < 3; i++) {
        stp_ui_set_scale(p.ui, scales[i]);
        frame(&p);
        heights[i] = stp_ui_text_height();
    }
    assert_true(heights[1] > 1.7 * heights[0]);
    assert_true(heights[2] >= heights[0] && heights[2] <= heights[1]);
    stp_ui_destroy(&p.ui);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keys_belong_to_the_field),
        cmocka_unit_test(clicks_find_widgets),
        cmocka_unit_test(marks_are_drawn_and_state_is_kept),
        cmocka_unit_test(rows_keep_numbers_whole),
        cmocka_unit_test(a_bar_holds_its_text),
        cmocka_unit_test(text_follows_the_scale),
    };
    int failed = cmocka_run_group_tests(tests, make_target, delete_target);
    stp_gl_context_destroy(&context);
    return failed;
}

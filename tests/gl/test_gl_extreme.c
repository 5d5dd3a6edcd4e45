/* Tests extreme discs in every mode and both projections: back faces, grazing discs, discs larger
 * than the screen, around and behind the eye, without radius, without normal. No buffer may hold a
 * value that is not a number. No pixel outside a disc's ellipse may be covered; the test finds the
 * ellipse by meeting rays with planes in double.
 *
 * A software rasteriser needs minutes for all of it. The two wider templates are one shader with
 * template3: the test judges each in half of the scenes. It judges each mode in one projection:
 * gauss in perspective, box, which has the same shaders but for the weights, orthographic, only
 * template3 and splats in both. It judges each disc alone in a quarter of a mode's views, and all
 * discs together by one of the four roads in each view. With the argument --every, as in
 * long_gl_extreme, it leaves out nothing. */
#include "tests/fixtures/disc_judge.h"
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"

enum {
    DISCS_LIMIT = 24,
    WIDTH = 262,
    HEIGHT = 90
}; /* wider than the largest point of some drivers */

typedef struct scene {
    fixture_disc discs[DISCS_LIMIT];
    uint32_t count;
} scene;

typedef enum projections { PERSPECTIVE = 1, ORTHOGRAPHIC = 2, BOTH = 3 } projections;

static const struct {
    const char *name;
    double floor_px, radius_part; /* shaders/README.md, The ellipse, Templates, Splatting */
    projections projections;      /* judged without --every */
} modes[] = {
    [STP_RECONSTRUCT_GAUSS] = {"gauss", 1.25, 1.0, PERSPECTIVE},
    [STP_RECONSTRUCT_BOX] = {"box", 1.25, 1.0, ORTHOGRAPHIC},
    [STP_RECONSTRUCT_TEMPLATE3] = {"template3", 0.75, 0.85, BOTH},
    [STP_RECONSTRUCT_TEMPLATE5] = {"template5", 0.75, 0.85, PERSPECTIVE},
    [STP_RECONSTRUCT_TEMPLATE7] = {"template7", 0.75, 0.85, PERSPECTIVE},
    [STP_RECONSTRUCT_SPLAT] = {"splat", 0.75, 0.85, BOTH},
    [STP_RECONSTRUCT_POINTS] = {"points", 0.0, 0.0, PERSPECTIVE},
};

static const int sizes[][2] = {{WIDTH, HEIGHT}, {61, 97}, {1, 1}};

/* ---- scenes ---- */

/* At depth 2 the widest picture holds x of +-4/3 and y of +-TALL. add() takes y in units of
 * TALL. */
#define TALL (4.0 / 3.0 * HEIGHT / WIDTH)

static fixture_disc *add(scene *s, double x, double y, double depth, double radius)
{
    assert_true(s->count < DISCS_LIMIT);
    fixture_disc *disc = &s->discs[s->count++];
    *disc = (fixture_disc){.position = {x, TALL * y, -depth},
                           .normal = {0.0, 0.0, 1.0},
                           .radius = radius,
                           .oriented = true};
    return disc;
}

/* Turns a disc so that its normal lies `degrees` off the ray to the eye, towards `azimuth`. */
static void turn(fixture_disc *disc, double degrees, double azimuth)
{
    stp_dvec3 w = stp_dvec3_normalize(disc->position);
    stp_dvec3 a = stp_dvec3_normalize(stp_dvec3_cross(w, (stp_dvec3){0.0, 1.0, 0.1}));
    stp_dvec3 b = stp_dvec3_cross(a, w);
    stp_dvec3 across =
        stp_dvec3_add(stp_dvec3_scale(a, cos(azimuth)), stp_dvec3_scale(b, sin(azimuth)));
    double angle = degrees * M_PI / 180.0;
    disc->normal =
        stp_dvec3_add(stp_dvec3_scale(w, -cos(angle)), stp_dvec3_scale(across, sin(angle)));
}

static void make_facing(scene *s)
{
    static const double radius[] = {0.0002, 0.004, 0.01, 0.03, 0.1, 0.3, 0.6};
    for (int i = 0; i < 14; i++) {
        double x = 0.9 * cos(2.4 * i), y = 0.7 * sin(2.4 * i);
        turn(add(s, x, y, 2.0 + 0.01 * i, radius[i % 7]), i < 7 ? 0.0 : 8.0 * (i - 7), i);
    }
}

static void make_back(scene *s)
{
    for (int i = 0; i < 12; i++) {
        fixture_disc *disc = add(s, 0.8 * cos(i), 0.7 * sin(i), 2.0, i % 2 ? 0.3 : 0.05);
        turn(disc, 180.0 - 7.0 * i, i);
        disc->oriented = i % 4 < 3;
        disc->kind = i % 4 == 2 ? STP_KIND_RIBBON : STP_KIND_SURFACE;
    }
}

static void make_grazing(scene *s)
{
    static const double degrees[] = {80.0, 88.0, 89.5, 89.99, 90.0, 91.0};
    for (int i = 0; i < 18; i++) {
        fixture_disc *disc = add(s, 0.8 * sin(2.0 * i), 0.6 * cos(3.0 * i), 2.0, i % 3 ? 0.4 : 0.1);
        turn(disc, degrees[i % 6], 0.7 * i);
        disc->oriented = i >= 12;
    }
    fixture_disc *edge = add(s, 0.0, 0.0, 2.0, 0.5); /* exactly along the axis */
    edge->normal = (stp_dvec3){0.0, 1.0, 0.0};
    edge->oriented = false;
    *add(s, 0.0, 0.0, 2.0, 0.5) = *edge;
    s->discs[s->count - 1].normal = (stp_dvec3){1.0, 0.0, 0.0};
}

static void make_large(scene *s)
{
    static const double radius[] = {1.9, 6.0, 400.0};
    static const double degrees[] = {0.0, 30.0, 60.0, 80.0, 89.0, 89.9};
    for (int i = 0; i < 18; i++) {
        fixture_disc *disc = add(s, 0.9 * cos(i), 0.6 * sin(i), 2.0, radius[i / 6]);
        turn(disc, degrees[i % 6], 1.3 * i);
        disc->oriented = i % 2;
    }
}

static void make_behind(scene *s)
{
    static const double depth[] = {-3.0, -0.2, 0.0, 1e-3, 0.02, 0.1};
    for (int i = 0; i < 18; i++) {
        double at = depth[i % 6];
        fixture_disc *disc = add(s, 0.2 * at, i < 6 ? 0.0 : 0.1 * at, at, i % 4 ? 1.0 : 0.05);
        if (i >= 6 && at != 0.0)
            turn(disc, 5.0 * i, i);
        disc->oriented = i >= 12;
    }
}

static void make_no_radius(scene *s)
{
    for (int i = 0; i < 12; i++) {
        fixture_disc *disc = add(s, 0.6 * cos(i), 0.6 * sin(i), i % 3 ? 2.0 : 0.5, 0.0);
        turn(disc, 9.0 * i, i);
        disc->oriented = i % 2;
        disc->kind = (stp_sample_kind)(i / 3);
    }
}

static void make_no_normal(scene *s)
{
    static const double radius[] = {0.0, 0.001, 0.05, 0.4, 3.0, 100.0};
    for (int i = 0; i < 18; i++) {
        fixture_disc *disc = add(s, 0.9 * cos(2.0 * i), 0.6 * sin(2.0 * i), 2.0, radius[i % 6]);
        disc->normal = (stp_dvec3){0.0, 0.0, 0.0};
        disc->oriented = i % 2; /* means nothing here */
        disc->kind = (stp_sample_kind)(i / 6);
    }
}

static void make_lines(scene *s)
{
    static const double radius[] = {0.001, 0.02, 0.3, 5.0};
    for (int i = 0; i < 16; i++) {
        fixture_disc *disc = add(s, 0.9 * cos(i), 0.7 * sin(i), 2.0, radius[i % 4]);
        turn(disc, 30.0 * (i / 2), i); /* tangents along the ray too, both ways */
        disc->oriented = false;
        disc->kind = i % 3 ? STP_KIND_TUBE : STP_KIND_RIBBON;
    }
}

static void make_rim(scene *s)
{
    static const double place[] = {-1.0, -0.9999, 0.0, 0.9999, 1.0, 1.0001};
    for (int i = 0; i < 18; i++) {
        double aside = i < 6 ? 0.0 : place[(i + i / 6) % 6];
        fixture_disc *disc = add(s, 4.0 / 3.0 * (i % 2 ? place[i % 6] : aside),
                                 i % 2 ? aside : place[i % 6], 2.0, i % 3 ? 0.2 : 0.01);
        turn(disc, 5.0 * i, i);
        disc->oriented = false;
    }
}

/* ---- one disc ---- */

/* Sets up the judge for what a mode draws of the disc; returns false if the disc is not visible. */
static bool judge_of(const stp_view *view, const fixture_disc *disc, int mode, disc_judge *out)
{
    stp_dvec3 w =
        view->orthographic ? (stp_dvec3){0.0, 0.0, -1.0} : stp_dvec3_normalize(disc->position);
    bool known = stp_dvec3_length(disc->normal) > 0.0;
    bool line = disc->kind == STP_KIND_RIBBON || disc->kind == STP_KIND_TUBE;
    bool point = disc->kind == STP_KIND_SURFACE || (line && mode == STP_RECONSTRUCT_SPLAT);
    double part = point ? modes[mode].radius_part : 1.0;
    *out =
        (disc_judge){view, disc->position, disc->normal, part * disc->radius, modes[mode].floor_px};
    if (!known)
        out->normal = stp_dvec3_scale(w, -1.0);
    if (disc->kind == STP_KIND_TUBE)
        out->normal = (stp_dvec3){0.0, 0.0, 0.0};
    return !(known && disc->oriented && stp_dvec3_dot(disc->normal, w) >= REFERENCE_CULL_COSINE) &&
           -disc->position.z > view->near_depth;
}

/* The pixel that holds a disc's centre, or -1. */
static int own_pixel(const stp_view *view, const fixture_disc *disc)
{
    stp_dvec3 p = stp_view_project(view, disc->position);
    if (!(p.x >= 0.0 && p.y >= 0.0 && p.x < view->width && p.y < view->height))
        return -1;
    return (int)p.y * view->width + (int)p.x;
}

/* Marks the pixels that a disc may cover; returns whether there are any. */
static bool allow(const stp_view *view, const fixture_disc *disc, int mode, uint8_t *cover)
{
    disc_judge judge;
    int own = own_pixel(view, disc);
    if (!judge_of(view, disc, mode, &judge) || own < 0)
        return false;
    if (mode != STP_RECONSTRUCT_POINTS && disc->radius > 0.0)
        disc_judge_cover(&judge, cover);
    cover[own] = cover[own] == 0 ? DISC_WITHIN_FLOOR : cover[own];
    return true;
}

typedef struct tally {
    size_t inside, covered_inside, outside;
} tally;

static tally compare(const reference_pixel *pixels, const uint8_t *cover, int count)
{
    tally sum = {0};
    for (int i = 0; i < count; i++) {
        sum.inside += cover[i] == DISC_INSIDE;
        sum.covered_inside += cover[i] == DISC_INSIDE && pixels[i].tag != 0;
        sum.outside += cover[i] == DISC_OUTSIDE && pixels[i].tag != 0;
    }
    return sum;
}

/* ---- buffers ---- */

static void check_floats(GLuint texture, GLenum format, int channels, size_t count,
                         const char *what)
{
    float *values = calloc(count * (size_t)channels, sizeof *values);
    assert_non_null(values);
    glGetTextureImage(texture, 0, format, GL_FLOAT,
                      (GLsizei)(count * (size_t)channels * sizeof *values), values);
    check_ok(stp_gl_check("reading a buffer", err));
    for (size_t i = 0; i < count * (size_t)channels; i++)
        if (!isfinite(values[i]))
            fail_msg("%s has %g at %zu", what, (double)values[i], i);
    free(values);
}

static void check_pixel(const uint32_t shape[4], const uint32_t paint[4], const char *mode,
                        int width, int x, int y)
{
    reference_pixel p = gl_fixture_pixel(shape, paint);
    bool good = isfinite(p.radius) && isfinite(p.z_min) && isfinite(p.z_max) && isfinite(p.dx) &&
                isfinite(p.dy) && p.radius >= 0.0 && p.z_min > 0.0 && p.z_max >= p.z_min &&
                fabs(stp_dvec3_length(p.normal) - 1.0) < 1e-6;
    for (int k = 0; k < 3; k++)
        good &= p.rgb[k] > 0.99; /* all discs are white */
    if (!good)
        fail_msg("%s, pixel %d %d of a level %d wide: radius %g, depth %g to %g, d %g %g, colour "
                 "%g %g %g",
                 mode, x, y, width, p.radius, p.z_min, p.z_max, p.dx, p.dy, p.rgb[0], p.rgb[1],
                 p.rgb[2]);
}

/* Reads the texels of a texture, which may be wider than its level; free them with free(). */
static uint32_t *read_texels(GLuint texture, int *width)
{
    int height;
    glGetTextureLevelParameteriv(texture, 0, GL_TEXTURE_WIDTH, width);
    glGetTextureLevelParameteriv(texture, 0, GL_TEXTURE_HEIGHT, &height);
    size_t count = (size_t)*width * (size_t)height;
    uint32_t *texels = calloc(count, 16);
    assert_non_null(texels);
    glGetTextureImage(texture, 0, GL_RGBA_INTEGER, GL_UNSIGNED_INT, (GLsizei)(16 * count), texels);
    check_ok(stp_gl_check("reading pixels", err));
    return texels;
}

/* Every pixel of a level must be invalid or have plausible numbers. */
static void check_level(const stp_pyramid_level *level, const GLuint *textures, const char *mode)
{
    int width = 0;
    uint32_t *shape = read_texels(textures[STP_TARGET_SHAPE], &width);
    uint32_t *paint = read_texels(textures[STP_TARGET_PAINT], &width);
    for (int y = 0; y < level->height; y++)
        for (int x = 0; x < level->width; x++) {
            size_t i = 4 * ((size_t)y * (size_t)width + (size_t)x);
            if (paint[i + 3] >> 16 != 0)
                check_pixel(shape + i, paint + i, mode, level->width, x, y);
        }
    free(shape);
    free(paint);
}

/* Phong lights white discs by at least 0.18; a darker pixel comes from an invalid number. */
static void check_picture(gl_fixture *f, const stp_view *view, const reference_pixel *pixels,
                          const char *mode)
{
    size_t count = (size_t)view->width * (size_t)view->height;
    uint8_t *rgba = calloc(count, 4);
    assert_non_null(rgba);
    check_ok(stp_renderer_read(f->renderer, rgba, err));
    for (size_t i = 0; i < count; i++) {
        const uint8_t *c = rgba + 4 * i;
        bool dark = c[0] < 45 || c[1] < 45 || c[2] < 45;
        if (c[3] != 0 && (dark || pixels[i].tag == 0))
            fail_msg("%s: pixel %zu of the picture is %d %d %d %d", mode, i, c[0], c[1], c[2],
                     c[3]);
    }
    free(rgba);
}

static void check_buffers(const gl_fixture *f, int mode, int levels)
{
    const stp_pyramid *pyramid = stp_renderer_inspect(f->renderer).pyramid;
    size_t count = (size_t)pyramid->width * (size_t)pyramid->height;
    bool pushes = mode <= STP_RECONSTRUCT_BOX;
    for (int l = 0; l <= levels; l++) {
        const stp_pyramid_level *level = &pyramid->levels[l];
        check_level(level, level->pulled, modes[mode].name);
        if (pushes && l > 0 && l < levels)
            check_level(level, stp_pyramid_finished(pyramid, l), modes[mode].name);
    }
    check_floats(pyramid->nearest_depth, GL_DEPTH_COMPONENT, 1, count, "the depth buffer");
    check_floats(pyramid->picture_depth, GL_RED, 1, count, "the picture's depth");
    for (int i = 0; i < 2 && mode == STP_RECONSTRUCT_SPLAT; i++)
        check_floats(pyramid->sums[i], GL_RGBA, 4, count, "a sum of splats");
}

/* ---- judging ---- */

/* Draws the scene without the hidden classes and checks every buffer. Returns level 0 as finished;
 * free it with free(). */
static reference_pixel *draw(gl_fixture *f, const stp_view *view, int mode, stp_lod lod,
                             const uint32_t hidden[8])
{
    stp_draw_stats stats;
    stp_draw_params params = {.reconstruct = (stp_reconstruct)mode,
                              .lod = lod,
                              .every_sample = lod != STP_LOD_GEOMETRY,
                              .cull = STP_CULL_BACK,
                              .keep_pixels = true};
    memcpy(params.hidden_classes, hidden, sizeof params.hidden_classes);
    check_ok(stp_renderer_draw(f->renderer, view, &params, &stats, err));
    assert_true(stats.cut_complete);
    bool finishes = mode != STP_RECONSTRUCT_POINTS &&
                    (mode >= STP_RECONSTRUCT_TEMPLATE3 || stats.pyramid_levels > 0);
    check_buffers(f, mode, stats.pyramid_levels);
    const stp_pyramid_level *level = &stp_renderer_inspect(f->renderer).pyramid->levels[0];
    if (finishes)
        check_level(level, level->finished, modes[mode].name);
    reference_pixel *pixels = gl_fixture_pixels(f, finishes);
    check_picture(f, view, pixels, modes[mode].name);
    return pixels;
}

/* Whether a disc is plain: it faces the eye well enough, lies wholly in front and is not left out.
 * Such a disc must be covered. */
static bool is_plain(const stp_view *view, const fixture_disc *disc)
{
    disc_judge judge;
    stp_dvec3 w =
        view->orthographic ? (stp_dvec3){0.0, 0.0, -1.0} : stp_dvec3_normalize(disc->position);
    judge_of(view, disc, STP_RECONSTRUCT_GAUSS, &judge);
    return -disc->position.z > disc->radius &&
           (disc->kind == STP_KIND_TUBE || fabs(stp_dvec3_dot(judge.normal, w)) > 0.7);
}

/* Each projection, each scene with the wider templates, each disc alone, each road. */
static bool every_view;

/* Is this disc judged alone, or this road taken, in other views of the mode only? turn: counts a
 * mode's views of a scene. */
static bool is_left_out(int turn, uint32_t i, int mode)
{
    return !every_view && ((int)i + turn + mode) % 4 != 0;
}

/* Judges one disc alone; cover: the pixels that it may cover, if it is seen. */
static void judge_disc(gl_fixture *f, const stp_view *view, const char *name, const scene *s,
                       uint32_t i, int mode, const uint8_t *cover, bool seen)
{
    int count = view->width * view->height;
    uint32_t hidden[8];
    memset(hidden, 255, sizeof hidden);
    hidden[i / 32] &= ~(UINT32_C(1) << i % 32);
    reference_pixel *pixels = draw(f, view, mode, (stp_lod)(i % 4), hidden);
    tally t = compare(pixels, cover, count);
    bool fills = seen && mode != STP_RECONSTRUCT_POINTS && is_plain(view, &s->discs[i]);
    if (t.outside > 0 || (fills && t.inside > 50 && 10 * t.covered_inside < 9 * t.inside))
        fail_msg("%s, %s, %s %d x %d, disc %u: %zu pixels outside its ellipse, %zu of %zu inside",
                 modes[mode].name, name, view->orthographic ? "orthographic" : "perspective",
                 view->width, view->height, i, t.outside, t.covered_inside, t.inside);
    free(pixels);
}

/* Judges discs alone, then all together. A merged sample is a mean and may lie between its
 * discs, so the union is checked only for modes that merge nothing. */
static void judge_view(gl_fixture *f, const stp_view *view, const char *name, const scene *s,
                       int mode, int turn)
{
    int count = view->width * view->height;
    uint8_t *all = calloc((size_t)count, 1);
    assert_non_null(all);
    for (uint32_t i = 0; i < s->count; i++) {
        bool alone = !is_left_out(turn, i, mode);
        if (!alone && mode < STP_RECONSTRUCT_SPLAT)
            continue;
        uint8_t *cover = calloc((size_t)count, 1);
        assert_non_null(cover);
        bool seen = allow(view, &s->discs[i], mode, cover);
        if (alone)
            judge_disc(f, view, name, s, i, mode, cover, seen);
        for (int k = 0; k < count; k++)
            all[k] = cover[k] > all[k] ? cover[k] : all[k];
        free(cover);
    }
    for (uint32_t lod = 0; lod < 4; lod++) {
        uint32_t hidden[8] = {0};
        if (is_left_out(turn, lod, mode))
            continue;
        reference_pixel *pixels = draw(f, view, mode, (stp_lod)lod, hidden);
        tally t = compare(pixels, all, count);
        if (mode >= STP_RECONSTRUCT_SPLAT)
            assert_int_equal(t.outside, 0);
        free(pixels);
    }
    free(all);
}

/* ---- scenes in every mode: one renderer each, whose programs serve all scenes ---- */

static const struct {
    const char *name;
    void (*make)(scene *);
} makers[] = {
    {"facing", make_facing},       {"back", make_back},           {"grazing", make_grazing},
    {"large", make_large},         {"behind", make_behind},       {"rim", make_rim},
    {"no radius", make_no_radius}, {"no normal", make_no_normal}, {"lines", make_lines},
};
#define SCENE_COUNT (sizeof makers / sizeof *makers)

static scene scenes[SCENE_COUNT];

/* Writes the scenes' files. */
static int write_scenes(void **state)
{
    if (scan_fixture_enter(state) != 0)
        return -1;
    for (size_t i = 0; i < SCENE_COUNT; i++) {
        makers[i].make(&scenes[i]);
        fixture_discs_write(scenes[i].discs, scenes[i].count, makers[i].name);
    }
    return 0;
}

/* Templates are slow, so they skip the largest size. */
static bool is_template(int mode)
{
    return mode >= STP_RECONSTRUCT_TEMPLATE3 && mode <= STP_RECONSTRUCT_TEMPLATE7;
}

static void judge_mode(int mode)
{
    bool wide = is_template(mode) && mode != STP_RECONSTRUCT_TEMPLATE3;
    gl_fixture f[SCENE_COUNT] = {0};
    gl_fixture_open(&f[0], makers[0].name, NULL);
    for (size_t i = 1; i < SCENE_COUNT; i++) {
        check_ok(stp_model_open(&f[i].model, makers[i].name, err));
        f[i].renderer = f[0].renderer;
    }
    for (size_t k = 0; k < 2 * SCENE_COUNT; k++) {
        size_t i = k % SCENE_COUNT;
        bool orthographic = k >= SCENE_COUNT;
        projections own = orthographic ? ORTHOGRAPHIC : PERSPECTIVE;
        if (!every_view &&
            ((wide && (int)i % 2 != mode % 2) || (modes[mode].projections & own) == 0))
            continue;
        const stp_model *model = f[i].model;
        check_ok(stp_renderer_set_models(f[i].renderer, &model, 1, err));
        for (int n = is_template(mode); n < 3; n++) {
            const int *size = sizes[n];
            stp_view view =
                check_view(size[0], size[1], size[0] * (orthographic ? 0.375 : 0.75), orthographic);
            stp_view_set_ball(&view, &f[i].model->ball);
            judge_view(&f[i], &view, makers[i].name, &scenes[i], mode, n + 3 * orthographic);
        }
    }
    stp_renderer_destroy(&f[0].renderer);
    for (size_t i = 0; i < SCENE_COUNT; i++)
        stp_model_close(&f[i].model);
}

#define MODE(name, mode)                                                                           \
    static void name(void **state)                                                                 \
    {                                                                                              \
        (void)state;                                                                               \
        judge_mode(mode);                                                                          \
    }

MODE(gauss, STP_RECONSTRUCT_GAUSS)
MODE(box, STP_RECONSTRUCT_BOX)
MODE(template3, STP_RECONSTRUCT_TEMPLATE3)
MODE(template5, STP_RECONSTRUCT_TEMPLATE5)
MODE(template7, STP_RECONSTRUCT_TEMPLATE7)
MODE(points, STP_RECONSTRUCT_POINTS)
MODE(splat, STP_RECONSTRUCT_SPLAT)

int main(int argc, char **argv)
{
    every_view = argc > 1 && strcmp(argv[1], "--every") == 0;
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points),    cmocka_unit_test(splat),     cmocka_unit_test(gauss),
        cmocka_unit_test(box),       cmocka_unit_test(template3), cmocka_unit_test(template5),
        cmocka_unit_test(template7),
    };
    int failed = cmocka_run_group_tests(tests, write_scenes, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}

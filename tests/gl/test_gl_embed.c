/* Tests a model among a host's own triangles: a sphere of points, cut by a plane. The depths of
 * sphere and plane are known, so the test knows what each pixel must show: in either order of
 * drawing, for each way to store depth, at any scale, and far from the origin. */
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/gl_program.h"
#include "tests/fixtures/prep_fixture.h"

#define W 200
#define H 150
#define MODEL "embed.stipple"
#define COUNT 60000u

/* The scan is georeferenced and has other units than the host. */
static const stp_dvec3 centre = {500000.25, 4.5e6, 312.5};
static const double radius = 20.0;

/* How a host stores depth. */
typedef struct convention {
    bool zero_to_one, reversed, infinite, orthographic, upper_left;
    int samples;     /* of its framebuffer; 0: one */
    double range[2]; /* of glDepthRange; 0, 0: 0 to 1 */
    double scale;    /* host units per unit of the scan */
    int x, y;        /* of its viewport */
} convention;

typedef struct scene {
    convention c;
    double near, model_view[16], projection[16];
    GLuint frame, colour, depth, program, array;
    int width, height; /* of the framebuffer */
} scene;

/* The host's lengths are in radii of the sphere, times its scale. */
#define NEAR 2.0
#define FAR 9.0
#define FOCUS 2.4       /* perspective: distance of an image plane of height 2 */
#define HALF_HEIGHT 1.6 /* orthographic: half the picture's height */
static const stp_dvec3 middle = {0.2, -0.1, -4.0}; /* the sphere's centre in eye space */

/* ---- the host ---- */

/* The near plane maps to -1 or 0, the far plane to 1; reversed: the other way round. */
static void set_projection(scene *s)
{
    const convention *c = &s->c;
    double n = c->scale * s->near, f = c->scale * FAR, low = c->zero_to_one ? 0.0 : -1.0;
    double *p = s->projection, at_near = c->reversed ? 1.0 : low, at_far = c->reversed ? low : 1.0;
    p[5] = c->orthographic ? 1.0 / (HALF_HEIGHT * c->scale) : FOCUS;
    p[0] = p[5] * H / W;
    p[c->orthographic ? 15 : 11] = c->orthographic ? 1.0 : -1.0;
    if (c->orthographic) {
        p[10] = (at_near - at_far) / (f - n);
        p[14] = at_near + p[10] * n;
    } else if (c->infinite) { /* far is 0, at infinity */
        p[14] = n;
    } else {
        p[14] = (at_near - at_far) * n * f / (f - n);
        p[10] = p[14] / f - at_far;
    }
}

/* Turns the scan, moves it to `middle` and scales it to the host's lengths. */
static void set_model_view(scene *s)
{
    const double a = 0.7, b = -0.4, k = s->c.scale / radius;
    const double r[3][3] = {{cos(a), 0.0, sin(a)},
                            {sin(b) * sin(a), cos(b), -sin(b) * cos(a)},
                            {-cos(b) * sin(a), sin(b), cos(b) * cos(a)}};
    const double at[3] = {middle.x * s->c.scale, middle.y * s->c.scale, middle.z * s->c.scale};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            s->model_view[4 * j + i] = k * r[i][j];
        s->model_view[12 + i] =
            at[i] - k * (r[i][0] * centre.x + r[i][1] * centre.y + r[i][2] * centre.z);
    }
    s->model_view[15] = 1.0;
}

static GLuint make_program(void)
{
    return gl_program_make("#version 450 core\nlayout(location = 0) uniform mat4 clip;\n"
                           "layout(location = 1) uniform vec4 corners[3];\n"
                           "void main() { gl_Position = clip * corners[gl_VertexID]; }\n",
                           "#version 450 core\nlayout(location = 0) out vec4 colour;\n"
                           "void main() { colour = vec4(1.0, 0.0, 1.0, 1.0); }\n",
                           NULL);
}

static void make_target(scene *s)
{
    GLenum target = s->c.samples > 0 ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D;
    s->width = W + s->c.x + 3;
    s->height = H + s->c.y + 2;
    GLuint *textures[2] = {&s->colour, &s->depth};
    const GLenum formats[2] = {GL_RGBA8, GL_DEPTH_COMPONENT32F};
    for (int i = 0; i < 2; i++) {
        glCreateTextures(target, 1, textures[i]);
        if (s->c.samples > 0)
            glTextureStorage2DMultisample(*textures[i], s->c.samples, formats[i], s->width,
                                          s->height, GL_TRUE);
        else
            glTextureStorage2D(*textures[i], 1, formats[i], s->width, s->height);
    }
    glCreateFramebuffers(1, &s->frame);
    glNamedFramebufferTexture(s->frame, GL_COLOR_ATTACHMENT0, s->colour, 0);
    glNamedFramebufferTexture(s->frame, GL_DEPTH_ATTACHMENT, s->depth, 0);
}

static scene make_scene(convention c, double near)
{
    scene s = {.c = c, .near = near};
    if (s.c.range[0] == s.c.range[1])
        s.c.range[1] = 1.0;
    if (s.c.scale <= 0.0)
        s.c.scale = 1.0;
    set_projection(&s);
    set_model_view(&s);
    s.program = make_program();
    glCreateVertexArrays(1, &s.array);
    make_target(&s);
    return s;
}

static void clear_scene(scene *s)
{
    const GLuint textures[2] = {s->colour, s->depth};
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glDeleteFramebuffers(1, &s->frame);
    glDeleteTextures(2, textures);
    glDeleteVertexArrays(1, &s->array);
    glDeleteProgram(s->program);
    glDisable(GL_DEPTH_TEST);
    glDepthRange(0.0, 1.0);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
}

/* Converts a depth in radii to the depth buffer's value. */
static double buffer_depth(const scene *s, double depth)
{
    const double *p = s->projection;
    double z = -depth * s->c.scale;
    double ndc = (p[10] * z + p[14]) / (p[11] * z + p[15]);
    double t = s->c.zero_to_one ? ndc : 0.5 * ndc + 0.5;
    return s->c.range[0] + (s->c.range[1] - s->c.range[0]) * t;
}

/* Clears the framebuffer and sets the state that the host draws with. */
static void begin_scene(const scene *s)
{
    static const float background[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    bool greater = buffer_depth(s, NEAR) > buffer_depth(s, 0.9 * FAR);
    const float farthest = greater ? 0.0f : 1.0f;
    glBindFramebuffer(GL_FRAMEBUFFER, s->frame);
    glClearBufferfv(GL_COLOR, 0, background);
    glClearBufferfv(GL_DEPTH, 0, &farthest);
    glViewport(s->c.x, s->c.y, W, H);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(greater ? GL_GREATER : GL_LESS);
    glDepthRange(s->c.range[0], s->c.range[1]);
    glClipControl(s->c.upper_left ? GL_UPPER_LEFT : GL_LOWER_LEFT,
                  s->c.zero_to_one ? GL_ZERO_TO_ONE : GL_NEGATIVE_ONE_TO_ONE);
}

/* The triangle lies in the plane of depth 4 - 0.8 x in eye space, below y = 0.3. It is wider and
 * deeper than the view. */
#define PLANE_DEPTH 4.0
#define PLANE_SLOPE 0.8
#define PLANE_TOP 0.3
static const double corners_xy[3][2] = {{-8.0, PLANE_TOP}, {8.0, PLANE_TOP}, {0.0, -40.0}};

static void draw_plane(const scene *s)
{
    float corners[3][4], clip[16];
    for (int i = 0; i < 3; i++) {
        double x = corners_xy[i][0], y = corners_xy[i][1];
        corners[i][0] = (float)(x * s->c.scale);
        corners[i][1] = (float)(y * s->c.scale);
        corners[i][2] = (float)((PLANE_SLOPE * x - PLANE_DEPTH) * s->c.scale);
        corners[i][3] = 1.0f;
    }
    for (int i = 0; i < 16; i++)
        clip[i] = (float)s->projection[i];
    glUseProgram(s->program);
    glUniformMatrix4fv(0, 1, GL_FALSE, clip);
    glUniform4fv(1, 3, corners[0]);
    glBindVertexArray(s->array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

/* ---- the expected pixels ---- */

/* Depths under one pixel's centre; INFINITY: nothing there. */
typedef struct truth {
    double sphere, plane;
    bool doubtful; /* an edge is near, or both are equally deep */
} truth;

static truth truth_at(const scene *s, int i, int j)
{
    bool flat = s->c.orthographic;
    double f = flat ? 0.5 * H / HALF_HEIGHT : 0.5 * H * FOCUS;
    double x = (i + 0.5 - 0.5 * W) / f, y = (j + 0.5 - 0.5 * H) / f;
    stp_dvec3 from = {flat ? x : 0.0, flat ? y : 0.0, 0.0};
    stp_dvec3 ray = {flat ? 0.0 : x, flat ? 0.0 : y, -1.0};
    stp_dvec3 o = stp_dvec3_sub(from, middle);
    double a = stp_dvec3_dot(ray, ray), b = stp_dvec3_dot(o, ray);
    double root = b * b - a * (stp_dvec3_dot(o, o) - 1.0);
    truth t = {.sphere = root > 0.0 ? (-b - sqrt(root)) / a : INFINITY};
    t.plane = flat ? PLANE_DEPTH - PLANE_SLOPE * x : PLANE_DEPTH / (1.0 + PLANE_SLOPE * x);
    double top = flat ? y : y * t.plane;
    t.doubtful = fabs(root) < 0.25 * a || fabs(top - PLANE_TOP) < 0.04;
    if (top > PLANE_TOP)
        t.plane = INFINITY;
    t.doubtful = t.doubtful || fabs(t.sphere - t.plane) < 0.08;
    return t;
}

typedef struct seen {
    uint8_t *rgba;
    float *depth;
} seen;

/* Reads the framebuffer. If it has several samples, a blit resolves it; the depth is then one
 * sample's. */
static seen read_back(const scene *s)
{
    size_t count = (size_t)s->width * (size_t)s->height;
    seen out = {malloc(4 * count), malloc(count * sizeof(float))};
    scene plain = {.c = {.x = s->c.x, .y = s->c.y}};
    make_target(&plain);
    glBlitNamedFramebuffer(s->frame, plain.frame, 0, 0, s->width, s->height, 0, 0, s->width,
                           s->height, GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT, GL_NEAREST);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glGetTextureImage(plain.colour, 0, GL_RGBA, GL_UNSIGNED_BYTE, (GLsizei)(4 * count), out.rgba);
    glGetTextureImage(plain.depth, 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                      (GLsizei)(count * sizeof(float)), out.depth);
    const GLuint textures[2] = {plain.colour, plain.depth};
    glDeleteFramebuffers(1, &plain.frame);
    glDeleteTextures(2, textures);
    assert_int_equal(glGetError(), GL_NO_ERROR);
    return out;
}

static void clear_seen(seen *s)
{
    free(s->rgba);
    free(s->depth);
}

typedef struct tally {
    int plane, points, none;
} tally;

/* Checks every pixel that is not doubtful: colour and depth must be the nearer surface's. */
static tally check_pixels(const scene *s, const seen *found)
{
    tally t = {0};
    for (int k = 0; k < W * H; k++) {
        int i = k % W, j = k / W, row = s->c.upper_left ? H - 1 - j : j;
        size_t at = (size_t)(s->c.y + row) * (size_t)s->width + (size_t)(s->c.x + i);
        const uint8_t *p = found->rgba + 4 * at;
        truth is = truth_at(s, i, j);
        double depth = fmin(is.sphere, is.plane);
        bool points = is.sphere < is.plane;
        if (is.doubtful || isinf(depth)) {
            t.none += isinf(depth) && !is.doubtful;
            assert_true(is.doubtful || p[3] == 0);
            continue;
        }
        /* Points are grey, the triangle is magenta. */
        if (p[3] != 255 || (p[1] == 0) == points)
            fail_msg("pixel %d %d: sphere at %g, plane at %g, colour %d %d %d %d", i, j, is.sphere,
                     is.plane, p[0], p[1], p[2], p[3]);
        double expected = buffer_depth(s, depth);
        /* A reconstructed depth comes from a sample some pixels away. With several samples in a
         * pixel, the depth's sample lies beside the centre. */
        double off = points ? 0.08 : s->c.samples > 0 ? 0.02 : 0.001;
        double slack = fabs(buffer_depth(s, depth + off) - expected);
        check_near((double)found->depth[at], expected, slack);
        t.plane += !points;
        t.points += points;
    }
    return t;
}

/* ---- the tests ---- */

static void draw_model(gl_fixture *f, const scene *s)
{
    stp_view view;
    stp_draw_stats stats = {0};
    /* if the near plane opens the sphere, no backs are drawn */
    const stp_draw_params params = {.cull = STP_CULL_BACK};
    stp_ball ball = stp_model_ball(f->model);
    check_ok(stp_view_from_matrices(&view, s->model_view, s->projection, &ball, W, H, err));
    check_ok(stp_renderer_draw_into(f->renderer, &view, &params, NULL, &stats, err));
    assert_true(stats.cut_complete);
}

/* Draws the triangle first, then the points; then the other way round. */
static void both_ways(gl_fixture *f, convention c)
{
    scene s = make_scene(c, NEAR);
    seen out[2];
    for (int way = 0; way < 2; way++) {
        begin_scene(&s);
        if (way == 0)
            draw_plane(&s);
        draw_model(f, &s);
        if (way == 1)
            draw_plane(&s);
        out[way] = read_back(&s);
        tally t = check_pixels(&s, &out[way]);
        assert_true(t.plane > 1000 && t.points > 1000 && t.none > 1000);
    }
    assert_memory_equal(out[0].rgba, out[1].rgba, (size_t)s.width * (size_t)s.height * 4);
    assert_memory_equal(out[0].depth, out[1].depth, (size_t)s.width * (size_t)s.height * 4);
    clear_seen(&out[0]);
    clear_seen(&out[1]);
    clear_scene(&s);
}

static void depth_conventions(void **state)
{
    gl_fixture *f = *state;
    both_ways(f, (convention){.scale = 1.0});
    both_ways(f, (convention){.zero_to_one = true, .scale = 0.001});
    both_ways(f, (convention){.zero_to_one = true, .reversed = true, .x = 7, .y = 11});
    both_ways(f, (convention){.zero_to_one = true, .reversed = true, .infinite = true});
    both_ways(f, (convention){.range = {0.25, 0.5}, .scale = 1000.0});
    both_ways(f, (convention){.range = {0.9, 0.1}, .upper_left = true, .x = 3});
}

static void orthographic(void **state)
{
    gl_fixture *f = *state;
    both_ways(f, (convention){.orthographic = true});
    both_ways(f, (convention){
                     .orthographic = true, .zero_to_one = true, .reversed = true, .scale = 20.0});
}

static void multisampled(void **state)
{
    both_ways(*state, (convention){.samples = 4});
}

/* The part before the host's near plane is cut away, unless depth is clamped. */
static void cut_by_depth_range(void **state)
{
    gl_fixture *f = *state;
    static const double near = 3.4;
    for (int clamp = 0; clamp < 2; clamp++)
        for (int flat = 0; flat < 2; flat++) {
            scene s = make_scene((convention){.orthographic = flat != 0}, near);
            int cut = 0, kept = 0;
            begin_scene(&s);
            if (clamp)
                glEnable(GL_DEPTH_CLAMP);
            draw_model(f, &s);
            glDisable(GL_DEPTH_CLAMP);
            seen out = read_back(&s);
            for (int k = 0; k < W * H; k++) {
                truth t = truth_at(&s, k % W, k / W);
                size_t at = (size_t)(k / W) * (size_t)s.width + (size_t)(k % W);
                if (t.sphere < near - 0.1 && !clamp) {
                    assert_int_equal(out.rgba[4 * at + 3], 0);
                    cut++;
                } else if (t.sphere < 3.6 && (t.sphere > near + 0.05 || clamp)) {
                    assert_int_equal(out.rgba[4 * at + 3], 255);
                    kept++;
                }
            }
            assert_true(kept > 500 && (clamp || cut > 500));
            clear_seen(&out);
            clear_scene(&s);
        }
}

/* A framebuffer of linear light must hold the decoded colours of the plain one. */
static void linear_light(void **state)
{
    gl_fixture *f = *state;
    stp_view view;
    scene s = make_scene((convention){0}, NEAR);
    stp_ball ball = stp_model_ball(f->model);
    seen out[2];
    check_ok(stp_view_from_matrices(&view, s.model_view, s.projection, &ball, W, H, err));
    for (int k = 0; k < 2; k++) {
        const stp_target target = {.linear_light = k == 1};
        const stp_draw_params params = {.every_sample = true};
        begin_scene(&s);
        check_ok(stp_renderer_draw_into(f->renderer, &view, &params, &target, NULL, err));
        out[k] = read_back(&s);
    }
    for (int i = 0; i < 4 * s.width * s.height; i++) {
        double c = out[0].rgba[i] / 255.0;
        double light = i % 4 == 3 ? c : c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
        check_near(out[1].rgba[i] / 255.0, light, 0.6 / 255.0);
    }
    clear_seen(&out[0]);
    clear_seen(&out[1]);
    clear_scene(&s);
}

#define check_refused(call, word)                                                                  \
    do {                                                                                           \
        stp_error refused = {0}, *err = &refused;                                                  \
        assert_true((call) != STP_OK);                                                             \
        if (strstr(refused.message, word) == NULL)                                                 \
            fail_msg("'%s' does not say %s", refused.message, word);                               \
    } while (0)

/* Matrices that cannot be used, and the messages about them. */
static void refused_matrices(void **state)
{
    gl_fixture *f = *state;
    static const struct {
        int matrix, element; /* 0: model_view */
        double value;
        const char *word;
    } wrong[] = {
        {0, 0, NAN, "model_view"},      {0, 3, 0.1, "last row"},       {0, 0, 7.0, "shears"},
        {1, 5, INFINITY, "projection"}, {1, 8, 0.1, "off the middle"}, {1, 11, 1.0, "+z"},
        {1, 4, 0.1, "element 4"},       {1, 5, 1.0, "not square"},     {1, 14, 0.0, "flattens"},
        {1, 15, 1.0, "element 15"},     {1, 5, -2.4, "mirrors"},
    };
    scene s = make_scene((convention){0}, NEAR);
    stp_ball ball = stp_model_ball(f->model);
    stp_view view = {.width = 77};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        double matrices[2][16];
        memcpy(matrices[0], s.model_view, sizeof s.model_view);
        memcpy(matrices[1], s.projection, sizeof s.projection);
        matrices[wrong[i].matrix][wrong[i].element] = wrong[i].value;
        check_refused(stp_view_from_matrices(&view, matrices[0], matrices[1], &ball, W, H, err),
                      wrong[i].word);
        assert_int_equal(view.width, 77);
    }
    double mirrored[16];
    for (int i = 0; i < 16; i++)
        mirrored[i] = i % 4 == 0 ? -s.model_view[i] : s.model_view[i];
    check_refused(stp_view_from_matrices(&view, mirrored, s.projection, &ball, W, H, err),
                  "mirrors");
    check_refused(stp_view_from_matrices(&view, s.model_view, s.projection, &ball, W, 0, err),
                  "empty");
    clear_scene(&s);
}

/* Framebuffers and views that cannot be used. */
static void refused_targets(void **state)
{
    gl_fixture *f = *state;
    const stp_draw_params params = {0};
    scene s = make_scene((convention){0}, NEAR);
    stp_ball ball = stp_model_ball(f->model);
    stp_view view, own;
    GLuint empty = 0, numbers = 0;
    check_ok(stp_view_from_matrices(&view, s.model_view, s.projection, &ball, W, H, err));
    stp_dbox box = stp_model_box(f->model);
    assert_int_equal(stp_model_point_count(f->model), COUNT);
    stp_camera camera = stp_camera_default(&box, &ball, W, H);
    check_ok(stp_view_create(&own, &camera, &ball, W, H, err));
    begin_scene(&s);
    check_refused(stp_renderer_draw_into(f->renderer, &own, &params, NULL, NULL, err),
                  "stp_view_from_matrices");
    glViewport(0, 0, W + 1, H);
    check_refused(stp_renderer_draw_into(f->renderer, &view, &params, NULL, NULL, err),
                  "viewport is 201 x 150");
    glViewport(0, 0, W, H);
    glCreateFramebuffers(1, &empty);
    glBindFramebuffer(GL_FRAMEBUFFER, empty);
    check_refused(stp_renderer_draw_into(f->renderer, &view, &params, NULL, NULL, err),
                  "not complete");
    glCreateTextures(GL_TEXTURE_2D, 1, &numbers);
    glTextureStorage2D(numbers, 1, GL_R32UI, W, H);
    glNamedFramebufferTexture(empty, GL_COLOR_ATTACHMENT0, numbers, 0);
    check_refused(stp_renderer_draw_into(f->renderer, &view, &params, NULL, NULL, err), "integers");
    glDeleteFramebuffers(1, &empty);
    glDeleteTextures(1, &numbers);
    clear_scene(&s);
}

static int open_sphere(void **state)
{
    static gl_fixture f;
    stp_prep_stats stats;
    prep_cloud cloud = prep_cloud_wavy(COUNT, (stp_dvec3){0.0, 0.0, 0.0}, 1.0);
    for (uint32_t i = 0; i < COUNT; i++) {
        stp_point *p = &cloud.points[i];
        stp_dvec3 n = stp_dvec3_normalize(p->position);
        p->position = stp_dvec3_add(centre, stp_dvec3_scale(n, radius));
        p->rgb[0] = p->rgb[1] = p->rgb[2] = 50000;
    }
    check_ok(prep_cloud_run(&cloud, MODEL, 2, NULL, &stats, err));
    free(cloud.points);
    gl_fixture_open(&f, MODEL, NULL);
    *state = &f;
    return 0;
}

static int close_sphere(void **state)
{
    gl_fixture_close(*state);
    return 0;
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(depth_conventions), cmocka_unit_test(orthographic),
        cmocka_unit_test(multisampled),      cmocka_unit_test(cut_by_depth_range),
        cmocka_unit_test(linear_light),      cmocka_unit_test(refused_matrices),
        cmocka_unit_test(refused_targets),
    };
    int failed = cmocka_run_group_tests(tests, open_sphere, close_sphere);
    stp_gl_context_destroy(&context);
    return failed;
}

/* Tests a host application's OpenGL state: whatever the host has set, every call leaves it as it
 * was, and the picture equals, byte by byte, the picture in an untouched context. */
#include "runtime/gl/gl_state.h"
#include "tests/fixtures/gl_dump.h"
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/gl_program.h"
#include "tests/fixtures/model_fixture.h"

#define SIZE 160
#define MODEL "gl_state.stipple"

typedef struct host {
    GLuint program, pipeline, array, frame, other_frame, feedback, query, sampler;
    GLuint colour, depth, read_colour, flat, volume, cube, texels;
    GLuint buffers[8];
} host;

static GLuint make_program(void)
{
    return gl_program_make("#version 450 core\nout vec4 kept;\n"
                           "void main() { kept = vec4(gl_VertexID); gl_Position = kept; }\n",
                           "#version 450 core\nlayout(location = 0) out vec4 c;\n"
                           "void main() { c = vec4(1.0); }\n",
                           "kept");
}

static GLuint make_texture(GLenum target, GLenum format, int size)
{
    GLuint texture = 0;
    glCreateTextures(target, 1, &texture);
    if (target == GL_TEXTURE_3D)
        glTextureStorage3D(texture, 1, format, size, size, size);
    else
        glTextureStorage2D(texture, 1, format, size, size);
    return texture;
}

static void make_objects(host *h)
{
    h->program = make_program();
    glCreateProgramPipelines(1, &h->pipeline);
    glCreateVertexArrays(1, &h->array);
    glCreateFramebuffers(1, &h->frame);
    glCreateFramebuffers(1, &h->other_frame);
    glCreateTransformFeedbacks(1, &h->feedback);
    glCreateQueries(GL_PRIMITIVES_GENERATED, 1, &h->query);
    glCreateSamplers(1, &h->sampler);
    h->colour = make_texture(GL_TEXTURE_2D, GL_SRGB8_ALPHA8, SIZE);
    h->read_colour = make_texture(GL_TEXTURE_2D, GL_RGBA8, 8);
    h->depth = make_texture(GL_TEXTURE_2D, GL_DEPTH32F_STENCIL8, SIZE);
    h->flat = make_texture(GL_TEXTURE_2D, GL_RGBA8, 4);
    h->volume = make_texture(GL_TEXTURE_3D, GL_RGBA8, 4);
    h->cube = make_texture(GL_TEXTURE_CUBE_MAP, GL_RGBA8, 4);
    glCreateBuffers(8, h->buffers);
    for (int i = 0; i < 8; i++)
        glNamedBufferStorage(h->buffers[i], 4096, NULL, 0);
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &h->texels);
    glTextureBuffer(h->texels, GL_RGBA32F, h->buffers[7]);
    glNamedFramebufferTexture(h->frame, GL_COLOR_ATTACHMENT0, h->colour, 0);
    glNamedFramebufferTexture(h->frame, GL_DEPTH_STENCIL_ATTACHMENT, h->depth, 0);
    /* the check also lets the driver count its stencil bits, to which it clamps the state that it
     * reports */
    assert_int_equal(glCheckNamedFramebufferStatus(h->frame, GL_FRAMEBUFFER),
                     GL_FRAMEBUFFER_COMPLETE);
    glClearTexImage(h->colour, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    glNamedFramebufferTexture(h->other_frame, GL_COLOR_ATTACHMENT1, h->read_colour, 0);
    glNamedFramebufferReadBuffer(h->other_frame, GL_COLOR_ATTACHMENT1);
}

/* Turns on everything that can be switched. */
static void set_switches(void)
{
    static const GLenum on[] = {GL_BLEND,
                                GL_COLOR_LOGIC_OP,
                                GL_CULL_FACE,
                                GL_DEPTH_CLAMP,
                                GL_DEPTH_TEST,
                                GL_DITHER,
                                GL_FRAMEBUFFER_SRGB,
                                GL_LINE_SMOOTH,
                                GL_MULTISAMPLE,
                                GL_POLYGON_OFFSET_FILL,
                                GL_POLYGON_OFFSET_LINE,
                                GL_POLYGON_OFFSET_POINT,
                                GL_POLYGON_SMOOTH,
                                GL_PRIMITIVE_RESTART,
                                GL_PRIMITIVE_RESTART_FIXED_INDEX,
                                GL_PROGRAM_POINT_SIZE,
                                GL_RASTERIZER_DISCARD,
                                GL_SAMPLE_ALPHA_TO_COVERAGE,
                                GL_SAMPLE_ALPHA_TO_ONE,
                                GL_SAMPLE_COVERAGE,
                                GL_SAMPLE_MASK,
                                GL_SAMPLE_SHADING,
                                GL_SCISSOR_TEST,
                                GL_STENCIL_TEST,
                                GL_TEXTURE_CUBE_MAP_SEAMLESS};
    for (size_t i = 0; i < sizeof on / sizeof *on; i++)
        glEnable(on[i]);
    for (GLenum i = 0; i < 8; i++)
        glEnable(GL_CLIP_DISTANCE0 + i);
}

/* Changes everything that decides where and how to draw. */
static void set_raster(void)
{
    for (GLuint i = 0; i < 16; i++) {
        glViewportIndexedf(i, 1.5f + (float)i, 2.0f, 33.0f, 17.0f + (float)i);
        glScissorIndexed(i, 1, (GLint)i, 3, 2);
        glDepthRangeIndexed(i, 0.75, 0.01 * i);
    }
    for (GLuint i = 0; i < 8; i++) {
        glColorMaski(i, i % 2 == 1, GL_FALSE, i % 3 == 1, GL_FALSE);
        glBlendFunci(i, GL_ZERO, i % 2 ? GL_ONE : GL_DST_ALPHA);
        glBlendEquationi(i, i % 2 ? GL_MAX : GL_FUNC_REVERSE_SUBTRACT);
    }
    glDisablei(GL_BLEND, 3);
    glDisablei(GL_SCISSOR_TEST, 5);
    glLogicOp(GL_XOR);
    glSampleMaski(0, 0);
    glSampleCoverage(0.0f, GL_TRUE);
    glMinSampleShading(0.5f);
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_NEVER);
    glClipControl(GL_UPPER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    glPolygonMode(GL_FRONT_AND_BACK, GL_POINT);
    glPolygonOffset(-100.0f, -1000.0f);
    glPointSize(7.0f);
    glLineWidth(1.0f);
    glPrimitiveRestartIndex(3);
    glCullFace(GL_FRONT_AND_BACK);
    glFrontFace(GL_CW);
    glProvokingVertex(GL_FIRST_VERTEX_CONVENTION);
    glStencilFunc(GL_NEVER, 5, 3);
    glStencilOp(GL_INVERT, GL_INCR, GL_ZERO);
    glStencilMask(6);
    glClearColor(0.5f, 0.25f, 0.125f, 1.0f);
    glClearDepth(0.25);
    glClearStencil(9);
}

static void set_bindings(const host *h)
{
    static const GLenum packing[2][6] = {
        {GL_PACK_ROW_LENGTH, GL_PACK_SKIP_ROWS, GL_PACK_SKIP_PIXELS, GL_PACK_IMAGE_HEIGHT,
         GL_PACK_SKIP_IMAGES, GL_PACK_SWAP_BYTES},
        {GL_UNPACK_ROW_LENGTH, GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_PIXELS, GL_UNPACK_IMAGE_HEIGHT,
         GL_UNPACK_SKIP_IMAGES, GL_UNPACK_SWAP_BYTES}};
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 6; k++)
            glPixelStorei(packing[i][k], k == 5 ? 1 : 7 + k);
    glPixelStorei(GL_PACK_ALIGNMENT, 8);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 2);
    glPixelStorei(GL_PACK_LSB_FIRST, 1);
    for (GLuint i = 0; i < 16; i++) {
        const GLuint textures[4] = {h->flat, h->volume, h->cube, h->texels};
        for (int k = 0; k < 4; k++)
            glBindTextureUnit(i, textures[k]);
        glBindSampler(i, h->sampler);
    }
    glSamplerParameteri(h->sampler, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glSamplerParameteri(h->sampler, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glActiveTexture(GL_TEXTURE5);
    for (GLuint i = 0; i < 8; i++) {
        glBindImageTexture(i, h->volume, 0, GL_FALSE, 2, GL_READ_ONLY, GL_RGBA8UI);
        glBindBufferRange(GL_UNIFORM_BUFFER, i, h->buffers[i], 256, 512);
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, i, h->buffers[i]);
    }
    glBindBuffer(GL_UNIFORM_BUFFER, h->buffers[2]);
    glBindBuffer(GL_SHADER_STORAGE_BUFFER, h->buffers[3]);
    glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, h->buffers[4]);
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, h->buffers[4]);
    glBindBuffer(GL_ARRAY_BUFFER, h->buffers[5]);
    glBindBuffer(GL_COPY_READ_BUFFER, h->buffers[5]);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, h->buffers[0]);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, h->buffers[1]);
    glBindVertexArray(h->array);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, h->frame);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, h->other_frame);
    glBindProgramPipeline(h->pipeline);
    glUseProgram(h->program);
}

/* Starts transform feedback and a query. */
static void begin_running(const host *h)
{
    glBindTransformFeedback(GL_TRANSFORM_FEEDBACK, h->feedback);
    glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, h->buffers[6]);
    glBeginTransformFeedback(GL_POINTS);
    glBeginQuery(GL_PRIMITIVES_GENERATED, h->query);
}

static void end_running(void)
{
    glEndQuery(GL_PRIMITIVES_GENERATED);
    glEndTransformFeedback();
}

static void check_same(gl_dump *before, const char *after)
{
    gl_dump now = gl_dump_take();
    assert_int_equal(glGetError(), GL_NO_ERROR);
    assert_int_equal(gl_dump_compare(before, &now, after), 0);
    free(now.text);
}

static stp_view make_view(const stp_model *model, bool orthographic)
{
    stp_view view;
    stp_ball ball = stp_model_ball(model);
    stp_dbox box = stp_model_box(model);
    stp_camera camera = stp_camera_default(&box, &ball, SIZE, SIZE);
    if (orthographic)
        camera.height = 2.0 * ball.radius;
    check_ok(stp_view_create(&view, &camera, &ball, SIZE, SIZE, err));
    return view;
}

/* A picture, and the depths at some pixels. */
typedef struct outcome {
    uint8_t rgba[4 * SIZE * SIZE];
    float depth[16];
} outcome;

static void take_outcome(stp_renderer *renderer, outcome *out)
{
    check_ok(stp_renderer_read(renderer, out->rgba, err));
    for (int i = 0; i < 16; i++)
        check_ok(stp_renderer_depth_at(renderer, 10 * i, 5 + 9 * i, &out->depth[i], err));
}

static const stp_draw_params drawn[] = {
    {.lod = STP_LOD_GEOMETRY},
    {.lod = STP_LOD_CPU, .shade = STP_SHADE_NORMAL},
    {.lod = STP_LOD_FULL, .reconstruct = STP_RECONSTRUCT_BOX},
    {.lod = STP_LOD_COMPUTE, .keep_pixels = true},
    {.lod = STP_LOD_GEOMETRY, .timed = true},
    {.lod = STP_LOD_CPU, .reconstruct = STP_RECONSTRUCT_TEMPLATE5, .keep_pixels = true},
    {.lod = STP_LOD_GEOMETRY, .reconstruct = STP_RECONSTRUCT_SPLAT, .edl = 1.0},
    {.lod = STP_LOD_COMPUTE, .reconstruct = STP_RECONSTRUCT_SPLAT},
    {.lod = STP_LOD_COMPUTE, .reconstruct = STP_RECONSTRUCT_POINTS, .cull = STP_CULL_NONE},
};
#define DRAWN ((int)(sizeof drawn / sizeof *drawn))

/* Draws each picture. If `before` is given, checks the state after each call. */
static void draw_all(gl_fixture *f, outcome *out, gl_dump *before)
{
    for (int i = 0; i < DRAWN; i++) {
        stp_view view = make_view(f->model, i == 1);
        check_ok(stp_renderer_draw(f->renderer, &view, &drawn[i], NULL, err));
        if (before != NULL)
            check_same(before, "drawing");
        take_outcome(f->renderer, &out[i]);
        if (before != NULL)
            check_same(before, "reading");
    }
}

static outcome *clean_outcomes(void)
{
    gl_fixture f = {0};
    outcome *clean = calloc((size_t)DRAWN, sizeof *clean);
    assert_non_null(clean);
    gl_fixture_open(&f, MODEL, NULL);
    draw_all(&f, clean, NULL);
    gl_fixture_close(&f);
    return clean;
}

/* Makes the same calls in a context where a host has changed everything. */
static void perverse_host(void **state)
{
    (void)state;
    host h = {0};
    gl_fixture f = {0};
    outcome *clean = clean_outcomes(), *out = calloc((size_t)DRAWN, sizeof *out);
    stp_cut_measure measure;
    assert_non_null(out);
    make_objects(&h);
    set_switches();
    set_raster();
    set_bindings(&h);
    begin_running(&h);
    assert_int_equal(glGetError(), GL_NO_ERROR);
    gl_dump before = gl_dump_take();
    assert_int_equal(glGetError(), GL_NO_ERROR);
    gl_fixture_open(&f, MODEL, NULL);
    check_same(&before, "creating");
    draw_all(&f, out, &before);
    for (int i = 0; i < DRAWN; i++) {
        assert_memory_equal(out[i].depth, clean[i].depth, sizeof clean[i].depth);
        assert_memory_equal(out[i].rgba, clean[i].rgba, sizeof clean[i].rgba);
    }
    stp_renderer_measure(f.renderer, &measure);
    const stp_model *models[2] = {f.model, f.model};
    check_ok(stp_renderer_set_models(f.renderer, models, 2, err));
    check_same(&before, "setting models");
    check_ok(stp_renderer_reload_shaders(f.renderer, err));
    check_same(&before, "reloading shaders");
    stp_renderer_present(f.renderer, h.frame, SIZE, SIZE);
    check_same(&before, "presenting");
    gl_fixture_close(&f);
    check_same(&before, "destroying");
    end_running();
    free(before.text);
    free(out);
    free(clean);
}

/* The host's framebuffer must hold nothing, or green where the model is. */
static void check_colour(const host *h, bool green)
{
    uint8_t pixels[4 * SIZE * SIZE];
    size_t found[4] = {0};
    stp_gl_state state;
    stp_gl_state_enter(&state);
    glGetTextureImage(h->colour, 0, GL_RGBA, GL_UNSIGNED_BYTE, sizeof pixels, pixels);
    stp_gl_state_leave(&state);
    for (size_t i = 0; i < sizeof pixels; i++)
        found[i % 4] += pixels[i] != 0;
    assert_int_equal(found[0] + found[2] + found[3], 0);
    assert_true(green ? found[1] > 1000 : found[1] == 0);
}

/* Draws into the host's framebuffer. The host's running feedback and query must go on, and
 * everything else must stay. The host's settings that decide which pixels may be written must be
 * obeyed. */
static void drawing_into(void **state)
{
    (void)state;
    static const double projection[16] = {
        [0] = 2.0, [5] = 2.0, [10] = -1.02, [11] = -1.0, [14] = -0.202};
    static const double model_view[16] = {
        [0] = 1.0, [5] = 1.0, [10] = 1.0, [14] = -4.0, [15] = 1.0};
    host h = {0};
    gl_fixture f = {0};
    stp_view view;
    make_objects(&h);
    set_switches();
    set_raster();
    set_bindings(&h);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, h.frame);
    glViewportIndexedf(0, 0.0f, 0.0f, SIZE, SIZE);
    begin_running(&h);
    gl_fixture_open(&f, MODEL, NULL);
    stp_ball ball = stp_model_ball(f.model);
    check_ok(stp_view_from_matrices(&view, model_view, projection, &ball, SIZE, SIZE, err));
    for (int i = 0; i < 2; i++) {
        /* at first nothing passes; then everything does, but the colour mask admits green alone */
        if (i == 1) {
            glDisable(GL_STENCIL_TEST);
            glDisable(GL_DEPTH_TEST);
            glDisablei(GL_SCISSOR_TEST, 0);
            glColorMaski(0, GL_FALSE, GL_TRUE, GL_FALSE, GL_FALSE);
        }
        gl_dump before = gl_dump_take();
        for (int k = 0; k < 3; k++) {
            stp_draw_params params = {.stream = k == 1, .fade = k == 1 ? 0.5 : 0.0};
            params.lod = k == 2 ? STP_LOD_COMPUTE : STP_LOD_GEOMETRY;
            check_ok(stp_renderer_draw_into(f.renderer, &view, &params, NULL, NULL, err));
            check_same(&before, "drawing into the host's framebuffer");
        }
        free(before.text);
        check_colour(&h, i == 1);
    }
    end_running();
    gl_fixture_close(&f);
}

/* Errors that the host left pending must not be taken for ours. */
static void pending_errors(void **state)
{
    (void)state;
    gl_fixture f = {0};
    gl_fixture_open(&f, MODEL, NULL);
    stp_view view = make_view(f.model, false);
    glEnable(GL_TEXTURE0);
    check_ok(stp_renderer_draw(f.renderer, &view, &drawn[0], NULL, err));
    gl_fixture_close(&f);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const model_recipe recipe = {.shape = GEN_STATUE, .point_count = 20000, .true_normals = true};
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pending_errors),
        cmocka_unit_test(perverse_host),
    };
    const struct CMUnitTest into[] = {cmocka_unit_test(drawing_into)};
    model_fixture_build(MODEL, &recipe);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stp_gl_context_destroy(&context);
    context = gl_fixture_context(); /* untouched again */
    failed += cmocka_run_group_tests(into, NULL, NULL);
    stp_gl_context_destroy(&context);
    return failed;
}

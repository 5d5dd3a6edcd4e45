/* Saves and restores the host's OpenGL state, and sets ours. */
#include "runtime/gl/gl_state.h"

#include "runtime/gl/gpu_layout.h"

_Static_assert((int)STP_UNIT_COUNT <= (int)STP_GL_UNITS, "every unit in use is kept");

#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

/* All capabilities that change what we draw, and the value that we set. */
static const struct {
    GLenum name;
    bool on;
} capabilities[] = {
    {GL_CULL_FACE, false},
    {GL_DITHER, false},
    {GL_MULTISAMPLE, false},
    {GL_STENCIL_TEST, false},
    {GL_FRAMEBUFFER_SRGB, false},
    {GL_PROGRAM_POINT_SIZE, false},
    {GL_DEPTH_TEST, false},
    {GL_DEPTH_CLAMP, false},
    {GL_COLOR_LOGIC_OP, false},
    {GL_RASTERIZER_DISCARD, false},
    {GL_POLYGON_OFFSET_FILL, false},
    {GL_POLYGON_OFFSET_LINE, false},
    {GL_POLYGON_OFFSET_POINT, false},
    {GL_POLYGON_SMOOTH, false},
    {GL_LINE_SMOOTH, false},
    {GL_SAMPLE_MASK, false},
    {GL_SAMPLE_COVERAGE, false},
    {GL_SAMPLE_ALPHA_TO_COVERAGE, false},
    {GL_SAMPLE_ALPHA_TO_ONE, false},
    {GL_SAMPLE_SHADING, false},
    {GL_PRIMITIVE_RESTART, false},
    {GL_PRIMITIVE_RESTART_FIXED_INDEX, false},
    {GL_CLIP_DISTANCE0, false},
    {GL_CLIP_DISTANCE1, false},
    {GL_CLIP_DISTANCE2, false},
    {GL_CLIP_DISTANCE3, false},
    {GL_CLIP_DISTANCE4, false},
    {GL_CLIP_DISTANCE5, false},
    {GL_CLIP_DISTANCE6, false},
    {GL_CLIP_DISTANCE7, false},
};
_Static_assert(sizeof capabilities / sizeof *capabilities <= STP_GL_CAPABILITIES, "room");

static const struct {
    GLenum target, binding;
} buffers[STP_GL_BUFFERS] = {
    {GL_UNIFORM_BUFFER, GL_UNIFORM_BUFFER_BINDING},
    {GL_SHADER_STORAGE_BUFFER, GL_SHADER_STORAGE_BUFFER_BINDING},
    {GL_DRAW_INDIRECT_BUFFER, GL_DRAW_INDIRECT_BUFFER_BINDING},
    {GL_DISPATCH_INDIRECT_BUFFER, GL_DISPATCH_INDIRECT_BUFFER_BINDING},
    {GL_PIXEL_PACK_BUFFER, GL_PIXEL_PACK_BUFFER_BINDING},
    {GL_PIXEL_UNPACK_BUFFER, GL_PIXEL_UNPACK_BUFFER_BINDING},
};

/* How pixels lie in memory; ours are packed tightly. */
static const struct {
    GLenum name;
    GLint value;
} pixel_stores[STP_GL_PIXEL_STORES] = {
    {GL_PACK_SWAP_BYTES, 0},   {GL_PACK_LSB_FIRST, 0},     {GL_PACK_ROW_LENGTH, 0},
    {GL_PACK_IMAGE_HEIGHT, 0}, {GL_PACK_SKIP_ROWS, 0},     {GL_PACK_SKIP_PIXELS, 0},
    {GL_PACK_SKIP_IMAGES, 0},  {GL_PACK_ALIGNMENT, 1},     {GL_UNPACK_SWAP_BYTES, 0},
    {GL_UNPACK_LSB_FIRST, 0},  {GL_UNPACK_ROW_LENGTH, 0},  {GL_UNPACK_IMAGE_HEIGHT, 0},
    {GL_UNPACK_SKIP_ROWS, 0},  {GL_UNPACK_SKIP_PIXELS, 0}, {GL_UNPACK_SKIP_IMAGES, 0},
    {GL_UNPACK_ALIGNMENT, 1},
};

static void enable(GLenum name, bool on)
{
    (on ? glEnable : glDisable)(name);
}

/* Discards pending errors, at most so many: a lost context reports errors for ever. */
static void discard_errors(void)
{
    for (int i = 0; i < 16 && glGetError() != GL_NO_ERROR; i++)
        continue;
}

static int limited(GLenum name, int most)
{
    GLint value = 0;
    glGetIntegerv(name, &value);
    return value < most ? value : most;
}

static void save_blend(stp_gl_blend *out, GLuint i)
{
    out->on = glIsEnabledi(GL_BLEND, i);
    glGetIntegeri_v(GL_BLEND_SRC_RGB, i, &out->source[0]);
    glGetIntegeri_v(GL_BLEND_SRC_ALPHA, i, &out->source[1]);
    glGetIntegeri_v(GL_BLEND_DST_RGB, i, &out->target[0]);
    glGetIntegeri_v(GL_BLEND_DST_ALPHA, i, &out->target[1]);
    glGetIntegeri_v(GL_BLEND_EQUATION_RGB, i, &out->equation[0]);
    glGetIntegeri_v(GL_BLEND_EQUATION_ALPHA, i, &out->equation[1]);
}

static void restore_blend(const stp_gl_blend *b, GLuint i)
{
    glBlendFuncSeparatei(i, (GLenum)b->source[0], (GLenum)b->target[0], (GLenum)b->source[1],
                         (GLenum)b->target[1]);
    glBlendEquationSeparatei(i, (GLenum)b->equation[0], (GLenum)b->equation[1]);
    (b->on ? glEnablei : glDisablei)(GL_BLEND, i);
}

static void save_raster(stp_gl_state *s)
{
    s->viewport_count = limited(GL_MAX_VIEWPORTS, STP_GL_VIEWPORTS);
    s->draw_buffer_count = limited(GL_MAX_DRAW_BUFFERS, STP_GL_DRAW_BUFFERS);
    for (int i = 0; i < COUNT(capabilities); i++)
        s->capabilities[i] = glIsEnabled(capabilities[i].name);
    for (int i = 0; i < s->draw_buffer_count; i++) {
        save_blend(&s->blend[i], (GLuint)i);
        glGetBooleani_v(GL_COLOR_WRITEMASK, (GLuint)i, s->colour_mask[i]);
    }
    for (int i = 0; i < s->viewport_count; i++) {
        s->scissor_test[i] = glIsEnabledi(GL_SCISSOR_TEST, (GLuint)i);
        glGetFloati_v(GL_VIEWPORT, (GLuint)i, s->viewport[i]);
        glGetIntegeri_v(GL_SCISSOR_BOX, (GLuint)i, s->scissor[i]);
        glGetDoublei_v(GL_DEPTH_RANGE, (GLuint)i, s->depth_range[i]);
    }
    glGetBooleanv(GL_DEPTH_WRITEMASK, &s->depth_mask);
    glGetIntegerv(GL_DEPTH_FUNC, &s->depth_func);
    glGetIntegerv(GL_CLIP_ORIGIN, &s->clip_origin);
    glGetIntegerv(GL_CLIP_DEPTH_MODE, &s->clip_depth);
    glGetIntegerv(GL_POLYGON_MODE, s->polygon_mode); /* gives one value, or two equal ones */
    glGetFloatv(GL_POINT_SIZE, &s->point_size);
    glGetFloatv(GL_LINE_WIDTH, &s->line_width);
    glGetIntegerv(GL_PROVOKING_VERTEX, &s->provoking_vertex);
}

static void save_block(stp_gl_block *out, GLenum buffer, GLenum begin, GLenum bytes, int index)
{
    glGetIntegeri_v(buffer, (GLuint)index, &out->buffer);
    glGetInteger64i_v(begin, (GLuint)index, &out->begin);
    glGetInteger64i_v(bytes, (GLuint)index, &out->bytes);
}

static void save_image(stp_gl_image *out, int index)
{
    glGetIntegeri_v(GL_IMAGE_BINDING_NAME, (GLuint)index, &out->texture);
    glGetIntegeri_v(GL_IMAGE_BINDING_LEVEL, (GLuint)index, &out->level);
    glGetIntegeri_v(GL_IMAGE_BINDING_LAYERED, (GLuint)index, &out->layered);
    glGetIntegeri_v(GL_IMAGE_BINDING_LAYER, (GLuint)index, &out->layer);
    glGetIntegeri_v(GL_IMAGE_BINDING_ACCESS, (GLuint)index, &out->access);
    glGetIntegeri_v(GL_IMAGE_BINDING_FORMAT, (GLuint)index, &out->format);
}

static void save_bindings(stp_gl_state *s)
{
    glGetIntegerv(GL_CURRENT_PROGRAM, &s->program);
    glGetIntegerv(GL_VERTEX_ARRAY_BINDING, &s->vertex_array);
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &s->draw_frame);
    glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &s->read_frame);
    glGetIntegerv(GL_ACTIVE_TEXTURE, &s->active_unit);
    for (int i = 0; i < STP_GL_BUFFERS; i++)
        glGetIntegerv(buffers[i].binding, &s->buffers[i]);
    for (int i = 0; i < STP_GL_PIXEL_STORES; i++)
        glGetIntegerv(pixel_stores[i].name, &s->pixel_stores[i]);
    for (int i = 0; i < STP_GL_UNITS; i++) {
        glActiveTexture(GL_TEXTURE0 + (GLenum)i);
        glGetIntegerv(GL_TEXTURE_BINDING_2D, &s->units[i].flat);
        glGetIntegerv(GL_TEXTURE_BINDING_BUFFER, &s->units[i].buffer);
        glGetIntegerv(GL_SAMPLER_BINDING, &s->units[i].sampler);
    }
    for (int i = 0; i < STP_GL_IMAGES; i++)
        save_image(&s->images[i], i);
    for (int i = 0; i < STP_GL_BLOCKS; i++) {
        save_block(&s->uniform_blocks[i], GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START,
                   GL_UNIFORM_BUFFER_SIZE, i);
        save_block(&s->storage_blocks[i], GL_SHADER_STORAGE_BUFFER_BINDING,
                   GL_SHADER_STORAGE_BUFFER_START, GL_SHADER_STORAGE_BUFFER_SIZE, i);
    }
}

/* Pauses transform feedback, since no program can be changed while it runs. */
static bool pause_feedback(void)
{
    GLint active = 0, paused = 0;
    glGetIntegerv(GL_TRANSFORM_FEEDBACK_ACTIVE, &active);
    glGetIntegerv(GL_TRANSFORM_FEEDBACK_PAUSED, &paused);
    if (!active || paused)
        return false;
    glPauseTransformFeedback();
    return true;
}

/* Sets the state that all of our passes share; depth runs from 1 (near) to 0. */
static void set_ours(void)
{
    for (int i = 0; i < COUNT(capabilities); i++)
        enable(capabilities[i].name, capabilities[i].on);
    glDisable(GL_BLEND);
    glEnable(GL_SCISSOR_TEST);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_GREATER);
    glDepthRange(0.0, 1.0);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    glPointSize(1.0f);
    glLineWidth(1.0f);
    glProvokingVertex(GL_LAST_VERTEX_CONVENTION);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    for (int i = 0; i < STP_GL_PIXEL_STORES; i++)
        glPixelStorei(pixel_stores[i].name, pixel_stores[i].value);
    glBindSamplers(0, STP_GL_UNITS, NULL);
}

void stp_gl_state_enter(stp_gl_state *host)
{
    discard_errors();
    save_raster(host);
    save_bindings(host);
    host->feedback_paused = pause_feedback();
    glGetQueryiv(GL_PRIMITIVES_GENERATED, GL_CURRENT_QUERY, &host->counting);
    set_ours();
}

static void restore_viewports(const stp_gl_state *s)
{
    glViewportArrayv(0, s->viewport_count, s->viewport[0]);
    glScissorArrayv(0, s->viewport_count, s->scissor[0]);
    glDepthRangeArrayv(0, s->viewport_count, s->depth_range[0]);
    for (int i = 0; i < s->viewport_count; i++)
        (s->scissor_test[i] ? glEnablei : glDisablei)(GL_SCISSOR_TEST, (GLuint)i);
    glDepthMask(s->depth_mask);
    glDepthFunc((GLenum)s->depth_func);
    glClipControl((GLenum)s->clip_origin, (GLenum)s->clip_depth);
}

static void restore_colour_mask(const stp_gl_state *s, int i)
{
    const GLboolean *m = s->colour_mask[i];
    glColorMaski((GLuint)i, m[0], m[1], m[2], m[3]);
}

static void restore_raster(const stp_gl_state *s)
{
    for (int i = 0; i < COUNT(capabilities); i++)
        enable(capabilities[i].name, s->capabilities[i]);
    for (int i = 0; i < s->draw_buffer_count; i++) {
        restore_blend(&s->blend[i], (GLuint)i);
        restore_colour_mask(s, i);
    }
    restore_viewports(s);
    glPolygonMode(GL_FRONT_AND_BACK, (GLenum)s->polygon_mode[0]);
    glPointSize(s->point_size);
    glLineWidth(s->line_width);
    glProvokingVertex((GLenum)s->provoking_vertex);
}

static void restore_block(GLenum target, int index, const stp_gl_block *block)
{
    if (block->bytes > 0)
        glBindBufferRange(target, (GLuint)index, (GLuint)block->buffer, (GLintptr)block->begin,
                          (GLsizeiptr)block->bytes);
    else
        glBindBufferBase(target, (GLuint)index, (GLuint)block->buffer);
}

static void restore_units(const stp_gl_state *s)
{
    for (int i = 0; i < STP_GL_UNITS; i++) {
        glActiveTexture(GL_TEXTURE0 + (GLenum)i);
        glBindTexture(GL_TEXTURE_2D, (GLuint)s->units[i].flat);
        glBindTexture(GL_TEXTURE_BUFFER, (GLuint)s->units[i].buffer);
        glBindSampler((GLuint)i, (GLuint)s->units[i].sampler);
    }
    glActiveTexture((GLenum)s->active_unit);
    for (int i = 0; i < STP_GL_IMAGES; i++) {
        const stp_gl_image *m = &s->images[i];
        glBindImageTexture((GLuint)i, (GLuint)m->texture, m->level, m->layered != 0, m->layer,
                           (GLenum)m->access, (GLenum)m->format);
    }
}

static void restore_bindings(const stp_gl_state *s)
{
    restore_units(s);
    for (int i = 0; i < STP_GL_BLOCKS; i++) {
        restore_block(GL_UNIFORM_BUFFER, i, &s->uniform_blocks[i]);
        restore_block(GL_SHADER_STORAGE_BUFFER, i, &s->storage_blocks[i]);
    }
    for (int i = 0; i < STP_GL_BUFFERS; i++) /* after the blocks, whose binding sets these too */
        glBindBuffer(buffers[i].target, (GLuint)s->buffers[i]);
    for (int i = 0; i < STP_GL_PIXEL_STORES; i++)
        glPixelStorei(pixel_stores[i].name, s->pixel_stores[i]);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, (GLuint)s->draw_frame);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, (GLuint)s->read_frame);
    glBindVertexArray((GLuint)s->vertex_array);
    glUseProgram((GLuint)s->program);
}

void stp_gl_state_leave(const stp_gl_state *host)
{
    restore_raster(host);
    restore_bindings(host);
    if (host->feedback_paused)
        glResumeTransformFeedback();
    discard_errors(); /* such as of a program that the host deleted while in use */
}

bool stp_gl_state_enabled(const stp_gl_state *host, GLenum capability)
{
    for (int i = 0; i < COUNT(capabilities); i++)
        if (capabilities[i].name == capability)
            return host->capabilities[i] != GL_FALSE;
    return false;
}

void stp_gl_state_aim(const stp_gl_state *host)
{
    enable(GL_DEPTH_TEST, stp_gl_state_enabled(host, GL_DEPTH_TEST));
    enable(GL_STENCIL_TEST, stp_gl_state_enabled(host, GL_STENCIL_TEST));
    glEnable(GL_MULTISAMPLE); /* otherwise llvmpipe writes the depth of one sample only */
    for (int i = 1; i < host->draw_buffer_count; i++)
        glColorMaski((GLuint)i, GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    restore_colour_mask(host, 0);
    restore_viewports(host);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, (GLuint)host->draw_frame);
}

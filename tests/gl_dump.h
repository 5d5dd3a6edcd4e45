/* The state of an OpenGL context as lines of text, by asking for it: what a host application may
 * have set and wants to find again. Two dumps are compared line by line. */
#ifndef STP_TESTS_GL_DUMP_H
#define STP_TESTS_GL_DUMP_H

#include <epoxy/gl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct gl_dump {
    char *text;
    size_t length;
} gl_dump;

typedef struct gl_dump_name {
    GLenum name;
    int count; /* of values */
    const char *word;
} gl_dump_name;

#define GL_DUMP_1(name)                                                                            \
    {                                                                                              \
        name, 1, #name                                                                             \
    }
#define GL_DUMP_N(name, count)                                                                     \
    {                                                                                              \
        name, count, #name                                                                         \
    }

static const gl_dump_name gl_dump_enabled[] = {GL_DUMP_1(GL_COLOR_LOGIC_OP),
                                               GL_DUMP_1(GL_CULL_FACE),
                                               GL_DUMP_1(GL_DEBUG_OUTPUT),
                                               GL_DUMP_1(GL_DEBUG_OUTPUT_SYNCHRONOUS),
                                               GL_DUMP_1(GL_DEPTH_CLAMP),
                                               GL_DUMP_1(GL_DEPTH_TEST),
                                               GL_DUMP_1(GL_DITHER),
                                               GL_DUMP_1(GL_FRAMEBUFFER_SRGB),
                                               GL_DUMP_1(GL_LINE_SMOOTH),
                                               GL_DUMP_1(GL_MULTISAMPLE),
                                               GL_DUMP_1(GL_POLYGON_OFFSET_FILL),
                                               GL_DUMP_1(GL_POLYGON_OFFSET_LINE),
                                               GL_DUMP_1(GL_POLYGON_OFFSET_POINT),
                                               GL_DUMP_1(GL_POLYGON_SMOOTH),
                                               GL_DUMP_1(GL_PRIMITIVE_RESTART),
                                               GL_DUMP_1(GL_PRIMITIVE_RESTART_FIXED_INDEX),
                                               GL_DUMP_1(GL_PROGRAM_POINT_SIZE),
                                               GL_DUMP_1(GL_RASTERIZER_DISCARD),
                                               GL_DUMP_1(GL_SAMPLE_ALPHA_TO_COVERAGE),
                                               GL_DUMP_1(GL_SAMPLE_ALPHA_TO_ONE),
                                               GL_DUMP_1(GL_SAMPLE_COVERAGE),
                                               GL_DUMP_1(GL_SAMPLE_MASK),
                                               GL_DUMP_1(GL_SAMPLE_SHADING),
                                               GL_DUMP_1(GL_STENCIL_TEST),
                                               GL_DUMP_1(GL_TEXTURE_CUBE_MAP_SEAMLESS),
                                               GL_DUMP_1(GL_CLIP_DISTANCE0),
                                               GL_DUMP_1(GL_CLIP_DISTANCE1),
                                               GL_DUMP_1(GL_CLIP_DISTANCE2),
                                               GL_DUMP_1(GL_CLIP_DISTANCE3),
                                               GL_DUMP_1(GL_CLIP_DISTANCE4),
                                               GL_DUMP_1(GL_CLIP_DISTANCE5),
                                               GL_DUMP_1(GL_CLIP_DISTANCE6),
                                               GL_DUMP_1(GL_CLIP_DISTANCE7)};

static const gl_dump_name gl_dump_values[] = {GL_DUMP_1(GL_ACTIVE_TEXTURE),
                                              GL_DUMP_1(GL_ARRAY_BUFFER_BINDING),
                                              GL_DUMP_N(GL_BLEND_COLOR, 4),
                                              GL_DUMP_1(GL_CLAMP_READ_COLOR),
                                              GL_DUMP_1(GL_CLIP_ORIGIN),
                                              GL_DUMP_1(GL_CLIP_DEPTH_MODE),
                                              GL_DUMP_N(GL_COLOR_CLEAR_VALUE, 4),
                                              GL_DUMP_1(GL_COPY_READ_BUFFER),
                                              GL_DUMP_1(GL_COPY_WRITE_BUFFER),
                                              GL_DUMP_1(GL_CULL_FACE_MODE),
                                              GL_DUMP_1(GL_CURRENT_PROGRAM),
                                              GL_DUMP_1(GL_DEPTH_CLEAR_VALUE),
                                              GL_DUMP_1(GL_DEPTH_FUNC),
                                              GL_DUMP_1(GL_DEPTH_WRITEMASK),
                                              GL_DUMP_1(GL_DISPATCH_INDIRECT_BUFFER_BINDING),
                                              GL_DUMP_1(GL_DRAW_BUFFER),
                                              GL_DUMP_1(GL_DRAW_BUFFER0),
                                              GL_DUMP_1(GL_DRAW_BUFFER1),
                                              GL_DUMP_1(GL_DRAW_BUFFER2),
                                              GL_DUMP_1(GL_DRAW_FRAMEBUFFER_BINDING),
                                              GL_DUMP_1(GL_DRAW_INDIRECT_BUFFER_BINDING),
                                              GL_DUMP_1(GL_FRONT_FACE),
                                              GL_DUMP_1(GL_LINE_SMOOTH_HINT),
                                              GL_DUMP_1(GL_LINE_WIDTH),
                                              GL_DUMP_1(GL_LOGIC_OP_MODE),
                                              GL_DUMP_1(GL_MIN_SAMPLE_SHADING_VALUE),
                                              GL_DUMP_1(GL_PACK_ALIGNMENT),
                                              GL_DUMP_1(GL_PACK_IMAGE_HEIGHT),
                                              GL_DUMP_1(GL_PACK_LSB_FIRST),
                                              GL_DUMP_1(GL_PACK_ROW_LENGTH),
                                              GL_DUMP_1(GL_PACK_SKIP_IMAGES),
                                              GL_DUMP_1(GL_PACK_SKIP_PIXELS),
                                              GL_DUMP_1(GL_PACK_SKIP_ROWS),
                                              GL_DUMP_1(GL_PACK_SWAP_BYTES),
                                              GL_DUMP_1(GL_PATCH_VERTICES),
                                              GL_DUMP_1(GL_PIXEL_PACK_BUFFER_BINDING),
                                              GL_DUMP_1(GL_PIXEL_UNPACK_BUFFER_BINDING),
                                              GL_DUMP_1(GL_POINT_FADE_THRESHOLD_SIZE),
                                              GL_DUMP_1(GL_POINT_SIZE),
                                              GL_DUMP_1(GL_POINT_SPRITE_COORD_ORIGIN),
                                              GL_DUMP_N(GL_POLYGON_MODE, 2),
                                              GL_DUMP_1(GL_POLYGON_OFFSET_FACTOR),
                                              GL_DUMP_1(GL_POLYGON_OFFSET_UNITS),
                                              GL_DUMP_1(GL_PRIMITIVE_RESTART_INDEX),
                                              GL_DUMP_1(GL_PROGRAM_PIPELINE_BINDING),
                                              GL_DUMP_1(GL_PROVOKING_VERTEX),
                                              GL_DUMP_1(GL_QUERY_BUFFER_BINDING),
                                              GL_DUMP_1(GL_READ_BUFFER),
                                              GL_DUMP_1(GL_READ_FRAMEBUFFER_BINDING),
                                              GL_DUMP_1(GL_RENDERBUFFER_BINDING),
                                              GL_DUMP_1(GL_SAMPLE_COVERAGE_INVERT),
                                              GL_DUMP_1(GL_SAMPLE_COVERAGE_VALUE),
                                              GL_DUMP_1(GL_SHADER_STORAGE_BUFFER_BINDING),
                                              GL_DUMP_1(GL_STENCIL_BACK_FAIL),
                                              GL_DUMP_1(GL_STENCIL_BACK_FUNC),
                                              GL_DUMP_1(GL_STENCIL_BACK_PASS_DEPTH_FAIL),
                                              GL_DUMP_1(GL_STENCIL_BACK_PASS_DEPTH_PASS),
                                              GL_DUMP_1(GL_STENCIL_BACK_REF),
                                              GL_DUMP_1(GL_STENCIL_BACK_VALUE_MASK),
                                              GL_DUMP_1(GL_STENCIL_BACK_WRITEMASK),
                                              GL_DUMP_1(GL_STENCIL_CLEAR_VALUE),
                                              GL_DUMP_1(GL_STENCIL_FAIL),
                                              GL_DUMP_1(GL_STENCIL_FUNC),
                                              GL_DUMP_1(GL_STENCIL_PASS_DEPTH_FAIL),
                                              GL_DUMP_1(GL_STENCIL_PASS_DEPTH_PASS),
                                              GL_DUMP_1(GL_STENCIL_REF),
                                              GL_DUMP_1(GL_STENCIL_VALUE_MASK),
                                              GL_DUMP_1(GL_STENCIL_WRITEMASK),
                                              GL_DUMP_1(GL_TEXTURE_BUFFER_BINDING),
                                              GL_DUMP_1(GL_TRANSFORM_FEEDBACK_BINDING),
                                              GL_DUMP_1(GL_TRANSFORM_FEEDBACK_BUFFER_BINDING),
                                              GL_DUMP_1(GL_TRANSFORM_FEEDBACK_ACTIVE),
                                              GL_DUMP_1(GL_TRANSFORM_FEEDBACK_PAUSED),
                                              GL_DUMP_1(GL_UNIFORM_BUFFER_BINDING),
                                              GL_DUMP_1(GL_UNPACK_ALIGNMENT),
                                              GL_DUMP_1(GL_UNPACK_IMAGE_HEIGHT),
                                              GL_DUMP_1(GL_UNPACK_LSB_FIRST),
                                              GL_DUMP_1(GL_UNPACK_ROW_LENGTH),
                                              GL_DUMP_1(GL_UNPACK_SKIP_IMAGES),
                                              GL_DUMP_1(GL_UNPACK_SKIP_PIXELS),
                                              GL_DUMP_1(GL_UNPACK_SKIP_ROWS),
                                              GL_DUMP_1(GL_UNPACK_SWAP_BYTES),
                                              GL_DUMP_1(GL_VERTEX_ARRAY_BINDING)};

/* By index; how many there are is asked for. */
static const struct {
    gl_dump_name name;
    GLenum limit;
} gl_dump_indexed[] = {
    {GL_DUMP_N(GL_VIEWPORT, 4), GL_MAX_VIEWPORTS},
    {GL_DUMP_N(GL_SCISSOR_BOX, 4), GL_MAX_VIEWPORTS},
    {GL_DUMP_N(GL_DEPTH_RANGE, 2), GL_MAX_VIEWPORTS},
    {GL_DUMP_N(GL_COLOR_WRITEMASK, 4), GL_MAX_DRAW_BUFFERS},
    {GL_DUMP_1(GL_BLEND_SRC_RGB), GL_MAX_DRAW_BUFFERS},
    {GL_DUMP_1(GL_BLEND_SRC_ALPHA), GL_MAX_DRAW_BUFFERS},
    {GL_DUMP_1(GL_BLEND_DST_RGB), GL_MAX_DRAW_BUFFERS},
    {GL_DUMP_1(GL_BLEND_DST_ALPHA), GL_MAX_DRAW_BUFFERS},
    {GL_DUMP_1(GL_BLEND_EQUATION_RGB), GL_MAX_DRAW_BUFFERS},
    {GL_DUMP_1(GL_BLEND_EQUATION_ALPHA), GL_MAX_DRAW_BUFFERS},
    {GL_DUMP_1(GL_IMAGE_BINDING_NAME), GL_MAX_IMAGE_UNITS},
    {GL_DUMP_1(GL_IMAGE_BINDING_LEVEL), GL_MAX_IMAGE_UNITS},
    {GL_DUMP_1(GL_IMAGE_BINDING_LAYERED), GL_MAX_IMAGE_UNITS},
    {GL_DUMP_1(GL_IMAGE_BINDING_LAYER), GL_MAX_IMAGE_UNITS},
    {GL_DUMP_1(GL_IMAGE_BINDING_ACCESS), GL_MAX_IMAGE_UNITS},
    {GL_DUMP_1(GL_IMAGE_BINDING_FORMAT), GL_MAX_IMAGE_UNITS},
    {GL_DUMP_1(GL_UNIFORM_BUFFER_BINDING), GL_MAX_UNIFORM_BUFFER_BINDINGS},
    {GL_DUMP_1(GL_UNIFORM_BUFFER_START), GL_MAX_UNIFORM_BUFFER_BINDINGS},
    {GL_DUMP_1(GL_UNIFORM_BUFFER_SIZE), GL_MAX_UNIFORM_BUFFER_BINDINGS},
    {GL_DUMP_1(GL_SHADER_STORAGE_BUFFER_BINDING), GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS},
    {GL_DUMP_1(GL_SHADER_STORAGE_BUFFER_START), GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS},
    {GL_DUMP_1(GL_SHADER_STORAGE_BUFFER_SIZE), GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS},
    {GL_DUMP_1(GL_ATOMIC_COUNTER_BUFFER_BINDING), GL_MAX_ATOMIC_COUNTER_BUFFER_BINDINGS},
    {GL_DUMP_1(GL_TRANSFORM_FEEDBACK_BUFFER_BINDING), GL_MAX_TRANSFORM_FEEDBACK_BUFFERS},
    {GL_DUMP_1(GL_SAMPLE_MASK_VALUE), GL_MAX_SAMPLE_MASK_WORDS}};

static const gl_dump_name gl_dump_unit[] = {GL_DUMP_1(GL_SAMPLER_BINDING),
                                            GL_DUMP_1(GL_TEXTURE_BINDING_1D),
                                            GL_DUMP_1(GL_TEXTURE_BINDING_1D_ARRAY),
                                            GL_DUMP_1(GL_TEXTURE_BINDING_2D),
                                            GL_DUMP_1(GL_TEXTURE_BINDING_2D_ARRAY),
                                            GL_DUMP_1(GL_TEXTURE_BINDING_2D_MULTISAMPLE),
                                            GL_DUMP_1(GL_TEXTURE_BINDING_2D_MULTISAMPLE_ARRAY),
                                            GL_DUMP_1(GL_TEXTURE_BINDING_3D),
                                            GL_DUMP_1(GL_TEXTURE_BINDING_BUFFER),
                                            GL_DUMP_1(GL_TEXTURE_BINDING_CUBE_MAP),
                                            GL_DUMP_1(GL_TEXTURE_BINDING_CUBE_MAP_ARRAY),
                                            GL_DUMP_1(GL_TEXTURE_BINDING_RECTANGLE)};

static const gl_dump_name gl_dump_queries[] = {
    GL_DUMP_1(GL_SAMPLES_PASSED), GL_DUMP_1(GL_ANY_SAMPLES_PASSED),
    GL_DUMP_1(GL_PRIMITIVES_GENERATED), GL_DUMP_1(GL_TIME_ELAPSED),
    GL_DUMP_1(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN)};

#define GL_DUMP_COUNT(array) (sizeof(array) / sizeof *(array))

static inline void gl_dump_line(gl_dump *d, const char *word, int index, const double *values,
                                int count)
{
    char line[256];
    int length = snprintf(line, sizeof line, "%s[%d]", word, index);
    for (int i = 0; i < count; i++)
        length += snprintf(line + length, sizeof line - (size_t)length, " %.9g", values[i]);
    line[length++] = '\n';
    d->text = realloc(d->text, d->length + (size_t)length + 1);
    memcpy(d->text + d->length, line, (size_t)length);
    d->length += (size_t)length;
    d->text[d->length] = '\0';
}

static inline int gl_dump_limit(GLenum name)
{
    GLint value = 0;
    glGetIntegerv(name, &value);
    return value;
}

/* Free .text. The active unit is moved and put back. */
static inline gl_dump gl_dump_take(void)
{
    gl_dump d = {0};
    GLint active = 0, query = 0;
    double values[4] = {0.0};
    for (size_t i = 0; i < GL_DUMP_COUNT(gl_dump_enabled); i++) {
        values[0] = glIsEnabled(gl_dump_enabled[i].name);
        gl_dump_line(&d, gl_dump_enabled[i].word, -1, values, 1);
    }
    for (size_t i = 0; i < GL_DUMP_COUNT(gl_dump_values); i++) {
        memset(values, 0, sizeof values);
        glGetDoublev(gl_dump_values[i].name, values);
        gl_dump_line(&d, gl_dump_values[i].word, -1, values, gl_dump_values[i].count);
    }
    for (size_t i = 0; i < GL_DUMP_COUNT(gl_dump_indexed); i++)
        for (int k = 0; k < gl_dump_limit(gl_dump_indexed[i].limit); k++) {
            glGetDoublei_v(gl_dump_indexed[i].name.name, (GLuint)k, values);
            gl_dump_line(&d, gl_dump_indexed[i].name.word, k, values,
                         gl_dump_indexed[i].name.count);
        }
    for (int k = 0; k < gl_dump_limit(GL_MAX_DRAW_BUFFERS); k++) {
        values[0] = glIsEnabledi(GL_BLEND, (GLuint)k);
        gl_dump_line(&d, "GL_BLEND", k, values, 1);
    }
    for (int k = 0; k < gl_dump_limit(GL_MAX_VIEWPORTS); k++) {
        values[0] = glIsEnabledi(GL_SCISSOR_TEST, (GLuint)k);
        gl_dump_line(&d, "GL_SCISSOR_TEST", k, values, 1);
    }
    glGetIntegerv(GL_ACTIVE_TEXTURE, &active);
    for (int k = 0; k < gl_dump_limit(GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS); k++) {
        glActiveTexture(GL_TEXTURE0 + (GLenum)k);
        for (size_t i = 0; i < GL_DUMP_COUNT(gl_dump_unit); i++) {
            glGetDoublev(gl_dump_unit[i].name, values);
            gl_dump_line(&d, gl_dump_unit[i].word, k, values, 1);
        }
    }
    glActiveTexture((GLenum)active);
    for (size_t i = 0; i < GL_DUMP_COUNT(gl_dump_queries); i++) {
        glGetQueryiv(gl_dump_queries[i].name, GL_CURRENT_QUERY, &query);
        values[0] = query;
        gl_dump_line(&d, gl_dump_queries[i].word, -1, values, 1);
    }
    return d;
}

/* Prints the lines that differ; their number. */
static inline int gl_dump_compare(const gl_dump *a, const gl_dump *b, const char *after)
{
    int differ = 0;
    const char *x = a->text, *y = b->text;
    while (*x != '\0' && *y != '\0') {
        size_t n = strcspn(x, "\n") + 1, m = strcspn(y, "\n") + 1;
        if (n != m || memcmp(x, y, n) != 0) {
            printf("after %s: was %.*s, is %.*s\n", after, (int)n - 1, x, (int)m - 1, y);
            differ++;
        }
        x += n;
        y += m;
    }
    return differ;
}

#endif

/* Draws bare one-pixel points. */
#include "tools/bench/bare_points.h"

#include "base/clock.h"
#include "base/memory.h"
#include "runtime/gl/gl_context.h"

#include <epoxy/gl.h>
#include <stdlib.h>
#include <string.h>

#define POINTS_LIMIT INT32_MAX

static const char vertex_text[] = "#version 450 core\n"
                                  "layout(location = 0) in vec3 position;\n"
                                  "layout(location = 0) uniform mat4 clip;\n"
                                  "void main() { gl_Position = clip * vec4(position, 1.0); }\n";
static const char fragment_text[] = "#version 450 core\n"
                                    "layout(location = 0) out vec4 colour;\n"
                                    "void main() { colour = vec4(1.0); }\n";

static void attach(GLuint program, GLenum kind, const char *text)
{
    GLuint shader = glCreateShader(kind);
    glShaderSource(shader, 1, &text, NULL);
    glCompileShader(shader);
    glAttachShader(program, shader);
    glDeleteShader(shader);
}

static stp_status create_program(GLuint *out, stp_error *err)
{
    GLint linked = 0;
    GLuint program = glCreateProgram();
    attach(program, GL_VERTEX_SHADER, vertex_text);
    attach(program, GL_FRAGMENT_SHADER, fragment_text);
    glLinkProgram(program);
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (!linked) {
        glDeleteProgram(program);
        return stp_error_set(err, STP_GL, "the program for bare points does not link");
    }
    *out = program;
    return STP_OK;
}

/* Sets the matrix from positions relative to the ball's centre to clip coordinates, columns first.
 */
static void set_clip(GLuint program, const stp_model *model, const stp_view *view)
{
    const stp_dvec3 rows[3] = {view->right, view->up, view->back};
    stp_dvec3 offset = stp_dvec3_sub(model->ball.centre, view->eye);
    double range = view->ball_far - view->ball_near;
    double scale[2] = {2.0 * view->f / view->width, 2.0 * view->f / view->height};
    float m[16] = {0.0f};
    for (int i = 0; i < 3; i++) {
        double r[4] = {rows[i].x, rows[i].y, rows[i].z, stp_dvec3_dot(rows[i], offset)};
        for (int k = 0; k < 4; k++)
            if (i < 2) {
                m[4 * k + i] = (float)(scale[i] * r[k]);
            } else { /* the depth is -r */
                m[4 * k + 2] = (float)(-r[k] * (view->ball_far + view->ball_near) / range);
                m[4 * k + 3] = (float)-r[k];
            }
    }
    m[14] -= (float)(2.0 * view->ball_far * view->ball_near / range);
    glProgramUniformMatrix4fv(program, 0, 1, GL_FALSE, m);
}

static void add_chunk(const stp_chunk *chunk, stp_dvec3 origin, float *positions, uint64_t *count)
{
    for (uint32_t i = 0; i < chunk->patch_count; i++)
        for (uint32_t k = chunk->level_begin[0][i]; k < chunk->level_begin[0][i + 1]; k++) {
            stp_dvec3 p = stp_sample_position(&chunk->samples[0][k], &chunk->patches[i]);
            vec3s q = stp_dvec3_to_float(stp_dvec3_add(origin, p));
            memcpy(positions + 3 * (*count)++, q.raw, sizeof q.raw);
        }
}

static stp_status read_positions(const stp_model *model, float **out, uint64_t *count,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    float *positions = NULL;
    uint64_t read = 0;
    STP_TRY(stp_alloc(&positions, (size_t)model->info->point_count, 3 * sizeof *positions,
                      "positions", err));
    for (uint32_t id = 0; id < model->info->chunk_count; id++) {
        if (model->entries[id].child_count != 0)
            continue;
        STP_TRY(stp_chunk_file_read(model->file, id, 0, &chunk, err));
        add_chunk(chunk, stp_dvec3_sub(model->entries[id].origin, model->ball.centre), positions,
                  &read);
        stp_chunk_destroy(&chunk);
    }
    *out = positions;
    *count = read;
    positions = NULL;
done:
    stp_chunk_destroy(&chunk);
    free(positions);
    return status;
}

static void create_buffer(bare_points *p, const float *positions)
{
    glCreateBuffers(1, &p->buffer);
    glNamedBufferStorage(p->buffer, (GLsizeiptr)(p->count * 3 * sizeof *positions), positions, 0);
    glCreateVertexArrays(1, &p->array);
    glVertexArrayVertexBuffer(p->array, 0, p->buffer, 0, 3 * sizeof *positions);
    glVertexArrayAttribFormat(p->array, 0, 3, GL_FLOAT, GL_FALSE, 0);
    glEnableVertexArrayAttrib(p->array, 0);
}

static void create_frame(bare_points *p)
{
    glCreateRenderbuffers(1, &p->colour);
    glNamedRenderbufferStorage(p->colour, GL_RGBA8, p->width, p->height);
    glCreateRenderbuffers(1, &p->depth);
    glNamedRenderbufferStorage(p->depth, GL_DEPTH_COMPONENT32F, p->width, p->height);
    glCreateFramebuffers(1, &p->frame);
    glNamedFramebufferRenderbuffer(p->frame, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, p->colour);
    glNamedFramebufferRenderbuffer(p->frame, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, p->depth);
}

stp_status bare_points_create(bare_points *out, const stp_model *model, const stp_view *view,
                              stp_error *err)
{
    stp_status status = STP_OK;
    bare_points p = {.width = view->width, .height = view->height};
    float *positions = NULL;
    if (model->info->point_count > POINTS_LIMIT)
        return stp_error_set(err, STP_LIMIT, "%s: too many points for one draw call",
                             stp_chunk_file_path(model->file));
    STP_TRY(read_positions(model, &positions, &p.count, err));
    STP_TRY(create_program(&p.program, err));
    set_clip(p.program, model, view);
    create_buffer(&p, positions);
    create_frame(&p);
    STP_TRY(stp_gl_check("making bare points", err));
    *out = p;
    p = (bare_points){0};
done:
    bare_points_destroy(&p);
    free(positions);
    return status;
}

void bare_points_destroy(bare_points *p)
{
    const GLuint targets[2] = {p->colour, p->depth};
    if (p->program == 0)
        return;
    glDeleteProgram(p->program);
    glDeleteBuffers(1, &p->buffer);
    glDeleteVertexArrays(1, &p->array);
    glDeleteFramebuffers(1, &p->frame);
    glDeleteRenderbuffers(2, targets);
    *p = (bare_points){0};
}

stp_status bare_points_draw(const bare_points *p, double *ms, stp_error *err)
{
    static const float black[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    static const float far_depth = 1.0f;
    double begun = stp_clock_seconds();
    glBindFramebuffer(GL_FRAMEBUFFER, p->frame);
    glDisable(GL_SCISSOR_TEST);
    glViewport(0, 0, p->width, p->height);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_LESS);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    glDisable(GL_PROGRAM_POINT_SIZE);
    glPointSize(1.0f);
    glClearBufferfv(GL_COLOR, 0, black);
    glClearBufferfv(GL_DEPTH, 0, &far_depth);
    glUseProgram(p->program);
    glBindVertexArray(p->array);
    glDrawArrays(GL_POINTS, 0, (GLsizei)p->count);
    glFinish();
    *ms = 1e3 * (stp_clock_seconds() - begun);
    return stp_gl_check("drawing bare points", err);
}

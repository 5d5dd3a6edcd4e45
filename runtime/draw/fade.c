/* Keeps pictures, depths, marks and differences of two frames, used in turn. */
#include "runtime/draw/fade.h"

#include "runtime/gl/gl_context.h"

#include <math.h>

/* A difference below this is gone. */
#define GONE (0.5 / 255.0)

static stp_status resize(stp_fade *f, int width, int height, stp_error *err)
{
    static const GLenum formats[STP_FADE_TARGETS] = {GL_RGBA8, GL_R32F, GL_R8UI, GL_RGBA16F};
    static const GLenum buffers[STP_FADE_TARGETS] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1,
                                                     GL_COLOR_ATTACHMENT2, GL_COLOR_ATTACHMENT3};
    if (f->width == width && f->height == height)
        return STP_OK;
    stp_fade_destroy(f);
    f->width = width;
    f->height = height;
    glCreateFramebuffers(2, f->frames);
    for (int i = 0; i < 2; i++) {
        glCreateTextures(GL_TEXTURE_2D, STP_FADE_TARGETS, f->textures[i]);
        for (int t = 0; t < STP_FADE_TARGETS; t++) {
            glTextureStorage2D(f->textures[i][t], 1, formats[t], width, height);
            glTextureParameteri(f->textures[i][t], GL_TEXTURE_MIN_FILTER, GL_NEAREST);
            glTextureParameteri(f->textures[i][t], GL_TEXTURE_MAG_FILTER, GL_NEAREST);
            glNamedFramebufferTexture(f->frames[i], buffers[t], f->textures[i][t], 0);
        }
        glNamedFramebufferDrawBuffers(f->frames[i], STP_FADE_TARGETS, buffers);
    }
    stp_status status = stp_gl_check("making the textures to fade with", err);
    if (status != STP_OK)
        stp_fade_destroy(f);
    return status;
}

void stp_fade_destroy(stp_fade *f)
{
    if (f->width > 0) {
        glDeleteFramebuffers(2, f->frames);
        glDeleteTextures(STP_FADE_TARGETS, f->textures[0]);
        glDeleteTextures(STP_FADE_TARGETS, f->textures[1]);
    }
    *f = (stp_fade){0};
}

void stp_fade_forget(stp_fade *f)
{
    f->known = false;
    f->left = 0;
}

static void set_uniforms(const stp_fade *f, const stp_gpu_frame *frame, stp_dvec3 eye, double kept)
{
    stp_dvec3 way = stp_dvec3_sub(eye, f->eye);
    const float to[3] = {(float)way.x, (float)way.y, (float)way.z};
    float axes[9];
    bool same = f->known && frame->modes[0] == f->frame.modes[0];
    for (int i = 0; i < 3; i++) {
        axes[i] = f->frame.axis_right[i];
        axes[3 + i] = f->frame.axis_up[i];
        axes[6 + i] = f->frame.axis_back[i];
    }
    glUniform1f(STP_UNIFORM_FADE_KEPT, same ? (float)kept : 0.0f);
    glUniform3fv(STP_UNIFORM_FADE_WAY, 1, to);
    glUniformMatrix3fv(STP_UNIFORM_FADE_AXES, 1, GL_TRUE, axes);
    glUniform1f(STP_UNIFORM_FADE_F, f->frame.viewport[2]);
}

/* Clears the targets, which stay empty where no tile is drawn. */
static void clear(const stp_fade *f, int which)
{
    static const float nothing[4] = {0.0f};
    static const GLuint no_mark[4] = {0};
    glBindFramebuffer(GL_FRAMEBUFFER, f->frames[which]);
    glScissor(0, 0, f->width, f->height);
    for (int t = 0; t < STP_FADE_TARGETS; t++)
        if (t == 2)
            glClearBufferuiv(GL_COLOR, t, no_mark);
        else
            glClearBufferfv(GL_COLOR, t, nothing);
}

stp_status stp_fade_apply(stp_fade *f, GLuint program, const stp_pyramid *pyramid,
                          const stp_tiles *tiles, const stp_gpu_frame *frame, stp_dvec3 eye,
                          double kept, bool changes, stp_error *err)
{
    stp_status status = resize(f, pyramid->width, pyramid->height, err);
    if (status != STP_OK || (f->known && f->left == 0 && !changes))
        return status;
    f->left = changes ? 1 + (int)(log(GONE) / log(kept)) : f->left > 0 ? f->left - 1 : 0;
    int last = f->now, now = 1 - last;
    const GLuint fresh[3] = {pyramid->picture, pyramid->picture_depth, pyramid->picture_mark};
    clear(f, now);
    glUseProgram(program);
    set_uniforms(f, frame, eye, f->left > 0 ? kept : 0.0);
    glBindTextures(STP_UNIT_FINE, 3, fresh);
    glBindTextures(STP_UNIT_FINE + 3, STP_FADE_TARGETS, f->textures[last]);
    stp_tiles_draw(tiles, 0);
    glCopyImageSubData(f->textures[now][0], GL_TEXTURE_2D, 0, 0, 0, 0, pyramid->picture,
                       GL_TEXTURE_2D, 0, 0, 0, 0, f->width, f->height, 1);
    f->now = now;
    f->known = true;
    f->frame = *frame;
    f->eye = eye;
    return STP_OK;
}

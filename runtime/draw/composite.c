/* Draws the finished picture into the host's framebuffer. */
#include "runtime/draw/composite.h"

#include "runtime/gl/gpu_layout.h"
#include "runtime/gl/shader.h"

#include <math.h>

/* Locations of shaders/shade/composite.frag. */
enum {
    UNIFORM_CORNER = 0,
    UNIFORM_FLIPPED = 1,
    UNIFORM_WINDOW_DEPTH = 2,
    UNIFORM_ORTHOGRAPHIC = 3,
    UNIFORM_CLAMPED = 4,
    UNIFORM_LINEAR_LIGHT = 5
};

static bool zero_to_one(const stp_gl_state *host)
{
    return host->clip_depth == GL_ZERO_TO_ONE;
}

/* Checks that a framebuffer is bound, and that its first draw buffer, if any, takes fractions. */
static stp_status check_frame(const stp_gl_state *host, stp_error *err)
{
    GLuint frame = (GLuint)host->draw_frame;
    GLint buffer = GL_NONE, type = GL_NONE;
    GLenum complete = glCheckNamedFramebufferStatus(frame, GL_DRAW_FRAMEBUFFER);
    if (complete != GL_FRAMEBUFFER_COMPLETE)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "the framebuffer to draw into, %u, is not complete (0x%04x): bind "
                             "one that is",
                             frame, complete);
    if (frame == 0)
        return STP_OK;
    glGetIntegerv(GL_DRAW_BUFFER0, &buffer); /* the framebuffer is still bound */
    if (buffer != GL_NONE)
        glGetNamedFramebufferAttachmentParameteriv(frame, (GLenum)buffer,
                                                   GL_FRAMEBUFFER_ATTACHMENT_COMPONENT_TYPE, &type);
    if (type == GL_INT || type == GL_UNSIGNED_INT)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "the framebuffer to draw into, %u, has a first draw buffer of "
                             "integers: give one of colours",
                             frame);
    return STP_OK;
}

/* The depth in front of which the host's depth range cuts; 0 if the range cuts nothing there. */
static double near_of(const stp_gl_state *host, const stp_view *view)
{
    const double ends[2] = {zero_to_one(host) ? 0.0 : -1.0, 1.0};
    double nearest = INFINITY;
    if (stp_gl_state_enabled(host, GL_DEPTH_CLAMP))
        return 0.0;
    for (int i = 0; i < 2; i++) {
        double rest = ends[i] - view->ndc[0];
        double depth = view->orthographic ? rest / view->ndc[1] : view->ndc[1] / rest;
        if (depth > 0.0 || view->orthographic)
            nearest = fmin(nearest, depth);
    }
    return isfinite(nearest) ? fmax(0.0, nearest) : 0.0;
}

stp_status stp_composite_view(stp_view *out, const stp_gl_state *host, const stp_view *view,
                              stp_error *err)
{
    const GLfloat *v = host->viewport[0];
    if (view->ndc[1] == 0.0)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "the view says nothing of the host's depth: make it with "
                             "stp_view_from_matrices");
    if (v[2] != (float)view->width || v[3] != (float)view->height || v[0] != floorf(v[0]) ||
        v[1] != floorf(v[1]))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "the viewport is %g x %g pixels at %g, %g, the view was made for %d x "
                             "%d at whole pixels: set one like the other",
                             (double)v[2], (double)v[3], (double)v[0], (double)v[1], view->width,
                             view->height);
    stp_status status = check_frame(host, err);
    if (status != STP_OK)
        return status;
    *out = *view;
    out->near_depth = fmax(view->near_depth, near_of(host, view));
    out->ball_near = fmax(view->ball_near, out->near_depth);
    out->ball_far = fmax(view->ball_far, 2.0 * out->near_depth);
    return STP_OK;
}

stp_status stp_composite_create(GLuint *program, const char *folder, stp_error *err)
{
    const stp_program_params params = {
        .vertex = "screen.vert", .fragment = "composite.frag", .folder = folder};
    return stp_program_create(program, &params, err);
}

/* How the view's normalised device coordinates map to values of the host's depth buffer. */
static void window_depth(const stp_gl_state *host, const stp_view *view, float out[4])
{
    double begin = host->depth_range[0][0], end = host->depth_range[0][1];
    double scale = zero_to_one(host) ? end - begin : 0.5 * (end - begin);
    double offset = zero_to_one(host) ? begin : 0.5 * (begin + end);
    out[0] = (float)(offset + scale * view->ndc[0]);
    out[1] = (float)(scale * view->ndc[1]);
    out[2] = (float)fmin(begin, end);
    out[3] = (float)fmax(begin, end);
}

void stp_composite_draw(GLuint program, GLuint empty_array, const stp_pyramid *pyramid,
                        const stp_gl_state *host, const stp_view *view, const stp_target *target)
{
    float depth[4];
    window_depth(host, view, depth);
    stp_gl_state_aim(host);
    glUseProgram(program);
    glUniform2i(UNIFORM_CORNER, (GLint)host->viewport[0][0], (GLint)host->viewport[0][1]);
    glUniform1i(UNIFORM_FLIPPED, host->clip_origin == GL_UPPER_LEFT);
    glUniform4fv(UNIFORM_WINDOW_DEPTH, 1, depth);
    glUniform1i(UNIFORM_ORTHOGRAPHIC, view->orthographic);
    glUniform1i(UNIFORM_CLAMPED, stp_gl_state_enabled(host, GL_DEPTH_CLAMP));
    glUniform1i(UNIFORM_LINEAR_LIGHT, target != NULL && target->linear_light);
    glBindTextureUnit(STP_UNIT_FINE, pyramid->picture);
    glBindTextureUnit(STP_UNIT_FINE + 1, pyramid->picture_depth);
    glBindVertexArray(empty_array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

/* What a host takes of the last picture: its pixels, its depths, a copy. */
#include "runtime/gl_context.h"
#include "runtime/gl_state.h"
#include "runtime/inspect.h"

stp_status stp_renderer_read(stp_renderer *r, uint8_t *rgba, stp_error *err)
{
    const stp_pyramid *p = stp_renderer_inspect(r).pyramid;
    stp_gl_state host;
    stp_gl_state_enter(&host);
    glGetTextureImage(p->picture, 0, GL_RGBA, GL_UNSIGNED_BYTE, 4 * p->width * p->height, rgba);
    stp_status status = stp_gl_check("reading the picture", err);
    stp_gl_state_leave(&host);
    return status;
}

stp_status stp_renderer_depth_at(stp_renderer *r, int x, int y, float *depth, stp_error *err)
{
    const stp_pyramid *p = stp_renderer_inspect(r).pyramid;
    stp_gl_state host;
    if (x < 0 || y < 0 || x >= p->width || y >= p->height)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "pixel %d, %d lies outside the picture", x,
                             y);
    stp_gl_state_enter(&host);
    glGetTextureSubImage(p->picture_depth, 0, x, y, 0, 1, 1, 1, GL_RED, GL_FLOAT, sizeof *depth,
                         depth);
    stp_status status = stp_gl_check("reading a depth", err);
    stp_gl_state_leave(&host);
    return status;
}

void stp_renderer_present(stp_renderer *r, unsigned framebuffer, int width, int height)
{
    const stp_pyramid *p = stp_renderer_inspect(r).pyramid;
    stp_gl_state host;
    stp_gl_state_enter(&host);
    glDisable(GL_SCISSOR_TEST);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, width, height); /* software drivers ask for a window's new size only here */
    glBlitNamedFramebuffer(p->picture_frame, framebuffer, 0, 0, p->width, p->height, 0, 0, width,
                           height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    stp_gl_state_leave(&host);
}

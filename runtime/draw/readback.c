/* Reads the last picture for a host: pixels, depths, picks, normals, a copy. */
#include "runtime/draw/pick.h"
#include "runtime/draw/pixel_read.h"
#include "runtime/frame_ready.h"
#include "runtime/gl/gl_context.h"
#include "runtime/gl/gl_state.h"
#include "runtime/renderer_parts.h"

stp_status stp_renderer_read(stp_renderer *r, uint8_t *rgba, stp_error *err)
{
    const stp_pyramid *p = &r->pyramid;
    stp_gl_state host;
    stp_gl_state_enter(&host);
    glGetTextureImage(p->picture, 0, GL_RGBA, GL_UNSIGNED_BYTE, 4 * p->width * p->height, rgba);
    stp_status status = stp_gl_check("reading the picture", err);
    stp_gl_state_leave(&host);
    return status;
}

stp_status stp_renderer_depth_at(stp_renderer *r, int x, int y, float *depth, stp_error *err)
{
    const stp_pyramid *p = &r->pyramid;
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

stp_status stp_renderer_read_depth(stp_renderer *r, float *depth, stp_error *err)
{
    const stp_pyramid *p = &r->pyramid;
    const size_t bytes = (size_t)p->width * (size_t)p->height * sizeof *depth;
    stp_gl_state host;
    if (bytes > INT32_MAX)
        return stp_error_set(err, STP_LIMIT, "%d x %d depths are too many to read at once",
                             p->width, p->height);
    stp_gl_state_enter(&host);
    glGetTextureImage(p->picture_depth, 0, GL_RED, GL_FLOAT, (GLsizei)bytes, depth);
    stp_status status = stp_gl_check("reading depths", err);
    stp_gl_state_leave(&host);
    return status;
}

stp_status stp_renderer_read_normals(stp_renderer *r, float *xyz, stp_error *err)
{
    stp_gl_state host;
    if (r->kept == NULL)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "the last picture was not drawn with keep_pixels: its normals are "
                             "gone");
    stp_gl_state_enter(&host);
    stp_status status = stp_pixel_read_normals(r->kept[STP_TARGET_PAINT], &r->frame, xyz, err);
    stp_gl_state_leave(&host);
    return status;
}

void stp_renderer_present(stp_renderer *r, unsigned framebuffer, int width, int height)
{
    stp_renderer_present_columns(r, framebuffer, width, height, 0, width);
}

void stp_renderer_present_columns(stp_renderer *r, unsigned framebuffer, int width, int height,
                                  int begin, int end)
{
    const stp_pyramid *p = &r->pyramid;
    GLenum filter = width == p->width && height == p->height ? GL_NEAREST : GL_LINEAR;
    stp_gl_state host;
    stp_gl_state_enter(&host);
    glScissor(begin, 0, end - begin, height);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, width, height); /* software drivers notice a new window size only here */
    glBlitNamedFramebuffer(p->picture_frames[STP_PICTURE_WITH_DEPTH], framebuffer, 0, 0, p->width,
                           p->height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, filter);
    stp_gl_state_leave(&host);
}

/* Restores the finished pixel of the last picture in the pyramid. */
static stp_status finish_pixel(stp_renderer *r, int x, int y, stp_error *err)
{
    if (r->settling.phase == STP_SETTLE_RUNS) { /* its passes already overwrite level 0 */
        stp_view view = r->motion.last;
        stp_draw_params params = r->drawn;
        r->motion.known = false;
        stp_status status = stp_renderer_draw(r, &view, &params, NULL, err);
        if (status != STP_OK)
            return status;
    }
    if (!stp_reconstruct_finishes(&r->reconstruct, r->last.pyramid_levels))
        return STP_OK;
    stp_status status = stp_pyramid_keep_level_0(&r->pyramid, err);
    if (status != STP_OK)
        return status;
    stp_renderer_bind_frame(r);
    stp_reconstruct_keep_pixel(&r->reconstruct, &r->pyramid, r->last.pyramid_levels, &r->tiles, x,
                               y);
    return STP_OK;
}

static stp_status pick(stp_renderer *r, int x, int y, stp_pick *out, stp_error *err)
{
    stp_status status = STP_OK;
    if (r->cache == NULL || !stp_pick_choose(&r->pyramid, &x, &y)) {
        *out = (stp_pick){.chunk = STP_PICK_NO_CHUNK, .level = -1};
        return stp_gl_check("picking", err);
    }
    STP_TRY(finish_pixel(r, x, y, err));
    STP_TRY(stp_pick_find(out,
                          &(stp_pick_params){.pyramid = &r->pyramid,
                                             .texture = stp_block_cache_texture(r->cache),
                                             .squares = &r->project.squares,
                                             .frame = &r->frame,
                                             .drawn = &r->drawn,
                                             .eye = r->eye,
                                             .finished = stp_reconstruct_finishes(
                                                 &r->reconstruct, r->last.pyramid_levels),
                                             .x = x,
                                             .y = y},
                          err));
done:
    return status;
}

stp_status stp_renderer_pick(stp_renderer *r, int x, int y, stp_pick *out, stp_error *err)
{
    stp_gl_state host;
    if (x < 0 || y < 0 || x >= r->pyramid.width || y >= r->pyramid.height)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "pixel %d, %d lies outside the picture", x,
                             y);
    stp_gl_state_enter(&host);
    stp_status status = pick(r, x, y, out, err);
    stp_gl_state_leave(&host);
    return status;
}

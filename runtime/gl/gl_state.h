/* Saves the OpenGL state of a host application while stipple draws, and restores it.
 *
 * Between enter and leave the context is in the state that our passes rely on, whatever the host
 * set. After leave the state is as it was. Some things GL can neither report nor restore; stipple.h
 * warns the host about them: conditional rendering, running queries of samples, a program deleted
 * while in use, values of subroutine uniforms, the buffer bound as our own memory (lazy_buffer.h).
 * Threads: the render thread. */
#ifndef STP_RUNTIME_GL_GL_STATE_H
#define STP_RUNTIME_GL_GL_STATE_H

#include <epoxy/gl.h>
#include <stdbool.h>

/* How much state is saved. Drivers have GL_MAX_VIEWPORTS 16 and GL_MAX_DRAW_BUFFERS 8. Texture
 * units, image units and blocks of each kind: all that the renderer binds, from 0. */
enum {
    STP_GL_VIEWPORTS = 16,
    STP_GL_DRAW_BUFFERS = 8,
    STP_GL_UNITS = 14,
    STP_GL_IMAGES = 8,
    STP_GL_BLOCKS = 7
};
enum { STP_GL_CAPABILITIES = 32, STP_GL_BUFFERS = 6, STP_GL_PIXEL_STORES = 16 };

typedef struct stp_gl_block {
    GLint buffer;
    GLint64 begin, bytes; /* 0, 0: the whole buffer */
} stp_gl_block;

typedef struct stp_gl_image {
    GLint texture, level, layered, layer, access, format;
} stp_gl_image;

typedef struct stp_gl_blend {
    GLboolean on;
    GLint source[2], target[2], equation[2]; /* of colour, of alpha */
} stp_gl_blend;

typedef struct stp_gl_unit {
    GLint flat, buffer, sampler; /* bound to GL_TEXTURE_2D, to GL_TEXTURE_BUFFER; the sampler */
} stp_gl_unit;

typedef struct stp_gl_state {
    GLboolean capabilities[STP_GL_CAPABILITIES]; /* in the order of gl_state.c's table */
    GLboolean colour_mask[STP_GL_DRAW_BUFFERS][4];
    stp_gl_blend blend[STP_GL_DRAW_BUFFERS];
    GLboolean scissor_test[STP_GL_VIEWPORTS];
    GLfloat viewport[STP_GL_VIEWPORTS][4];
    GLint scissor[STP_GL_VIEWPORTS][4];
    GLdouble depth_range[STP_GL_VIEWPORTS][2];
    int viewport_count, draw_buffer_count;
    GLboolean depth_mask;
    GLint depth_func, clip_origin, clip_depth, polygon_mode[2];
    GLfloat point_size, line_width;
    GLint provoking_vertex;
    GLint program, vertex_array, draw_frame, read_frame, active_unit;
    GLint buffers[STP_GL_BUFFERS], pixel_stores[STP_GL_PIXEL_STORES];
    stp_gl_unit units[STP_GL_UNITS];
    stp_gl_image images[STP_GL_IMAGES];
    stp_gl_block uniform_blocks[STP_GL_BLOCKS], storage_blocks[STP_GL_BLOCKS];
    bool feedback_paused; /* stp_gl_state_enter paused transform feedback */
    GLint counting;       /* the running query of GL_PRIMITIVES_GENERATED, or 0 */
} stp_gl_state;

/* Saves the host's state and sets ours. Discards pending GL errors, which would otherwise be taken
 * for ours. */
void stp_gl_state_enter(stp_gl_state *host);
/* Restores the host's state. */
void stp_gl_state_leave(const stp_gl_state *host);

/* Whether the host had a capability enabled. Only for capabilities in gl_state.c's table. */
bool stp_gl_state_enabled(const stp_gl_state *host, GLenum capability);

/* Restores the part of the host's state that decides where a picture lands: framebuffer, viewport,
 * scissor, depth and stencil test, clip control, and the colour mask of the first draw buffer.
 * Masks the other draw buffers; blending stays off. */
void stp_gl_state_aim(const stp_gl_state *host);

#endif

/* Copies the finished picture into a host's framebuffer, through the host's viewport and depth
 * test, like one draw call of the host. Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_COMPOSITE_H
#define STP_RUNTIME_DRAW_COMPOSITE_H

#include "runtime/draw/pyramid.h"
#include "runtime/gl/gl_state.h"
#include "runtime/stipple.h"

/* The view to draw: `view`, with the near plane where the host's depth range cuts. Errors:
 * INVALID_ARGUMENT (the view was made from a camera, or not for this viewport), UNSUPPORTED (the
 * bound framebuffer cannot be drawn into; the message says why). */
stp_status stp_composite_view(stp_view *out, const stp_gl_state *host, const stp_view *view,
                              stp_error *err);

/* folder: as in stp_program_params. Errors: those of stp_program_create. */
stp_status stp_composite_create(GLuint *program, const char *folder, stp_error *err);

/* Draws the pyramid's picture under the host state that decides where a picture lands. target may
 * be NULL. */
void stp_composite_draw(GLuint program, GLuint empty_array, const stp_pyramid *pyramid,
                        const stp_gl_state *host, const stp_view *view, const stp_target *target);

#endif

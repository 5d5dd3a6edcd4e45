/* The last step of drawing into a host's framebuffer: the finished picture goes through the host's
 * viewport and depth test, as one draw call of the host's would. Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_COMPOSITE_H
#define STP_RUNTIME_DRAW_COMPOSITE_H

#include "runtime/draw/pyramid.h"
#include "runtime/gl/gl_state.h"
#include "runtime/stipple.h"

/* The view as it is drawn: nothing in front of where the host's depth range cuts. Errors:
 * INVALID_ARGUMENT (the view was made of a camera, or not for this viewport), UNSUPPORTED (what the
 * host has bound cannot be drawn into: the sentence says why). */
stp_status stp_composite_view(stp_view *out, const stp_gl_state *host, const stp_view *view,
                              stp_error *err);

/* Errors: those of stp_program_create. folder: as there. */
stp_status stp_composite_create(GLuint *program, const char *folder, stp_error *err);

/* Draws the pyramid's picture, with the host's state that decides where it lands. target may be
 * NULL. */
void stp_composite_draw(GLuint program, GLuint empty_array, const stp_pyramid *pyramid,
                        const stp_gl_state *host, const stp_view *view, const stp_target *target);

#endif

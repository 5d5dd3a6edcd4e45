/* Gets ready to draw: compiles the programs that a picture's parameters ask for, and makes room for
 * its pixels. Threads: the render thread. */
#ifndef STP_RUNTIME_FRAME_READY_H
#define STP_RUNTIME_FRAME_READY_H

#include "runtime/draw/project.h"
#include "runtime/frame.h"

/* Compiles the programs for the picture, unless the last one's fit, and makes room for its pixels.
 * A picture first asks for blocks, then does this, since the former takes time of the network, the
 * latter of the processor. Does nothing the second time. Errors: GL, OUT_OF_MEMORY. */
stp_status stp_frame_ready(stp_renderer *r, stp_drawing *d, stp_error *err);
/* Compiles the programs of a variant, and of one road of projection, in place of the old ones.
 * Errors: GL, OUT_OF_MEMORY, NOT_FOUND. */
stp_status stp_frame_compile(stp_renderer *r, const stp_variant *variant, stp_lod lod,
                             stp_error *err);
/* Binds what all passes read. Call this in the state that stp_gl_state_enter sets. */
void stp_renderer_bind_frame(const stp_renderer *r);

#endif

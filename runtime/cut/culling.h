/* What a picture leaves out because nobody can see it: backs of closed surfaces (docs/closed.md).
 * Threads: any. */
#ifndef STP_RUNTIME_CUT_CULLING_H
#define STP_RUNTIME_CUT_CULLING_H

#include "runtime/cut/scene.h"
#include "runtime/gl/gpu_layout.h"

/* Sets modes[1], modes[3] and openings of a frame: of stp_draw_params.cull, and for AUTO and NONE
 * by where the eye is, for both draw the same outlines. */
void stp_culling_place(stp_gpu_frame *frame, const stp_draw_params *params, const stp_view *view,
                       const stp_scene *scene);

#endif

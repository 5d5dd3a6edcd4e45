/* Decides which backs a picture leaves out because nobody can see them: backs of closed surfaces
 * (docs/closed.md). Threads: any. */
#ifndef STP_RUNTIME_CUT_CULLING_H
#define STP_RUNTIME_CUT_CULLING_H

#include "runtime/cut/scene.h"
#include "runtime/gl/gpu_layout.h"

/* Sets modes[1], modes[3] and openings of a frame by stp_draw_params.cull. For AUTO and NONE the
 * position of the eye decides, too: both draw the same outlines. Backs of grids of heights seen
 * from above are drawn, but as hidden ones are at outlines. */
void stp_culling_place(stp_gpu_frame *frame, const stp_draw_params *params, const stp_view *view,
                       const stp_scene *scene);

/* A frame that gives the same answers about a block's patches, sooner: one that has only the
 * openings through which backs of the block may be seen. It is made in `room` unless `frame` itself
 * has none. set: bit i % 32 of word i / 32 says whether opening i of `frame` is one; may be NULL.
 */
const stp_gpu_frame *stp_culling_narrow(stp_gpu_frame *room, const stp_gpu_frame *frame,
                                        const stp_scene *scene, uint32_t block, stp_dvec3 eye,
                                        uint32_t set[STP_OPENING_WORDS]);

#endif

/* What lies at a pixel: the front surface out of the finished pixel's depth interval, and the
 * sample drawn next to it out of the Object Texture (shaders/README.md, "Picking").
 *
 * Reads textures and buffers alone; draws nothing. Threads: the render thread,
 * between stp_gl_state_enter and leave. */
#ifndef STP_RUNTIME_DRAW_PICK_H
#define STP_RUNTIME_DRAW_PICK_H

#include "runtime/draw/pyramid.h"
#include "runtime/stipple.h"
#include "runtime/stream/object_texture.h"

#define STP_PICK_REACH_PX 2

/* Borrowed, as the last frame left them. */
typedef struct stp_pick_params {
    const stp_pyramid *pyramid;
    const stp_object_texture *texture;
    const stp_gpu_frame *frame;
    stp_dvec3 eye;
    bool finished; /* the pixel has been finished in level 0 */
    int x, y;      /* inside the picture */
} stp_pick_params;

/* The pixel that a pick at (*x, *y), inside the picture, takes: this one, or where nothing is there
 * the nearest covered one within STP_PICK_REACH_PX, of equals the frontmost. False: none. */
bool stp_pick_choose(const stp_pyramid *pyramid, int *x, int *y);

/* Says what is at a covered pixel. Errors: GL, OUT_OF_MEMORY. */
stp_status stp_pick_find(stp_pick *out, const stp_pick_params *params, stp_error *err);

#endif

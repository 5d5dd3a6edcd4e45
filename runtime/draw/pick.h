/* Finds what lies at a pixel: the front surface from the depth interval of the finished pixel, and
 * the nearest sample drawn from the Object Texture (shaders/README.md, "Picking").
 *
 * Only reads textures and buffers; draws nothing. Threads: the render thread, between
 * stp_gl_state_enter and leave. */
#ifndef STP_RUNTIME_DRAW_PICK_H
#define STP_RUNTIME_DRAW_PICK_H

#include "runtime/draw/pyramid.h"
#include "runtime/draw/squares.h"
#include "runtime/stipple.h"
#include "runtime/stream/cache/object_texture.h"

#define STP_PICK_REACH_PX 2

/* Borrowed, in the state that the last frame left. */
typedef struct stp_pick_params {
    const stp_pyramid *pyramid;
    const stp_object_texture *texture;
    const stp_squares *squares; /* drawn as triangles */
    const stp_gpu_frame *frame;
    const stp_draw_params *drawn; /* what the picture was drawn with */
    stp_dvec3 eye;
    bool finished; /* level 0 has the finished pixel */
    int x, y;      /* inside the picture */
} stp_pick_params;

/* Moves (*x, *y), inside the picture, to the pixel to pick: the pixel itself if covered, otherwise
 * the nearest covered pixel within STP_PICK_REACH_PX; of equally near ones the frontmost. False:
 * there is none. */
bool stp_pick_choose(const stp_pyramid *pyramid, int *x, int *y);

/* Describes what is at a covered pixel. Errors: GL, OUT_OF_MEMORY. */
stp_status stp_pick_find(stp_pick *out, const stp_pick_params *params, stp_error *err);

#endif

/* Level changes that fade instead of popping.
 *
 * A picture knows of each pixel at which level its surface is drawn. Where that was another one in
 * the last frame, what was shown there is taken over as a difference that is lost frame by frame:
 * the rest of the picture stays sharp. shaders/README.md, "Fading". Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_FADE_H
#define STP_RUNTIME_DRAW_FADE_H

#include "runtime/cut/tiles.h"
#include "runtime/draw/pyramid.h"
#include "runtime/gl/gpu_layout.h"

#include "base/vec.h"

#include <stdbool.h>

/* picture, depth, mark, difference */
enum { STP_FADE_TARGETS = 4 };

/* Zero knows no last frame. */
typedef struct stp_fade {
    int width, height;
    GLuint textures[2][STP_FADE_TARGETS], frames[2];
    int now; /* which of the two is the last frame's */
    bool known;
    stp_gpu_frame frame; /* of the last frame */
    stp_dvec3 eye;
    int left; /* frames until nothing of a difference is left */
} stp_fade;

void stp_fade_destroy(stp_fade *fade);

/* The last frame is no longer one to fade from. */
void stp_fade_forget(stp_fade *fade);

/* Fades the pyramid's picture. program: of fade.frag; kept: the share of a difference that stays in
 * each frame, in (0, 1); changes: something may be drawn at another level than in the last frame.
 * Errors: GL (no memory). */
stp_status stp_fade_apply(stp_fade *fade, GLuint program, const stp_pyramid *pyramid,
                          const stp_tiles *tiles, const stp_gpu_frame *frame, stp_dvec3 eye,
                          double kept, bool changes, stp_error *err);

#endif
